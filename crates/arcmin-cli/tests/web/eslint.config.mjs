// For the scripts of the page joined in their order, as the page has them.
const browser = ['window', 'document', 'location', 'fetch', 'performance', 'EventSource', 'URLSearchParams',
  'requestAnimationFrame', 'setTimeout', 'clearTimeout', 'ResizeObserver', 'THREE', 'Set', 'Map', 'WeakMap'];

export default [{
  files: ['page.js'],
  languageOptions: {
    sourceType: 'script', ecmaVersion: 2022, globals: Object.fromEntries(browser.map((name) => [name, 'readonly'])),
  },
  rules: { 'no-undef': 'error', 'no-unused-vars': 'error', 'no-redeclare': 'error', eqeqeq: 'error', 'prefer-const': 'error' },
}];
