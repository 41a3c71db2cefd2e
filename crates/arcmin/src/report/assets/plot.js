// An x–y plot: drawing, zoom, hover, legend, keyboard.

class PlotFigure {
  constructor(figure, plot) {
    this.figure = figure;
    this.plot = plot;
    this.stage = figure.querySelector('.stage');
    this.stage.textContent = '';
    this.visible = plot.series.map(one => !one.hidden);
    this.zoomed = { x: null, y: null };
    this.svg = svgElement('svg', { role: 'img', tabindex: '0' }, this.stage);
    this.svg.setAttribute('aria-label', `${plot.title}: ${headed(plot.y)} over ${headed(plot.x)}. `
      + plot.series.map(one => one.name).join(', ') + '. Arrow keys read values, plus and minus zoom, Escape resets.');
    this.tip = htmlElement('div', { class: 'tip', 'aria-hidden': 'true' }, this.stage);
    this.spoken = htmlElement('div', { class: 'spoken', role: 'status' }, this.stage);
    this.resetTool = tool(figure, 'Reset zoom', 'Reset the zoom', () => this.reset());
    this.resetTool.disabled = true;
    tool(figure, 'CSV', `Download the data of “${plot.title}” as CSV`, () => saveAs(figure.dataset.file + '.csv', 'text/csv', plotCsv(plot)));
    tool(figure, 'SVG', `Download “${plot.title}” as SVG`, () => saveAs(figure.dataset.file + '.svg', 'image/svg+xml', this.svgFile()));
    // Of curves that are not single-valued in x (outlines, loops) the nearest point is shown, of others the point at x.
    this.readByX = plot.series.every(one => one.points.x.every((x, index, all) => index === 0 || x >= all[index - 1]));
    this.drawLegend();
    this.listen();
  }

  svgFile() {
    const legend = this.plot.series.map((one, index) => ({ name: one.name, colour: this.colours[index], dash: this.dashes[index], shown: this.visible[index] })).filter(one => one.shown && one.name);
    this.hideCursor();
    return svgText(this.svg, this.plot.title, legend);
  }

  drawLegend() {
    const legend = this.figure.querySelector('.legend');
    legend.textContent = '';
    this.colours = seriesColours(this.plot.series);
    this.dashes = seriesDashes(this.plot.series, this.colours);
    if (this.plot.series.length < 2) return;
    this.plot.series.forEach((one, index) => {
      const button = htmlElement('button', { type: 'button', 'aria-pressed': this.visible[index], title: 'Show or hide; double-click shows only this' }, legend);
      const swatch = svgElement('svg', { width: 20, height: 12, 'aria-hidden': 'true' }, button), colour = this.colours[index];
      if (one.style === 'band') svgElement('rect', { width: 20, height: 12, style: `fill:${colour};fill-opacity:.3` }, swatch);
      else if (one.style === 'bars') svgElement('rect', { x: 7, width: 6, height: 12, style: `fill:${colour}` }, swatch);
      else if (one.style !== 'markers') svgElement('path', { d: 'M0 6H20', style: `stroke:${colour};stroke-width:${one.strong ? 3.4 : 2.2};stroke-dasharray:${this.dashes[index]}` }, swatch);
      if (one.style === 'markers' || one.style === 'line_markers') this.marker(swatch, 10, 6, index);
      htmlElement('span', {}, button, one.name);
      button.addEventListener('click', () => this.toggle(index));
      button.addEventListener('dblclick', () => this.only(index));
    });
  }

  toggle(index) { this.visible[index] = !this.visible[index]; this.updated(); }

  only(index) { this.visible = this.visible.map((_, other) => other === index); this.updated(); }

  updated() {
    this.figure.querySelectorAll('.legend button').forEach((button, index) => button.setAttribute('aria-pressed', this.visible[index]));
    this.draw();
  }

  // Shapes differ as well as colours.
  marker(parent, x, y, index) {
    const size = 4, style = `fill:${this.colours[index]}`, shape = this.plot.series[index].colour === 'reference' ? 1 : index % 4;
    const paths = [null, `M${x} ${y - size - 1}l${size + 1} ${size + 1}l${-size - 1} ${size + 1}l${-size - 1} ${-size - 1}Z`, `M${x - size} ${y - size}h${2 * size}v${2 * size}h${-2 * size}Z`, `M${x} ${y - size - 1}l${size + 1} ${2 * size}h${-2 * size - 2}Z`];
    return shape === 0 ? svgElement('circle', { cx: x, cy: y, r: size, class: 'mark', style }, parent) : svgElement('path', { d: paths[shape], class: 'mark', style }, parent);
  }

