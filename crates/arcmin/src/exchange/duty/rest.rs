//! Detection of rest from the signal itself.

use super::clock::{median, quantile};

/// A log's readings, each valid until the next.
pub(super) struct Motion<'a> {
    /// Times, s.
    pub time: &'a [f64],
    /// Output speed in rad/s.
    pub speed: &'a [f64],
    /// Whether a reading follows the previous one without a gap.
    pub connected: &'a [bool],
    /// Number of readings over which the speeds are already averaged.
    pub blurred: usize,
    /// Standard deviation of the speeds in rad/s if known, otherwise 0.
    pub noise: f64,
}

/// Readings in motion and at rest.
pub(super) struct Rest {
    /// Output speed in rad/s below which the joint rests.
    pub speed: f64,
    /// For each reading whether the joint moves.
    pub moves: Vec<bool>,
    /// Number of starts from rest.
    pub starts: usize,
    pub reversals: usize,
}

/// Fraction of the largest speed below which the joint is at rest in a log without noise.
const LEAST: f64 = 1e-3;
/// Fraction of the largest speed below which flickering about zero is searched.
const SLOW: f64 = 0.2;
/// s; readings with longer steps do not show flickering.
const QUICK: f64 = 0.1;
/// Number of successive readings of one sign that are not flickering.
const SUSTAINED: usize = 20;

