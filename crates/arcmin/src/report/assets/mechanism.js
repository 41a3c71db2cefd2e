// The reducer to scale, turning, with its contact forces. Lengths are millimetres, y points up, angles are radians.

const TURN = 2 * Math.PI;
const polar = (radius, angle) => [radius * Math.cos(angle), radius * Math.sin(angle)];
const xy = ([x, y]) => `${x.toFixed(3)} ${(-y).toFixed(3)}`;
const ringPath = (x, y, radius) => `M${(x + radius).toFixed(3)} ${(-y).toFixed(3)}a${radius} ${radius} 0 1 0 ${-2 * radius} 0a${radius} ${radius} 0 1 0 ${2 * radius} 0Z`;
const wrapped = angle => angle - TURN * Math.floor(angle / TURN);
const degrees = angle => angle * 180 / Math.PI;
const TURNS_PER_SECOND = 0.06;

class MechanismFigure {
  constructor(figure, drawing) {
    this.figure = figure;
    this.drawing = drawing;
    this.stage = figure.querySelector('.stage');
    this.stage.textContent = '';
    this.crankAngle = 0;
    this.speed = TURNS_PER_SECOND;
    this.disc = 0;
    this.state = Math.max(0, drawing.states.length - 1);
    this.largest = Math.max(1e-9, ...drawing.states.flatMap(state => state.force_n.flat(2)));
    this.build();
    this.panel();
    tool(figure, 'SVG', `Download “${drawing.title}” as SVG`, () => saveAs(figure.dataset.file + '.svg', 'image/svg+xml', svgText(this.svg, '')));
    if (drawing.states.length) tool(figure, 'CSV', 'Download the contact forces as CSV', () => saveAs(figure.dataset.file + '.csv', 'text/csv', this.csv()));
    new IntersectionObserver(entries => { this.seen = entries[0].isIntersecting; this.tick(); }).observe(this.stage);
    this.play(!matchMedia('(prefers-reduced-motion: reduce)').matches);
  }

  // Parts of constant shape are built once; a rotation only moves them.
  build() {
    const { drawing } = this, half = drawing.housing_outer_radius_mm * 1.04;
    const svg = this.svg = svgElement('svg', { class: 'drawing', viewBox: `${-half} ${-half} ${2 * half} ${2 * half}`, role: 'img', 'aria-label': `${drawing.title}: section through the reducer to scale, with contact forces as arrows` }, this.stage);
    const ring = drawing.pin_circle_radius_mm;
    // In the view from the output side the gear stage is behind all other parts.
    this.gears = this.buildGears(svg);
    svgElement('path', { class: 'housing', 'fill-rule': 'evenodd', d: ringPath(0, 0, drawing.housing_outer_radius_mm) + ringPath(0, 0, ring) }, svg);
    this.pins = Array.from({ length: drawing.pin_count }, (_, pin) => {
      const [x, y] = polar(ring, TURN * pin / drawing.pin_count);
      return svgElement('circle', { class: 'pin', cx: x, cy: -y, r: drawing.pin_radius_mm }, svg);
    });
    svgElement('circle', { class: 'carrier', r: drawing.crankshafts.circle_radius_mm }, svg);
    this.discs = drawing.eccentric_phase_deg.map((phase, disc) => {
      const alpha = phase * Math.PI / 180, offset = -alpha / drawing.lobe_count;
      return { alpha, offset, path: svgElement('path', { class: 'disc', d: this.discPath(offset), style: `stroke:${discColour(disc)};fill:${discColour(disc)}` }, svg) };
    });
    this.cranks = drawing.crankshafts.place_deg.map((place, index) => {
      const group = svgElement('g', {}, svg);
      svgElement('circle', { class: 'shaft', r: drawing.crankshafts.shaft_radius_mm }, group);
      this.discs.forEach(({ alpha }, disc) => {
        const [x, y] = polar(drawing.eccentricity_mm, alpha);
        svgElement('circle', { class: 'eccentric', cx: x, cy: -y, r: drawing.crankshafts.eccentric_radius_mm, style: `stroke:${discColour(disc)}` }, group);
      });
      svgElement('path', { class: 'carrier-mark', d: `M0 0H${drawing.crankshafts.shaft_radius_mm}` }, group);
      return { group, place: place * Math.PI / 180, index };
    });
    this.output = svgElement('path', { class: 'carrier-mark', d: `M${ring * 0.62} 0H${ring * 0.74}` }, svg);
    this.actions = svgElement('path', { class: 'action' }, svg);
    this.forces = svgElement('g', {}, svg);
    this.pitchPoint = svgElement('circle', { class: 'pitch-point', r: 1 }, svg);
    this.longest = drawing.pin_circle_radius_mm * 0.3;
    this.scales = svgElement('g', {}, svg);
  }

