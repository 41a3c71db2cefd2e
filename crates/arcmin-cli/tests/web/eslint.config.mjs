// For the scripts of a page joined in their order, as the page has them: the explorer, and a report.
const browser = ['window', 'document', 'location', 'fetch', 'performance', 'EventSource', 'URLSearchParams',
  'requestAnimationFrame', 'setTimeout', 'clearTimeout', 'ResizeObserver', 'THREE', 'Set', 'Map', 'WeakMap'];
const ofReports = ['URL', 'Blob', 'getComputedStyle', 'XMLSerializer', 'IntersectionObserver', 'matchMedia', 'localStorage', 'navigator'];
const readonly = (names) => Object.fromEntries(names.map((name) => [name, 'readonly']));
const language = (names) => ({ sourceType: 'script', ecmaVersion: 2022, globals: readonly(names) });
const rules = { 'no-undef': 'error', 'no-unused-vars': 'error', 'no-redeclare': 'error', eqeqeq: 'error', 'prefer-const': ['error', { destructuring: 'all' }] };

export default [
  { files: ['page.js'], languageOptions: language(browser), rules },
  // The film of the explorer is not in reports.
  { files: ['report.js'], languageOptions: language([...browser, ...ofReports]), rules: { ...rules, 'no-unused-vars': ['error', { varsIgnorePattern: '^frame(sOf|At)$' }] } },
];
