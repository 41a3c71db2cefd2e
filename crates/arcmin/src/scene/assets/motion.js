// Positions of bodies and forces at a crank angle. Uses neither page nor graphics.
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

/// Ring partner of the discs in these rings, in words: pins, or the teeth of rings of one piece.
function ringWords(rings) {
  if (rings.every((ring) => ring.one_piece)) return { one: 'ring tooth', several: 'ring teeth' };
  if (rings.some((ring) => ring.one_piece)) return { one: 'pin or ring tooth', several: 'pins and ring teeth' };
  return { one: 'pin', several: 'pins' };
}

/// The same with a capital, for the beginning of a sentence.
function capital(words) {
  return words[0].toUpperCase() + words.slice(1);
}

/// Depth at a meshing angle in degrees from samples over −180° … 180°.
function depthAt(samples, angleDeg) {
  if (!samples || samples.length === 0) return 0;
  const wrapped = ((((angleDeg + 180) % 360) + 360) % 360) / 360 * (samples.length - 1);
  const low = Math.min(Math.floor(wrapped), samples.length - 2);
  return samples[low] + (samples[low + 1] - samples[low]) * (wrapped - low);
}

/// Rows of the tables of pins and of rolling elements, ring by ring, by crank position: the turns until all
/// eccentrics are in the same position again.
function framesOf(film) {
  if (!film || !film.crank_angle_deg) return [];
  const frames = film.crank_angle_deg.map((crank, i) => ({ crank, te: film.te_loaded_arcmin[i], contacts: [], rollers: [] }));
  const inTurn = ({ crank_angle_deg: cranks, force_n: force }, add) => {
    let at = 0;
    (cranks || []).forEach((crank, row) => {
      while (at < frames.length - 1 && Math.abs(frames[at].crank - crank) > 1e-9) at += 1;
      if (force[row] > 0) add(frames[at], row, force[row]);
    });
  };
  film.contacts.forEach((pins, ring) => inTurn(pins, (frame, row, force) => {
    frame.contacts.push({ ring, disc: pins.disc[row], pin: pins.pin[row], force, pressure: pins.pressure_mpa[row] });
  }));
  (film.rollers || []).forEach((rollers, ring) => inTurn(rollers, (frame, row, force) => {
    frame.rollers.push({ ring, disc: rollers.disc[row], crankshaft: rollers.crankshaft && rollers.crankshaft[row], direction: rollers.direction_deg[row] * TURN, force });
  }));
  return frames;
}

/// The position nearest to a crank angle; positions are equidistant over whole turns.
function frameAt(frames, crankDeg) {
  const { length } = frames;
  if (length < 2) return frames[0] || null;
  const step = (frames[length - 1].crank - frames[0].crank) / (length - 1);
  return frames[((Math.round(crankDeg / step) % length) + length) % length];
}

/// A position known over one pin pitch of each ring only, at any crank angle: one pitch later the same forces act on the next
/// pin. `known` are the positions ring by ring.
function pitchFrameAt(known, rings, crankDeg) {
  const frame = { crank: crankDeg, te: null, contacts: [] };
  known.forEach((positions, ring) => {
    if (!positions || positions.length === 0) return;
    const { pin_count: pinCount, rate, eccentric_rate: eccentricRate } = rings[ring];
    const pitch = 360 / pinCount;
    const crank = (eccentricRate - rate) * crankDeg;
    const count = Math.floor(crank / pitch + 1e-9);
    const index = Math.round((crank / pitch - count) * positions.length);
    const moved = count + (index === positions.length ? 1 : 0);
    const from = positions[index % positions.length];
    const wrap = (pin) => (((pin + moved) % pinCount) + pinCount) % pinCount;
    if (rings.length === 1) frame.te = from.te_arcmin;
    frame.contacts.push(...from.contacts.map(([disc, pin, force, pressure]) => ({ ring, disc, pin: wrap(pin), force, pressure })));
  });
  return frame;
}

/// Whether a contact belongs to a body: to its ring and, if the body has them, to its disc and crankshaft.
function isOn(body, contact) {
  return contact.ring === body.ring && ['disc', 'crankshaft'].every((of) => (body[of] ?? null) === null || body[of] === contact[of]);
}

/// Largest pressure on each of the pins of a body.
function pressuresOn(body, count, contacts) {
  const pressed = new Array(count).fill(0);
  for (const contact of contacts) if (isOn(body, contact)) pressed[contact.pin] = Math.max(pressed[contact.pin], contact.pressure);
  return pressed;
}

/// Force on each rolling element of a body. The elements are equidistant, at the positions `at` in the frame of the body;
/// forces are given by their directions in the frame of the ring. Angles in rad.
function rollerForcesOn(body, at, rollers, bodyTurn, ringTurn) {
  const forces = new Array(at.length).fill(0);
  const [x, y] = at[0];
  for (const roller of rollers) {
    if (!isOn(body, roller)) continue;
    const index = Math.round(((roller.direction + ringTurn - bodyTurn - Math.atan2(y, x)) * at.length) / (2 * Math.PI));
    const own = ((index % at.length) + at.length) % at.length;
    forces[own] = Math.max(forces[own], roller.force);
  }
  return forces;
}

function largest(frames, what, of = 'contacts') {
  let most = 0;
  for (const frame of frames) for (const one of frame[of] || []) most = Math.max(most, one[what]);
  return most;
}

/// Position of a pin and direction of its force on the disc: the lines of action meet in the pitch point, at the distance
/// e z_p/m from the centre of the ring (m: tooth difference).
function pressOf(ring, disc, pin, crankDeg) {
  const flank = ring.flanks[disc];
  const place = (2 * Math.PI * pin) / ring.pin_count + (flank.row_deg + ring.rate * crankDeg) * TURN;
  const at = { x: ring.pin_circle_radius_mm * Math.cos(place), y: ring.pin_circle_radius_mm * Math.sin(place) };
  const crank = (ring.eccentric_rate * crankDeg + flank.phase_deg) * TURN;
  const reach = (ring.eccentricity_mm * ring.pin_count) / (ring.tooth_difference || 1);
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
