//! Wind-up of a joint with hysteresis: the measured loop with memory of the torque history.

/// The hysteresis loop of a joint: wind-up (rad) against the external torque on the output flange (N·m).
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// Torques in N·m in increasing order, from − to + the largest measured one.
    torques: Vec<f64>,
    /// Wind-up in rad for increasing and for decreasing torque, both listed from the smallest torque to the
    /// largest.
    rising: Vec<f64>,
    falling: Vec<f64>,
    /// N·m: 3 % of the rated torque, at which lost motion is defined.
    lost_motion_torque: f64,
}

impl Loop {
    /// From a measured loop: (torque, angle), first decreasing from + to −, then increasing. `None` for other
    /// sequences.
    pub fn new(points: &[(f64, f64)], rated: f64) -> Option<Loop> {
        let half = points.len() / 2;
        let (falling, rising) = points.split_at(half);
        let torques: Vec<f64> = rising.iter().map(|point| point.0).collect();
        let rises = torques.windows(2).all(|pair| pair[1] > pair[0]);
        let alike = falling.len() == rising.len()
            && falling.iter().rev().zip(rising).all(|(down, up)| down.0 == up.0);
        if half < 3 || !rises || !alike || torques[0] >= 0.0 || torques[half - 1] <= 0.0 {
            return None;
        }
        let mut rising: Vec<f64> = rising.iter().map(|point| point.1).collect();
        let mut falling: Vec<f64> = falling.iter().rev().map(|point| point.1).collect();
        // The branches of a complete cycle meet at the tips, except for the first loading.
        for tip in [0, half - 1] {
            let middle = 0.5 * (rising[tip] + falling[tip]);
            (rising[tip], falling[tip]) = (middle, middle);
        }
        // The scatter of equilibria is below any result of interest; the branches are corrected so that they
        // are monotonic and do not cross.
        for branch in [&mut rising, &mut falling] {
            for i in 1..half {
                branch[i] = branch[i].max(branch[i - 1]);
            }
        }
        for (low, high) in rising.iter_mut().zip(&mut falling) {
            (*low, *high) = (low.min(*high), low.max(*high));
        }
        Some(Loop { torques, rising, falling, lost_motion_torque: crate::rig::LOST_MOTION_SHARE * rated })
    }

    fn tips(&self) -> [(f64, f64); 2] {
        let last = self.torques.len() - 1;
        [(self.torques[0], self.rising[0]), (self.torques[last], self.rising[last])]
    }

    /// Range of the measured torques, N·m.
    pub fn range(&self) -> [f64; 2] {
        self.tips().map(|tip| tip.0)
    }

    /// Wind-up (rad) on the outer branch for increasing or decreasing torque (N·m): interpolated; beyond the
    /// tips extrapolated with the mean slope of the outer half.
    pub fn branch(&self, rises: bool, torque: f64) -> f64 {
        let angles = if rises { &self.rising } else { &self.falling };
        let last = self.torques.len() - 1;
        let tip = match torque {
            torque if torque <= self.torques[0] => 0,
            torque if torque >= self.torques[last] => last,
            torque => return self.between(angles, torque),
        };
        let inner = 0.5 * self.torques[tip];
        let middle = 0.5 * (self.between(&self.rising, inner) + self.between(&self.falling, inner));
        angles[tip] + (torque - self.torques[tip]) * (angles[tip] - middle) / (self.torques[tip] - inner)
    }

    fn between(&self, angles: &[f64], torque: f64) -> f64 {
        let upper = self.torques.partition_point(|t| *t <= torque).clamp(1, self.torques.len() - 1);
        let (a, b) = (upper - 1, upper);
        let share = (torque - self.torques[a]) / (self.torques[b] - self.torques[a]);
        angles[a] + share * (angles[b] - angles[a])
    }

    /// Mean of both branches, rad.
    pub fn middle(&self, torque: f64) -> f64 {
        0.5 * (self.branch(true, torque) + self.branch(false, torque))
    }

    /// Elastic part of [`Loop::middle`] in rad: the change beyond ±3 % of the rated torque. The remainder of
    /// the loop is lost motion; between + and − 3 % it is exactly the catalogue value.
    pub fn elastic(&self, torque: f64) -> f64 {
        let low = self.lost_motion_torque;
        self.middle(torque) - self.middle(torque.clamp(-low, low))
    }

    /// Lost motion in rad.
    pub fn lost_motion(&self) -> f64 {
        self.middle(self.lost_motion_torque) - self.middle(-self.lost_motion_torque)
    }
}