  shown() { return this.plot.series.map((one, index) => ({ one, index })).filter(({ index }) => this.visible[index]); }

  *valuesOfX() {
    for (const { one } of this.shown()) yield* one.points.x;
    for (const mark of this.plot.annotations) { if (mark.kind === 'vertical') yield mark.at; if (mark.kind === 'point') yield mark.x; }
  }

  *valuesOfY(xRange) {
    for (const { one } of this.shown()) {
      const { x, y, low } = one.points;
      for (let index = 0; index < x.length; index++) {
        // With the neighbours outside of the range, so that a zoomed line extends to the edges.
        const inside = x[index] >= xRange[0] && x[index] <= xRange[1];
        if (!inside) continue;
        yield y[index];
        if (low) yield low[index];
        if (one.style === 'bars') yield 0;
      }
    }
    if (this.zoomed.x) return;
    for (const mark of this.plot.annotations) { if (mark.kind === 'horizontal') yield mark.at; if (mark.kind === 'point') yield mark.y; }
  }

  ranges() {
    const { x, y } = this.plot;
    const xRange = this.zoomed.x || x.range || fitRange(x, this.valuesOfX(), this.plot.series.some(one => /marker|bars/.test(one.style)) || this.plot.equal_scales ? 0.03 : 0);
    const yRange = this.zoomed.y || y.range || fitRange(y, this.valuesOfY(xRange));
    return [xRange, yRange];
  }

  draw() {
    const width = Math.round(this.stage.clientWidth), height = Math.round(this.stage.clientHeight);
    if (!width || !height) return;
    const { svg, plot } = this;
    this.hideCursor();
    svg.textContent = '';
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    let [xRange, yRange] = this.ranges();
    const top = 24, bottom = 42, right = 14, plotHeight = height - top - bottom;
    const yTicks = makeScale(plot.y, yRange, 0, 1).ticks(Math.max(3, plotHeight / 40));
    const left = Math.max(34, 14 + 7 * Math.max(...yTicks.map(tick => tick.label.length), 1));
    if (plot.equal_scales) [xRange, yRange] = equalScales(xRange, yRange, width - left - right, plotHeight);
    const xs = makeScale(plot.x, xRange, left, width - right), ys = makeScale(plot.y, yRange, height - bottom, top);
    this.xs = xs; this.ys = ys;
    this.area = { left, right: width - right, top, bottom: height - bottom };
    this.drawAxes(width, height);
    const clip = `clip-${this.figure.id}`, defs = svgElement('defs', {}, svg);
    svgElement('rect', { x: left, y: top - 1, width: width - left - right, height: plotHeight + 2 }, svgElement('clipPath', { id: clip }, defs));
    const body = svgElement('g', { 'clip-path': `url(#${clip})` }, svg);
    for (const mark of plot.annotations) this.drawAnnotation(body, mark, false);
    const order = this.shown().sort((a, b) => layer(a.one) - layer(b.one));
    for (const { one, index } of order) this.drawSeries(body, one, index);
    // Labels do not cover the lines of other marks either.
    const line = mark => mark.kind === 'vertical' ? { left: xs.at(mark.at) - 2, right: xs.at(mark.at) + 2, top, bottom: height - bottom }
      : { left, right: width - right, top: ys.at(mark.at) - 2, bottom: ys.at(mark.at) + 2 };
    this.labels = plot.annotations.filter(mark => mark.kind === 'vertical' || mark.kind === 'horizontal').map(line);
    for (const mark of plot.annotations) this.drawAnnotation(body, mark, true);
    this.cursor = svgElement('g', { 'data-transient': '' }, svg);
    this.resetTool.disabled = !(this.zoomed.x || this.zoomed.y);
  }