impl Motion<'_> {
    /// Divides the log into rest and motion. The joint is at rest below `given`; without it, below the largest
    /// of
    ///
    /// * a thousandth of the largest speed,
    /// * one count, if the speeds are counts,
    /// * the largest flickering speed: runs of one sign of at most three readings; without such runs, four standard
    ///   deviations of the noise of slow readings,
    ///
    /// but at most a quarter of the largest speed. An interval below it that is not longer than a passage
    /// through zero at the acceleration around it is not rest, and a move begins and ends where its ramps,
    /// extrapolated, reach zero.
    pub(super) fn split(&self, given: Option<f64>) -> Rest {
        let sizes: Vec<f64> = self.speed.iter().map(|speed| speed.abs()).collect();
        let peak = quantile(&sizes, 0.999);
        let step = self.step();
        let threshold = given.unwrap_or_else(|| {
            let flicker = 1.05 * self.flicker(SLOW * peak, step);
            let noise = if flicker > 0.0 { flicker } else { 4.0 * self.noise_of_slow(SLOW * peak, step) };
            let count = if step < QUICK { self.count(0.05 * peak) } else { 0.0 };
            noise.max(4.0 * self.noise).max(1.05 * count).max(LEAST * peak).min(0.25 * peak)
        });
        let mut moves: Vec<bool> = sizes.iter().map(|size| *size > threshold).collect();
        self.keep_slow(&mut moves, threshold);
        self.drop_flicker(&mut moves, threshold, step);
        self.keep_passing(&mut moves, threshold, step);
        let starts = (1..moves.len()).filter(|i| moves[*i] && !moves[i - 1] && self.connected[*i]).count();
        let reversals = self.reversals(&moves, threshold);
        if given.is_none() {
            self.draw_ramps_on(&mut moves, threshold);
        }
        Rest { speed: threshold, moves, starts, reversals }
    }

    fn step(&self) -> f64 {
        let steps: Vec<f64> = self.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        median(&steps)
    }

    /// Standard deviation of slow readings from a smooth curve, by second differences.
    fn noise_of_slow(&self, slow: f64, step: f64) -> f64 {
        let near = |i: usize| self.time[i + 1] - self.time[i] < 3.0 * step && self.connected[i + 1];
        let bends: Vec<f64> = (1..self.speed.len().saturating_sub(1))
            .filter(|i| near(i - 1) && near(*i) && self.speed[i - 1..=i + 1].iter().all(|v| v.abs() < slow))
            .map(|i| (self.speed[i + 1] - 2.0 * self.speed[i] + self.speed[i - 1]).abs())
            .collect();
        // With fewer values the result is random; in averages over several readings the curvature exceeds the
        // noise.
        if bends.len() < 30 || self.blurred > 1 { 0.0 } else { median(&bends) / (0.6745 * 6_f64.sqrt()) }
    }

    /// The unit of which the speeds are multiples, if there is one and it is not larger than this; otherwise 0.
    fn count(&self, largest: f64) -> f64 {
        let changes = self.speed.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let count = changes.filter(|change| *change > 0.0).fold(f64::INFINITY, f64::min);
        let whole = self.speed.iter().filter(|speed| {
            let counts = *speed / count;
            (counts - counts.round()).abs() < 0.05
        });
        if count <= largest && whole.count() * 100 > self.speed.len() * 99 { count } else { 0.0 }
    }

    /// Sustained slow readings of one sign are motion.
    fn keep_slow(&self, moves: &mut [bool], threshold: f64) {
        let slow = |i: usize| self.speed[i].abs() > 0.5 * threshold;
        let mut from = 0;
        for to in 1..=moves.len() {
            let same = to < moves.len()
                && self.connected[to]
                && slow(to) == slow(from)
                && (self.speed[to] > 0.0) == (self.speed[from] > 0.0);
            if same {
                continue;
            }
            if slow(from) && to - from >= SUSTAINED * self.blurred {
                moves[from..to].fill(true);
            }
            from = to;
        }
    }

    /// Largest slow speed of runs of one sign of at most three readings (of unaveraged ones).
    fn flicker(&self, slow: f64, step: f64) -> f64 {
        let longest = 3 * self.blurred;
        let mut tops: Vec<f64> = Vec::new();
        let mut from = 0;
        for to in 1..=self.speed.len() {
            let sign = |i: usize| self.speed[i].partial_cmp(&0.0);
            if to < self.speed.len() && sign(to) == sign(from) && self.connected[to] {
                continue;
            }
            let top = self.speed[from..to].iter().fold(0.0_f64, |top, v| top.max(v.abs()));
            let end = self.time[to.min(self.time.len() - 1)];
            let lasts = end - self.time[from];
            let inside = from > 0 && to < self.speed.len();
            if inside && to - from <= longest && top < slow && step < QUICK && lasts <= 0.3 {
                tops.push(top);
            }
            from = to;
        }
        let flickers = tops.iter().filter(|top| **top > 0.0).count();
        if flickers < 3 { 0.0 } else { tops.into_iter().fold(0.0, f64::max) }
    }

    /// Changes of direction from one moving interval to the next. An interval that is slow and short, or of two
    /// readings with a small excess over the threshold, is noise.
    fn reversals(&self, moves: &[bool], threshold: f64) -> usize {
        let mut ways: Vec<(f64, usize, f64)> = Vec::new();
        for i in (0..moves.len()).filter(|i| moves[*i] && self.speed[*i].abs() > 0.5 * threshold) {
            let (way, size) = (self.speed[i].signum(), self.speed[i].abs());
            match ways.last_mut() {
                Some((last, count, top)) if *last == way => (*count, *top) = (*count + 1, top.max(size)),
                _ => ways.push((way, 1, size)),
            }
        }
        let quick = self.step() < QUICK;
        let real = |(_, count, top): &&(f64, usize, f64)| {
            let fast = *top > threshold && (!quick || *count > 2 * self.blurred || *top > 2.0 * threshold);
            fast || *count >= SUSTAINED * self.blurred
        };
        let mut ways = ways.iter().filter(real).map(|way| way.0);
        let first = ways.next();
        ways.fold((0, first), |(count, last), way| (count + usize::from(Some(way) != last), Some(way))).0
    }

    /// One or two readings that exceed the threshold by less than its own value are noise.
    fn drop_flicker(&self, moves: &mut [bool], threshold: f64, step: f64) {
        for (from, to) in runs(moves, self.connected, true) {
            let top = self.speed[from..to].iter().fold(0.0_f64, |top, v| top.max(v.abs()));
            let lasts = self.time[to.min(self.time.len() - 1)] - self.time[from];
            let short = to - from <= 2 * self.blurred && lasts <= 2.5 * step * self.blurred as f64;
            let alone = from > 0 && to < moves.len() && self.connected[from];
            if short && alone && step < QUICK && top < 2.0 * threshold {
                moves[from..to].fill(false);
            }
        }
    }

    /// Intervals below the threshold during a passage through zero are motion.
    fn keep_passing(&self, moves: &mut [bool], threshold: f64, step: f64) {
        let count = moves.len();
        for (from, to) in runs(moves, self.connected, false) {
            if from == 0 || to == count || !self.connected[from] || !self.connected[to] {
                continue;
            }
            let lasts = self.time[to] - self.time[from];
            let passing = self.ramp(from - 1, true, threshold) + self.ramp(to, false, threshold);
            if lasts < (2.0 * passing).min(0.5) + 1.5 * step.min(QUICK) {
                moves[from..to].fill(true);
            }
        }
    }
}