  // Scale bar and sample arrow in the corners of the view, their text at the size of the other figures' text.
  drawScales(half) {
    const { drawing, scales } = this, text = 12 * 2 * half / (this.svg.clientWidth || 640);
    scales.textContent = '';
    scales.setAttribute('font-size', text);
    const bar = niceBelow(half * 0.45), x = -half + 0.04 * half, y = half - 0.04 * half, tick = 0.3 * text;
    svgElement('path', { class: 'scale', d: `M${x} ${y - tick}v${tick}h${bar}v${-tick}`, style: `stroke-width:${text / 8}` }, scales);
    svgElement('text', { x: x + bar / 2, y: y - 0.6 * text, 'text-anchor': 'middle' }, scales, `${formatValue(bar)} mm`);
    if (!drawing.states.length) return;
    const sample = niceBelow(this.largest), length = this.longest * sample / this.largest, right = half - 0.04 * half;
    this.arrow(scales, [right - length, -y + 0.2 * text], [1, 0], length, 'var(--bad)');
    svgElement('text', { x: right, y: y - text, 'text-anchor': 'end' }, scales, `${formatValue(sample)} N`);
  }

  discPath(offset) {
    const { drawing } = this, points = [];
    for (let lobe = 0; lobe < drawing.lobe_count; lobe++) {
      const angle = offset + TURN * lobe / drawing.lobe_count, [c, s] = polar(1, angle);
      for (let at = 0; at + 1 < drawing.lobe_mm.length; at += 2) {
        const x = drawing.lobe_mm[at], y = drawing.lobe_mm[at + 1];
        points.push(xy([c * x - s * y, s * x + c * y]));
      }
    }
    return 'M' + points.join('L') + 'Z' + drawing.holes.map(hole => ringPath(hole.x_mm, hole.y_mm, hole.radius_mm)).join('');
  }

  // Teeth are drawn as trapezoids with correct number and size; the involute is not visible at this scale.
  buildGears(svg) {
    const { drawing } = this, stage = drawing.gear_stage;
    const gear = (teeth, radius) => {
      const module = 2 * radius / teeth, points = [];
      for (let tooth = 0; tooth < teeth; tooth++) {
        for (const [part, height] of [[-.33, -1.25], [-.14, 1], [.14, 1], [.33, -1.25]]) points.push(xy(polar(radius + height * module, TURN * (tooth + part) / teeth)));
      }
      return 'M' + points.join('L') + 'Z';
    };
    const planet = gear(stage.planet_teeth, stage.planet_pitch_radius_mm);
    const planets = drawing.crankshafts.place_deg.map(place => {
      const gamma = place * Math.PI / 180;
      // A planet tooth faces a gap of the sun.
      const offset = gamma + Math.PI - TURN * (0.5 - stage.sun_teeth * gamma / TURN) / stage.planet_teeth;
      return { offset, path: svgElement('path', { class: 'gear', d: planet }, svg) };
    });
    const sun = svgElement('path', { class: 'gear', d: gear(stage.sun_teeth, stage.sun_pitch_radius_mm) }, svg);
    return { planets, sun };
  }

