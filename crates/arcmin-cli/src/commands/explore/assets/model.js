// Computations of the page. They use neither page nor graphics.
/// A number as text for readers.
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

/// Ends and step of a key's slider: around its value, within the range of the schema.
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

/// Unit and words of a result by its key: `max_force_n` is "max force" in N, `play_chain.total_arcmin` the total of the play chain.
const UNITS = [['_n_m_per_arcmin', 'N·m/arcmin'], ['_arcmin', 'arcmin'], ['_n_m', 'N·m'], ['_mpa', 'MPa'], ['_deg', '°'], ['_um', 'µm'], ['_mm', 'mm'], ['_n', 'N'], ['_h', 'h'], ['_w', 'W'], ['_c', '°C'], ['_rpm', 'rpm'], ['_per_pa', '1/Pa']];
function labelOf(path) {
  const key = path.split('.').slice(/\.total_/.test(path) ? -2 : -1).join('_');
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

/// Whether a key matches the search text: its name, meaning or unit contains every word.
function fits(key, search) {
  const text = `${key.path} ${key.what} ${key.unit}`.toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

/// Keys with the largest effect on the figures among those that a designer chooses, in order of importance.
const FIRST = ['load.rated_torque_n_m', 'load.input_speed_rpm', 'ring.pin_count', 'ring.pin_circle_radius_mm', 'ring.pin_radius_mm',
  'crankshafts.eccentricity_mm', 'eccentric.eccentricity_mm', 'disc.width_mm', 'disc.modification.equidistant_offset_um', 'disc.modification.radial_offset_um',
  'bearings.turning_arm.clearance_um', 'bearings.turning_arm.roller_length_mm', 'bearings.turning_arm.roller_diameter_mm', 'bearings.eccentric.clearance_um',
  'output_pins.hole_clearance_um', 'output_pins.circle_radius_mm', 'gear_stage.backlash_um', 'crankshafts.shaft_diameter_mm', 'thermal.temperature_c',
  'thermal.housing_temperature_c', 'wear.coefficient_per_pa', 'limits.lost_motion_arcmin', 'limits.service_life_h'];
/// Position of a key among them, keys of another ring or stage after those without prefix; −1 for other keys.
function firstOf(path) {
  const own = FIRST.indexOf(path);
  const other = FIRST.findIndex((first) => path.endsWith(`.${first}`) || path.endsWith(`_${first}`));
  return own >= 0 || other < 0 ? own : other + 0.5;
}

/// Keys that the advice of `life` changes, each with its sentence. Empty before the answer arrives, and for families without
/// advice.
function adviceOf(answer) {
  const { advice = [], advice_keys: paths = [] } = (answer && answer.status === 'done' && answer.summary) || {};
  return paths.map((path, i) => ({ path, text: advice[i] }));
}

/// Ranges of a slider in which the design is invalid or has error findings: from and to in percent, and the reason.
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
