// A quantity over two others as coloured cells.

class HeatmapFigure {
  constructor(figure, map) {
    this.figure = figure;
    this.map = map;
    this.stage = figure.querySelector('.stage');
    this.stage.textContent = '';
    this.svg = svgElement('svg', { role: 'img', tabindex: '0', 'aria-label': `${map.title}: ${headed(map.value)} over ${headed(map.x)} and ${headed(map.y)}. Arrow keys read cells.` }, this.stage);
    this.tip = htmlElement('div', { class: 'tip', 'aria-hidden': 'true' }, this.stage);
    this.spoken = htmlElement('div', { class: 'spoken', role: 'status' }, this.stage);
    tool(figure, 'CSV', `Download the data of “${map.title}” as CSV`, () => saveAs(figure.dataset.file + '.csv', 'text/csv', heatmapCsv(map)));
    tool(figure, 'SVG', `Download “${map.title}” as SVG`, () => { this.leave(); saveAs(figure.dataset.file + '.svg', 'image/svg+xml', svgText(this.svg, map.title)); });
    this.column = 0; this.row = 0;
    this.svg.addEventListener('pointermove', event => {
      const box = this.svg.getBoundingClientRect(), column = this.cellAt(this.xEdges, event.clientX - box.left), row = this.cellAt(this.yEdges, event.clientY - box.top);
      if (column < 0 || row < 0) this.leave(); else this.show(column, row);
    });
    this.svg.addEventListener('pointerleave', () => this.leave());
    this.svg.addEventListener('blur', () => this.leave());
    this.svg.addEventListener('keydown', event => {
      const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!move) return;
      event.preventDefault();
      this.show(clampIndex(this.column + move[0], map.x_values), clampIndex(this.row + move[1], map.y_values));
      this.spoken.textContent = this.tip.textContent;
    });
  }

  cellAt(edges, pixel) {
    for (let at = 0; at + 1 < edges.length; at++) if ((pixel - edges[at]) * (pixel - edges[at + 1]) <= 0) return at;
    return -1;
  }

  leave() { this.tip.style.visibility = 'hidden'; if (this.mark) this.mark.setAttribute('visibility', 'hidden'); }

  show(column, row) {
    const { map, tip } = this, value = map.cells[row * map.x_values.length + column];
    this.column = column; this.row = row;
    const [x0, x1] = [this.xEdges[column], this.xEdges[column + 1]], [y0, y1] = [this.yEdges[row], this.yEdges[row + 1]].sort((a, b) => a - b);
    for (const [name, number] of [['x', x0], ['y', y0], ['width', x1 - x0], ['height', y1 - y0], ['visibility', 'visible']]) this.mark.setAttribute(name, number);
    tip.textContent = '';
    htmlElement('b', {}, tip, `${map.value.label} ${value === null ? 'not known' : withUnit(formatValue(value), map.value.unit)}`);
    htmlElement('div', {}, tip, `${map.x.label} ${withUnit(formatValue(map.x_values[column]), map.x.unit)}, `);
    htmlElement('div', {}, tip, `${map.y.label} ${withUnit(formatValue(map.y_values[row]), map.y.unit)}`);
    const late = x0 > this.stage.clientWidth / 2;
    tip.style.left = late ? 'auto' : `${x1 + 8}px`;
    tip.style.right = late ? `${this.stage.clientWidth - x0 + 8}px` : 'auto';
    tip.style.top = `${Math.max(2, Math.min(y0, this.stage.clientHeight - tip.offsetHeight - 2))}px`;
    tip.style.visibility = 'visible';
  }

  draw() {
    const width = this.stage.clientWidth, height = this.stage.clientHeight, { map, svg } = this;
    if (!width || !height) return;
    this.leave();
    svg.textContent = '';
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    const top = 24, bottom = 42, barWidth = 14, right = 84, left = 14 + 7 * Math.max(3, ...map.y_values.map(value => formatValue(value).length));
    const edgesX = cellEdges(map.x_values, map.x.scale), edgesY = cellEdges(map.y_values, map.y.scale);
    const xs = makeScale(map.x, [edgesX[0], edgesX.at(-1)], left, width - right), ys = makeScale(map.y, [edgesY[0], edgesY.at(-1)], height - bottom, top);
    this.xEdges = edgesX.map(xs.at); this.yEdges = edgesY.map(ys.at);
    const range = map.value.range || fitRange(map.value, map.cells, 0), colours = makeScale(map.value, range[0] < range[1] ? range : [range[0], range[0] + 1], 0, 1);
    map.cells.forEach((value, index) => {
      if (value === null) return;
      const column = index % map.x_values.length, row = Math.floor(index / map.x_values.length);
      svgElement('rect', { x: px(this.xEdges[column]), y: px(this.yEdges[row + 1]), width: px(this.xEdges[column + 1] - this.xEdges[column] + .3), height: px(this.yEdges[row] - this.yEdges[row + 1] + .3), style: `fill:${ramp(colours.at(value))}` }, svg);
    });
    for (const tick of xs.ticks((width - left - right) / 76)) if (tick.label) svgElement('text', { x: xs.at(tick.at), y: height - bottom + 17, 'text-anchor': 'middle' }, svg, tick.label);
    for (const tick of ys.ticks((height - top - bottom) / 46)) if (tick.label) svgElement('text', { x: left - 7, y: ys.at(tick.at) + 4, 'text-anchor': 'end' }, svg, tick.label);
    svgElement('rect', { class: 'frame', x: left, y: top, width: width - left - right, height: height - top - bottom }, svg);
    svgElement('text', { class: 'axis-label', x: 2, y: 13 }, svg, labelled(map.y));
    svgElement('text', { class: 'axis-label', x: width - 2, y: 13, 'text-anchor': 'end' }, svg, labelled(map.value));
    svgElement('text', { class: 'axis-label', x: (left + width - right) / 2, y: height - 5, 'text-anchor': 'middle' }, svg, labelled(map.x));
    const bar = makeScale(map.value, colours.range, height - bottom, top), x = width - right + 16;
    for (let pixel = 0; pixel < height - top - bottom; pixel += 2) svgElement('rect', { x, y: top + pixel, width: barWidth, height: 2.4, style: `fill:${ramp(1 - pixel / (height - top - bottom))}` }, svg);
    for (const tick of bar.ticks((height - top - bottom) / 46)) if (tick.label) svgElement('text', { x: x + barWidth + 5, y: bar.at(tick.at) + 4 }, svg, tick.label);
    this.mark = svgElement('rect', { 'data-transient': '', visibility: 'hidden', style: 'fill:none;stroke:var(--ink);stroke-width:2' }, svg);
  }
}

const clampIndex = (index, list) => Math.min(list.length - 1, Math.max(0, index));

// Cells reach half-way to their neighbours.
function cellEdges(values, scale) {
  const inner = scale === 'log' ? values.map(Math.log10) : values, edges = [];
  if (inner.length === 1) edges.push(inner[0] - 0.5, inner[0] + 0.5);
  else inner.forEach((value, at) => {
    if (at === 0) edges.push(value - (inner[1] - value) / 2);
    edges.push(at + 1 < inner.length ? (value + inner[at + 1]) / 2 : value + (value - inner[at - 1]) / 2);
  });
  return scale === 'log' ? edges.map(edge => 10 ** edge) : edges;
}
