//! Where a joint stands in its hysteresis loop: the measured loop with a memory of where it came from.

/// The loop of a joint: wind-up (rad) over the torque on the output flange from outside (N·m).
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// Rising, from − to + the largest torque that was measured.
    torques: Vec<f64>,
    /// Wind-up while the torque rises and while it falls, both from the least torque to the largest.
    rising: Vec<f64>,
    falling: Vec<f64>,
    /// N·m: 3 % of the rated torque, at which lost motion is read.
    lost_motion_torque: f64,
}

impl Loop {
    /// From the loop of a bench: (torque, angle), first falling from + to −, then rising. `None` for anything else.
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
        // A loop that is gone through once closes at its tips but for the first loading.
        for tip in [0, half - 1] {
            let middle = 0.5 * (rising[tip] + falling[tip]);
            (rising[tip], falling[tip]) = (middle, middle);
        }
        // Balances scatter by less than any figure; no torque may make the wind-up fall, and no way cross the other.
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

    /// Torques up to which the loop was measured.
    pub fn range(&self) -> [f64; 2] {
        self.tips().map(|tip| tip.0)
    }

    /// Wind-up on the outer branch of a torque that rises, or falls: between its points, beyond the tips as steep as the
    /// outer half is on average.
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

    /// Mean of both branches.
    pub fn middle(&self, torque: f64) -> f64 {
        0.5 * (self.branch(true, torque) + self.branch(false, torque))
    }

    /// The part of [`Loop::middle`] that is elastic: what a torque adds beyond ±3 % of the rated one. What is left of
    /// the loop is lost motion, between + and − 3 % exactly the catalogue's.
    pub fn elastic(&self, torque: f64) -> f64 {
        let low = self.lost_motion_torque;
        self.middle(torque) - self.middle(torque.clamp(-low, low))
    }

    /// Lost motion in rad.
    pub fn lost_motion(&self) -> f64 {
        self.middle(self.lost_motion_torque) - self.middle(-self.lost_motion_torque)
    }
}

/// Where the joint stands in its loop: a generalised play (Krasnosel'skii and Pokrovskii) between the measured branches.
///
/// After a reversal friction holds the wind-up where it is until the torque has left the band of both branches:
/// φ ← min(max(φ, rising(T)), falling(T)). On the outer loop that is the bench's loop to the last digit; it remembers
/// where it turned round, and a larger swing wipes a smaller one out.
#[derive(Debug, Clone)]
pub struct Standing<'a> {
    curve: &'a Loop,
    torque: f64,
    wind_up: f64,
    rises: bool,
}

impl<'a> Standing<'a> {
    /// Without load, in the middle of what friction and play allow.
    pub fn settled(curve: &'a Loop) -> Standing<'a> {
        Standing { curve, torque: 0.0, wind_up: curve.middle(0.0), rises: true }
    }

    /// Wind-up in rad.
    pub fn wind_up(&self) -> f64 {
        self.wind_up
    }

    /// Whether the torque rose last.
    pub fn rises(&self) -> bool {
        self.rises
    }

    /// Goes to another torque; the wind-up there.
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

    /// Dead band of ±10 µrad that the flank crosses at ±1 N·m, 1 µrad per N·m beyond, a width of 4 µrad from friction.
    fn curve() -> Loop {
        let torques = [-100.0, -50.0, -3.0, -1.0, 1.0, 3.0, 50.0, 100.0];
        let middle = |t: f64| 1e-6 * (t + 10.0 * (t / 1.0).clamp(-1.0, 1.0));
        let width = |t: f64| 2e-6 * (1.0 - (t / 100.0_f64).powi(2));
        let falling = torques.iter().rev().map(|t| (*t, middle(*t) + width(*t)));
        let rising = torques.iter().map(|t| (*t, middle(*t) - width(*t)));
        Loop::new(&falling.chain(rising).collect::<Vec<_>>(), 100.0).unwrap()
    }

    /// On the outer loop the model is the measured loop, point by point, however often it is gone through.
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

    /// A swing between two torques closes, and a larger one forgets it (return-point memory, wiping out).
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

    /// Wind-up never falls while the torque rises, inner ways stay within the outer loop, and what rises at a torque
    /// stands below what falls.
    #[test]
    fn ways_stay_within_the_loop() {
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

    /// Beyond the torque that was measured the wind-up goes on as steep as before, without hysteresis.
    #[test]
    fn beyond_the_tips_it_goes_on() {
        let curve = curve();
        let mut standing = Standing::settled(&curve);
        let there = standing.load(150.0);
        standing.load(160.0);
        assert_eq!(standing.load(150.0), there);
        assert!((there - standing.load(100.0) - 50e-6).abs() < 3e-6);
    }
}
