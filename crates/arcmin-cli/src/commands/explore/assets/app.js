// Builds the page and exchanges messages with the server.
const $ = (id) => document.getElementById(id);
const saved = $('data') ? JSON.parse($('data').textContent) : null;
const token = new URLSearchParams(location.search).get('token') || '';
const still = window.matchMedia('(prefers-reduced-motion: reduce)').matches;

const app = { state: null, answers: {}, film: null, frames: [], reached: [], pinned: null, crank: 0, age: 0, running: false, thumbs: new Map(), keysOf: '' };

async function request(path, body) {
  const options = body === undefined ? {} : { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) };
  try {
    const response = await fetch(`${path}?token=${encodeURIComponent(token)}`, options);
    const json = await response.json();
    lost('');
    return response.ok ? { json } : { error: json };
  } catch {
    lost('The server does not answer: it was ended, or is busy. Start `arcmin explore` again.');
    return { error: { error: 'the server does not answer' } };
  }
}

function lost(text) {
  $('failed').textContent = text;
  $('failed').hidden = text === '';
}

let view = null;
try {
  view = new View($('canvas'), pickedPart);
} catch {
  $('canvas').hidden = true;
  $('no-webgl').hidden = false;
}

const keys = new Keys($('key-list'), $('search'), $('found'), setKey, async (key, values) => (await request('/api/try', { key, values })).json);

// Changes: while a value is dragged there is at most one pending request; the latest value is sent after its reply.
let onItsWay = false;
let waiting = null;
async function setKey(key, value, drag) {
  if (onItsWay) {
    if (waiting) waiting.done(null);
    return new Promise((done) => { waiting = { key, value, drag, done }; });
  }
  onItsWay = true;
  const started = performance.now();
  const { json, error } = await request('/api/set', { key, value, drag });
  onItsWay = false;
  if (json) {
    take(json);
    app.lastAnswerMs = performance.now() - started;
  }
  if (waiting) {
    const next = waiting;
    waiting = null;
    setKey(next.key, next.value, next.drag).then(next.done);
  }
  return error || null;
}

/// Shows a state of the server, unless a later one is already shown.
function take(state) {
  const before = app.state;
  if (before && state.changes < before.changes) return;
  const isNew = !before || before.state !== state.state;
  app.state = state;
  if (isNew) {
    Object.assign(app, { answers: {}, reached: [], film: null, frames: [] });
  }
  for (const [name, answer] of Object.entries(state.analyses)) app.answers[name] = answer;
  $('name').textContent = state.design.name;
  document.title = `${state.design.name} – arcmin explore`;
  $('undo').disabled = !state.can_undo;
  $('redo').disabled = !state.can_redo;
  $('assumed').textContent = state.scene.assumed;
  keys.take(state.design.values);
  $('crank').max = 360 * state.scene.turns;
  $('angle-name').textContent = state.scene.angle_name;
  if (view && (!before || JSON.stringify(before.scene) !== JSON.stringify(state.scene))) {
    view.show(state.scene);
    partsShown();
  }
  const shape = Object.keys(state.design.values).join();
  if (!saved && app.keysOf !== shape) {
    app.keysOf = shape;
    request('/api/keys').then(({ json }) => json && keys.show(json, app.state.design.values, false));
  }
  show();
  if (isNew && !saved) historySoon();
  if (app.early && app.early.state === state.state) {
    const { messages } = app.early;
    app.early = null;
    messages.forEach(heard);
  }
}

/// A message of the stream. Messages about a state that is still requested are kept until its reply.
function heard(message) {
  const isPresent = app.state && message.state === app.state.state;
  if (message.news === 'state') {
    if (isPresent) app.reached = [];
    else {
      app.early = { state: message.state, messages: [] };
      if (!onItsWay) request('/api/state').then(({ json }) => json && (!app.state || json.state !== app.state.state) && take(json));
    }
    return;
  }
  if (!isPresent) {
    if (app.early && app.early.state === message.state) app.early.messages.push(message);
    return;
  }
  if (message.news === 'reached') {
    app.reached.push(message.data);
    showHours();
  } else if (message.news === 'answer') {
    if (message.name === 'film') {
      app.film = message.data.film || null;
      app.frames = framesOf(app.film);
    } else app.answers[message.name] = message.data;
    show();
    historySoon();
  } else if (message.news === 'progress') {
    const parts = Object.entries(message.data).map(([name, { stage, share }]) => `${name}: ${stage} ${Math.round(100 * share)} %`);
    $('work').textContent = parts.join(' · ');
  }
}