  panel() {
    const { drawing } = this, panel = htmlElement('div', { class: 'panel' }, this.stage);
    const row = htmlElement('div', { class: 'row' }, panel);
    this.playButton = htmlElement('button', { type: 'button' }, row, 'Play');
    this.playButton.addEventListener('click', () => this.play(!this.playing));
    const choose = (label, options, chosen, action) => {
      const box = htmlElement('label', { class: 'inline' }, row, label), select = htmlElement('select', {}, box);
      options.forEach((text, index) => { const option = htmlElement('option', { value: index }, select, text); option.selected = index === chosen; });
      select.addEventListener('change', () => { action(Number(select.value)); this.move(); });
    };
    if (drawing.states.length > 1) choose('State', drawing.states.map(state => state.label), this.state, value => { this.state = value; });
    if (this.discs.length > 1) choose('Forces on', this.discs.map((_, disc) => `disc ${disc + 1}`), 0, value => { this.disc = value; });
    choose('View', ['whole', 'teeth'], 0, value => { this.close = value === 1; });
    const crankLabel = htmlElement('label', {}, panel, 'Crank angle ');
    this.slider = htmlElement('input', { type: 'range', min: 0, max: 360, step: 0.5, value: 0, 'aria-label': 'Crank angle in degrees' }, crankLabel);
    this.slider.addEventListener('input', () => { this.play(false); const turns = Math.floor(-this.crankAngle / TURN); this.crankAngle = -(turns * TURN + this.slider.value * Math.PI / 180); this.move(); });
    const speedLabel = htmlElement('label', {}, panel, 'Speed '), slowed = htmlElement('output', {}, speedLabel);
    const speed = htmlElement('input', { type: 'range', min: -2.3, max: 0, step: 0.05, value: Math.log10(TURNS_PER_SECOND), 'aria-label': 'Speed of the animation' }, speedLabel);
    const crankTurnsPerSecond = Math.abs(drawing.input_speed_rpm / 60) * drawing.gear_stage.sun_teeth / (drawing.gear_stage.planet_teeth || 1) ;
    const setSpeed = () => {
      this.speed = 10 ** Number(speed.value);
      slowed.textContent = crankTurnsPerSecond > 0 ? ` slowed about ${formatValue(crankTurnsPerSecond / this.speed, 2)} times from ${formatValue(drawing.input_speed_rpm)} rpm at the input` : '';
    };
    speed.addEventListener('input', setSpeed);
    setSpeed();
    const readings = htmlElement('dl', { class: 'readings' }, panel);
    this.readings = {};
    const names = [['input', 'Input'], ['crank', 'Crankshaft'], ['output', 'Output']];
    if (drawing.states.length) names.push(['force', 'Largest force'], ['pairs', 'Pins that carry'], ['moment', 'Torque on this disc']);
    for (const [key, label] of names) { const box = htmlElement('div', {}, readings); htmlElement('dt', {}, box, label); this.readings[key] = htmlElement('dd', {}, box, ' '); }
    if (drawing.states.length) {
      const colours = htmlElement('div', {}, panel);
      htmlElement('div', {}, colours, 'Force on the pin');
      htmlElement('div', { class: 'scale-colours', style: `background:linear-gradient(90deg,${[0, .2, .4, .6, .8, 1].map(forceColour).join(',')})` }, colours);
      const ends = htmlElement('div', { class: 'scale-ends' }, colours);
      htmlElement('span', {}, ends, '0 N'); htmlElement('span', {}, ends, `${formatValue(this.largest, 3)} N`);
    }
    const key = htmlElement('ul', { class: 'key' }, panel);
    const entry = (paint, text) => { const item = htmlElement('li', {}, key); paint(svgElement('svg', { width: 16, height: 14, viewBox: '0 0 16 14', 'aria-hidden': 'true' }, item)); item.append(text); };
    this.discs.forEach((_, disc) => entry(svg => svgElement('rect', { x: 1, y: 2, width: 14, height: 10, style: `fill:${discColour(disc)};fill-opacity:.25;stroke:${discColour(disc)}` }, svg), `cycloid disc ${disc + 1}`));
    entry(svg => svgElement('circle', { cx: 8, cy: 7, r: 5.5, style: 'fill:var(--metal-2);stroke:var(--metal-edge)' }, svg), 'crankshaft');
    entry(svg => svgElement('circle', { cx: 8, cy: 7, r: 5, style: 'fill:var(--metal);stroke:var(--metal-edge);stroke-dasharray:2 1.4;stroke-width:2' }, svg), 'sun and planet gears');
    entry(svg => svgElement('path', { d: 'M0 7H16', style: 'stroke:var(--soft);stroke-width:2;stroke-dasharray:4 2' }, svg), 'carrier, circle of cranks');
    if (drawing.states.length) {
      entry(svg => svgElement('path', { d: 'M1 7H11M10 3l6 4-6 4Z', style: 'stroke:var(--bad);stroke-width:2;fill:var(--bad)' }, svg), 'force on the disc');
      entry(svg => svgElement('path', { d: 'M0 11L16 3', style: 'stroke:var(--faint)' }, svg), 'line of action');
    }
    entry(svg => svgElement('circle', { cx: 8, cy: 7, r: 4, style: 'fill:var(--card);stroke:var(--ink);stroke-width:1.6' }, svg), 'pitch point');
  }

