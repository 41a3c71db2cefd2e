// What computes and touches neither page nor graphics.
const TURN = Math.PI / 180;

/// Place (mm) and turn (rad) of a body at a crank angle, as arcmin::scene::Motion::at.
function poseAt(motion, crankDeg) {
  let x = 0;
  let y = 0;
  for (const arm of motion.arms) {
    const angle = (arm.angle_deg + arm.rate * crankDeg) * TURN;
    x += arm.length_mm * Math.cos(angle);
    y += arm.length_mm * Math.sin(angle);
  }
  return { x, y, turn: (motion.turn_deg + motion.turn_rate * crankDeg) * TURN };
}

/// Depth at a meshing angle in degrees from samples over −180° … 180°.
function depthAt(samples, angleDeg) {
  if (!samples || samples.length === 0) return 0;
  const wrapped = ((((angleDeg + 180) % 360) + 360) % 360) / 360 * (samples.length - 1);
  const low = Math.min(Math.floor(wrapped), samples.length - 2);
  return samples[low] + (samples[low + 1] - samples[low]) * (wrapped - low);
}

/// Rows of contact.csv by crank position: the film of one turn.
function framesOf(film) {
  if (!film || !film.crank_angle_deg) return [];
  const frames = film.crank_angle_deg.map((crank, i) => ({ crank, te: film.te_loaded_arcmin[i], contacts: [] }));
  const { crank_angle_deg: cranks, disc, pin, force_n: force, pressure_mpa: pressure } = film.contacts;
  let at = 0;
  for (let row = 0; row < cranks.length; row += 1) {
    while (at < frames.length - 1 && Math.abs(frames[at].crank - cranks[row]) > 1e-9) at += 1;
    if (force[row] > 0) frames[at].contacts.push({ disc: disc[row], pin: pin[row], force: force[row], pressure: pressure[row] });
  }
  return frames;
}

/// The position of a film of one whole turn nearest to a crank angle.
function frameAt(frames, crankDeg) {
  if (frames.length === 0) return null;
  const turn = (((crankDeg % 360) + 360) % 360) / 360;
  return frames[Math.round(turn * frames.length) % frames.length];
}

/// A position known over one pin pitch only, at any crank angle: one pitch later the same forces act on the next pin.
function pitchFrameAt(positions, pinCount, crankDeg) {
  if (!positions || positions.length === 0) return null;
  const pitch = 360 / pinCount;
  const count = Math.floor(crankDeg / pitch + 1e-9);
  const index = Math.round((crankDeg / pitch - count) * positions.length);
  const moved = count + (index === positions.length ? 1 : 0);
  const from = positions[index % positions.length];
  const wrap = (pin) => (((pin + moved) % pinCount) + pinCount) % pinCount;
  return {
    crank: crankDeg, te: from.te_arcmin,
    contacts: from.contacts.map(([disc, pin, force, pressure]) => ({ disc, pin: wrap(pin), force, pressure })),
  };
}

function largest(frames, what) {
  let most = 0;
  for (const frame of frames) for (const contact of frame.contacts) most = Math.max(most, contact[what]);
  return most;
}

/// Where a pin stands and in which direction it presses the disc: the lines of action meet in the pitch point, e z_p from
/// the middle of the ring. `side` tells the disc from the far end of the line.
function pressOf(teeth, disc, pin, crankDeg) {
  const place = (2 * Math.PI * pin) / teeth.pin_count;
  const at = { x: teeth.pin_circle_radius_mm * Math.cos(place), y: teeth.pin_circle_radius_mm * Math.sin(place) };
  const crank = (crankDeg + teeth.phases_deg[disc]) * TURN;
  const reach = teeth.eccentricity_mm * teeth.pin_count;
  const dx = reach * Math.cos(crank) - at.x;
  const dy = reach * Math.sin(crank) - at.y;
  const length = Math.hypot(dx, dy);
  return { x: at.x, y: at.y, dx: dx / length, dy: dy / length };
}

/// Viridis from 0 to 1, as three numbers from 0 to 1.
const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function ramp(share) {
  const t = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1);
  const low = Math.min(Math.floor(t), RAMP.length - 2);
  return RAMP[low].map((c, i) => (c + (RAMP[low + 1][i] - c) * (t - low)) / 255);
}

/// A number as a reader wants it.
function shown(value, digits = 4) {
  if (value === null || value === undefined) return '–';
  if (typeof value === 'boolean') return value ? 'yes' : 'no';
  if (typeof value !== 'number') return String(value);
  if (!Number.isFinite(value)) return '–';
  if (Number.isInteger(value) && Math.abs(value) <= 1e7) return String(value).replace('-', '−');
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4 ? value.toExponential(digits - 1).replace(/\.?0+e/, 'e') : Number(value.toPrecision(digits)).toString();
  return text.replace(/-/g, '−');
}

