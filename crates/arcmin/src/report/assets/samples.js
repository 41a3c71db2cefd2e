// Samples of a study: parallel coordinates with brushes, a scatter matrix, and the design behind every point.

// Largest number of lines and points drawn, chosen evenly from all samples; counts are always those of all samples.
const LINES_DRAWN = 1500, POINTS_DRAWN = 3000, MATRIX_COLUMNS = 5;
// While a range is dragged: the number that a slow computer draws in a tenth of a second.
const LINES_DRAGGED = 400, POINTS_DRAGGED = 500;

class SamplesFigure {
  constructor(figure, data) {
    this.figure = figure; this.data = data;
    this.stage = figure.querySelector('.stage');
    this.stage.textContent = '';
    this.failures = new Map(data.failed);
    this.brushes = new Map();
    this.columns = data.columns.filter((column, index) => index !== data.design.seed && column.values.some(value => value !== null));
    // In the matrix the main results first, then the varied keys.
    this.chosen = [...this.columns.filter(column => column.result), ...this.columns.filter(column => !column.result)].slice(0, MATRIX_COLUMNS);
    for (const column of this.columns) column.axis = { label: column.name, unit: column.unit, scale: column.logarithmic ? 'log' : 'linear' };
    for (const column of this.columns) column.span = column.words.length ? [-0.5, column.words.length - 0.5] : fitRange(column.axis, column.values, 0.02);
    this.count = htmlElement('p', { class: 'samples-count', role: 'status' }, this.stage);
    htmlElement('h4', {}, this.stage, 'Parallel coordinates: drag along an axis to keep a range, click it to let go');
    this.parallel = htmlElement('canvas', { class: 'samples-parallel', tabindex: '0', role: 'img', 'aria-label': 'Parallel coordinates of all samples' }, this.stage);
    htmlElement('h4', {}, this.stage, 'Scatter matrix: click a point to see its design');
    this.choices = htmlElement('div', { class: 'samples-choices' }, this.stage);
    for (const column of this.columns) this.choice(column);
    this.matrix = htmlElement('canvas', { class: 'samples-matrix', role: 'img', 'aria-label': 'Scatter matrix of the chosen columns' }, this.stage);
    this.card = htmlElement('div', { class: 'samples-card' }, this.stage);
    const row = htmlElement('label', {}, this.card, 'Sample ');
    this.entry = htmlElement('input', { type: 'number', min: '0', step: '1', value: data.numbers[0] ?? 0 }, row);
    this.entry.addEventListener('input', () => { const at = data.numbers.indexOf(Number(this.entry.value)); if (at >= 0) this.pick(at); });
    this.copy = htmlElement('button', { type: 'button' }, this.card, 'Copy design as TOML');
    this.copy.addEventListener('click', () => copyText(this.toml()).then(() => { this.copied.textContent = 'Copied'; }, () => { this.copied.textContent = 'The browser does not allow copying; the text is below.'; this.show(); }));
    tool(figure, 'CSV', 'Download the samples that are kept as CSV', () => saveAs(figure.dataset.file + '.csv', 'text/csv', this.csv()));
    tool(figure, 'TOML', 'Download the design of the picked sample', () => saveAs(`sample-${data.numbers[this.picked]}.toml`, 'text/plain', this.toml()));
    tool(figure, 'All', 'Let go of all ranges', () => { this.brushes.clear(); this.filter(); });
    this.copied = htmlElement('span', { role: 'status' }, this.card);
    this.values = htmlElement('div', { class: 'samples-values' }, this.card);
    this.text = htmlElement('pre', { hidden: '' }, this.card);
    this.picked = 0;
    this.listen();
    this.filter();
    if (data.numbers.length) this.pick(0);
  }

  choice(column) {
    const button = htmlElement('button', { type: 'button', 'aria-pressed': this.chosen.includes(column) }, this.choices, column.name);
    button.addEventListener('click', () => {
      if (this.chosen.includes(column)) this.chosen = this.chosen.filter(other => other !== column);
      else this.chosen = [...this.chosen, column].slice(-MATRIX_COLUMNS);
      [...this.choices.children].forEach((other, index) => other.setAttribute('aria-pressed', this.chosen.includes(this.columns[index])));
      this.drawMatrix();
    });
  }

  show() { this.text.hidden = false; this.text.textContent = this.toml(); }

  // The design file with the values of the picked sample in their places.
  toml() {
    const { design, columns, numbers } = this.data, value = index => {
      const column = columns[index], at = column.values[this.picked];
      return column.words.length ? JSON.stringify(column.words[at]).replace(/^"(true|false)"$/, '$1') : String(at);
    };
    let text = `# Sample ${numbers[this.picked]} of a study.\n`;
    if (design.seed !== null) text += `# Drawn machine: --errors drawn --seed ${value(design.seed)}\n`;
    design.text.forEach((part, index) => { text += part; if (index < design.columns.length) text += value(design.columns[index]); });
    return text;
  }

  csv() {
    const { columns, numbers } = this.data;
    let text = csvLine(['sample', ...columns.map(column => column.name), 'failed']);
    for (const at of this.kept) text += csvLine([numbers[at], ...columns.map(column => column.words.length ? column.words[column.values[at]] : column.values[at]), this.failures.get(at)]);
    return text;
  }