  // Force of every pin: the table holds one pin pitch of crank angle, after which each force acts on the next pin.
  forcesAt(disc) {
    const { drawing } = this, state = drawing.states[this.state], count = drawing.pin_count;
    if (!state || !state.force_n[disc] || !state.force_n[disc].length) return null;
    const rows = state.force_n[disc], pitches = wrapped(this.crankAngle) / (TURN / count);
    const shift = Math.floor(pitches), place = (pitches - shift) * rows.length, row = Math.min(rows.length - 1, Math.floor(place)), part = place - row;
    const value = (step, pin) => step < rows.length ? rows[step][((pin - shift) % count + count) % count] : rows[0][((pin - shift - 1) % count + count) % count];
    return Array.from({ length: count }, (_, pin) => (1 - part) * value(row, pin) + part * value(row + 1, pin));
  }

  arrow(parent, from, direction, length, colour) {
    const head = Math.min(2.6, length * 0.5), stem = length - head, [dx, dy] = direction;
    const point = (along, across) => [from[0] + along * dx - across * dy, from[1] + along * dy + across * dx];
    svgElement('path', { class: 'force', d: `M${xy(from)}L${xy(point(stem + head * 0.2, 0))}`, style: `stroke:${colour}` }, parent);
    svgElement('path', { class: 'force-head', d: `M${xy(point(length, 0))}L${xy(point(stem, head * 0.42))}L${xy(point(stem, -head * 0.42))}Z`, style: `fill:${colour}` }, parent);
  }

  move() {
    const { drawing, crankAngle } = this, stage = drawing.gear_stage, carrierAngle = -crankAngle / drawing.lobe_count;
    const sunAngle = carrierAngle - stage.planet_teeth / stage.sun_teeth * (crankAngle - carrierAngle);
    const put = (element, [x, y], angle) => element.setAttribute('transform', `translate(${xy([x, y])}) rotate(${(-degrees(angle)).toFixed(4)})`);
    this.discs.forEach(({ alpha, path }, disc) => { put(path, polar(drawing.eccentricity_mm, crankAngle + alpha), carrierAngle); path.classList.toggle('chosen', disc === this.disc); });
    for (const { group, place, index } of this.cranks) {
      const centre = polar(drawing.crankshafts.circle_radius_mm, place + carrierAngle);
      put(group, centre, crankAngle);
      put(this.gears.planets[index].path, centre, crankAngle + this.gears.planets[index].offset);
    }
    put(this.gears.sun, [0, 0], sunAngle);
    put(this.output, [0, 0], carrierAngle);
    this.drawForces();
    this.slider.value = degrees(wrapped(-crankAngle));
    const turned = (key, angle) => { this.readings[key].textContent = formatAngle(angle); };
    turned('input', sunAngle); turned('crank', crankAngle); turned('output', carrierAngle);
    this.frameView();
  }