/// State of a joint in its hysteresis loop: a generalised play operator (Krasnosel'skii and Pokrovskii) between
/// the measured branches.
///
/// After a reversal, friction keeps the wind-up constant until the torque leaves the band between the branches:
/// φ ← min(max(φ, rising(T)), falling(T)). On the outer loop the result is the measured loop exactly. The
/// operator has return-point memory: it remembers reversals, and a larger cycle deletes smaller ones (wiping
/// out).
#[derive(Debug, Clone)]
pub struct Standing<'a> {
    curve: &'a Loop,
    torque: f64,
    wind_up: f64,
    rises: bool,
}

impl<'a> Standing<'a> {
    /// Without load, in the middle of the band of friction and backlash.
    pub fn settled(curve: &'a Loop) -> Standing<'a> {
        Standing { curve, torque: 0.0, wind_up: curve.middle(0.0), rises: true }
    }

    /// Wind-up in rad.
    pub fn wind_up(&self) -> f64 {
        self.wind_up
    }

    /// Whether the last change of the torque was an increase.
    pub fn rises(&self) -> bool {
        self.rises
    }

    /// Changes the torque (N·m); returns the wind-up (rad).
    pub fn load(&mut self, torque: f64) -> f64 {
        if torque != self.torque {
            self.rises = torque > self.torque;
            self.torque = torque;
        }
        let (low, high) = (self.curve.branch(true, torque), self.curve.branch(false, torque));
        self.wind_up = self.wind_up.max(low).min(high);
        self.wind_up
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dead band of ±10 µrad, crossed by the flank at ±1 N·m; 1 µrad per N·m beyond; a width of 4 µrad by
    /// friction.
    fn curve() -> Loop {
        let torques = [-100.0, -50.0, -3.0, -1.0, 1.0, 3.0, 50.0, 100.0];
        let middle = |t: f64| 1e-6 * (t + 10.0 * (t / 1.0).clamp(-1.0, 1.0));
        let width = |t: f64| 2e-6 * (1.0 - (t / 100.0_f64).powi(2));
        let falling = torques.iter().rev().map(|t| (*t, middle(*t) + width(*t)));
        let rising = torques.iter().map(|t| (*t, middle(*t) - width(*t)));
        Loop::new(&falling.chain(rising).collect::<Vec<_>>(), 100.0).unwrap()
    }

    /// On the outer loop the model equals the measured loop, point by point, in any number of cycles.
    #[test]
    fn the_outer_loop_is_the_measured_one() {
        let curve = curve();
        let mut standing = Standing::settled(&curve);
        standing.load(100.0);
        for _ in 0..3 {
            for (torque, angle) in curve.torques.iter().zip(&curve.falling).rev() {
                assert_eq!(standing.load(*torque), *angle);
            }
            for (torque, angle) in curve.torques.iter().zip(&curve.rising) {
                assert_eq!(standing.load(*torque), *angle);
            }
        }
        assert!((curve.lost_motion() - 26e-6).abs() < 1e-15);
    }

    /// A cycle between two torques closes, and a larger one deletes it (return-point memory, wiping out).
    #[test]
    fn inner_swings_close_and_are_wiped_out() {
        let curve = curve();
        let mut standing = Standing::settled(&curve);
        standing.load(40.0);
        let first = standing.load(-20.0);
        let mut plain = standing.clone();
        for inner in [15.0, 5.0, 10.0, 7.0, 38.0] {
            standing.load(inner);
            assert!((standing.load(-20.0) - first).abs() < 1e-18, "{inner}");
        }
        for torque in [0.0, 30.0, 60.0, 10.0] {
            assert!((standing.load(torque) - plain.load(torque)).abs() < 1e-18);
        }
    }

    /// The wind-up does not decrease while the torque increases, inner branches are within the outer loop, and
    /// at the same torque the increasing branch is below the decreasing one.
    #[test]
    fn inner_cycles_stay_within_the_loop() {
        let curve = curve();
        let mut standing = Standing::settled(&curve);
        let (mut seed, mut torque, mut before) = (7_u64, 0.0, standing.wind_up());
        for _ in 0..20_000 {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let next = ((seed >> 33) as f64 / (1_u64 << 31) as f64 - 0.5) * 240.0;
            let wind_up = standing.load(next);
            assert!((wind_up - before) * (next - torque) >= -1e-16);
            let bounds = [curve.branch(true, next), curve.branch(false, next)];
            assert!(
                wind_up >= bounds[0] - 1e-15 && wind_up <= bounds[1] + 1e-15,
                "{next} {wind_up} {bounds:?}"
            );
            (torque, before) = (next, wind_up);
        }
    }

    /// Beyond the measured torques the wind-up is extrapolated with the same slope, without hysteresis.
    #[test]
    fn wind_up_is_extrapolated_beyond_the_tips() {
        let curve = curve();
        let mut standing = Standing::settled(&curve);
        let there = standing.load(150.0);
        standing.load(160.0);
        assert_eq!(standing.load(150.0), there);
        assert!((there - standing.load(100.0) - 50e-6).abs() < 3e-6);
    }
}