  filter() {
    const all = this.data.numbers.length, ranges = [...this.brushes];
    this.kept = [];
    for (let at = 0; at < all; at++) {
      if (ranges.every(([column, [low, high]]) => { const value = column.values[at]; return value !== null && value >= low && value <= high; })) this.kept.push(at);
    }
    const failed = this.failures.size ? `, ${this.failures.size} without result` : '';
    this.count.textContent = `${groupDigits(String(this.kept.length))} of ${groupDigits(String(all))} samples${failed}` + (this.kept.length > LINES_DRAWN ? `; ${LINES_DRAWN} lines drawn` : '');
    this.draw();
  }

  pick(at) {
    this.picked = at;
    const { numbers, columns } = this.data;
    if (document.activeElement !== this.entry) this.entry.value = numbers[at];
    this.copied.textContent = '';
    this.text.hidden = true;
    this.values.textContent = '';
    if (this.failures.has(at)) htmlElement('p', { class: 'samples-failed' }, this.values, `No result: ${this.failures.get(at)}`);
    for (const column of columns) {
      const value = column.values[at], row = htmlElement('div', { class: column.result ? 'result' : '' }, this.values);
      htmlElement('span', {}, row, column.name);
      htmlElement('b', {}, row, value === null ? '–' : column.words.length ? column.words[value] : columns[this.data.design.seed] === column ? String(value) : withUnit(formatValue(value, 5), column.unit));
    }
    this.draw();
  }

  sized(canvas, height) {
    const width = this.stage.clientWidth, ratio = window.devicePixelRatio || 1;
    if (!width) return null;
    canvas.style.height = `${height}px`;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
    const pen = canvas.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = '12px system-ui, "DejaVu Sans", Arial, sans-serif';
    const style = getComputedStyle(root), colour = name => style.getPropertyValue(name).trim();
    this.inks = { ink: colour('--ink'), soft: colour('--soft'), line: colour('--line'), faint: colour('--faint'), kept: colour('--s0'), picked: colour('--s1'), bad: colour('--bad'), accent: colour('--accent') };
    return { pen, width, height };
  }

  scale(column, from, to) { return makeScale(column.axis, column.span, from, to); }

  some(list, most) {
    if (list.length <= most) return list;
    return Array.from({ length: most }, (_, index) => list[Math.floor(index * list.length / most)]);
  }

  draw() { this.drawParallel(); this.drawMatrix(); }

  drawParallel() {
    const sheet = this.sized(this.parallel, 330);
    if (!sheet) return;
    const { pen, width, height } = sheet, { inks, columns } = this, top = 46, bottom = height - 22, gap = (width - 80) / Math.max(1, columns.length - 1);
    this.axes = columns.map((column, index) => ({ column, x: 40 + index * gap, scale: this.scale(column, bottom, top) }));
    const line = at => {
      let pen_down = false;
      for (const { column, x, scale } of this.axes) {
        const value = column.values[at];
        if (value === null) { pen_down = false; continue; }
        const y = scale.at(value);
        if (pen_down) pen.lineTo(x, y); else pen.moveTo(x, y);
        pen_down = true;
      }
    };
    const lines = (list, colour, alpha, wide) => {
      pen.strokeStyle = colour; pen.globalAlpha = alpha; pen.lineWidth = wide;
      pen.beginPath();
      list.forEach(line);
      pen.stroke();
      pen.globalAlpha = 1;
    };
    if (this.brushes.size) lines(this.some(this.data.numbers.map((_, at) => at), this.dragging ? 100 : 400), inks.faint, .15, 1);
    const kept = this.some(this.kept, this.dragging ? LINES_DRAGGED : LINES_DRAWN);
    lines(kept, inks.kept, Math.min(.7, Math.max(.06, 60 / kept.length)), 1);
    if (this.data.numbers.length) lines([this.picked], inks.picked, 1, 2.4);
    this.axes.forEach(({ column, x, scale }, index) => {
      pen.strokeStyle = column.result ? inks.ink : inks.soft; pen.lineWidth = 1.2;
      pen.beginPath(); pen.moveTo(x, top); pen.lineTo(x, bottom); pen.stroke();
      const range = this.brushes.get(column);
      if (range) {
        pen.fillStyle = inks.accent; pen.globalAlpha = .3;
        const ends = range.map(value => Math.min(bottom, Math.max(top, scale.at(value))));
        pen.fillRect(x - 7, Math.min(...ends), 14, Math.abs(ends[1] - ends[0]));
        pen.globalAlpha = 1;
      }
      for (const limit of [column.low, column.high]) if (limit !== null && limit >= column.span[0] && limit <= column.span[1]) { pen.fillStyle = inks.bad; pen.fillRect(x - 9, scale.at(limit) - 1, 18, 2); }
      pen.fillStyle = inks.ink; pen.textAlign = index === 0 ? 'left' : index === columns.length - 1 ? 'right' : 'center';
      const at = index === 0 ? 2 : index === columns.length - 1 ? width - 2 : x, name = column.name.split('.').at(-1);
      pen.fillText(name, at, 13 + 14 * (index % 2), gap * 1.9);
      pen.fillStyle = inks.soft;
      const end = value => column.words.length ? column.words[Math.round(value)] ?? '' : formatValue(value, 3);
      pen.fillText(end(column.words.length ? column.words.length - 1 : column.span[1]), at, top - 5, gap * .95);
      pen.fillText(end(column.words.length ? 0 : column.span[0]), at, height - 6, gap * .95);
    });
  }

