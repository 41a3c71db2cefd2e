// An arm in space moving along its program, the tool's path with its error magnified. Lengths are millimetres, z points up.

const ARM_SPEEDS = [0.25, 0.5, 1, 2, 4];

class ArmFigure {
  constructor(figure, arm) {
    this.figure = figure;
    this.arm = arm;
    this.stage = figure.querySelector('.stage');
    this.stage.textContent = '';
    this.turn = -0.6; this.tilt = 0.35; this.frame = 0; this.pace = 1; this.magnified = arm.magnified;
    const row = htmlElement('div', { class: 'row' }, this.stage);
    this.button = htmlElement('button', { type: 'button' }, row, 'Play');
    this.button.addEventListener('click', () => this.play(!this.playing));
    const time = htmlElement('label', {}, row, 'Time ');
    this.slider = htmlElement('input', { type: 'range', min: 0, max: arm.frames.length - 1, step: 1, value: 0, 'aria-label': 'Place in the program' }, time);
    this.slider.addEventListener('input', () => { this.play(false); this.frame = Number(this.slider.value); this.draw(); });
    this.readout = htmlElement('output', {}, row);
    const larger = htmlElement('label', {}, row, 'Error × '), size = htmlElement('input', { type: 'range', min: 0, max: 2, step: 0.01, value: 1, 'aria-label': 'Exaggeration of the error' }, larger);
    this.factor = htmlElement('output', {}, row);
    size.addEventListener('input', () => { this.magnified = arm.magnified * Number(size.value); this.draw(); });
    const pace = htmlElement('label', {}, row, 'Pace '), select = htmlElement('select', { 'aria-label': 'Pace' }, pace);
    for (const one of ARM_SPEEDS) htmlElement('option', { value: one, ...(one === 1 ? { selected: '' } : {}) }, select, `${one} ×`);
    select.addEventListener('change', () => { this.pace = Number(select.value); });
    this.canvas = htmlElement('canvas', { role: 'img', tabindex: 0, 'aria-label': `${arm.title}; drag or use the arrow keys to turn it` }, this.stage);
    this.canvas.addEventListener('pointerdown', event => { this.drag = [event.clientX, event.clientY]; this.canvas.setPointerCapture(event.pointerId); });
    this.canvas.addEventListener('pointermove', event => {
      if (!this.drag) return;
      this.look((event.clientX - this.drag[0]) * 0.01, (event.clientY - this.drag[1]) * 0.01);
      this.drag = [event.clientX, event.clientY];
    });
    this.canvas.addEventListener('pointerup', () => { this.drag = null; });
    this.canvas.addEventListener('keydown', event => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (step) { event.preventDefault(); this.look(...step); }
    });
    this.largest = Math.max(1e-9, ...arm.shares_mm.map(Math.abs));
    const key = htmlElement('div', { class: 'row' }, this.stage, 'Share at the tool: ');
    arm.joints.forEach((name, joint) => {
      const one = htmlElement('span', {}, key);
      htmlElement('span', { style: `display:inline-block;width:10px;height:10px;border-radius:5px;margin-right:4px;outline:1px solid var(--soft);background:${this.colour(joint)}` }, one);
      htmlElement('span', {}, one, `${name} ${formatValue(arm.shares_mm[joint], 2)} mm`);
    });
    const all = arm.frames.flatMap(frame => frame.points_mm);
    this.centre = [0, 1, 2].map(axis => { const line = all.map(p => p[axis]); return (Math.min(...line) + Math.max(...line)) / 2; });
    this.reach = Math.max(1, ...all.map(p => Math.hypot(...p.map((x, axis) => x - this.centre[axis]))));
    tool(figure, 'PNG', `Download “${arm.title}” as picture`, () => this.canvas.toBlob(blob => {
      htmlElement('a', { download: figure.dataset.file + '.png', href: URL.createObjectURL(blob) }).click();
    }));
    new IntersectionObserver(entries => { this.seen = entries[0].isIntersecting; this.tick(); }).observe(this.stage);
    this.play(!matchMedia('(prefers-reduced-motion: reduce)').matches);
  }

  colour(joint) { return ramp(Math.abs(this.arm.shares_mm[joint]) / this.largest); }

  look(turn, tilt) { this.turn += turn; this.tilt = Math.min(1.5, Math.max(-1.5, this.tilt + tilt)); this.draw(); }

  play(playing) { this.playing = playing; this.button.textContent = playing ? 'Stop' : 'Play'; this.since = null; this.tick(); }

  tick() {
    if (!this.playing || !this.seen || this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(now => {
      this.waiting = false;
      if (!this.playing || !this.seen) { this.since = null; return; }
      const { frames } = this.arm, whole = frames[frames.length - 1].time_s - frames[0].time_s;
      this.time = ((this.time ?? frames[this.frame].time_s) + (this.since ? this.pace * (now - this.since) / 1000 : 0)) % (whole || 1);
      this.since = now;
      while (this.frame + 1 < frames.length && frames[this.frame + 1].time_s <= this.time) this.frame += 1;
      if (frames[this.frame].time_s > this.time) this.frame = 0;
      this.slider.value = this.frame;
      this.draw();
      this.tick();
    });
  }

  draw() {
    const { arm, canvas } = this, width = canvas.clientWidth, sharp = Math.max(2, window.devicePixelRatio || 1);
    if (!width) return;
    canvas.width = Math.round(width * sharp); canvas.height = Math.round(0.75 * width * sharp);
    const context = canvas.getContext('2d'), scale = 0.46 * Math.min(canvas.width, canvas.height) / this.reach;
    const [ct, st, cp, sp] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.tilt), Math.sin(this.tilt)];
    const place = point => {
      const [x, y, z] = point.map((value, axis) => value - this.centre[axis]);
      const along = ct * x - st * y, away = st * x + ct * y;
      return [canvas.width / 2 + scale * along, canvas.height / 2 - scale * (cp * z + sp * away)];
    };
    const line = (points, colour, thick) => {
      context.beginPath();
      points.map(place).forEach(([x, y], at) => (at ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.strokeStyle = colour; context.lineWidth = thick * sharp; context.stroke();
    };
    const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue('--soft'), metal = style.getPropertyValue('--metal-edge');
    context.lineCap = context.lineJoin = 'round';
    const floor = 0.5 * this.reach;
    for (const at of [-1, -0.5, 0, 0.5, 1]) for (const way of [[[-floor, at * floor, 0], [floor, at * floor, 0]], [[at * floor, -floor, 0], [at * floor, floor, 0]]]) { context.globalAlpha = 0.3; line(way, ink, 0.5); }
    context.globalAlpha = 1;
    const tools = arm.frames.map(frame => frame.points_mm[frame.points_mm.length - 1]);
    line(tools, ink, 1);
    line(arm.frames.map((frame, at) => tools[at].map((x, axis) => x + this.magnified * frame.error_mm[axis])), style.getPropertyValue('--bad') || '#c33', 1.5);
    const { points_mm: points, error_mm: error, time_s: time } = arm.frames[this.frame];
    line(points, metal, 5);
    points.slice(1, -1).forEach((point, joint) => {
      const [x, y] = place(point);
      context.beginPath(); context.arc(x, y, 7 * sharp, 0, 7); context.fillStyle = this.colour(joint); context.fill();
      context.lineWidth = sharp; context.strokeStyle = metal; context.stroke();
    });
    this.readout.textContent = `${formatValue(time, 3)} s, ${formatValue(Math.hypot(...error), 2)} mm off`;
    this.factor.textContent = formatValue(this.magnified, 2);
  }
}
