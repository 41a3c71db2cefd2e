// The drive as solids; in a browser without three-dimensional graphics the drawing in its place.

class SolidsFigure {
  constructor(figure, data) {
    if (!document.createElement('canvas').getContext('webgl2')) {
      figure.classList.add('mechanism');
      if (data.instead) return new MechanismFigure(figure, data.instead);
      figure.querySelector('.stage').textContent = 'This browser shows no three-dimensional graphics (WebGL 2).';
      Object.assign(this, { figure, stage: figure.querySelector('.stage') });
      return;
    }
    Object.assign(this, { figure, data, stage: figure.querySelector('.stage'), crank: 0, state: Math.max(0, data.states.length - 1) });
    this.stage.textContent = '';
    const box = htmlElement('div', { class: 'solid' }, this.stage);
    const label = `${data.title}, in three dimensions. Arrow keys turn, shift and arrow keys move, plus and minus zoom, Home resets.`;
    const canvas = htmlElement('canvas', { tabindex: 0, role: 'img', 'aria-label': label }, box);
    this.view = new Solid.View(canvas, () => {});
    this.view.amongText();
    this.view.show(data.scene);
    this.panel();
    const frames = data.states.flatMap(state => state.rings.flat().map(position => ({ contacts: position.contacts.map(([, , force, pressure]) => ({ force, pressure })) })));
    this.most = { force: Solid.largest(frames, 'force'), pressure: Solid.largest(frames, 'pressure') };
    if (data.states.length) tool(figure, 'CSV', 'Download the contact forces as CSV', () => saveAs(figure.dataset.file + '.csv', 'text/csv', this.csv()));
    new IntersectionObserver(entries => { this.seen = entries[0].isIntersecting; this.tick(); }).observe(this.stage);
    this.move();
  }

  panel() {
    const { data } = this, row = htmlElement('div', { class: 'row' }, this.stage);
    this.button = htmlElement('button', { type: 'button', 'aria-pressed': false }, row, 'Run');
    this.button.addEventListener('click', () => { this.running = !this.running; this.button.textContent = this.running ? 'Stop' : 'Run'; this.button.setAttribute('aria-pressed', this.running); this.tick(); });
    const control = (words, kind, attributes, then, options = []) => {
      const made = htmlElement(kind, attributes, htmlElement('label', { class: 'inline' }, row, `${words} `));
      options.forEach(([value, text], index) => { const option = htmlElement('option', { value }, made, text); option.selected = index === options.length - 1; });
      made.addEventListener('input', () => then(made.value));
      return made;
    };
    if (data.states.length > 1) control('State', 'select', {}, value => { this.state = Number(value); this.move(); }, data.states.map((state, index) => [index, state.label]));
    this.slider = control(data.scene.angle_name, 'input', { type: 'range', min: 0, max: 360 * data.scene.turns, step: 1, value: 0 }, value => { this.crank = Number(value); this.move(); });
    control('Cut', 'select', {}, value => this.view.set({ cut: value }), [['along', 'along the axis'], ['none', 'none'], ['across', 'across the axis']]);
    control('at', 'input', { type: 'range', min: 0, max: 100, value: this.view.state.cutAt, 'aria-label': 'Place of the cut in percent' }, value => this.view.set({ cutAt: Number(value) }));
    control('Explode', 'input', { type: 'range', min: 0, max: 100, value: 0 }, value => this.view.set({ explode: Number(value) }));
    this.words = htmlElement('p', { class: 'words' }, this.stage);
  }

  // A turn of the crank in four seconds.
  tick() {
    if (!this.running || !this.seen || this.requested) return;
    this.requested = true;
    const before = performance.now();
    requestAnimationFrame(() => {
      this.requested = false;
      this.crank += Math.min(performance.now() - before, 100) * 0.09;
      this.move();
      this.tick();
    });
  }

  move() {
    const { data, most } = this, state = data.states[this.state], all = 360 * data.scene.turns;
    this.slider.value = ((this.crank % all) + all) % all;
    if (!state) { this.view.set({ crank: this.crank }); return; }
    const wear = state.depth_um.some(depths => Math.max(0, ...depths) > 0) ? state.depth_um : null;
    const frame = Solid.pitchFrameAt(state.rings, data.scene.rings, this.crank);
    this.view.set({ crank: this.crank, wear, frame, most });
    const { several } = Solid.ringWords(data.scene.rings);
    const words = [`Arrows: forces of the ${several} on the discs, up to ${formatValue(most.force, 4)} N. ${Solid.capital(several)} by pressure, up to ${formatValue(most.pressure, 4)} MPa.`,
      `At this angle ${frame.contacts.length} contacts carry, ${formatValue(Solid.largest([frame], 'force'), 4)} N and ${formatValue(Solid.largest([frame], 'pressure'), 4)} MPa at most.`];
    if (wear) words.push(`Flank by wear, up to ${formatValue(Math.max(...wear.flat()), 3)} µm, drawn ×${this.view.state.wearFactor}.`);
    this.words.textContent = words.join(' ');
  }

  csv() {
    let text = csvLine(['state', 'ring', 'disc', 'eccentric angle [°]', Solid.ringWords(this.data.scene.rings).one, 'force [N]', 'pressure [MPa]']);
    for (const state of this.data.states) state.rings.forEach((positions, ring) => positions.forEach(({ contacts }, step) => contacts.forEach(([disc, pin, force, pressure]) => {
      text += csvLine([state.label, ring + 1, disc + 1, 360 / this.data.scene.rings[ring].pin_count * step / positions.length, pin, force, pressure]);
    })));
    return text;
  }

  draw() { if (this.view) this.view.redraw(); }
}