  drawAxes(width, height) {
    const { svg, plot, xs, ys, area } = this;
    for (const tick of ys.ticks(Math.max(3, (area.bottom - area.top) / 40))) {
      const y = ys.at(tick.at);
      svgElement('line', { class: tick.at === 0 ? 'zeroline' : 'gridline', x1: area.left, x2: area.right, y1: y, y2: y }, svg);
      if (tick.label) svgElement('text', { x: area.left - 7, y: y + 4, 'text-anchor': 'end' }, svg, tick.label);
    }
    let previousEnd = -Infinity;
    for (const tick of xs.ticks(Math.max(3, (area.right - area.left) / 64))) {
      const x = xs.at(tick.at), half = tick.label.length * 3.8 + 5;
      // The last number of the axis must be within the picture.
      const middle = Math.min(x, width + 2 - half);
      svgElement('line', { class: tick.at === 0 && xs.range[0] < 0 ? 'zeroline' : 'gridline', x1: x, x2: x, y1: area.top, y2: area.bottom }, svg);
      if (tick.label && middle - half > previousEnd) {
        svgElement('text', { x: middle, y: area.bottom + 17, 'text-anchor': 'middle' }, svg, tick.label);
        previousEnd = middle + half + 6;
      }
    }
    svgElement('rect', { class: 'frame', x: area.left, y: area.top, width: area.right - area.left, height: area.bottom - area.top }, svg);
    svgElement('text', { class: 'axis-label', x: 2, y: 13 }, svg, labelled(plot.y));
    svgElement('text', { class: 'axis-label', x: (area.left + area.right) / 2, y: height - 5, 'text-anchor': 'middle' }, svg, labelled(plot.x));
  }

  drawAnnotation(parent, mark, texts) {
    const { xs, ys, area } = this;
    const colour = { bad: 'var(--bad)', caution: 'var(--caution)', good: 'var(--good)' }[mark.tone] || 'var(--soft)';
    const text = (...places) => { const [x, y, anchor] = this.freePlace(mark.label, places); svgElement('text', { class: 'note-text', x, y, 'text-anchor': anchor, style: `fill:${colour}` }, parent, mark.label); };
    if (mark.kind === 'horizontal') {
      const y = ys.at(mark.at);
      const middle = (area.left + area.right) / 2;
      const level = at => [[area.right - 6, at, 'end'], [area.left + 6, at, 'start'], [middle, at, 'middle']];
      const above = y < area.top + 18 ? [] : level(y - 6), below = y > area.bottom - 18 ? [] : level(y + 15);
      if (texts) text(...above.slice(0, 1), ...below, ...above.slice(1));
      else svgElement('line', { class: 'limit', x1: area.left, x2: area.right, y1: y, y2: y, style: `stroke:${colour}` }, parent);
    } else if (mark.kind === 'vertical') {
      const x = xs.at(mark.at), late = x > (area.left + area.right) / 2;
      // The first free position from the top down, on either side.
      const rows = Array.from({ length: Math.max(1, Math.floor((area.bottom - area.top) / 16)) }, (_, row) => area.top + 15 + 16 * row);
      const sides = at => late ? [[x - 6, at, 'end'], [x + 6, at, 'start']] : [[x + 6, at, 'start'], [x - 6, at, 'end']];
      if (texts) text(...rows.flatMap(sides));
      else svgElement('line', { class: 'limit', x1: x, x2: x, y1: area.top, y2: area.bottom, style: `stroke:${colour}` }, parent);
    } else if (mark.kind === 'span') {
      const from = xs.at(mark.from), to = xs.at(mark.to);
      if (texts) text([(Math.max(from, area.left) + Math.min(to, area.right)) / 2, area.top + 15, 'middle']);
      else svgElement('rect', { class: 'span', x: from, y: area.top, width: Math.max(0, to - from), height: area.bottom - area.top }, parent);
    } else if (texts) {
      const x = xs.at(mark.x), y = ys.at(mark.y), late = x > (area.left + area.right) / 2;
      svgElement('circle', { cx: x, cy: y, r: 4.5, style: 'fill:none;stroke:var(--ink);stroke-width:1.4' }, parent);
      const left = at => [x - 9, at, 'end'], right = at => [x + 9, at, 'start'], sides = late ? [left, right] : [right, left];
      const level = sides.map(side => side(y + 4)), below = sides.map(side => side(y + 17));
      // Above its point, or beside it if a neighbour's label is there.
      text(...(y < area.top + 22 ? below : [[x, y - 9, 'middle'], ...level, ...below]));
    }
  }

  // The first position at which a label covers no earlier one; the first position if there is none.
  freePlace(label, places) {
    const wide = 6.6 * label.length, high = 13;
    const box = ([x, y, anchor]) => { const left = anchor === 'end' ? x - wide : anchor === 'middle' ? x - wide / 2 : x; return { left, right: left + wide, top: y - high, bottom: y }; };
    const inside = ({ left, right }) => left >= this.area.left && right <= this.area.right;
    const meets = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    const place = places.find(one => inside(box(one)) && !this.labels.some(other => meets(box(one), other))) || places[0];
    this.labels.push(box(place));
    return place;
  }

