// CSV and SVG of every figure, written in the browser.

function saveAs(name, type, text) {
  const link = htmlElement('a', { download: name, href: URL.createObjectURL(new Blob([text], { type })) });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const csvCell = text => /[",\n]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text;
const csvLine = cells => cells.map(cell => csvCell(String(cell ?? ''))).join(',') + '\n';
const headed = axis => axis.unit ? `${axis.label} [${axis.unit}]` : axis.label;

// Long form: one row per point, so that series with different x need no padding.
function plotCsv(plot) {
  const banded = plot.series.some(one => one.style === 'band');
  let text = csvLine(['series', headed(plot.x), headed(plot.y)].concat(banded ? ['lower edge'] : []));
  for (const one of plot.series) {
    one.points.x.forEach((x, index) => {
      text += csvLine([one.name, x, one.points.y[index]].concat(banded ? [one.points.low ? one.points.low[index] : ''] : []));
    });
  }
  return text;
}

function heatmapCsv(map) {
  let text = csvLine([headed(map.x), headed(map.y), headed(map.value)]);
  map.y_values.forEach((y, row) => map.x_values.forEach((x, column) => { text += csvLine([x, y, map.cells[row * map.x_values.length + column]]); }));
  return text;
}

const tableCsv = table => [...table.rows].map(row => csvLine([...row.cells].filter(cell => !cell.matches('[aria-hidden]')).map(cell => cell.innerText.replace(/\s+/g, ' ').trim()))).join('');

const STYLED = ['fill', 'fill-opacity', 'fill-rule', 'stroke', 'stroke-width', 'stroke-opacity', 'stroke-dasharray', 'stroke-linejoin', 'stroke-linecap', 'paint-order',
  'font-family', 'font-size', 'font-weight', 'text-anchor', 'dominant-baseline', 'opacity', 'visibility', 'display'];

// The drawing with its styles written into it, in light colours, with title and legend, as a file of its own.
function svgText(svg, title, legend = []) {
  const root = document.documentElement, theme = root.dataset.theme;
  root.dataset.theme = 'light';
  const copy = svg.cloneNode(true), originals = [svg, ...svg.querySelectorAll('*')], copies = [copy, ...copy.querySelectorAll('*')];
  originals.forEach((element, index) => {
    if (element.closest('defs')) return;
    const style = getComputedStyle(element);
    copies[index].setAttribute('style', STYLED.map(name => `${name}:${style.getPropertyValue(name)}`).join(';'));
    copies[index].removeAttribute('class');
  });
  const ink = getComputedStyle(root).getPropertyValue('--ink').trim();
  const colourOf = value => value.startsWith('var(') ? getComputedStyle(root).getPropertyValue(value.slice(4, -1)).trim() : value;
  const box = svg.viewBox.baseVal, width = box.width, lines = Math.ceil(legend.length / 3), unit = width / 640;
  const head = legend.length || title ? (26 + lines * 18) * unit : 0;
  const font = `font-family:system-ui,"DejaVu Sans",Arial,sans-serif;font-size:`;
  for (const skipped of copy.querySelectorAll('[data-transient]')) skipped.remove();
  const outer = svgElement('svg', { xmlns: SVG, viewBox: `${box.x} ${box.y - head} ${width} ${box.height + head}`, width: Math.round(640 * Math.max(1, width / 640 > 4 ? 1 : width / 640)) });
  svgElement('rect', { x: box.x, y: box.y - head, width, height: box.height + head, fill: '#ffffff' }, outer);
  svgElement('text', { x: box.x + 8 * unit, y: box.y - head + 18 * unit, style: `${font}${14 * unit}px;font-weight:600`, fill: ink }, outer, title);
  legend.forEach((entry, index) => {
    const x = box.x + (8 + (index % 3) * 208) * unit, y = box.y - head + (38 + Math.floor(index / 3) * 18) * unit;
    svgElement('line', { x1: x, x2: x + 18 * unit, y1: y - 4 * unit, y2: y - 4 * unit, stroke: colourOf(entry.colour), 'stroke-width': 3 * unit, 'stroke-dasharray': entry.dashed ? `${5 * unit} ${3 * unit}` : 'none' }, outer);
    svgElement('text', { x: x + 24 * unit, y, style: `${font}${12 * unit}px`, fill: ink }, outer, entry.name);
  });
  for (const name of ['x', 'y', 'width', 'height', 'style', 'tabindex', 'role']) copy.removeAttribute(name);
  for (const [name, value] of [['x', box.x], ['y', box.y], ['width', box.width], ['height', box.height]]) copy.setAttribute(name, value);
  outer.append(copy);
  root.dataset.theme = theme;
  return '<?xml version="1.0" encoding="UTF-8"?>\n' + new XMLSerializer().serializeToString(outer);
}

function tool(figure, label, description, action) {
  const button = htmlElement('button', { type: 'button', title: description, 'aria-label': description }, figure.querySelector('.tools'), label);
  button.addEventListener('click', action);
  return button;
}