  drawMatrix() {
    const count = this.chosen.length, edge = Math.min(210, (this.stage.clientWidth - 20) / Math.max(1, count)), sheet = this.sized(this.matrix, Math.max(40, edge * count + 26));
    if (!sheet || !count) { this.cells = []; return; }
    const { pen } = sheet, { inks } = this, points = this.some(this.kept, this.dragging ? POINTS_DRAGGED : POINTS_DRAWN);
    this.cells = [];
    this.chosen.forEach((down, row) => this.chosen.forEach((across, column) => {
      const left = 12 + column * edge, top = 18 + row * edge, inner = edge - 12;
      pen.strokeStyle = inks.line; pen.strokeRect(left, top, inner, inner);
      const xs = this.scale(across, left + 3, left + inner - 3);
      if (row === column) { this.histogram(pen, across, points, xs, top, inner); return; }
      const ys = this.scale(down, top + inner - 3, top + 3);
      this.cells.push({ left, top, inner, across, down, xs, ys });
      pen.fillStyle = inks.kept; pen.globalAlpha = Math.min(.8, Math.max(.15, 300 / points.length));
      for (const at of points) {
        const a = across.values[at], b = down.values[at];
        if (a !== null && b !== null) pen.fillRect(xs.at(a) - 1, ys.at(b) - 1, 2, 2);
      }
      pen.globalAlpha = 1;
      const a = across.values[this.picked], b = down.values[this.picked];
      if (a !== null && b !== null && a !== undefined) { pen.fillStyle = inks.picked; pen.beginPath(); pen.arc(xs.at(a), ys.at(b), 4, 0, 7); pen.fill(); }
    }));
  }

  histogram(pen, column, points, xs, top, inner) {
    const bins = new Array(24).fill(0), [from, to] = [xs.from, xs.to];
    for (const at of points) {
      const value = column.values[at];
      if (value !== null) bins[Math.min(23, Math.max(0, Math.floor((xs.at(value) - from) / (to - from) * 24)))]++;
    }
    const most = Math.max(1, ...bins), wide = (to - from) / 24;
    pen.fillStyle = this.inks.faint; pen.globalAlpha = .5;
    bins.forEach((many, index) => { const high = many / most * (inner - 26); pen.fillRect(from + index * wide, top + inner - high, wide - 1, high); });
    pen.globalAlpha = 1;
    pen.fillStyle = this.inks.ink; pen.textAlign = 'center';
    pen.fillText(column.name.split('.').at(-1), (from + to) / 2, top + 15, to - from);
  }

  listen() {
    let held = null;
    const place = event => { const box = this.parallel.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    this.parallel.addEventListener('pointerdown', event => {
      const [x, y] = place(event), near = this.axes.reduce((best, axis) => Math.abs(axis.x - x) < Math.abs(best.x - x) ? axis : best);
      if (Math.abs(near.x - x) > 22) return;
      held = { axis: near, from: y, moved: false };
      this.parallel.setPointerCapture(event.pointerId);
    });
    this.parallel.addEventListener('pointermove', event => {
      if (!held) return;
      const [, y] = place(event);
      held.moved ||= Math.abs(y - held.from) > 3;
      if (!held.moved) return;
      const ends = [held.from, y].map(pixel => held.axis.scale.value(pixel)).sort((a, b) => a - b);
      this.dragging = true;
      this.brushes.set(held.axis.column, ends);
      if (!this.queued) { this.queued = true; requestAnimationFrame(() => { this.queued = false; this.filter(); }); }
    });
    const release = () => {
      if (!held) return;
      if (!held.moved) this.brushes.delete(held.axis.column);
      held = null;
      this.dragging = false;
      this.filter();
    };
    this.parallel.addEventListener('pointerup', release);
    this.parallel.addEventListener('pointercancel', release);
    this.matrix.addEventListener('click', event => {
      const box = this.matrix.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      const cell = this.cells.find(cell => x >= cell.left && x <= cell.left + cell.inner && y >= cell.top && y <= cell.top + cell.inner);
      if (!cell) return;
      let best = -1, least = Infinity;
      for (const at of this.kept) {
        const a = cell.across.values[at], b = cell.down.values[at];
        if (a === null || b === null) continue;
        const distance = (cell.xs.at(a) - x) ** 2 + (cell.ys.at(b) - y) ** 2;
        if (distance < least) { least = distance; best = at; }
      }
      if (best >= 0) this.pick(best);
    });
    this.parallel.addEventListener('keydown', event => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key], all = this.data.numbers.length;
      if (!step || !all) return;
      event.preventDefault();
      this.pick((this.picked + step + all) % all);
    });
  }
}