function listen() {
  const source = new EventSource(`/api/stream?token=${encodeURIComponent(token)}`);
  source.onmessage = (event) => { lost(''); heard(JSON.parse(event.data)); };
  source.onerror = () => lost('The connection to the server is gone; it is tried again.');
}

// Figures, findings.
const SHOWN = { profile: ['ratio', 'short_width_coefficient', 'min_convex_flank_radius_mm'],
  contact: ['max_force_n', 'max_pressure_mpa', 'loaded_pairs', 'play_arcmin', 'te_loaded_arcmin', 'torsional_stiffness_n_m_per_arcmin', 'max_output_pin_force_n', 'eccentric_bearing_force_n'],
  check: ['play_chain.total_arcmin'], rig: ['lost_motion_arcmin', 'backlash_arcmin', 'stiffness_n_m_per_arcmin', 'efficiency'],
  life: ['hours_to_limit', 'hours_to_lost_motion_limit', 'lost_motion_arcmin', 'max_depth_um'] };

function headline() {
  const found = {};
  for (const [name, wanted] of Object.entries(SHOWN)) {
    const numbers = numbersOf(app.answers[name] && app.answers[name].summary);
    const keys = wanted.flatMap((key) => app.state.scene.rings.map((ring) => ring.key + key));
    for (const key of keys) if (key in numbers) found[`${name}: ${key}`] = numbers[key];
  }
  return found;
}

function everything() {
  const found = {};
  for (const [name, answer] of Object.entries(app.answers)) {
    for (const [key, value] of Object.entries(numbersOf(answer.summary))) found[`${name}: ${key}`] = value;
  }
  return found;
}

function showResults() {
  const then = app.pinned && app.pinned.headline;
  const body = element('tbody');
  let last = '';
  for (const { key, now, then: before, change } of differences(headline(), then)) {
    const [name, figure] = key.split(': ');
    const { words, unit } = labelOf(figure);
    if (name !== last) {
      const { command, status } = app.answers[name] || { command: name };
      const report = `/api/report/${name}/${app.state.state}?token=${encodeURIComponent(token)}`;
      const link = saved || status !== 'done' ? [] : [element('a', { class: 'report', href: report, target: '_blank', rel: 'noopener', 'aria-label': `Report of ${command}` }, 'Report')];
      body.append(element('tr', {}, element('th', { colspan: 4, scope: 'colgroup', class: 'soft' }, command, ...link)));
      last = name;
    }
    const row = element('tr', { 'data-result': key }, element('th', { scope: 'row', title: key }, words), element('td', {}, `${shown(now)} ${unit}`));
    if (then) row.append(element('td', { class: 'ghost' }, shown(before)), element('td', {}, change === null ? '' : `${change > 0 ? '+' : ''}${shown(change, 3)} %`));
    body.append(row);
  }
  for (const [name, answer] of Object.entries(app.answers)) {
    if (answer.status !== 'done') {
      body.append(element('tr', {}, element('th', { scope: 'row' }, name), element('td', { class: answer.status === 'failed' ? 'words bad' : 'words soft', colspan: 3 }, [answer.error, answer.hint].filter(Boolean).join('; '))));
    }
  }
  const head = then ? [element('thead', {}, element('tr', {}, ...['figure', 'now', 'pinned', 'change'].map((text) => element('th', { scope: 'col' }, text))))] : [];
  const results = $('results');
  results.replaceChildren(...head, body);
  let all = $('all-results');
  if (!all) {
    all = element('details', { id: 'all-results' }, element('summary', {}, 'All figures'), element('table', { class: 'figures' }));
    results.after(all);
    all.addEventListener('toggle', showResults);
  }
  if (all.open) {
    const rows = differences(everything(), app.pinned && app.pinned.everything).map(({ key, now, then: before, change }) => element('tr', {},
      element('th', { scope: 'row' }, key), element('td', {}, `${shown(now, 6)} ${labelOf(key).unit}`),
      ...(app.pinned ? [element('td', { class: 'ghost' }, shown(before, 6)), element('td', {}, change === null ? '' : `${shown(change, 3)} %`)] : [])));
    all.querySelector('table').replaceChildren(element('tbody', {}, ...rows));
  }
}

