// What the page of the explorer computes by itself: `node --test crates/arcmin-cli/tests/web/model.test.mjs`.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const files = ['../../../arcmin/src/scene/assets/motion.js', '../../src/commands/explore/assets/model.js'];
const source = files.map((file) => readFileSync(new URL(file, import.meta.url), 'utf8')).join('');
const names = [...source.matchAll(/^function (\w+)/gm)].map((found) => found[1]);
const model = vm.runInThisContext(`(() => {'use strict';\n${source}\nreturn {${names.join()}};})()`);

const near = (a, b, within = 1e-12) => assert.ok(Math.abs(a - b) <= within, `${a} is not ${b}`);

test('a ring of one piece has teeth, others pins', () => {
  const several = (...pieces) => model.ringWords(pieces.map((piece) => ({ one_piece: piece }))).several;
  assert.deepEqual([several(false), several(true, true), several(false, true)], ['pins', 'ring teeth', 'pins and ring teeth']);
  assert.equal(model.capital('ring teeth'), 'Ring teeth');
});

test('a body moves by its arms and turns', () => {
  const motion = { arms: [{ length_mm: 2, angle_deg: 90, rate: 1 }, { length_mm: 10, angle_deg: 0, rate: -0.1 }], turn_deg: 5, turn_rate: -0.1 };
  const pose = model.poseAt(motion, 90);
  near(pose.x, -2 + 10 * Math.cos((-9 * Math.PI) / 180));
  near(pose.y, 10 * Math.sin((-9 * Math.PI) / 180));
  near(pose.turn, (-4 * Math.PI) / 180);
});

test('depths are read between samples and around the whole angle', () => {
  const samples = [0, 1, 2, 1, 0];
  near(model.depthAt(samples, -180), 0);
  near(model.depthAt(samples, 0), 2);
  near(model.depthAt(samples, 45), 1.5);
  near(model.depthAt(samples, 405), 1.5);
  near(model.depthAt(samples, 180), 0);
  near(model.depthAt(null, 10), 0);
});

test('rows of contact.csv become frames in the order of the turn', () => {
  const film = { crank_angle_deg: [0, 120, 240], te_loaded_arcmin: [-1, -2, -3],
    contacts: [{ crank_angle_deg: [0, 0, 240], disc: [0, 1, 0], pin: [3, 4, 5], force_n: [10, 20, 30], pressure_mpa: [100, 200, 300] },
      { crank_angle_deg: [120, 240], disc: [0, 0], pin: [1, 2], force_n: [5, 0], pressure_mpa: [50, 0] }] };
  const frames = model.framesOf(film);
  assert.deepEqual(frames.map((f) => f.contacts.length), [2, 1, 1]);
  assert.deepEqual(frames.map((f) => f.contacts[0].ring), [0, 1, 0]);
  assert.equal(model.frameAt(frames, 479).crank, 120);
  assert.equal(model.frameAt(frames, -1).crank, 0);
  assert.equal(model.largest(frames, 'force'), 30);
  assert.deepEqual(model.framesOf(null), []);
});

test('a film of several turns is read over all of them', () => {
  const frames = Array.from({ length: 77 }, (_, i) => ({ crank: (i * 20 * 360) / 77, contacts: [] }));
  assert.equal(model.frameAt(frames, frames[40].crank + 20 * 360).crank, frames[40].crank);
  assert.equal(model.frameAt(frames, 20 * 360 - 1).crank, 0);
  assert.equal(model.frameAt([], 1), null);
});

test('one pin pitch later the same forces act on the next pin', () => {
  const rings = [{ pin_count: 8, rate: 0, eccentric_rate: 1 }];
  const positions = [{ te_arcmin: 0, contacts: [[0, 7, 1, 1]] }, { te_arcmin: 1, contacts: [[0, 7, 2, 2]] }];
  const at = (crank) => model.pitchFrameAt([positions], rings, crank).contacts[0];
  assert.equal(at(0).pin, 7);
  assert.equal(at(45).pin, 0);
  assert.equal(at(-45).pin, 6);
  assert.equal(at(22.5).force, 2);
  // The nearest position after the last is the first of the next pitch.
  assert.deepEqual({ ...at(44) }, { ring: 0, disc: 0, pin: 0, force: 1, pressure: 1 });
  // A ring whose eccentrics turn backwards at half the speed, beside one of which nothing is known.
  const two = [rings[0], { pin_count: 8, rate: 0, eccentric_rate: -0.5 }];
  const frame = model.pitchFrameAt([null, positions], two, 90);
  assert.deepEqual({ ...frame.contacts[0] }, { ring: 1, disc: 0, pin: 6, force: 1, pressure: 1 });
  assert.equal(frame.te, null);
});