  drawForces() {
    const { drawing, crankAngle } = this, { alpha } = this.discs[this.disc], forces = this.forcesAt(this.disc);
    const pitch = polar(drawing.eccentricity_mm * drawing.pin_count, crankAngle + alpha), centre = polar(drawing.eccentricity_mm, crankAngle + alpha);
    this.pitchPoint.setAttribute('cx', pitch[0]); this.pitchPoint.setAttribute('cy', -pitch[1]);
    this.pitchPoint.style.stroke = discColour(this.disc);
    this.forces.textContent = '';
    this.loadCentre = null;
    if (!forces) { this.pins.forEach(pin => { pin.style.fill = 'var(--card)'; }); return; }
    let lines = '', largest = 0, pairs = 0, moment = 0, sum = [0, 0], weight = 0;
    this.pins.forEach((element, pin) => {
      const force = forces[pin];
      element.style.fill = force > 0 ? forceColour(force / this.largest) : 'var(--card)';
      if (!(force > 0)) return;
      const at = polar(drawing.pin_circle_radius_mm, TURN * pin / drawing.pin_count), toPitch = [pitch[0] - at[0], pitch[1] - at[1]];
      const distance = Math.hypot(...toPitch), normal = [toPitch[0] / distance, toPitch[1] / distance];
      const contact = [at[0] + drawing.pin_radius_mm * normal[0], at[1] + drawing.pin_radius_mm * normal[1]];
      lines += `M${xy(at)}L${xy(pitch)}`;
      largest = Math.max(largest, force); pairs++;
      moment += ((contact[0] - centre[0]) * normal[1] - (contact[1] - centre[1]) * normal[0]) * force / 1000;
      sum = [sum[0] + at[0] * force, sum[1] + at[1] * force]; weight += force;
      this.arrow(this.forces, contact, normal, Math.max(0.4, this.longest * force / this.largest), 'var(--bad)');
    });
    this.actions.setAttribute('d', lines || 'M0 0');
    if (weight) this.loadCentre = [sum[0] / weight, sum[1] / weight];
    this.readings.force.textContent = `${formatValue(largest, 3)} N`;
    this.readings.pairs.textContent = `${pairs} of ${drawing.pin_count}`;
    this.readings.moment.textContent = `${formatValue(moment, 4)} N·m`;
  }

  // The enlarged view moves with the loaded teeth.
  frameView() {
    const half = this.drawing.housing_outer_radius_mm * 1.04, size = this.close && this.loadCentre ? half * 0.36 : half;
    const [x, y] = this.close && this.loadCentre ? this.loadCentre : [0, 0];
    this.svg.setAttribute('viewBox', `${x - size} ${-y - size} ${2 * size} ${2 * size}`);
    this.scales.setAttribute('transform', `translate(${x} ${-y})`);
    const drawn = `${size} ${this.svg.clientWidth}`;
    if (drawn !== this.drawnScales) { this.drawnScales = drawn; this.drawScales(size); }
  }

  csv() {
    let text = csvLine(['state', 'disc', 'crank angle [°]', 'pin', 'force [N]']);
    for (const state of this.drawing.states) state.force_n.forEach((rows, disc) => rows.forEach((row, step) => row.forEach((force, pin) => {
      if (force > 0) text += csvLine([state.label, disc + 1, 360 / this.drawing.pin_count * step / rows.length, pin, force]);
    })));
    return text;
  }

  play(on) {
    this.playing = on;
    this.playButton.textContent = on ? 'Pause' : 'Play';
    this.last = null;
    this.tick();
  }

  tick() {
    if (this.waiting || !this.playing || !this.seen) return;
    this.waiting = true;
    requestAnimationFrame(now => {
      this.waiting = false;
      // A forward input turns the crankshafts backwards.
      if (this.last !== null) this.crankAngle -= TURN * this.speed * Math.min(0.1, (now - this.last) / 1000);
      this.last = now;
      this.move();
      this.tick();
    });
  }

  draw() { this.move(); }
}

const discColour = disc => `var(--s${[0, 4, 2][disc % 3]})`;
const forceColour = part => ramp(0.95 - 0.7 * part);
const formatAngle = angle => (angle < -5e-4 ? MINUS : '') + Math.abs(degrees(angle)).toFixed(1) + '°';
// 1, 2 or 5 times a power of ten, at most three quarters of `value`.
function niceBelow(value) {
  const decade = 10 ** Math.floor(Math.log10(value * 0.75));
  return ([5, 2, 1].find(factor => factor * decade <= value * 0.75) || 1) * decade;
}
