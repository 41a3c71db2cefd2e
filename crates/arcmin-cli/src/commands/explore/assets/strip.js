// Curves over the hours, with one cursor.
const SVG = 'http://www.w3.org/2000/svg';
const CURVES = [
  { key: 'lost_motion_arcmin', name: 'Lost motion, arcmin' },
  { key: 'max_pressure_mpa', name: 'Largest pressure, MPa' },
  { key: 'max_depth_um', name: 'Deepest wear, µm' },
  { key: 'max_force_n', name: 'Largest force, N' },
];
const [WIDE, HIGH, LEFT, TOP, BOTTOM] = [260, 120, 40, 18, 18];

function svg(name, attributes, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

/// Draws the curves of tables `{hours, …}`; `then` is the pinned one, `limits` by key.
function drawStrip(box, now, then, limits, service, hours) {
  box.replaceChildren();
  if (!now || !now.hours || now.hours.length === 0) return;
  for (const { key, name } of CURVES) {
    if (!now[key]) continue;
    const limit = limits[key];
    const ghost = then && then[key] ? then : null;
    const end = Math.max(service || 0, ...now.hours, ...(ghost ? ghost.hours : [])) || 1;
    const values = [...now[key], ...(ghost ? ghost[key] : []), ...(limit ? [limit * 1.05] : [])].filter(Number.isFinite);
    const top = Math.max(...values, 0) || 1;
    const x = (h) => LEFT + ((WIDE - LEFT - 6) * h) / end;
    const y = (v) => HIGH - BOTTOM - ((HIGH - BOTTOM - TOP) * v) / top;
    const row = now.hours.findIndex((h) => h >= hours - 1e-9);
    const value = now[key][row < 0 ? now[key].length - 1 : row];
    const beyond = limit && value > limit;
    const figure = svg('svg', { viewBox: `0 0 ${WIDE} ${HIGH}`, role: 'img', 'aria-label': `${name} over the hours: ${shown(value)} at ${shown(hours)} h${limit ? `, limit ${shown(limit)}` : ''}` });
    figure.append(svg('rect', { class: 'frame', x: LEFT, y: TOP, width: WIDE - LEFT - 6, height: HIGH - BOTTOM - TOP }));
    figure.append(svg('text', { x: LEFT, y: 12, class: beyond ? 'beyond' : 'name' }, `${name}${beyond ? ': limit exceeded' : ''}`));
    figure.append(svg('text', { x: LEFT - 4, y: TOP + 9, 'text-anchor': 'end' }, shown(top, 3)), svg('text', { x: LEFT - 4, y: HIGH - BOTTOM, 'text-anchor': 'end' }, '0'));
    figure.append(svg('text', { x: LEFT, y: HIGH - 5 }, '0'), svg('text', { x: WIDE - 6, y: HIGH - 5, 'text-anchor': 'end' }, `${shown(end)} h`));
    const line = (table, style) => {
      const points = table[key].map((v, i) => (Number.isFinite(v) ? `${x(table.hours[i]).toFixed(1)},${y(v).toFixed(1)}` : null)).filter(Boolean);
      figure.append(svg('polyline', { class: style, points: points.join(' ') }));
    };
    if (ghost) line(ghost, 'then');
    if (limit) figure.append(svg('line', { class: 'limit', x1: LEFT, x2: WIDE - 6, y1: y(limit), y2: y(limit) }));
    line(now, 'line');
    figure.append(svg('line', { class: 'cursor', x1: x(hours), x2: x(hours), y1: TOP, y2: HIGH - BOTTOM }));
    box.append(figure);
  }
}
