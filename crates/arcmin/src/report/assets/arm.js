// An arm that moves along its programs. Joints are coloured by their shares of the error; the error of the path is magnified.
// In a browser without three-dimensional graphics it is drawn flat. Lengths are millimetres, z points up.

const ARM_PACES = [0.1, 0.25, 0.5, 1, 2, 4];
const ARM_LOOKS = 'Drag or use the arrow keys to turn it';

/// Lines on a canvas, in a view that can be rotated.
class ArmLines {
  constructor(stage, data, ball) {
    Object.assign(this, { ball, turn: -0.6, tilt: 0.35 });
    this.canvas = htmlElement('canvas', { class: 'flat', role: 'img', tabindex: 0, 'aria-label': `${data.title}. ${ARM_LOOKS}.` }, stage);
    this.canvas.addEventListener('pointerdown', event => { this.drag = [event.clientX, event.clientY]; this.canvas.setPointerCapture(event.pointerId); });
    this.canvas.addEventListener('pointermove', event => {
      if (!this.drag) return;
      this.rotate((event.clientX - this.drag[0]) * 0.01, (event.clientY - this.drag[1]) * 0.01);
      this.drag = [event.clientX, event.clientY];
    });
    this.canvas.addEventListener('pointerup', () => { this.drag = null; });
    this.canvas.addEventListener('keydown', event => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (step) { event.preventDefault(); this.rotate(...step); }
    });
    this.known = {};
  }

  rotate(turn, tilt) { this.turn += turn; this.tilt = Math.min(1.5, Math.max(-1.5, this.tilt + tilt)); this.draw(); }

  set(change) { Object.assign(this.known, change); this.draw(); }

  paint(colours) { this.colours = colours; this.draw(); }

  draw() {
    const { canvas, ball, colours, known: { links, joints, way, reached, now } } = this, width = canvas.clientWidth, sharp = Math.max(2, window.devicePixelRatio || 1);
    if (!width || !colours || !links) return;
    canvas.width = Math.round(width * sharp); canvas.height = Math.round(0.75 * width * sharp);
    const context = canvas.getContext('2d'), scale = 0.48 * Math.min(canvas.width, canvas.height) / ball.radius;
    const [ct, st, cp, sp] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.tilt), Math.sin(this.tilt)];
    const place = point => {
      const [x, y, z] = point.map((value, axis) => value - ball.middle[axis]);
      return [canvas.width / 2 + scale * (ct * x - st * y), canvas.height / 2 - scale * (cp * z + sp * (st * x + ct * y))];
    };
    const line = (points, colour, thick) => {
      context.beginPath();
      points.map(place).forEach(([x, y], at) => (at ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.strokeStyle = colour; context.lineWidth = thick * sharp; context.stroke();
    };
    const dot = (point, colour, size) => {
      const [x, y] = place(point);
      context.beginPath(); context.arc(x, y, size * sharp, 0, 7); context.fillStyle = colour; context.fill();
    };
    context.lineCap = context.lineJoin = 'round';
    const floor = Solid.gridStep(2 * ball.radius) * 2;
    context.globalAlpha = 0.3;
    for (const at of [-1, -0.5, 0, 0.5, 1]) for (const one of [[[-floor, at * floor, 0], [floor, at * floor, 0]], [[at * floor, -floor, 0], [at * floor, floor, 0]]]) line(one, colours.grid, 0.5);
    context.globalAlpha = 1;
    line(way, colours.way, 1);
    line(reached, colours.reached, 1.5);
    const places = links.map(frame => frame.slice(9));
    line([[0, 0, 0], ...places, now[0]], colours.metal, 5);
    places.forEach((point, joint) => { dot(point, colours.edge, 8); dot(point, joints[joint], 7); });
    line(now, colours.reached, 1.5);
    dot(now[1], colours.reached, 3);
  }
}