impl Motion<'_> {
    /// Time in s for which the ramp of the move before or after an interval of rest is between zero and the
    /// threshold, extrapolated from the time it needs up to three times the threshold, or to the top of a
    /// slower move.
    fn ramp(&self, edge: usize, back: bool, threshold: f64) -> f64 {
        let (mut at, mut top) = (edge, edge);
        let next = |at: usize| match back {
            true => at.checked_sub(1).filter(|_| self.connected[at]),
            false => Some(at + 1).filter(|at| *at < self.speed.len() && self.connected[*at]),
        };
        while self.speed[at].abs() < 3.0 * threshold {
            let Some(following) = next(at).filter(|at| self.speed[*at].abs() > 0.5 * threshold) else {
                break;
            };
            at = following;
            top = if self.speed[at].abs() > self.speed[top].abs() { at } else { top };
        }
        let (from, gained) = (self.speed[edge].abs(), self.speed[top].abs() - self.speed[edge].abs());
        let seconds = (self.time[top] - self.time[edge]).abs();
        if gained > 0.25 * threshold { (seconds * from / gained).min(0.5) } else { 0.0 }
    }

    /// Readings below the threshold on the ramps of a move belong to it.
    fn draw_ramps_on(&self, moves: &mut [bool], threshold: f64) {
        // Averages over several readings increase before the speed itself.
        let early = if self.blurred > 1 { self.blurred as f64 * self.step() } else { 0.0 };
        let reach = |edge: usize, back: bool| (self.ramp(edge, back, threshold) - early).max(0.0);
        for (from, to) in runs(moves, self.connected, false) {
            let (start, end) = (self.time[from], self.time[to.min(moves.len() - 1)]);
            // A ramp is at most the outer third of a move.
            let most = (end - start) / 3.0;
            let after_move = from > 0 && self.connected[from];
            let before_move = to < moves.len() && self.connected[to];
            let down = if after_move { reach(from - 1, true).min(most) } else { 0.0 };
            let up = if before_move { reach(to, false).min(most) } else { 0.0 };
            for i in from..to {
                // A reading that remains valid for a long time is not on a ramp.
                let until = self.time[(i + 1).min(moves.len() - 1)];
                let slack = 1e-6 * (until - self.time[i]);
                moves[i] = until <= start + down + slack || (up > 0.0 && self.time[i] >= end - up - slack);
            }
        }
    }
}

/// Runs of readings that all move, or are all at rest, as index ranges.
fn runs(moves: &[bool], connected: &[bool], wanted: bool) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut from = 0;
    for to in 1..=moves.len() {
        if to < moves.len() && moves[to] == moves[from] && connected[to] {
            continue;
        }
        if moves[from] == wanted {
            found.push((from, to));
        }
        from = to;
    }
    found
}
