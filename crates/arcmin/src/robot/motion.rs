//! Motion of all axes over a program: from readings, or generated between poses.

use std::f64::consts::TAU;

/// Angles, speeds and accelerations of all axes at increasing times; one inner list for each axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Time, s.
    pub time: Vec<f64>,
    /// Angles, rad.
    pub angle: Vec<Vec<f64>>,
    /// Speeds, rad/s.
    pub speed: Vec<Vec<f64>>,
    /// Accelerations, rad/s².
    pub acceleration: Vec<Vec<f64>>,
}

/// Fraction of its largest speed below which an axis of a table counts as at rest.
const RESTS: f64 = 1e-3;

impl Motion {
    /// From readings of angles (rad) at increasing times (s): speed and acceleration at a reading are those of
    /// the least-squares parabola through all readings within `window` (s) on either side, at least three.
    pub fn of_readings(time: Vec<f64>, angle: Vec<Vec<f64>>, window: f64) -> Motion {
        let parabolas = |values: &Vec<f64>| -> (Vec<f64>, Vec<f64>) {
            (0..time.len()).map(|i| slopes(&time, values, i, window)).unzip()
        };
        let (speed, acceleration) = angle.iter().map(parabolas).unzip();
        Motion { time, angle, speed, acceleration }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0) - self.time.first().copied().unwrap_or(0.0)
    }

    /// Angles of all axes at one sample, rad.
    pub fn angles_at(&self, sample: usize) -> Vec<f64> {
        self.angle.iter().map(|axis| axis[sample]).collect()
    }

    /// Time in s that a reading represents: half of the steps on both sides.
    pub fn weight(&self, sample: usize) -> f64 {
        let at = |i: usize| self.time[i];
        let before = if sample > 0 { at(sample) - at(sample - 1) } else { 0.0 };
        let after = if sample + 1 < self.len() { at(sample + 1) - at(sample) } else { 0.0 };
        0.5 * (before + after)
    }

    /// Speed in rad/s below which an axis counts as at rest.
    pub fn rest_speed(&self, axis: usize) -> f64 {
        RESTS * self.speed[axis].iter().fold(0.0, |most: f64, speed| most.max(speed.abs()))
    }

    /// The first sample at which an axis turns faster than allowed (rad/s), and its speed.
    pub fn too_fast(&self, axis: usize, allowed: f64) -> Option<(usize, f64)> {
        // Excess speeds by smoothing and rounding are not errors of the program.
        let speeds = self.speed[axis].iter().copied().enumerate();
        speeds.into_iter().find(|(_, speed)| speed.abs() > 1.02 * allowed)
    }

    /// Whether all axes are at rest, for each sample.
    pub fn rests(&self) -> Vec<bool> {
        let slow: Vec<f64> = (0..self.angle.len()).map(|axis| self.rest_speed(axis)).collect();
        let rests =
            |sample: usize| self.speed.iter().zip(&slow).all(|(axis, slow)| axis[sample].abs() <= *slow);
        (0..self.len()).map(rests).collect()
    }

    /// The same path with all speeds multiplied by `share`.
    pub fn at_pace(&self, share: f64) -> Motion {
        let scaled = |all: &[Vec<f64>], factor: f64| -> Vec<Vec<f64>> {
            all.iter().map(|axis| axis.iter().map(|x| x * factor).collect()).collect()
        };
        Motion {
            time: self.time.iter().map(|t| t / share).collect(),
            angle: self.angle.clone(),
            speed: scaled(&self.speed, share),
            acceleration: scaled(&self.acceleration, share * share),
        }
    }
}