/// Ends and step of a key's slider: around its value, within what the schema allows.
function sliderOf(key, value) {
  const [low, high] = key.range;
  if (key.kind === 'count') {
    const span = Math.max(5, Math.round(Math.abs(value) * 0.25));
    return { min: Math.max(Math.ceil(low), value - span), max: Math.min(Math.floor(high), value + span), step: 1 };
  }
  let [min, max] = value === 0 ? [low < 0 ? Math.max(low, -10) : 0, Math.min(high, 20)] : [value - 0.5 * Math.abs(value), value + 0.5 * Math.abs(value)];
  min = Math.max(min, low);
  max = Math.min(max, high);
  const step = 10 ** Math.floor(Math.log10((max - min) / 100 || 1));
  const floor = Math.ceil(min / step - 1e-9) * step;
  const round = (x) => Number(x.toPrecision(12));
  return { min: round(Math.max(floor, low)), max: round(max), step: round(step) };
}

/// Unit and words of a result by its key: `max_force_n` is "max force" in N.
const UNITS = [['_n_m_per_arcmin', 'N·m/arcmin'], ['_arcmin', 'arcmin'], ['_n_m', 'N·m'], ['_mpa', 'MPa'], ['_deg', '°'], ['_um', 'µm'], ['_mm', 'mm'], ['_n', 'N'], ['_h', 'h'], ['_w', 'W'], ['_c', '°C'], ['_rpm', 'rpm'], ['_per_pa', '1/Pa']];
function labelOf(path) {
  const key = path.split('.').pop();
  const unit = UNITS.find(([ending]) => key.endsWith(ending)) || ['', ''];
  const words = key.slice(0, key.length - unit[0].length).replace(/_/g, ' ').replace(/\bte\b/, 'TE').replace(/^./, (c) => c.toUpperCase());
  return { words, unit: unit[1] };
}

/// Numbers of an answer's summary by dotted key.
function numbersOf(summary, prefix = '') {
  const found = {};
  for (const [key, value] of Object.entries(summary || {})) {
    const path = prefix ? `${prefix}.${key}` : key;
    if (typeof value === 'number') found[path] = value;
    else if (value && typeof value === 'object' && !Array.isArray(value)) Object.assign(found, numbersOf(value, path));
  }
  return found;
}

/// Rows of the comparison: present and pinned value, and the change in percent where it has a meaning.
function differences(now, then) {
  const keys = [...new Set([...Object.keys(now), ...Object.keys(then || {})])];
  return keys.map((key) => {
    const [a, b] = [now[key], then ? then[key] : undefined];
    const change = typeof a === 'number' && typeof b === 'number' && b !== 0 ? (100 * (a - b)) / Math.abs(b) : null;
    return { key, now: a, then: b, change };
  });
}

/// Whether a key fits what is searched: every word is somewhere in its name, meaning or unit.
function fits(key, search) {
  const text = `${key.path} ${key.what} ${key.unit}`.toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

/// Keys that move the figures most and that a designer chooses, the first ones first.
const FIRST = ['load.rated_torque_n_m', 'load.input_speed_rpm', 'ring.pin_count', 'ring.pin_circle_radius_mm', 'ring.pin_radius_mm',
  'crankshafts.eccentricity_mm', 'eccentric.eccentricity_mm', 'disc.width_mm', 'disc.modification.equidistant_offset_um', 'disc.modification.radial_offset_um',
  'bearings.turning_arm.clearance_um', 'bearings.turning_arm.roller_length_mm', 'bearings.turning_arm.roller_diameter_mm', 'bearings.eccentric.clearance_um',
  'output_pins.hole_clearance_um', 'output_pins.circle_radius_mm', 'gear_stage.backlash_um', 'crankshafts.shaft_diameter_mm', 'thermal.temperature_c',
  'thermal.housing_temperature_c', 'wear.coefficient_per_pa', 'limits.lost_motion_arcmin', 'limits.service_life_h'];
function isFirst(path) {
  return FIRST.includes(path);
}

/// Where a body goes along the axis when the drive is taken apart, in lengths of the drive.
function apartOf(body, discs) {
  const own = body.disc === null ? 0 : 0.8 * (body.disc - (discs - 1) / 2);
  switch (body.kind) {
    case 'gear': return -2.4;
    case 'shaft': return -1.5;
    case 'disc': return own + 0.2;
    case 'rollers': return body.disc === null ? 1.6 : own - 0.25;
    case 'carrier': return 2.4;
    case 'output_pins': return 1.6;
    default: return 0;
  }
}

/// Stretches of a slider where the design cannot be or has error findings: from and to in percent, and why.
function shadesOf(tryouts) {
  const last = tryouts.length - 1;
  const shades = [];
  tryouts.forEach((tryout, i) => {
    const why = tryout.refused || (tryout.errors.length > 0 ? `error findings: ${tryout.errors.join(', ')}` : null);
    if (!why) return;
    const [from, to] = [Math.max(0, (100 * (i - 0.5)) / last), Math.min(100, (100 * (i + 0.5)) / last)];
    const before = shades[shades.length - 1];
    if (before && before.to === from) before.to = to;
    else shades.push({ from, to, why });
  });
  return shades;
}