  drawSeries(parent, one, index) {
    const { x, y, low } = one.points, { xs, ys } = this, colour = this.colours[index];
    const log = { x: this.plot.x.scale === 'log', y: this.plot.y.scale === 'log' };
    const known = at => y[at] !== null && (!log.y || y[at] > 0) && (!log.x || x[at] > 0);
    if (one.style === 'band') {
      const upper = [], lower = [];
      x.forEach((value, at) => { if (known(at)) { upper.push(`${px(xs.at(value))} ${px(ys.at(y[at]))}`); lower.unshift(`${px(xs.at(value))} ${px(ys.at(low[at]))}`); } });
      if (upper.length) svgElement('path', { class: 'band', d: 'M' + upper.join('L') + 'L' + lower.join('L') + 'Z', style: `fill:${colour}` }, parent);
      return;
    }
    if (one.style === 'bars') {
      const base = ys.at(log.y ? ys.range[0] : 0);
      const gap = x.reduce((smallest, value, at) => at ? Math.min(smallest, xs.at(value) - xs.at(x[at - 1])) : smallest, 40);
      const wide = Math.max(2, Math.min(26, gap * 0.7));
      x.forEach((value, at) => { if (known(at)) svgElement('rect', { x: px(xs.at(value) - wide / 2), width: px(wide), y: px(Math.min(base, ys.at(y[at]))), height: px(Math.abs(base - ys.at(y[at]))), style: `fill:${colour}` }, parent); });
      return;
    }
    if (one.style !== 'markers') {
      svgElement('path', { class: one.strong ? 'curve strong' : 'curve', d: this.linePath(one, known), style: `stroke:${colour};stroke-dasharray:${this.dashes[index]}` }, parent);
    }
    if (one.style === 'markers' || one.style === 'line_markers') x.forEach((value, at) => { if (known(at)) this.marker(parent, xs.at(value), ys.at(y[at]), index); });
  }

  // Long series are reduced to the lowest and the highest point of every half pixel; the picture is the same.
  linePath(one, known) {
    const { x, y } = one.points, { xs, ys } = this, parts = [];
    const thin = this.readByX && x.length > 4 * (xs.to - xs.from), step = one.style === 'step';
    let pen = false, column = null, held = [];
    const flush = () => { for (const at of [...new Set(held)].sort((a, b) => a - b)) { put(at); } held = []; };
    const put = at => {
      const X = px(xs.at(x[at])), Y = px(ys.at(y[at]));
      parts.push(!pen ? `M${X} ${Y}` : step ? `H${X}V${Y}` : `L${X} ${Y}`);
      pen = true;
    };
    for (let at = 0; at < x.length; at++) {
      if (!known(at)) { flush(); column = null; pen = false; continue; }
      if (!thin) { put(at); continue; }
      if (x[at + 1] < xs.range[0] || x[at - 1] > xs.range[1]) continue;
      const here = Math.floor(xs.at(x[at]) * 2);
      if (here !== column) { flush(); column = here; held = [at, at, at, at]; }
      if (y[at] < y[held[1]]) held[1] = at;
      if (y[at] > y[held[2]]) held[2] = at;
      held[3] = at;
    }
    flush();
    return parts.join('');
  }

  reset() { this.zoomed = { x: null, y: null }; this.draw(); }
}

const px = value => Math.round(Math.max(-1e5, Math.min(1e5, value)) * 100) / 100;
const labelled = axis => axis.unit ? `${axis.label} (${axis.unit})` : axis.label;
// Areas below, reference marks on top, strong lines above thin ones.
const layer = one => one.style === 'band' ? 0 : one.style === 'bars' ? 1 : one.style === 'markers' ? 4 : one.strong ? 3 : 2;

function equalScales(xRange, yRange, width, height) {
  const perPixel = Math.max((xRange[1] - xRange[0]) / width, (yRange[1] - yRange[0]) / height);
  const grow = ([low, high], pixels) => { const middle = (low + high) / 2, half = perPixel * pixels / 2; return [middle - half, middle + half]; };
  return [grow(xRange, width), grow(yRange, height)];
}