/// First and second derivative at a reading of the least-squares parabola through its neighbours.
fn slopes(time: &[f64], values: &[f64], i: usize, window: f64) -> (f64, f64) {
    let n = time.len();
    let (mut low, mut high) = (i.saturating_sub(1), (i + 1).min(n - 1));
    // Times in steps of a millisecond are rounded; the window must include equally many readings on either
    // side.
    let window = window * (1.0 + 1e-6);
    while low > 0 && time[i] - time[low - 1] <= window {
        low -= 1;
    }
    while high + 1 < n && time[high + 1] - time[i] <= window {
        high += 1;
    }
    // At the ends three readings on one side are used.
    if high - low < 2 {
        (low, high) = if low == 0 { (0, 2.min(n - 1)) } else { (n.saturating_sub(3), n - 1) };
    }
    if high - low < 2 {
        let slope = if high > low { (values[high] - values[low]) / (time[high] - time[low]) } else { 0.0 };
        return (slope, 0.0);
    }
    // Scaling the times by the window's width keeps the sums well conditioned.
    let scale = (time[high] - time[low]).max(f64::MIN_POSITIVE);
    let mut s = [0.0; 5];
    let mut r = [0.0; 3];
    for k in low..=high {
        let t = (time[k] - time[i]) / scale;
        let y = values[k] - values[i];
        let mut power = 1.0;
        for (j, sum) in s.iter_mut().enumerate() {
            *sum += power;
            if j < 3 {
                r[j] += power * y;
            }
            power *= t;
        }
    }
    let matrix = nalgebra::Matrix3::new(s[0], s[1], s[2], s[1], s[2], s[3], s[2], s[3], s[4]);
    let found = matrix.lu().solve(&nalgebra::Vector3::from(r)).unwrap_or_default();
    (found[1] / scale, 2.0 * found[2] / (scale * scale))
}

/// Limits of an axis between poses: rad/s and rad/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    pub speed: f64,
    pub acceleration: f64,
}

/// A pose that is held: angles in rad, time in s.
#[derive(Debug, Clone, PartialEq)]
pub struct Stop {
    pub angles: Vec<f64>,
    pub hold: f64,
}

/// All axes start and stop together: each covers the fraction s(t) of its displacement. The speed increases by
/// a half wave, ṡ = v (τ − sin(2πτ)/2π), is constant, and decreases in the same way; the slowest axis
/// determines the pace by its speed and acceleration.
struct Leg {
    ramp: f64,
    cruise: f64,
    speed: f64,
}

impl Leg {
    fn between(from: &[f64], to: &[f64], paces: &[Pace]) -> Option<Leg> {
        let (mut speed, mut acceleration) = (f64::INFINITY, f64::INFINITY);
        for ((a, b), pace) in from.iter().zip(to).zip(paces) {
            let way = (b - a).abs();
            if way > 0.0 {
                speed = speed.min(pace.speed / way);
                acceleration = acceleration.min(pace.acceleration / way);
            }
        }
        if !acceleration.is_finite() {
            return None;
        }
        // The largest acceleration of the wave is twice its mean; both ramps together cover the same
        // displacement as one at full speed.
        let speed = speed.min((0.5 * acceleration).sqrt());
        let ramp = 2.0 * speed / acceleration;
        Some(Leg { ramp, cruise: 1.0 / speed - ramp, speed })
    }

    fn duration(&self) -> f64 {
        2.0 * self.ramp + self.cruise
    }

    /// s, ṡ and s̈ at a time.
    fn at(&self, time: f64) -> [f64; 3] {
        let Leg { ramp, cruise, speed } = *self;
        let rising = |t: f64| {
            let x = t / ramp;
            [
                speed * ramp * (0.5 * x * x + ((TAU * x).cos() - 1.0) / (TAU * TAU)),
                speed * (x - (TAU * x).sin() / TAU),
                speed / ramp * (1.0 - (TAU * x).cos()),
            ]
        };
        if time < ramp {
            rising(time.max(0.0))
        } else if time <= ramp + cruise {
            [0.5 * speed * ramp + speed * (time - ramp), speed, 0.0]
        } else {
            let [s, v, a] = rising((self.duration() - time).max(0.0));
            [1.0 - s, v, -a]
        }
    }
}

