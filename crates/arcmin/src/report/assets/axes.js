// Numbers, ticks, colours and small SVG helpers that all figures use.

const SVG = 'http://www.w3.org/2000/svg';

function svgElement(name, attributes = {}, parent = null, text = null) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== null) element.textContent = text;
  if (parent) parent.append(element);
  return element;
}

function htmlElement(name, attributes = {}, parent = null, text = null) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== null) element.textContent = text;
  if (parent) parent.append(element);
  return element;
}

const MINUS = '\u2212', THIN = '\u2009';

// Whole part in groups of three from five digits on, with a real minus sign.
function groupDigits(text) {
  let [whole, fraction] = text.replace('-', '').split('.');
  if (whole.length > 4) whole = whole.replace(/\B(?=(\d{3})+$)/g, THIN);
  return (text.startsWith('-') ? MINUS : '') + whole + (fraction ? '.' + fraction : '');
}

const SUPERSCRIPT = { '-': '⁻', 0: '⁰', 1: '¹', 2: '²', 3: '³', 4: '⁴', 5: '⁵', 6: '⁶', 7: '⁷', 8: '⁸', 9: '⁹' };
const powerOfTen = exponent => '10' + String(exponent).replace(/./g, digit => SUPERSCRIPT[digit]);

function exponentForm(value, digits) {
  const [mantissa, exponent] = value.toExponential(digits).split('e');
  return groupDigits(mantissa) + '·' + powerOfTen(Number(exponent));
}

// A value at the cursor: four significant digits.
function formatValue(value, digits = 4) {
  if (value === null || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return exponentForm(value, digits - 1);
  const decimals = size === 0 ? 0 : Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  let text = value.toFixed(Math.min(decimals, 10));
  if (text.includes('.')) text = text.replace(/\.?0+$/, '');
  return groupDigits(text === '-0' ? '0' : text);
}

const withUnit = (text, unit) => !unit ? text : text + (unit === '°' || unit === '′' ? '' : '\u00a0') + unit;

// Ticks on 1-2-5 steps; angles on steps that divide a turn, counts on whole numbers.
function linearTicks(low, high, wanted, { unit, counted }) {
  const span = high - low;
  let step = 0;
  if (unit === '°' && span > 20) {
    step = [5, 10, 15, 30, 45, 60, 90, 180, 360].find(size => span / size <= wanted * 1.2) || 0;
  }
  if (!step) {
    const rough = span / Math.max(1, wanted), decade = 10 ** Math.floor(Math.log10(rough));
    step = decade * ([1, 2, 5, 10].find(size => size * decade >= rough * 0.8) || 10);
  }
  if (counted) step = Math.max(1, Math.round(step));
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const ticks = [];
  for (let index = Math.ceil(low / step - 1e-9); index * step <= high + step * 1e-9 && ticks.length < 100; index++) {
    const at = index * step;
    const far = Math.max(Math.abs(low), Math.abs(high));
    const label = at === 0 ? '0' : far < 1e-4 || far >= 1e7 ? exponentForm(at, 1) : groupDigits(at.toFixed(Math.min(decimals, 12)));
    ticks.push({ at, label });
  }
  return ticks;
}

function logTicks(low, high) {
  const ticks = [], from = Math.floor(Math.log10(low)), to = Math.ceil(Math.log10(high));
  for (let exponent = from; exponent <= to; exponent++) {
    for (let factor = 1; factor < 10; factor++) {
      const at = factor * 10 ** exponent;
      if (at < low * 0.999 || at > high * 1.001) continue;
      const named = factor === 1 || (to - from <= 2 && (factor === 2 || factor === 5));
      const label = !named ? '' : exponent >= -3 && exponent <= 4 ? groupDigits(String(Number(at.toPrecision(3)))) : factor === 1 ? powerOfTen(exponent) : '';
      ticks.push({ at, label, minor: factor !== 1 });
    }
  }
  return ticks;
}

// value → pixel and back, for one axis.
function makeScale(axis, range, from, to) {
  const log = axis.scale === 'log', forward = log ? Math.log10 : value => value;
  const low = forward(range[0]), high = forward(range[1]);
  return {
    range, from, to,
    at: value => from + (forward(value) - low) / (high - low) * (to - from),
    value: pixel => { const inner = low + (pixel - from) / (to - from) * (high - low); return log ? 10 ** inner : inner; },
    ticks: wanted => log ? logTicks(range[0], range[1]) : linearTicks(range[0], range[1], wanted, axis),
  };
}

// Range of values on an axis, with a margin.
function fitRange(axis, values, air = 0.05) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value === null || (axis.scale === 'log' && value <= 0)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return axis.scale === 'log' ? [0.1, 1] : [0, 1];
  if (axis.scale === 'log') {
    const margin = Math.max((high / low) ** air, 1.05);
    return [low / margin, high * margin];
  }
  const touchesZero = { low: low === 0, high: high === 0 };
  if (axis.include_zero) { if (low > 0) { low = 0; touchesZero.low = true; } if (high < 0) { high = 0; touchesZero.high = true; } }
  // Values that differ by rounding only are one value: no ticks would fit into the range of their differences.
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (high - low < 1e-9 * size) { low -= 0.05 * size; high += 0.05 * size; }
  // If all values are zero, the range still has ticks.
  if (low === 0 && high === 0) return [0, 1];
  const span = high - low || 1;
  return [touchesZero.low && axis.include_zero ? 0 : low - span * air, touchesZero.high && axis.include_zero ? 0 : high + span * air];
}

const VIRIDIS = [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];

// Colours in a perceptually uniform order; part 0..1.
function ramp(part) {
  const place = Math.min(0.99999, Math.max(0, part)) * (VIRIDIS.length - 1), index = Math.floor(place), rest = place - index;
  return 'rgb(' + VIRIDIS[index].map((low, channel) => Math.round(low + rest * (VIRIDIS[index + 1][channel] - low))).join(',') + ')';
}

const isDark = () => document.documentElement.dataset.theme === 'dark' && !document.documentElement.dataset.printing;

// Ordered series omit the end of the ramp with too little contrast to the background.
const orderedColour = part => isDark() ? ramp(0.4 + 0.6 * part) : ramp(0.82 * part);

function seriesColours(series) {
  const taken = new Set(series.filter(one => typeof one.colour === 'object' && 'palette' in one.colour).map(one => one.colour.palette % 7));
  let next = 0;
  return series.map(one => {
    const colour = one.colour;
    if (colour === 'reference') return 'var(--reference)';
    if (colour === 'auto') {
      while (taken.has(next % 7) && next < 7) next++;
      return `var(--s${next++ % 7})`;
    }
    return 'ordered' in colour ? orderedColour(colour.ordered) : `var(--s${colour.palette % 7})`;
  });
}

// Lines of the same colour differ by their dashes: dashed series, and series beyond the number of colours.
function seriesDashes(series, colours) {
  const used = {};
  return series.map((one, index) => {
    if (/band|bars|markers/.test(one.style) && one.style !== 'line_markers') return 'none';
    const key = `${colours[index]} ${one.style}`, before = used[key] || 0;
    used[key] = before + 1;
    return one.style === 'dashed' ? ['7 4', '14 4', '3 4'][before % 3] : ['none', '2 3', '16 4'][before % 3];
  });
}
