// The page itself: theme, copying, contents, printing, start.

const KINDS = { plot: PlotFigure, heatmap: HeatmapFigure, mechanism: MechanismFigure, solids: SolidsFigure, mesh: MeshFigure, arm: ArmFigure, samples: SamplesFigure };
const figures = [];
const root = document.documentElement;

function redraw() {
  for (const figure of figures) { if (figure.drawLegend) figure.drawLegend(); figure.draw(); }
}

function setTheme(theme) {
  root.dataset.theme = theme;
  document.getElementById('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
  redraw();
}

// Browsers may refuse storage to a page opened from disk.
function remembered(theme) {
  try {
    if (theme) localStorage.setItem('arcmin-theme', theme);
    return localStorage.getItem('arcmin-theme');
  } catch { return null; }
}

async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = htmlElement('textarea', { readonly: '', style: 'position:fixed;left:-999px' }, document.body);
    area.value = text;
    area.select();
    const copied = document.execCommand('copy');
    area.remove();
    if (!copied) throw new Error('not allowed');
  }
}

function startCopying() {
  const button = document.getElementById('copy-summary'), done = document.getElementById('copy-done');
  if (button) button.addEventListener('click', () => copyText(document.getElementById('summary-text').textContent).then(
    () => { done.textContent = 'Copied'; setTimeout(() => { done.textContent = ''; }, 3000); },
    () => { done.textContent = 'The browser does not allow copying; the text is below.'; document.querySelector('.summary details').open = true; }));
  for (const copy of document.querySelectorAll('.copy-code')) copy.addEventListener('click', () => copyText(copy.parentElement.querySelector('pre').textContent).then(
    () => { copy.textContent = 'Copied'; setTimeout(() => { copy.textContent = 'Copy'; }, 3000); }, () => {}));
}

function startContents() {
  const links = new Map([...document.querySelectorAll('.contents a')].map(link => [link.hash.slice(1), link]));
  const inView = new Set();
  const observer = new IntersectionObserver(entries => {
    for (const entry of entries) if (entry.isIntersecting) inView.add(entry.target.id); else inView.delete(entry.target.id);
    const current = [...links.keys()].find(id => inView.has(id));
    for (const [id, link] of links) if (id === current) link.setAttribute('aria-current', 'true'); else link.removeAttribute('aria-current');
  }, { rootMargin: '0px 0px -60% 0px' });
  for (const id of links.keys()) { const section = document.getElementById(id); if (section) observer.observe(section); }
}

for (const figure of document.querySelectorAll('.figure')) {
  const data = JSON.parse(figure.querySelector('script[type="application/json"]').textContent);
  if (data) figures.push(new KINDS[figure.dataset.kind](figure, data));
}
for (const table of document.querySelectorAll('.table')) tool(table, 'CSV', 'Download this table as CSV', () => saveAs((table.dataset.file || 'table') + '.csv', 'text/csv', tableCsv(table.querySelector('table'))));

const systemDark = matchMedia('(prefers-color-scheme: dark)');
setTheme(remembered() || (systemDark.matches ? 'dark' : 'light'));
systemDark.addEventListener('change', () => { if (!remembered()) setTheme(systemDark.matches ? 'dark' : 'light'); });
document.getElementById('theme').addEventListener('click', () => { const theme = root.dataset.theme === 'dark' ? 'light' : 'dark'; remembered(theme); setTheme(theme); });
document.getElementById('print').addEventListener('click', () => window.print());
startCopying();
startContents();

// Paper has another width: every figure is drawn again for it, in light colours.
const folded = [...document.querySelectorAll('details.code:not([open])')];
const printing = on => { for (const part of folded) part.open = on; if (on) root.dataset.printing = 'yes'; else delete root.dataset.printing; redraw(); };
matchMedia('print').addEventListener('change', event => printing(event.matches));
window.addEventListener('beforeprint', () => printing(true));
window.addEventListener('afterprint', () => printing(false));

let queued = false;
const sizes = new ResizeObserver(() => {
  if (queued) return;
  queued = true;
  requestAnimationFrame(() => { queued = false; for (const figure of figures) figure.draw(); });
});
for (const figure of figures) sizes.observe(figure.stage);
root.classList.remove('starting');