class ArmFigure {
  constructor(figure, data) {
    const { arm, programs, hours } = data;
    Object.assign(this, { figure, data, stage: figure.querySelector('.stage'), time: 0, pace: 1, program: 0, age: hours.length - 1, factor: data.magnified, from: 'worst', whole: true });
    this.stage.textContent = '';
    this.ways = programs.map(program => Solid.wayOf(arm, program));
    const places = programs.flatMap(program => program.time_s.filter((_, i) => i % 20 === 0).map((_, i) => Solid.postureOf(arm, program.angles_deg.slice(20 * i * arm.links.length)).links.map(frame => frame.slice(9)))).flat();
    const ball = Solid.ballAround([[0, 0, 0], ...places, ...this.ways.flat()]);
    this.solid = Boolean(document.createElement('canvas').getContext('webgl2'));
    if (this.solid) {
      const box = htmlElement('div', { class: 'solid' }, this.stage);
      const label = `${data.title}, in three dimensions. ${ARM_LOOKS}; shift and arrow keys move, plus and minus zoom, Home resets.`;
      this.canvas = htmlElement('canvas', { tabindex: 0, role: 'img', 'aria-label': label }, box);
      this.view = new Solid.ArmView(this.canvas);
      this.view.amongText();
      this.view.show(arm, ball, Math.max(...programs.map(program => program.time_s.length)));
    } else {
      this.view = new ArmLines(this.stage, data, ball);
      this.canvas = this.view.canvas;
    }
    this.grid = Solid.gridStep(2 * ball.radius);
    this.panel();
    tool(figure, 'PNG', `Download “${data.title}” as picture`, () => this.canvas.toBlob(blob => {
      htmlElement('a', { download: figure.dataset.file + '.png', href: URL.createObjectURL(blob) }).click();
    }));
    tool(figure, 'CSV', 'Download the way of the tool as CSV', () => saveAs(figure.dataset.file + '.csv', 'text/csv', this.csv()));
    new IntersectionObserver(entries => { this.seen = entries[0].isIntersecting; this.tick(); }).observe(this.stage);
    this.play(!matchMedia('(prefers-reduced-motion: reduce)').matches);
  }

  panel() {
    const { data } = this, row = htmlElement('div', { class: 'row' }, this.stage);
    this.button = htmlElement('button', { type: 'button' }, row, 'Play');
    this.button.addEventListener('click', () => this.play(!this.playing));
    const slider = (words, attributes, then) => {
      const label = htmlElement('label', {}, row, `${words} `), made = htmlElement('input', { type: 'range', ...attributes }, label);
      const output = htmlElement('output', {}, label);
      made.addEventListener('input', () => then(Number(made.value)));
      return [made, output];
    };
    const choice = (words, chosen, options, then) => {
      const made = htmlElement('select', {}, htmlElement('label', {}, row, `${words} `));
      for (const [value, text] of options) htmlElement('option', { value, ...(value === chosen ? { selected: '' } : {}) }, made, text);
      made.addEventListener('input', () => then(made.value));
    };
    if (data.programs.length > 1) choice('Program', 0, data.programs.map((program, index) => [index, program.name]), value => { this.program = Number(value); this.time = 0; this.whole = true; this.draw(); });
    [this.slider, this.clock] = slider('Time', { min: 0, step: 'any', value: 0, class: 'long' }, value => { this.play(false); this.time = value; this.draw(); });
    choice('Pace', 1, ARM_PACES.map(pace => [pace, `${formatValue(pace, 2)} ×`]), value => { this.pace = Number(value); });
    [, this.age_said] = slider('Hours', { min: 0, max: data.hours.length - 1, step: 1, value: this.age }, value => { this.age = value; this.whole = true; this.draw(); });
    [, this.factor_said] = slider('Error', { min: 0, max: 3, step: 0.05, value: Math.log10(this.factor) }, value => { this.factor = Solid.magnificationAt(value); this.whole = true; this.draw(); });
    choice('Shares', 'worst', [['worst', 'at the test pose that is off most'], ['now', 'at this moment']], value => { this.from = value; this.draw(); });
    this.key = htmlElement('div', { class: 'row key' }, this.stage);
    this.swatches = data.arm.links.map(link => {
      const one = htmlElement('span', {}, this.key);
      return [htmlElement('i', {}, one), htmlElement('span', {}, one), link.name];
    });
    const scale = htmlElement('span', { class: 'scale' }, this.key);
    htmlElement('span', {}, scale, '0');
    htmlElement('b', { style: `background:linear-gradient(to right,${[0, 0.2, 0.4, 0.6, 0.8, 1].map(ramp).join(',')})` }, scale);
    this.most_said = htmlElement('span', {}, scale);
    this.words = htmlElement('p', { class: 'words' }, this.stage);
  }