function showFindings() {
  const check = app.answers.check;
  const findings = (check && check.summary && check.summary.findings) || null;
  const box = $('findings');
  box.replaceChildren();
  if (!findings) {
    box.append(element('p', { class: 'soft' }, 'being checked …'));
    return;
  }
  const bad = findings.filter((finding) => finding.severity !== 'info');
  const errors = bad.filter((finding) => finding.severity === 'error').length;
  $('headline').textContent = bad.length === 0 ? `${findings.length} checks, all passed` : `${errors} errors, ${bad.length - errors} warnings of ${findings.length} checks`;
  $('headline').className = errors > 0 ? 'bad' : bad.length > 0 ? 'caution' : 'good';
  for (const finding of bad) {
    box.append(element('div', { class: 'finding' }, element('b', { class: finding.severity === 'error' ? 'bad' : 'caution' }, `${finding.severity}: ${finding.code}`), ` ${finding.message}`,
      element('p', { class: 'soft' }, `Why: ${finding.why}. Change: ${finding.change}.`)));
  }
  const passed = findings.filter((finding) => finding.severity === 'info');
  box.append(element('details', {}, element('summary', {}, `${passed.length} passed`), ...passed.map((finding) => element('p', { class: 'finding' }, `${finding.code}: ${finding.message}`))));
}

/// Largest force and pressure over all positions, computed once per result of `contact`.
const mosts = new WeakMap();
function mostOf(film, frames) {
  if (!mosts.has(film)) mosts.set(film, { force: largest(frames(film), 'force'), pressure: largest(frames(film), 'pressure'), roller: largest(frames(film), 'force', 'rollers') });
  return mosts.get(film);
}

// The view.
function showFrame() {
  const table = lifeTable();
  const hours = table ? table.hours[app.age] : 0;
  const worn = app.age > 0 ? forcesAt(hours) : null;
  const { rings } = app.state.scene;
  let frame = null;
  const most = worn ? mostOf(app.answers.life.ages, (ages) => ages.forces.flatMap((one) => one.rings.flat().map((position) => ({ contacts: position.contacts.map(([, , force, pressure]) => ({ force, pressure })) }))))
    : mostOf(app.frames, (frames) => frames);
  if (worn) frame = pitchFrameAt(worn.rings, rings, app.crank);
  else if (app.age === 0) frame = frameAt(app.frames, app.crank);
  app.frame = frame;
  const wear = app.age > 0 ? depthsAt(app.age) : null;
  if (view) view.set({ crank: app.crank, frame, most, wear });
  showCrank();
  const words = [frame && most, worn, wear, $('wear-factor').value];
  if (app.legend && app.legend.every((one, i) => one === words[i])) return;
  app.legend = words;
  const legend = $('legend');
  legend.replaceChildren();
  const { several } = ringWords(rings);
  if (frame) legend.append(`Arrows: forces of the ${several} on the discs, up to ${shown(most.force, 4)} N. ${capital(several)} by pressure: 0 `, element('i'), ` ${shown(most.pressure, 4)} MPa. `);
  if (frame && frame.rollers && most.roller > 0) legend.append(`Rolling elements of the ${app.state.design.family === 'rv' ? 'turning-arm bearings (contact --joints bearings)' : 'eccentric bearings'} by force: 0 `, element('i'), ` ${shown(most.roller, 4)} N. `);
  if (worn) legend.append(`Forces of the state at ${shown(worn.hours, 5)} h. `);
  if (wear) legend.append(`Flank by wear: 0 `, element('i'), ` ${shown(Math.max(...wear.flat()), 3)} µm, drawn ×${$('wear-factor').value}.`);
}

/// The crank angle within the turns after which all eccentrics are in the same position again.
function crankAngle() {
  const all = 360 * app.state.scene.turns;
  return ((app.crank % all) + all) % all;
}

function showCrank() {
  const angle = crankAngle();
  if (document.activeElement !== $('crank') || app.running) $('crank').value = angle;
  $('crank-value').textContent = `${Math.round(angle)}°`;
}

function partsShown() {
  const kinds = [...new Set(app.state.scene.bodies.map((body) => body.kind))];
  const names = { housing: 'housing', pins: ringWords(app.state.scene.rings).several, disc: 'discs', shaft: 'shafts', rollers: 'rollers', carrier: app.state.design.family === 'rv' ? 'carrier' : 'output plates', gear: 'gears', output_pins: 'output pins', output_ring: 'output ring' };
  const boxes = $('parts');
  const known = boxes.dataset.kinds;
  const wanted = kinds.map((kind) => names[kind]).join();
  if (known === wanted) return;
  boxes.dataset.kinds = wanted;
  boxes.querySelectorAll('label').forEach((label) => label.remove());
  for (const kind of kinds) {
    const box = element('input', { type: 'checkbox', checked: !view.hidden.has(kind) });
    box.addEventListener('change', () => view.hide(kind, !box.checked));
    boxes.append(element('label', {}, box, ` ${names[kind]}`));
  }
}

