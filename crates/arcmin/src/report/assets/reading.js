// Reading and zooming a plot with pointer and keyboard.

Object.assign(PlotFigure.prototype, {
  listen() {
    const { svg } = this;
    let start = null;
    const place = event => { const box = svg.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    svg.addEventListener('pointerdown', event => {
      if (event.button !== 0 || !this.area) return;
      start = place(event);
      // Focus for key presses, without the focus ring of keyboard navigation.
      event.preventDefault();
      svg.focus({ preventScroll: true, focusVisible: false });
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener('pointermove', event => {
      if (!this.area) return;
      const here = place(event);
      if (start) this.drawRubber(start, here); else this.read(here[0], here[1]);
    });
    const finish = event => {
      if (!start) return;
      const box = this.rubber(start, place(event));
      start = null;
      if (box) this.zoomTo(box); else { this.cursor.textContent = ''; this.read(...place(event)); }
    };
    svg.addEventListener('pointerup', finish);
    svg.addEventListener('pointercancel', () => { start = null; this.hideCursor(); });
    svg.addEventListener('pointerleave', () => { if (!start) this.hideCursor(); });
    svg.addEventListener('dblclick', () => this.reset());
    svg.addEventListener('blur', () => this.hideCursor());
    svg.addEventListener('keydown', event => this.key(event));
  },

  key(event) {
    const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: 10, ArrowDown: -10 };
    if (event.key in steps) this.readNext(steps[event.key]);
    else if (event.key === 'Escape' || event.key === '0') this.reset();
    else if (event.key === '+' || event.key === '=') this.zoomBy(0.5);
    else if (event.key === '-') this.zoomBy(2);
    else return;
    event.preventDefault();
  },

  // The dragged box in pixels; a flat one zooms x alone; null if nothing was dragged.
  rubber([x0, y0], [x1, y1]) {
    const { area } = this, within = (value, low, high) => Math.min(high, Math.max(low, value));
    const box = { left: within(Math.min(x0, x1), area.left, area.right), right: within(Math.max(x0, x1), area.left, area.right),
      top: within(Math.min(y0, y1), area.top, area.bottom), bottom: within(Math.max(y0, y1), area.top, area.bottom) };
    if (box.right - box.left < 6) return null;
    box.onlyX = box.bottom - box.top < 14 && !this.plot.equal_scales;
    if (box.onlyX) { box.top = area.top; box.bottom = area.bottom; }
    return box;
  },

  drawRubber(start, here) {
    this.hideCursor();
    const box = this.rubber(start, here);
    if (box) svgElement('rect', { class: 'rubber', x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top }, this.cursor);
  },

  zoomTo(box) {
    this.zoomed.x = [this.xs.value(box.left), this.xs.value(box.right)];
    // After a zoom in x alone, the range of y is that of the visible points, unless it was given.
    this.zoomed.y = box.onlyX ? this.zoomed.y : [this.ys.value(box.bottom), this.ys.value(box.top)];
    this.draw();
  },

  zoomBy(factor) {
    const { area } = this, middle = this.pointer ? this.pointer.x : (area.left + area.right) / 2, half = (area.right - area.left) / 2 * factor;
    if (factor > 1 && !this.zoomed.x) return;
    this.zoomTo({ left: middle - half, right: middle + half, onlyX: true });
  },

  hideCursor() {
    if (this.cursor) this.cursor.textContent = '';
    this.tip.style.visibility = 'hidden';
  },

  // Nearest point over all shown series: by x alone or by distance on the screen.
  nearest(X, Y) {
    let best = null;
    for (const { one, index } of this.shown()) {
      const { x, y } = one.points;
      const consider = at => {
        if (y[at] === null || y[at] === undefined) return;
        const dx = this.xs.at(x[at]) - X, dy = this.ys.at(y[at]) - Y, inside = x[at] >= this.xs.range[0] && x[at] <= this.xs.range[1];
        const distance = this.readByX ? Math.abs(dx) + Math.abs(dy) * 1e-4 : dx * dx + dy * dy;
        if (inside && Number.isFinite(distance) && (!best || distance < best.distance)) best = { index, at, distance };
      };
      if (this.readByX) {
        const near = lowerBound(x, this.xs.value(X));
        for (let at = near - 2; at <= near + 2; at++) if (at >= 0 && at < x.length) consider(at);
      } else x.forEach((_, at) => consider(at));
    }
    return best;
  },

  read(X, Y) {
    const { area } = this, inside = X >= area.left - 4 && X <= area.right + 4 && Y >= area.top - 4 && Y <= area.bottom + 4;
    const best = inside && this.nearest(X, Y);
    if (!best) { this.hideCursor(); return; }
    this.readAt(best.index, best.at);
  },

  readNext(step) {
    const series = this.shown().filter(({ one }) => one.points.x.length);
    if (!series.length) return;
    const index = this.pointer && this.visible[this.pointer.index] ? this.pointer.index : series[0].index;
    const count = this.plot.series[index].points.x.length;
    const at = this.pointer && this.pointer.index === index ? Math.min(count - 1, Math.max(0, this.pointer.at + step)) : 0;
    this.readAt(index, at, true);
  },

  readAt(index, at, speak = false) {
    const { plot, xs, ys, area } = this, chosen = plot.series[index], x = chosen.points.x[at];
    const X = xs.at(x), rows = [];
    this.pointer = { index, at, x: X };
    this.cursor.textContent = '';
    if (this.readByX) svgElement('line', { class: 'cursor', x1: X, x2: X, y1: area.top, y2: area.bottom }, this.cursor);
    for (const { one, index: other } of this.shown()) {
      if (!this.readByX && other !== index) continue;
      const reading = other === index ? { y: chosen.points.y[at], low: chosen.points.low && chosen.points.low[at] } : valueAt(one, x, xs);
      if (!reading || reading.y === null) continue;
      rows.push({ name: one.name, colour: this.colours[other], ...reading });
      for (const y of [reading.y, reading.low]) {
        if (y !== undefined && y !== null && ys.at(y) >= area.top - 1 && ys.at(y) <= area.bottom + 1) svgElement('circle', { class: 'dot', cx: X, cy: ys.at(y), r: 4, style: `fill:${this.colours[other]}` }, this.cursor);
      }
    }
    this.showTip(X, ys.at(chosen.points.y[at] ?? ys.range[0]), x, rows);
    if (speak) this.spoken.textContent = `${plot.x.label} ${withUnit(formatValue(x), plot.x.unit)}: ` + rows.map(row => `${row.name} ${withUnit(formatValue(row.y), plot.y.unit)}`).join(', ');
  },

  showTip(X, Y, x, rows) {
    const { tip, plot } = this;
    tip.textContent = '';
    htmlElement('b', {}, tip, `${plot.x.label} ${withUnit(formatValue(x), plot.x.unit)}`);
    for (const row of rows) {
      const line = htmlElement('div', {}, tip);
      htmlElement('i', { style: `background:${row.colour}` }, line);
      htmlElement('span', {}, line, plot.series.length > 1 ? row.name : plot.y.label);
      const range = row.low !== undefined && row.low !== null ? `${formatValue(row.low)} … ${formatValue(row.y)}` : formatValue(row.y);
      htmlElement('span', {}, line, withUnit(range, plot.y.unit));
    }
    const right = X > (this.area.left + this.area.right) / 2;
    tip.style.left = tip.style.right = 'auto';
    if (right) tip.style.right = `${this.stage.clientWidth - X + 12}px`; else tip.style.left = `${X + 12}px`;
    const top = Math.min(Math.max(2, Y - tip.offsetHeight / 2), Math.max(2, this.stage.clientHeight - tip.offsetHeight - 2));
    tip.style.top = `${this.readByX ? this.area.top + 4 : top}px`;
    tip.style.visibility = 'visible';
  },
});

function lowerBound(sorted, value) {
  let low = 0, high = sorted.length;
  while (low < high) { const middle = (low + high) >> 1; if (sorted[middle] < value) low = middle + 1; else high = middle; }
  return low;
}

// Lines are interpolated between their points, as drawn; marks and bars are read at their points only.
function valueAt(one, x, xs) {
  const points = one.points, after = lowerBound(points.x, x), before = after - 1;
  const read = at => ({ y: points.y[at], low: points.low && points.low[at] });
  for (const at of [after, before]) if (at >= 0 && at < points.x.length && Math.abs(xs.at(points.x[at]) - xs.at(x)) < 0.5) return read(at);
  if (before < 0 || after >= points.x.length || one.style === 'markers' || one.style === 'bars') return null;
  if (one.style === 'step') return read(before);
  const part = (x - points.x[before]) / (points.x[after] - points.x[before]);
  const mix = list => list && list[before] !== null && list[after] !== null ? list[before] + part * (list[after] - list[before]) : null;
  const y = mix(points.y);
  return y === null ? null : { y, low: points.low ? mix(points.low) : undefined };
}