test('lines of action meet in the pitch point', () => {
  const flanks = [{ phase_deg: 0, row_deg: 0 }, { phase_deg: 180, row_deg: 3 }];
  const ring = { pin_count: 20, pin_circle_radius_mm: 17, eccentricity_mm: 0.5, rate: 0.1, eccentric_rate: -2, flanks };
  const crank = 33;
  const [a, b] = [model.pressOf(ring, 1, 2, crank), model.pressOf(ring, 1, 11, crank)];
  const point = { x: 10 * Math.cos(((180 - 2 * crank) * Math.PI) / 180), y: 10 * Math.sin(((180 - 2 * crank) * Math.PI) / 180) };
  for (const press of [a, b]) {
    near((point.x - press.x) * press.dy - (point.y - press.y) * press.dx, 0, 1e-9);
    near(Math.hypot(press.dx, press.dy), 1);
  }
  near(Math.atan2(a.y, a.x), ((36 + 3 + 3.3) * Math.PI) / 180);
  // With a tooth difference of 2 it lies half as far out.
  const press = model.pressOf({ ...ring, tooth_difference: 2 }, 1, 2, crank);
  near((0.5 * point.x - press.x) * press.dy - (0.5 * point.y - press.y) * press.dx, 0, 1e-9);
});

test('pins show the pressure of their own ring and disc', () => {
  const contacts = [{ ring: 0, disc: 0, pin: 1, pressure: 5 }, { ring: 0, disc: 1, pin: 1, pressure: 7 }, { ring: 1, disc: 0, pin: 1, pressure: 9 }];
  const on = (body) => [...model.pressuresOn(body, 2, contacts)];
  assert.deepEqual(on({ ring: 0, disc: null }), [0, 7]);
  assert.deepEqual(on({ ring: 0, disc: 0 }), [0, 5]);
  assert.deepEqual(on({ ring: 1, disc: null }), [0, 9]);
});

test('rolling elements light up where the force is', () => {
  const at = [0, 1, 2, 3].map((i) => [5 * Math.cos((i * Math.PI) / 2 + 0.1), 5 * Math.sin((i * Math.PI) / 2 + 0.1)]);
  const film = { crank_angle_deg: [0, 90], te_loaded_arcmin: [0, 0], contacts: [],
    rollers: [{ crank_angle_deg: [0, 0, 90], disc: [0, 1, 0], direction_deg: [100, 10, 190], force_n: [7, 9, 3] }, { crank_angle_deg: null, force_n: null }] };
  const frames = model.framesOf(film);
  assert.equal(model.largest(frames, 'force', 'rollers'), 9);
  assert.equal(model.largest(frames, 'force'), 0);
  assert.equal(model.largest([{ contacts: [] }], 'force', 'rollers'), 0);
  const on = (disc, frame, bodyTurn, ringTurn) => [...model.rollerForcesOn({ ring: 0, disc }, at, frames[frame].rollers, bodyTurn, ringTurn)];
  assert.deepEqual(on(0, 0, 0, 0), [0, 7, 0, 0]);
  assert.deepEqual(on(1, 0, 0, 0), [9, 0, 0, 0]);
  // The cage has turned by 90°: another element stands where the force is; a ring that turns takes the force along.
  assert.deepEqual(on(0, 0, Math.PI / 2, 0), [7, 0, 0, 0]);
  assert.deepEqual(on(0, 0, 0, Math.PI / 2), [0, 0, 7, 0]);
  assert.deepEqual(on(0, 1, 0, 0), [0, 0, 3, 0]);
  // Bearings of several crankshafts each have their own elements.
  const own = { ...film, rollers: [{ crank_angle_deg: [0, 0], crankshaft: [0, 1], disc: [0, 0], direction_deg: [100, 10], force_n: [7, 9] }] };
  const of = (crankshaft) => [...model.rollerForcesOn({ ring: 0, disc: 0, crankshaft }, at, model.framesOf(own)[0].rollers, 0, 0)];
  assert.deepEqual([of(0), of(1)], [[0, 7, 0, 0], [9, 0, 0, 0]]);
});