function pickedPart(hit) {
  const card = $('part');
  if (view) view.select(hit ? hit.body.id : null);
  card.hidden = !hit;
  if (!hit) return;
  const { body, index } = hit;
  const lines = [];
  const contacts = app.frame ? app.frame.contacts : [];
  if (body.kind === 'pins') {
    const own = contacts.filter((contact) => isOn(body, contact) && contact.pin === index);
    lines.push(`${capital(ringWords([app.state.scene.rings[body.ring]]).one)} ${index}: ${own.length === 0 ? 'carries nothing at this angle' : own.map((c) => `${shown(c.force)} N and ${shown(c.pressure)} MPa on disc ${c.disc + 1}`).join(', ')}.`);
  } else if (body.kind === 'disc') {
    for (const { ring } of body.shapes.filter((shape) => shape.type === 'lobes')) {
      const own = contacts.filter((contact) => isOn({ ring, disc: body.disc }, contact));
      const most = own.reduce((best, c) => (c.force > best.force ? c : best), { force: 0 });
      const { name } = app.state.scene.rings[ring], { one, several } = ringWords([app.state.scene.rings[ring]]);
      lines.push(own.length === 0 ? 'No force is known at this angle.' : `${own.length} ${several}${name ? ` (${name})` : ''} carry at this angle, ${one} ${most.pin} most: ${shown(most.force)} N.`);
    }
  }
  const values = Object.entries(app.state.design.values).filter(([path, value]) => value !== null && body.keys.some((section) => path.startsWith(`${section}.`)));
  card.replaceChildren(element('h2', {}, body.kind === 'pins' && index !== undefined ? `${body.name}: number ${index}` : body.name), ...lines.map((text) => element('p', {}, text)),
    element('table', { class: 'figures' }, element('tbody', {}, ...values.slice(0, 14).map(([path, value]) => element('tr', {}, element('th', { scope: 'row' }, path), element('td', {}, shown(value)))))));
  if (!saved) {
    for (const section of body.keys) {
      const button = element('button', { type: 'button' }, `Keys of [${section}]`);
      button.addEventListener('click', () => keys.reveal(section));
      card.append(button, ' ');
    }
  }
}

// History.
let historyTimer = null;
function historySoon() {
  if (saved || historyTimer) return;
  historyTimer = setTimeout(async () => {
    historyTimer = null;
    thumbnail();
    const { json } = await request('/api/history');
    if (!json) return;
    $('history').replaceChildren(...json.map((one) => {
      const thumb = app.thumbs.get(one.state);
      const picture = thumb ? [element('img', { src: thumb, alt: '', width: 60, height: 40 }), ' '] : [];
      const button = element('button', { type: 'button', 'aria-current': one.present ? 'true' : null, disabled: one.present }, ...picture, one.change || 'as opened');
      button.addEventListener('click', async () => { const { json: state } = await request('/api/goto', { state: one.state }); if (state) take(state); });
      const words = [one.errors === null ? 'not checked' : one.errors > 0 ? `${one.errors} errors` : one.warnings > 0 ? `${one.warnings} warnings` : 'sound'];
      if (one.max_force_n !== null) words.push(`${shown(one.max_force_n)} N`);
      if (one.verdict !== null) words.push(one.verdict ? 'limits kept' : `first limit ${shown(one.hours_to_limit)} h`);
      return element('li', {}, button, element('span', { class: 'soft' }, words.join(', ')));
    }));
  }, 400);
}

function thumbnail() {
  if (!view || !app.state) return;
  const small = element('canvas', { width: 120, height: 80 });
  small.getContext('2d').drawImage($('canvas'), 0, 0, 120, 80);
  app.thumbs.set(app.state.state, small.toDataURL('image/jpeg', 0.7));
}

function show() {
  const pending = saved ? [] : Object.values(SHOWN).length ? ['profile', 'contact', 'check', 'life', 'rig', 'advice'].filter((name) => !app.answers[name]) : [];
  if (pending.length === 0) $('work').textContent = '';
  else if ($('work').textContent === '') $('work').textContent = `being computed: ${pending.join(', ')}`;
  showResults();
  showFindings();
  showHours();
  keys.advise(adviceOf(app.answers.advice));
}