  play(playing) { this.playing = playing; this.button.textContent = playing ? 'Stop' : 'Play'; this.button.setAttribute('aria-pressed', playing); this.since = null; this.tick(); }

  tick() {
    if (!this.playing || !this.seen || this.requested) return;
    this.requested = true;
    requestAnimationFrame(now => {
      this.requested = false;
      if (!this.playing || !this.seen) { this.since = null; return; }
      this.time += this.since ? this.pace * Math.min(now - this.since, 200) / 1000 : 0;
      this.since = now;
      if (this.time > this.end()) this.time = 0;
      this.move();
      this.tick();
    });
  }

  end() { const { time_s: times } = this.data.programs[this.program]; return times[times.length - 1]; }

  /// Draws the parts that do not depend on the time, then the present moment.
  draw() {
    const { data, view } = this, root = document.documentElement, { theme, printing } = root.dataset;
    const style = getComputedStyle(root), colour = name => style.getPropertyValue(name).trim();
    if (printing) root.dataset.theme = 'light';
    view.paint({ metal: colour(this.solid ? '--metal-2' : '--metal'), grid: colour('--soft'), way: colour('--ink'), reached: colour('--bad'), edge: colour('--metal-edge') });
    root.dataset.theme = theme;
    if (this.whole) {
      const way = this.ways[this.program], program = data.programs[this.program];
      view.set({ way, reached: Solid.reachedWay(way, program.states[this.age].error_um, this.factor), now: [way[0], way[0]] });
      this.whole = false;
      this.slider.max = this.end();
    }
    this.factor_said.textContent = `× ${formatValue(this.factor, 2)}`;
    this.age_said.textContent = this.age ? `${formatValue(data.hours[this.age], 5)} h` : 'new';
    this.move();
  }

  /// Shares of the joints in mm, and the largest over all hours.
  shares(moment) {
    const { data, from, age } = this, { states } = data.programs[this.program], count = data.arm.links.length;
    if (from === 'worst') return [data.shares_um[age].map(share => share / 1e3), Math.max(...data.shares_um.flat().map(Math.abs)) / 1e3];
    const most = states.reduce((most, { share_um: all }) => all.reduce((most, share) => Math.max(most, Math.abs(share)), most), 0);
    return [Solid.readAt(states[age].share_um, count, moment).map(share => share / 1e3), most / 1e3];
  }

  move() {
    const { data, time, factor } = this, program = data.programs[this.program], count = data.arm.links.length;
    const moment = Solid.momentAt(program.time_s, time), error = Solid.readAt(program.states[this.age].error_um, 3, moment).map(x => x / 1e3);
    const { links, tool: at } = Solid.postureOf(data.arm, Solid.readAt(program.angles_deg, count, moment));
    const [shares, most] = this.shares(moment), colours = shares.map(share => ramp(most > 0 ? Math.abs(share) / most : 0));
    this.view.set({ links, joints: colours, now: [at, at.map((x, axis) => x + factor * error[axis])] });
    this.swatches.forEach(([swatch, words, name], joint) => { swatch.style.background = colours[joint]; words.textContent = `${name} ${formatValue(shares[joint], 2)} mm`; });
    this.most_said.textContent = `${formatValue(most, 2)} mm`;
    this.slider.value = time;
    this.clock.textContent = `${time.toFixed(2)} s`;
    const sign = x => formatValue(Number(x.toFixed(4)), 3);
    this.words.textContent = `At this moment the tool is ${formatValue(Math.hypot(...error), 3)} mm off: x ${sign(error[0])}, y ${sign(error[1])}, z ${sign(error[2])} mm. The grid lies in the plane of the base; its squares are ${formatValue(this.grid, 3)} mm wide.`;
  }

  csv() {
    const { data, age } = this;
    let text = csvLine(['program', 'hours [h]', 'time [s]', ...['x', 'y', 'z'].map(axis => `commanded ${axis} [mm]`), ...['x', 'y', 'z'].map(axis => `off ${axis} [mm]`)]);
    data.programs.forEach((program, index) => program.time_s.forEach((time, i) => {
      const error = program.states[age].error_um.slice(3 * i, 3 * i + 3).map(x => x / 1e3);
      text += csvLine([program.name, data.hours[age], time, ...this.ways[index][i].map(x => Number(x.toFixed(3))), ...error]);
    }));
    return text;
  }
}
