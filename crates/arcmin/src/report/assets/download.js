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

// Heads as in the other files: label [unit].
function cellText(cell) {
  const copy = cell.cloneNode(true), unit = copy.querySelector('.unit');
  if (unit) unit.textContent = ` [${unit.textContent}]`;
  return copy.textContent.replace(/\s+/g, ' ').trim();
}

const tableCsv = table => [...table.rows].map(row => csvLine([...row.cells].filter(cell => !cell.matches('[aria-hidden]')).map(cellText))).join('');

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
  const box = svg.viewBox.baseVal, width = box.width, columns = Math.max(1, Math.floor(width / 240)), lines = Math.ceil(legend.length / columns);
  const head = title ? 26 + lines * 18 : 0;
  const font = `font-family:system-ui,"DejaVu Sans",Arial,sans-serif;font-size:`;
  for (const skipped of copy.querySelectorAll('[data-transient]')) skipped.remove();
  const outer = svgElement('svg', { xmlns: SVG, viewBox: `${box.x} ${box.y - head} ${width} ${box.height + head}`, width: title ? width : 900 });
  svgElement('rect', { x: box.x, y: box.y - head, width, height: box.height + head, fill: '#ffffff' }, outer);
  if (title) svgElement('text', { x: 4, y: 18 - head, style: `${font}14px;font-weight:600`, fill: ink }, outer, title);
  legend.forEach((entry, index) => {
    const x = 4 + (index % columns) * width / columns, y = 38 + Math.floor(index / columns) * 18 - head;
    svgElement('line', { x1: x, x2: x + 18, y1: y - 4, y2: y - 4, stroke: colourOf(entry.colour), 'stroke-width': 3, 'stroke-dasharray': entry.dash }, outer);
    svgElement('text', { x: x + 24, y, style: `${font}12px`, fill: ink }, outer, entry.name);
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