/// Motion through poses and back to the first, with the last sample at rest of every pose.
pub fn through(stops: &[Stop], paces: &[Pace], step: f64) -> (Motion, Vec<usize>) {
    let axes = paces.len();
    let mut motion = Motion {
        angle: vec![Vec::new(); axes],
        speed: vec![Vec::new(); axes],
        acceleration: vec![Vec::new(); axes],
        ..Motion::default()
    };
    let mut now = 0.0;
    let mut ends = Vec::with_capacity(stops.len());
    let push = |motion: &mut Motion, time: f64, from: &[f64], to: &[f64], [s, v, a]: [f64; 3]| {
        motion.time.push(time);
        for axis in 0..axes {
            let way = to[axis] - from[axis];
            motion.angle[axis].push(from[axis] + s * way);
            motion.speed[axis].push(v * way);
            motion.acceleration[axis].push(a * way);
        }
    };
    for (index, stop) in stops.iter().enumerate() {
        let here = &stop.angles;
        if index == 0 {
            push(&mut motion, now, here, here, [0.0; 3]);
        }
        let steps = (stop.hold / step).ceil();
        for k in 1..=steps as usize {
            push(&mut motion, now + stop.hold * k as f64 / steps, here, here, [0.0; 3]);
        }
        now += stop.hold;
        ends.push(motion.len() - 1);
        let next = &stops[(index + 1) % stops.len()].angles;
        let Some(leg) = Leg::between(here, next, paces) else { continue };
        let steps = (leg.duration() / step).ceil().max(4.0);
        for k in 1..=steps as usize {
            let at = leg.duration() * k as f64 / steps;
            push(&mut motion, now + at, here, next, leg.at(at));
        }
        now += leg.duration();
    }
    (motion, ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speeds and accelerations from readings agree with the function that was sampled.
    #[test]
    fn readings_give_speed_and_acceleration() {
        let time: Vec<f64> = (0..2001).map(|i| 1e-3 * f64::from(i)).collect();
        let of = |f: fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        let motion = Motion::of_readings(time.clone(), vec![of(|t| (3.0 * t).sin())], 0.008);
        for i in 20..1980 {
            assert!((motion.speed[0][i] - 3.0 * (3.0 * time[i]).cos()).abs() < 3e-3);
            assert!((motion.acceleration[0][i] + 9.0 * (3.0 * time[i]).sin()).abs() < 1e-2);
        }
        // A parabola is reproduced exactly, also at the ends and for nonuniform steps.
        let time = vec![0.0, 0.1, 0.25, 0.3, 0.5];
        let parabola: Vec<f64> = time.iter().map(|t| 1.0 - 2.0 * t + 3.0 * t * t).collect();
        let motion = Motion::of_readings(time.clone(), vec![parabola], 0.0);
        for (i, t) in time.iter().enumerate() {
            assert!((motion.speed[0][i] + 2.0 - 6.0 * t).abs() < 1e-9, "{i}");
            assert!((motion.acceleration[0][i] - 6.0).abs() < 1e-9);
        }
    }

    /// Poses are reached, limits are observed and one of them is used fully, and speeds are the derivatives of
    /// angles.
    #[test]
    fn motion_between_poses_keeps_the_limits() {
        let paces = [Pace { speed: 2.0, acceleration: 5.0 }, Pace { speed: 1.0, acceleration: 9.0 }];
        let stops = [
            Stop { angles: vec![0.0, 0.0], hold: 0.1 },
            Stop { angles: vec![0.05, -0.02], hold: 0.0 },
            Stop { angles: vec![2.0, 1.5], hold: 0.3 },
        ];
        let (motion, ends) = through(&stops, &paces, 1e-3);
        assert_eq!(ends.len(), 3);
        for (stop, end) in stops.iter().zip(&ends) {
            let off =
                motion.angles_at(*end).iter().zip(&stop.angles).map(|(a, b)| (a - b).abs()).sum::<f64>();
            assert!(off < 1e-12 && motion.rests()[*end]);
        }
        let most = |of: &[f64]| of.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut used = 0.0_f64;
        for (axis, pace) in paces.iter().enumerate() {
            let (speed, acceleration) = (most(&motion.speed[axis]), most(&motion.acceleration[axis]));
            assert!(speed < pace.speed * (1.0 + 1e-9) && acceleration < pace.acceleration * (1.0 + 1e-9));
            used = used.max(speed / pace.speed);
            for i in 1..motion.len() - 1 {
                let (before, after) = (i - 1, i + 1);
                let slope = (motion.angle[axis][after] - motion.angle[axis][before])
                    / (motion.time[after] - motion.time[before]);
                assert!((slope - motion.speed[axis][i]).abs() < 2e-2 * pace.speed, "{i}");
            }
        }
        assert!(used > 0.999);
        assert!(motion.time.windows(2).all(|pair| pair[1] > pair[0]));
    }
}