// Controls.
$('crank').addEventListener('input', () => {
  app.crank += Number($('crank').value) - crankAngle();
  showFrame();
});
$('hours').addEventListener('input', () => { app.age = Number($('hours').value); showHours(); });
const bind = (id, name, value = (control) => control.value) => $(id).addEventListener('input', () => { if (view) view.set({ [name]: value($(id)) }); showFrame(); });
bind('magnify', 'magnify', (control) => Number(control.value));
bind('wear-factor', 'wearFactor', (control) => Number(control.value));
bind('cut', 'cut');
bind('cut-at', 'cutAt', (control) => Number(control.value));
bind('explode', 'explode', (control) => Number(control.value));
bind('colour', 'colour');
bind('arrows', 'arrows', (control) => control.checked);

if (still) $('run').textContent = 'Step';
function turnOn(before) {
  if (!app.running) return;
  const now = performance.now();
  // A turn of the crank in four seconds.
  app.crank += Math.min(now - before, 100) * 0.09;
  showFrame();
  requestAnimationFrame(() => turnOn(now));
}
$('run').addEventListener('click', () => {
  if (still) {
    app.crank += 5;
    showFrame();
    return;
  }
  app.running = !app.running;
  $('run').textContent = app.running ? 'Stop' : 'Run';
  $('run').setAttribute('aria-pressed', app.running);
  if (app.running) turnOn(performance.now());
});
$('canvas').addEventListener('keydown', (event) => { if (event.key === ' ') { event.preventDefault(); $('run').click(); } });

$('pin').addEventListener('click', () => {
  app.pinned = app.pinned ? null : { headline: headline(), everything: everything(), table: app.answers.life && app.answers.life.table, scene: app.state.scene, state: app.state.state };
  $('pin').setAttribute('aria-pressed', app.pinned !== null);
  $('pin').textContent = app.pinned ? 'Unpin' : 'Pin';
  if (view) view.ghost(app.pinned ? app.pinned.scene : null);
  show();
});

async function step(path) {
  const { json } = await request(path, {});
  if (json) take(json);
}
$('undo').addEventListener('click', () => step('/api/undo'));
$('redo').addEventListener('click', () => step('/api/redo'));
document.addEventListener('keydown', (event) => {
  const writes = /^(text|search|number)$/.test((document.activeElement && document.activeElement.type) || '');
  if (saved || writes || !(event.ctrlKey || event.metaKey)) return;
  const key = event.key.toLowerCase();
  if (key === 'z' && !event.shiftKey && !$('undo').disabled) step('/api/undo');
  else if ((key === 'y' || (key === 'z' && event.shiftKey)) && !$('redo').disabled) step('/api/redo');
  else return;
  event.preventDefault();
});

function proposedName() {
  const stem = app.state.design.file.split(/[\\/]/).pop().replace(/\.toml$/, '');
  $('save-name').value = $('save-what').value === 'toml' ? `${stem}-changed.toml` : `${stem}.html`;
  $('save-over').checked = false;
  $('save-status').textContent = '';
}
$('save').addEventListener('click', () => { proposedName(); $('save-dialog').showModal(); });
$('save-what').addEventListener('input', proposedName);
$('save-do').addEventListener('click', async () => {
  const page = $('save-what').value === 'html';
  const body = { name: $('save-name').value, overwrite: $('save-over').checked, page };
  const { json, error } = await request('/api/save', body);
  $('save-status').textContent = json ? `saved: ${json.saved}` : error.error;
});

const root = document.documentElement;
function paint(dark) {
  root.dataset.theme = dark ? 'dark' : 'light';
  $('theme').textContent = dark ? 'Light' : 'Dark';
}
paint(window.matchMedia('(prefers-color-scheme: dark)').matches);
$('theme').addEventListener('click', () => paint(root.dataset.theme !== 'dark'));
$('got-it').addEventListener('click', () => { $('first').hidden = true; $('canvas').focus(); });

// For tests in a browser.
window.explorer = { app, view, take };

if (saved) {
  document.body.classList.add('offline');
  keys.show(saved.keys, saved.state.design.values, true);
  app.film = saved.film && saved.film.film;
  $('first').replaceChildren(`Saved by arcmin ${saved.about.version} from the design ${saved.state.design.name} (${saved.about.hash.slice(0, 12)}). The view, the crank angle and the hours can be moved; the keys are shown as they were.`);
  const state = saved.state;
  app.state = null;
  const film = app.film;
  take(state);
  app.film = film;
  app.frames = framesOf(film);
  show();
} else {
  request('/api/state').then(({ json }) => {
    if (json) take(json);
    listen();
  });
}
