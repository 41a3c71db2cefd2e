// What reports of robots compute by themselves: `node --test crates/arcmin-cli/tests/web/arm.test.mjs`.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const source = ['motion.js', 'kinematics.js'].map((file) => readFileSync(new URL(`../../../arcmin/src/scene/assets/${file}`, import.meta.url), 'utf8')).join('');
const names = [...source.matchAll(/^(?:function|const) (\w+)/gm)].map((found) => found[1]);
const arms = vm.runInThisContext(`(() => {'use strict';\n${source}\nreturn {${names.join()}};})()`);

const near = (a, b, within = 1e-9) => a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) <= within, `${a} is not ${b}`));
const straight = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const frame = (place, rotation = straight) => ({ position_mm: place, rotation });
const link = (place, axis, rotation) => ({ frame: frame(place, rotation), axis });
const [sin, cos] = [(deg) => Math.sin((deg * Math.PI) / 180), (deg) => Math.cos((deg * Math.PI) / 180)];

test('two links in a plane reach where trigonometry has them', () => {
  const arm = { links: [link([0, 0, 100], [0, -1, 0]), link([500, 0, 0], [0, -1, 0])], tool_mm: [300, 0, 0] };
  for (const [a, b] of [[0, 0], [90, 0], [30, -75], [-170, 420]]) {
    const { links, tool } = arms.postureOf(arm, [a, b]);
    near(links[1].slice(9), [500 * cos(a), 0, 100 + 500 * sin(a)]);
    near(tool, [500 * cos(a) + 300 * cos(a + b), 0, 100 + 500 * sin(a) + 300 * sin(a + b)]);
  }
});

test('an oblique axis turns its link around it and keeps distances', () => {
  const axis = [2 / 7, 3 / 7, 6 / 7];
  const arm = { links: [link([10, 20, 30], axis)], tool_mm: [40, -5, 7] };
  const whole = arms.postureOf(arm, [0]).tool;
  // Three turns of 120° are one, and their middle lies on the axis.
  const reached = [0, 120, 240].map((angle) => arms.postureOf(arm, [angle]).tool);
  near(reached[0], whole);
  near(arms.postureOf(arm, [360]).tool, whole, 1e-9);
  const along = axis.reduce((sum, x, i) => sum + x * arm.tool_mm[i], 0);
  near([0, 1, 2].map((i) => (reached[0][i] + reached[1][i] + reached[2][i]) / 3), axis.map((x, i) => [10, 20, 30][i] + along * x));
  // Seen against the axis it turns to the left.
  const [u, v] = [reached[0], reached[1]].map((point) => point.map((x, i) => x - [10, 20, 30][i]));
  const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  assert.ok(cross.reduce((sum, x, i) => sum + x * axis[i], 0) > 0);
});

test('frames that are turned at angle 0 turn what hangs on them', () => {
  // x of the link points upwards: its z axis, against x of the base, turns it.
  const arm = { links: [link([0, 0, 50], [0, 0, 1], [0, 0, -1, 0, 1, 0, 1, 0, 0])], tool_mm: [100, 0, 0] };
  near(arms.postureOf(arm, [0]).tool, [0, 0, 150]);
  near(arms.postureOf(arm, [90]).tool, [0, 100, 50]);
});

test('moments are read between samples and held at the ends', () => {
  const times = [0, 1, 3];
  assert.deepEqual({ ...arms.momentAt(times, 2) }, { low: 1, high: 2, share: 0.5 });
  assert.deepEqual({ ...arms.momentAt(times, 1) }, { low: 1, high: 2, share: 0 });
  assert.deepEqual({ ...arms.momentAt(times, -5) }, { low: 0, high: 1, share: 0 });
  assert.deepEqual({ ...arms.momentAt(times, 9) }, { low: 1, high: 2, share: 1 });
  near(arms.readAt([0, 10, 2, 20, 6, 0], 2, arms.momentAt(times, 2)), [4, 10]);
  near(arms.readAt([5], 1, arms.momentAt([0], 3)), [5]);
});

test('the way as reached is the commanded one with the error so many times', () => {
  const arm = { links: [link([0, 0, 0], [0, 0, 1])], tool_mm: [1000, 0, 0] };
  const way = arms.wayOf(arm, { time_s: [0, 1], angles_deg: [0, 90] });
  near(way[1], [0, 1000, 0]);
  const reached = arms.reachedWay(way, [250, 0, -1000, 0, -500, 0], 100);
  near(reached[0], [1025, 0, -100]);
  near(reached[1], [0, 950, 0]);
});

test('the slider of the magnification goes from 1 to 1000', () => {
  assert.equal(arms.magnificationAt(0), 1);
  assert.equal(arms.magnificationAt(2), 100);
  assert.equal(arms.magnificationAt(3), 1000);
  assert.equal(arms.magnificationAt(7), 1000);
  assert.equal(arms.magnificationAt(1.5), 32);
  for (let at = 0.05; at <= 3; at += 0.05) assert.ok(arms.magnificationAt(at) > arms.magnificationAt(at - 0.05));
});

test('a ball holds its points, and a grid has a few round lines in it', () => {
  const points = [[0, 0, 0], [100, 0, 0], [0, 300, 40]];
  const { middle, radius } = arms.ballAround(points);
  near(middle, [50, 150, 20]);
  for (const point of points) assert.ok(Math.hypot(...point.map((x, i) => x - middle[i])) <= radius + 1e-9);
  for (const size of [90, 100, 1999, 2000, 4800, 7.3]) {
    const step = arms.gridStep(size);
    assert.ok(size / step >= 4 - 1e-9 && size / step <= 10.1, `${size}: ${step}`);
    assert.ok([1, 2, 5].some((one) => Math.abs(Math.log10(step / one) % 1) < 1e-9), String(step));
  }
});
