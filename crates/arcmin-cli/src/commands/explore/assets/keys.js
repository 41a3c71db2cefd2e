// Keys of the design as controls.
function element(name, attributes = {}, ...inside) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === true) made.setAttribute(key, '');
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(key, value);
  }
  made.append(...inside);
  return made;
}

class Keys {
  /// `set(path, value, drags)` returns an error message, or nothing.
  constructor(box, search, found, set, tryAll) {
    Object.assign(this, { box, found, set, tryAll, rows: [], values: {} });
    search.addEventListener('input', () => this.filter(search.value.trim()));
  }

  show(keys, values, readOnly) {
    this.values = values;
    this.readOnly = readOnly;
    this.box.replaceChildren();
    this.rows = [];
    const usable = keys.filter((key) => key.kind !== 'other');
    const groups = new Map([['first', usable.filter((key) => firstOf(key.path) >= 0).sort((a, b) => firstOf(a.path) - firstOf(b.path))]]);
    for (const key of usable.filter((one) => firstOf(one.path) < 0)) {
      const section = key.path.includes('.') ? key.path.split(/[.[]/)[0] : 'design';
      if (!groups.has(section)) groups.set(section, []);
      groups.get(section).push(key);
    }
    for (const [section, members] of groups) {
      if (members.length === 0) continue;
      const details = element('details', { open: section === 'first' }, element('summary', {}, section === 'first' ? 'Important keys' : `[${section}]`));
      for (const key of members) {
        const row = this.row(key);
        this.rows.push({ ...row, details });
        details.append(row.element);
      }
      this.box.append(details);
    }
    this.take(values);
    this.advise(this.advice || []);
  }

  /// Moves the keys of an advice to the front of the important ones, each with its sentence. The order is not changed
  /// while one of these controls has the focus.
  advise(advice) {
    this.advice = advice;
    for (const row of this.rows) {
      const entry = advice.find((one) => one.path === row.key.path);
      row.advised.textContent = entry ? entry.text : '';
    }
    if (this.rows.length === 0 || this.box.contains(document.activeElement)) return;
    const first = this.rows[0].details;
    for (const one of [...advice].reverse()) {
      const row = this.rows.find((known) => known.key.path === one.path);
      if (row) first.querySelector('summary').after(row.element);
    }
  }

  row(key) {
    const id = `key-${key.path.replace(/[^a-z0-9_]/gi, '-')}`;
    const unit = element('span', { class: 'unit' }, key.unit);
    const refused = element('p', { class: 'refused', role: 'alert', id: `${id}-refused` });
    const about = { 'aria-describedby': `${id}-what ${id}-refused`, disabled: this.readOnly };
    const controls = element('div', { class: 'set' });
    let take;
    let after = '';
    const send = async (value, drags) => {
      const error = await this.set(key.path, value, drags);
      refused.textContent = error ? [error.error, error.hint].filter(Boolean).join('; ') : '';
      for (const control of controls.querySelectorAll('input, select')) control.setAttribute('aria-invalid', error ? 'true' : 'false');
    };
    if (key.kind === 'number' || key.kind === 'count') {
      const number = element('input', { type: 'number', id, step: 'any', ...about });
      const slider = element('input', { type: 'range', 'aria-label': `${key.path}, slider`, ...about });
      let ends = null;
      const shade = element('div', { class: 'shade', 'aria-hidden': 'true' });
      const note = element('span', { class: 'soft', role: 'status' });
      let shaded = '';
      // Values with an invalid design, requested when the control gets the focus.
      const shadeInvalid = async () => {
        if (!ends || this.readOnly) return;
        const { min, max } = ends;
        const range = `${min} ${max} ${this.version}`;
        if (range === shaded) return;
        shaded = range;
        const count = key.kind === 'count' ? Math.min(max - min, 16) : 14;
        const at = (i) => (key.kind === 'count' ? Math.round(min + ((max - min) * i) / count) : min + ((max - min) * i) / count);
        const tryouts = await this.tryAll(key.path, Array.from({ length: count + 1 }, (_, i) => at(i)));
        if (range !== shaded || !tryouts || tryouts.length !== count + 1) { shaded = ''; return; }
        const shades = shadesOf(tryouts);
        shade.style.background = shades.length === 0 ? 'none' : `linear-gradient(90deg, ${shades.map(({ from, to }) => `transparent ${from}%, var(--bad) ${from}%, var(--bad) ${to}%, transparent ${to}%`).join(', ')})`;
        note.textContent = shades.map(({ from, to, why }) => `${shown(min + ((max - min) * from) / 100, 3)} to ${shown(min + ((max - min) * to) / 100, 3)}: ${why}`).join('. ');
      };
      slider.addEventListener('focus', shadeInvalid);
      number.addEventListener('focus', shadeInvalid);
      const parsed = () => (number.value.trim() === '' ? null : Number(number.value));
      number.addEventListener('change', () => send(parsed(), false));
      slider.addEventListener('input', () => { number.value = slider.value; send(Number(slider.value), true); });
      slider.addEventListener('change', () => { send(Number(slider.value), false); ends = null; });
      take = (value) => {
        const active = document.activeElement === slider || document.activeElement === number;
        if (document.activeElement !== number || number.value === '' || Number(number.value) !== value) number.value = value === null ? '' : String(value);
        slider.hidden = value === null;
        if (value === null) return;
        if (!ends || !active || value < ends.min || value > ends.max) {
          ends = sliderOf(key, value);
          slider.min = ends.min;
          slider.max = ends.max;
          slider.step = key.kind === 'count' ? 1 : 'any';
          if (key.kind !== 'count') slider.step = ends.step;
        }
        if (document.activeElement !== slider) slider.value = value;
      };
      number.placeholder = key.default === null ? 'left out' : String(key.default);
      controls.append(element('div', { class: 'slide' }, slider, shade), element('span', { class: 'number' }, number, unit));
      after = note;
    } else if (key.kind === 'flag') {
      const box = element('input', { type: 'checkbox', id, ...about });
      box.addEventListener('change', () => send(box.checked, false));
      take = (value) => { box.checked = value === true; };
      controls.classList.add('single');
      controls.append(element('span', {}, box));
    } else if (key.kind === 'choice') {
      const select = element('select', { id, ...about }, ...key.words.map(([word, what]) => element('option', { value: word }, `${word}: ${what}`)));
      select.addEventListener('change', () => send(select.value, false));
      take = (value) => { select.value = value === null ? '' : value; };
      controls.classList.add('single');
      controls.append(select);
    } else {
      const text = element('input', { type: 'text', id, ...about });
      text.addEventListener('change', () => send(text.value === '' && !key.required ? null : text.value, false));
      take = (value) => { if (document.activeElement !== text) text.value = value === null ? '' : value; };
      controls.classList.add('single');
      controls.append(text);
    }
    const advised = element('p', { class: 'advised' });
    const range = key.range ? ` Range ${shown(key.range[0], 6)} to ${shown(key.range[1], 6)}${key.unit ? ` ${key.unit}` : ''}.` : '';
    const row = element('div', { class: 'key', 'data-key': key.path }, element('label', { for: id }, element('code', {}, key.path)), controls,
      element('p', { class: 'what', id: `${id}-what` }, `${key.what.replace(/`/g, '')}${range}`), after, advised, refused);
    return { key, element: row, take, refused, advised };
  }

  take(values) {
    this.values = values;
    this.version = (this.version || 0) + 1;
    for (const row of this.rows) {
      row.take(values[row.key.path] === undefined ? null : values[row.key.path]);
    }
  }

  filter(search) {
    let count = 0;
    for (const row of this.rows) {
      const shownRow = search === '' || fits(row.key, search);
      row.element.hidden = !shownRow;
      count += shownRow;
      row.details.hidden = false;
    }
    for (const details of this.box.children) {
      const any = [...details.querySelectorAll('.key')].some((row) => !row.hidden);
      details.hidden = !any;
      if (search !== '') details.open = any;
    }
    this.found.textContent = search === '' ? '' : `${count} found`;
  }

  /// Scrolls to the keys of a section.
  reveal(section) {
    const row = this.rows.find((one) => one.key.path.startsWith(section));
    if (!row) return;
    row.element.closest('details').open = true;
    row.element.scrollIntoView({ block: 'nearest' });
    row.element.querySelector('input, select').focus();
  }
}