test('sliders stay within the schema and around their value', () => {
  assert.deepEqual({ ...model.sliderOf({ kind: 'count', range: [3, 60] }, 6) }, { min: 3, max: 11, step: 1 });
  const around = model.sliderOf({ kind: 'number', range: [0.1, 1000] }, 8.75);
  assert.ok(around.min >= 0.1 && around.min <= 8.75 && around.max >= 8.75 && around.step > 0);
  for (const [range, value] of [[[0, 2000], 0], [[-5, 5], 0], [[-1e7, 1e7], -412], [[0.05, 0.06], 0.05], [[1, 1], 1]]) {
    const slider = model.sliderOf({ kind: 'number', range }, value);
    assert.ok(slider.min >= range[0] && slider.max <= range[1] && slider.min <= value && slider.max >= value, JSON.stringify([range, value, slider]));
  }
});

test('numbers and names as a reader wants them', () => {
  assert.equal(model.shown(-0.19699788), '−0.197');
  assert.equal(model.shown(null), '–');
  assert.equal(model.shown(1445.6657), '1446');
  assert.equal(model.shown(1e-13), '1e−13');
  assert.deepEqual({ ...model.labelOf('verdict.max_force_n') }, { words: 'Max force', unit: 'N' });
  assert.equal(model.labelOf('torsional_stiffness_n_m_per_arcmin').unit, 'N·m/arcmin');
  assert.deepEqual({ ...model.labelOf('play_chain.total_arcmin') }, { words: 'Play chain total', unit: 'arcmin' });
});

test('comparison of two designs', () => {
  const rows = model.differences({ a: 110, b: 1 }, { a: 100, c: 2 });
  assert.equal(rows.length, 3);
  near(rows[0].change, 10);
  assert.equal(rows[1].change, null);
  assert.deepEqual({ ...model.numbersOf({ a: 1, b: { c: 2, d: null }, e: [1] }) }, { a: 1, 'b.c': 2 });
});

test('the search looks into name, meaning and unit', () => {
  const key = { path: 'bearings.turning_arm.clearance_um', what: 'Diametral clearance.', unit: 'µm' };
  assert.ok(model.fits(key, 'arm CLEAR') && model.fits(key, 'diametral µm') && !model.fits(key, 'arm width'));
});

test('stretches without a design are told with their reason', () => {
  const shades = model.shadesOf([{ refused: 'too small' }, { refused: 'too small' }, { errors: [] }, { errors: ['undercut'] }, { errors: [] }]);
  assert.deepEqual(JSON.parse(JSON.stringify(shades)), [{ from: 0, to: 37.5, why: 'too small' }, { from: 62.5, to: 87.5, why: 'error findings: undercut' }]);
});

test('keys of another ring or stage stand beside those of the first', () => {
  const answer = { status: 'done', summary: { advice: ['less play', 'wider disc'], advice_keys: ['bearings.main.clearance_um', 'disc.width_mm'] } };
  assert.deepEqual(model.adviceOf(answer), [{ path: 'bearings.main.clearance_um', text: 'less play' }, { path: 'disc.width_mm', text: 'wider disc' }]);
  for (const none of [undefined, { status: 'not_available' }, { status: 'failed', error: 'no life' }]) assert.deepEqual(model.adviceOf(none), []);
  assert.ok(model.firstOf('ring.pin_count') >= 0 && model.firstOf('thermal.seals') === -1);
  for (const other of ['second_ring.pin_count', 'first_stage.ring.pin_count']) assert.equal(model.firstOf(other), model.firstOf('ring.pin_count') + 0.5);
});
