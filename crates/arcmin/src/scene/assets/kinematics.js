// Positions of the links and the tool of an arm, and errors of the tool. Uses neither page nor graphics. A frame is twelve
// numbers: its rotation by rows, then its position in mm.

const frameOf = ({ rotation, position_mm: place }) => [...rotation, ...place];

/// A point (mm) given in `frame`, in the frame in which `frame` is given.
function pointAt(frame, [x, y, z]) {
  return [0, 1, 2].map((row) => frame[3 * row] * x + frame[3 * row + 1] * y + frame[3 * row + 2] * z + frame[9 + row]);
}

/// The frame `inner`, given in `outer`, in the frame in which `outer` is given.
function framesChained(outer, inner) {
  const product = [];
  for (let row = 0; row < 3; row += 1) {
    for (let column = 0; column < 3; column += 1) {
      product.push(outer[3 * row] * inner[column] + outer[3 * row + 1] * inner[3 + column] + outer[3 * row + 2] * inner[6 + column]);
    }
  }
  return [...product, ...pointAt(outer, inner.slice(9))];
}

/// The frame turned about a unit vector of its own (Rodrigues' formula).
function frameTurned(frame, [x, y, z], angleDeg) {
  const angle = angleDeg * TURN;
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  const d = 1 - c;
  const turn = [c + x * x * d, x * y * d - z * s, x * z * d + y * s, y * x * d + z * s, c + y * y * d, y * z * d - x * s, z * x * d - y * s, z * y * d + x * s, c + z * z * d];
  return framesChained(frame, [...turn, 0, 0, 0]);
}

/// Frames of all links at joint angles in degrees, and the place of the tool in mm.
function postureOf(arm, anglesDeg) {
  let at = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];
  const links = arm.links.map((link, joint) => {
    at = frameTurned(framesChained(at, frameOf(link.frame)), link.axis, anglesDeg[joint]);
    return at;
  });
  return { links, tool: pointAt(at, arm.tool_mm) };
}

/// The two moments of a program around a time, and the share of the interval before the time.
function momentAt(times, time) {
  if (times.length < 2) return { low: 0, high: 0, share: 0 };
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  return { low, high, share: Math.min(1, Math.max(0, (time - times[low]) / (times[high] - times[low]))) };
}

/// `count` numbers of every moment, interpolated linearly between two moments.
function readAt(numbers, count, { low, high, share }) {
  return Array.from({ length: count }, (_, i) => {
    const [a, b] = [numbers[count * low + i], numbers[count * high + i]];
    return a + share * (b - a);
  });
}

/// The tool at every moment of a program, in mm.
function wayOf(arm, program) {
  const count = arm.links.length;
  return program.time_s.map((_, i) => postureOf(arm, program.angles_deg.slice(count * i, count * (i + 1))).tool);
}

/// The reached path, with its errors (µm, three numbers per moment) magnified.
function reachedWay(way, errorUm, factor) {
  return way.map((point, i) => point.map((x, axis) => x + factor * 1e-3 * errorUm[3 * i + axis]));
}

/// Magnification from the position of a slider, which is its decadic logarithm from 0 to 3: 1 to 1000 in two digits.
function magnificationAt(slider) {
  return Number((10 ** Math.min(3, Math.max(0, slider))).toPrecision(2));
}

/// Middle and radius (mm) of a ball around points.
function ballAround(points) {
  const bounds = [0, 1, 2].map((axis) => points.reduce(([low, high], point) => [Math.min(low, point[axis]), Math.max(high, point[axis])], [Infinity, -Infinity]));
  const middle = bounds.map(([low, high]) => (low + high) / 2);
  return { middle, radius: Math.max(1, ...points.map((point) => Math.hypot(...point.map((x, axis) => x - middle[axis])))) };
}

/// Distance of the lines of a grid for an object of this size: 1, 2 or 5 times a power of ten.
function gridStep(size) {
  const decade = 10 ** Math.floor(Math.log10(size / 4));
  return decade * [5, 2, 1].find((step) => step * decade <= size / 4);
}
