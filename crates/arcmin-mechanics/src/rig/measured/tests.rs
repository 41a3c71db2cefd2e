//! Exact curves with the distortions of test benches, read back.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::*;
use crate::rig::{Branch, LoopFigures, LoopPoint, evaluate_loop};
use crate::units::ARCMIN;

/// A closed loop with clearance and friction, rad over N·m.
struct Truth {
    rated: f64,
    stiffness: f64,
    /// Half of the clearance, and the range of torque over which it is crossed.
    clearance: f64,
    passing: f64,
    /// Torque by which friction delays the crossing.
    delay: f64,
    /// Half width of the loop by friction, and the range of torque after a reversal over which it opens.
    width: f64,
    opening: f64,
}

impl Truth {
    fn random(random: &mut Pcg64) -> Truth {
        let rated = 10f64.powf(random.random_range(1.2..3.5));
        let windup = random.random_range(0.5..4.0) * ARCMIN;
        let opening = random.random_range(0.03..0.2) * rated;
        Truth {
            rated,
            stiffness: rated / windup,
            clearance: random.random_range(0.05..1.0) * ARCMIN,
            passing: random.random_range(0.005..0.02) * rated,
            delay: random.random_range(0.0..0.02) * rated,
            // After a reversal the angle follows the torque less than further on, but not in the opposite
            // direction.
            width: 0.5 * random.random_range(0.1..0.9) * opening * windup / rated,
            opening,
        }
    }

    fn angle(&self, torque: f64, branch: Branch) -> f64 {
        let side = if branch == Branch::Falling { 1.0 } else { -1.0 };
        let since = self.rated - side * torque;
        torque / self.stiffness
            + self.clearance * ((torque + side * self.delay) / self.passing).tanh()
            + side * self.width * (1.0 - 2.0 * (-since / self.opening).exp())
    }

    /// Values of a loop of 20 000 rows without distortion.
    fn figures(&self) -> LoopFigures {
        let mut points = Vec::new();
        for branch in [Branch::Falling, Branch::Rising] {
            for i in 0..=10_000 {
                let share = 1.0 - 2.0 * f64::from(i) / 10_000.0;
                let torque = if branch == Branch::Falling { share } else { -share } * self.rated;
                points.push(LoopPoint { torque, angle: self.angle(torque, branch), branch });
            }
        }
        evaluate_loop(&points, self.rated).unwrap()
    }
}

/// Distortions of a loop by a bench and its operators.
#[derive(Debug, Clone)]
struct Bench {
    rows: usize,
    cycles: usize,
    torque_noise: f64,
    angle_noise: f64,
    offset: f64,
    drift: f64,
    turned: bool,
    both_turned: bool,
    first_loading: bool,
    from_below: bool,
    named: bool,
    sorted: bool,
    /// Rows at each step of torque; 1 for a continuous ramp.
    dwell: usize,
    cut: usize,
}

impl Bench {
    fn quiet() -> Bench {
        Bench {
            rows: 800,
            cycles: 1,
            torque_noise: 0.0,
            angle_noise: 0.0,
            offset: 0.0,
            drift: 0.0,
            turned: false,
            both_turned: false,
            first_loading: false,
            from_below: false,
            named: false,
            sorted: false,
            dwell: 1,
            cut: 0,
        }
    }

    fn random(random: &mut Pcg64) -> Bench {
        let mut bench = Bench {
            rows: random.random_range(150..1500),
            cycles: random.random_range(1..4),
            torque_noise: [0.0, 1e-3, 3e-3, 1e-2][random.random_range(0..4)],
            angle_noise: [0.0, 0.002, 0.01][random.random_range(0..3)] * ARCMIN,
            offset: random.random_range(-500.0..500.0) * ARCMIN,
            drift: [0.0, 0.2][random.random_range(0..2)] * random.random_range(-1.0..1.0) * ARCMIN,
            turned: random.random(),
            both_turned: random.random(),
            first_loading: random.random(),
            from_below: random.random(),
            named: random.random(),
            sorted: false,
            dwell: [1, 1, 6, 12][random.random_range(0..4)],
            cut: random.random_range(0..3),
        };
        if bench.torque_noise > 5e-3 {
            bench.rows = bench.rows.max(400);
        }
        if bench.dwell > 1 {
            bench.rows = bench.dwell * random.random_range(60..120);
            bench.torque_noise = bench.torque_noise.min(3e-3);
        }
        bench
    }

    fn measure(&self, truth: &Truth, random: &mut Pcg64) -> Vec<LoopRow> {
        let mut rows = Vec::new();
        let first = if self.from_below { Branch::Rising } else { Branch::Falling };
        let second = if self.from_below { Branch::Falling } else { Branch::Rising };
        let end = if self.from_below { -truth.rated } else { truth.rated };
        if self.first_loading {
            let count = self.rows / 2;
            for i in 0..count {
                let torque = end * self.step(i, count);
                // Without the friction of a reversal: the virgin curve is between the branches.
                let angle =
                    0.5 * (truth.angle(torque, Branch::Falling) + truth.angle(torque, Branch::Rising));
                rows.push(LoopRow { torque, angle, branch: Some(second) });
            }
        }
        for _ in 0..self.cycles {
            for branch in [first, second] {
                let begin = if branch == Branch::Falling { truth.rated } else { -truth.rated };
                for i in 0..self.rows {
                    let torque = begin * (1.0 - 2.0 * self.step(i, self.rows));
                    rows.push(LoopRow { torque, angle: truth.angle(torque, branch), branch: Some(branch) });
                }
            }
        }
        rows.truncate(rows.len() - self.cut);
        let per_loop = (2 * self.rows) as f64;
        let normal = Normal::new(0.0, 1.0).unwrap();
        for (index, row) in rows.iter_mut().enumerate() {
            row.torque += self.torque_noise * truth.rated * normal.sample(random);
            row.angle += self.angle_noise * normal.sample(random);
            row.angle += self.offset + self.drift * index as f64 / per_loop;
            if !self.named {
                row.branch = None;
            }
            if self.both_turned {
                (row.torque, row.angle) = (-row.torque, -row.angle);
            }
            if self.turned {
                row.angle = -row.angle;
            }
        }
        if self.sorted {
            rows.sort_by(|a, b| {
                (a.branch == Some(Branch::Rising))
                    .cmp(&(b.branch == Some(Branch::Rising)))
                    .then(a.torque.total_cmp(&b.torque))
            });
        }
        rows
    }

    /// Part of the path at row `i` of `count`; steps at which the torque is held are denser around zero.
    fn step(&self, i: usize, count: usize) -> f64 {
        let steps = count / self.dwell;
        let way = ((i / self.dwell) as f64 / (steps.max(2) - 1) as f64).min(1.0);
        if self.dwell == 1 || count < self.rows {
            return way;
        }
        let share = 1.0 - 2.0 * way;
        0.5 - 0.5 * share * share.abs()
    }
}

/// Mean over all loops with the half width of its interval.
fn read(rows: &[LoopRow], rated: f64) -> ([(f64, f64); 6], Vec<Remark>) {
    let (loops, remarks) = read_loops(rows, rated).unwrap();
    let bench = MeasuredOnBench { loops, ..MeasuredOnBench::default() };
    let of: [fn(&LoopFigures) -> f64; 6] = [
        |f| f.lost_motion,
        |f| f.backlash,
        |f| f.stiffness,
        |f| f.soft_stiffness,
        |f| f.middle_stiffness,
        |f| f.work.abs(),
    ];
    (of.map(|of| bench.figure(of).unwrap()), remarks)
}

/// Random loops on random benches: noise of torque and angle, offset, drift, either sign of torque and angle,
/// first loading, one to three cycles, steps, missing last rows, with and without names of the branches.
/// Nineteen of twenty values (four of five soft stiffnesses) are within their 95 % intervals and 1 %.
#[test]
#[ignore = "long"]
fn loops_are_read_with_distortions_of_benches() {
    let mut random = Pcg64::seed_from_u64(1);
    let cases = 120;
    let mut within = [0; 4];
    let mut off = vec![Vec::new(); 4];
    for _ in 0..cases {
        let (truth, bench) = (Truth::random(&mut random), Bench::random(&mut random));
        let rows = bench.measure(&truth, &mut random);
        let (expected, (found, _)) = (truth.figures().all(), read(&rows, truth.rated));
        for (k, (value, uncertainty)) in found.into_iter().take(4).enumerate() {
            let error = (value - expected[k]).abs();
            within[k] += usize::from(error <= uncertainty + 0.01 * expected[k]);
            // The backlash may be near zero.
            off[k].push(error / expected[if k < 2 { 0 } else { k }]);
        }
    }
    // The soft stiffness is that of the rows between 3 % and 15 %, which are few in some tests.
    for (k, (median, nine_of_ten, least)) in
        [(0.01, 0.05, 0.95), (0.02, 0.08, 0.95), (0.005, 0.02, 0.95), (0.02, 0.1, 0.8)]
            .into_iter()
            .enumerate()
    {
        off[k].sort_by(f64::total_cmp);
        let (half, most) = (off[k][cases / 2], off[k][cases * 9 / 10]);
        assert!(half < median && most < nine_of_ten, "figure {k}: {half} {most}");
        assert!(within[k] as f64 >= least * cases as f64, "figure {k}: {within:?}");
    }
}

/// The same file from a bench with other signs, started at the lower end, with rows sorted by torque, or with
/// exchanged names of the branches, gives the same values, and each correction is reported.
#[test]
fn signs_and_orders_of_rows_do_not_matter_and_are_reported() {
    let mut random = Pcg64::seed_from_u64(2);
    let truth = Truth::random(&mut random);
    let expected = truth.figures().all();
    let check = |rows: &[LoopRow], words: &[&str]| {
        let (found, remarks) = read(rows, truth.rated);
        for k in 0..5 {
            assert!((found[k].0 / expected[k] - 1.0).abs() < 0.01, "{k}: {} {}", found[k].0, expected[k]);
        }
        assert_eq!(remarks.len(), words.len(), "{remarks:?}");
        for (remark, words) in remarks.iter().zip(words) {
            assert!(remark.text.contains(words), "{remark:?}");
        }
    };
    let plain = Bench { named: true, ..Bench::quiet() };
    check(&plain.measure(&truth, &mut random), &[]);
    check(&Bench { from_below: true, ..plain.clone() }.measure(&truth, &mut random), &[]);
    check(&Bench { named: false, both_turned: true, ..plain.clone() }.measure(&truth, &mut random), &[]);
    check(&Bench { turned: true, ..plain.clone() }.measure(&truth, &mut random), &["opposite senses"]);
    check(&Bench { both_turned: true, ..plain.clone() }.measure(&truth, &mut random), &["contradict"]);
    check(&Bench { sorted: true, ..plain.clone() }.measure(&truth, &mut random), &["sorted by torque"]);
    let first = Bench { first_loading: true, ..plain.clone() }.measure(&truth, &mut random);
    check(&first, &["first loading"]);
    let mut reversed = plain.measure(&truth, &mut random);
    reversed.reverse();
    reversed.iter_mut().for_each(|row| row.branch = None);
    check(&reversed, &["order of the rows is"]);
    let drifting = Bench { drift: 0.3 * ARCMIN, ..plain.clone() }.measure(&truth, &mut random);
    check(&drifting, &["drifts by"]);
    // A loop that is computed, or measured without noise, is read without any change, to the last bit.
    let rows = plain.measure(&truth, &mut random);
    let points: Vec<LoopPoint> = rows
        .iter()
        .map(|row| LoopPoint { torque: row.torque, angle: row.angle, branch: row.branch.unwrap() })
        .collect();
    let own = evaluate_loop(&points, truth.rated).unwrap();
    assert_eq!(read_loops(&rows, truth.rated).unwrap().0[0].figures, own);
}

/// Rows that are not a loop are refused with the reason.
#[test]
fn rows_that_are_not_a_loop_are_refused() {
    let row = |torque: f64, angle: f64| LoopRow { torque, angle, branch: None };
    let up: Vec<LoopRow> = (0..50).map(|i| row(f64::from(i) - 25.0, f64::from(i))).collect();
    let half: Vec<LoopRow> = up.iter().map(|r| row(0.3 * r.torque, r.angle)).collect();
    let small: Vec<LoopRow> = half.iter().chain(half.iter().rev()).copied().collect();
    for (rows, words) in [
        (vec![row(1.0, 0.0); 20], "torque does not change"),
        (vec![row(1.0, 0.0), row(2.0, 1.0)], "torque does not change"),
        (up, "branch is missing"),
        (small, "does not reach the rated torque"),
    ] {
        let error = read_loops(&rows, 25.0).unwrap_err();
        assert!(error.what.contains(words) && !error.remedy.is_empty(), "{error:?}");
    }
}

/// Noise, lines and steps separately.
#[test]
fn lines_average_noise_and_keep_corners() {
    use super::series::{Course, Lines, held, noise, one_way, turning_points};
    let mut random = Pcg64::seed_from_u64(3);
    let normal = Normal::new(0.0, 0.1).unwrap();
    let rows: Vec<f64> = (0..1000).map(f64::from).collect();
    let corner = |x: &f64| if *x < 500.0 { 0.01 * x } else { 5.0 + 0.03 * (x - 500.0) };
    let noisy: Vec<f64> = rows.iter().map(|x| corner(x) + normal.sample(&mut random)).collect();
    assert!((noise(&rows, &noisy) / 0.1 - 1.0).abs() < 0.1);
    let lines = Lines::through(&rows, &noisy, Course::Answer);
    let square: f64 = rows.iter().zip(&lines.values).map(|(x, y)| (y - corner(x)).powi(2)).sum();
    // As means over eighteen rows.
    assert!((square / 1000.0).sqrt() < 0.1 / 18f64.sqrt(), "{}", (square / 1000.0).sqrt());
    let clean: Vec<f64> = rows.iter().map(corner).collect();
    assert!(
        Lines::through(&rows, &clean, Course::Set)
            .values
            .iter()
            .zip(&clean)
            .all(|(a, b)| (a - b).abs() < 1e-9)
    );
    assert_eq!(one_way(&[1.0, 3.0, 2.0, 4.0], true), [1.0, 2.5, 2.5, 4.0]);
    assert_eq!(one_way(&[4.0, 2.0, 3.0], false), [4.0, 2.5, 2.5]);
    assert_eq!(turning_points(&[0.0, 5.0, 4.8, 5.2, -5.0, 5.0, 4.0], 3.0), [0, 3, 4, 6]);
    assert_eq!(held(&[1.0, 1.0, 1.1, 1.0, 3.0, 2.9, 3.0, 5.0, 5.0], true).unwrap(), [0..4, 4..7, 7..9]);
    // Rows that become denser towards zero are not steps, nor is a ramp, with or without noise.
    assert!(held(&[100.0, 50.0, 20.0, 10.0, 5.0, 3.0, 2.0, 1.0, 0.0], false).is_none());
    assert!(held(&clean, true).is_none() && held(&noisy, true).is_none());
}

/// A transmission error of known orders, rad over the angle of the output.
fn waves() -> [(usize, f64, f64); 5] {
    [(1, 0.2, 0.3), (39, 0.12, 1.0), (40, 0.3, 2.0), (78, 0.05, -1.0), (156, 0.02, 0.5)]
        .map(|(order, amplitude, phase)| (order, amplitude * ARCMIN, phase))
}

fn error_at(angle: f64) -> f64 {
    waves().iter().map(|(order, size, phase)| size * (*order as f64 * angle + phase).cos()).sum()
}

/// Distortions of a transmission error by a bench.
#[derive(Debug, Clone)]
struct TurnBench {
    places: usize,
    /// Number of positions per turn.
    per_turn: usize,
    /// Number of readings at each position.
    readings: usize,
    /// Standard deviations of the angle in steps and of the error in rad.
    jitter: f64,
    noise: f64,
    /// Counts of the encoder per turn.
    counts: Option<f64>,
    /// Drift in rad per turn.
    drift: f64,
    wraps: bool,
    backwards: bool,
}

impl TurnBench {
    fn measure(&self, random: &mut Pcg64) -> Vec<TurnRow> {
        let normal = Normal::new(0.0, 1.0).unwrap();
        let step = std::f64::consts::TAU / self.per_turn as f64;
        let sign = if self.backwards { -1.0 } else { 1.0 };
        let mut rows = Vec::new();
        for place in 0..self.places {
            for _ in 0..self.readings {
                let angle = place as f64 * step;
                let mut shown = angle + self.jitter * step * normal.sample(random);
                if let Some(counts) = self.counts {
                    let count = std::f64::consts::TAU / counts;
                    shown = (shown / count).floor() * count;
                }
                if self.wraps {
                    shown = shown.rem_euclid(std::f64::consts::TAU);
                }
                let error = error_at(sign * angle)
                    + self.drift * angle / std::f64::consts::TAU
                    + self.noise * normal.sample(random);
                rows.push(TurnRow { angle: sign * shown, error, direction: None, torque: None });
            }
        }
        rows
    }
}

/// A turn without its last position, several turns with an angle that wraps, repeated and noisy angles, coarse
/// encoders, noise, drift, both directions: the orders are within their intervals (and 1 %), and so is the
/// peak-to-peak value.
#[test]
fn turns_are_read_with_distortions_of_benches() {
    let plain = TurnBench {
        places: 1440,
        per_turn: 1440,
        readings: 1,
        jitter: 0.0,
        noise: 0.0,
        counts: None,
        drift: 0.0,
        wraps: false,
        backwards: false,
    };
    let closed = TurnBench { places: 1441, ..plain.clone() };
    let benches = [
        plain.clone(),
        closed.clone(),
        TurnBench { places: 1439, ..plain.clone() },
        TurnBench { backwards: true, ..plain.clone() },
        TurnBench { noise: 0.05 * ARCMIN, ..plain.clone() },
        TurnBench { jitter: 0.2, ..plain.clone() },
        TurnBench { jitter: 1.0, noise: 0.02 * ARCMIN, ..plain.clone() },
        TurnBench { places: 4 * 1440, wraps: true, noise: 0.05 * ARCMIN, ..plain.clone() },
        TurnBench { places: 3 * 1440 + 700, wraps: true, jitter: 0.5, ..plain.clone() },
        TurnBench { readings: 6, noise: 0.05 * ARCMIN, ..plain.clone() },
        TurnBench { readings: 8, jitter: 0.05, noise: 0.05 * ARCMIN, ..plain.clone() },
        TurnBench { places: 14_400, per_turn: 14_400, counts: Some(2048.0), ..plain.clone() },
        TurnBench {
            places: 3600,
            per_turn: 3600,
            counts: Some(2000.0),
            noise: 0.02 * ARCMIN,
            ..plain.clone()
        },
        TurnBench { drift: 0.3 * ARCMIN, ..closed.clone() },
        TurnBench { drift: -0.2 * ARCMIN, noise: 0.01 * ARCMIN, ..plain.clone() },
        TurnBench { places: 3 * 1440 + 10, drift: 0.2 * ARCMIN, noise: 0.03 * ARCMIN, ..plain.clone() },
        TurnBench { backwards: true, wraps: true, places: 2 * 1440 + 3, jitter: 0.3, ..plain },
    ];
    let truth: Vec<f64> =
        (0..100_000).map(|i| error_at(std::f64::consts::TAU * f64::from(i) / 1e5)).collect();
    let peak_to_peak =
        truth.iter().fold(f64::MIN, |m, e| m.max(*e)) - truth.iter().fold(f64::MAX, |m, e| m.min(*e));
    let mut random = Pcg64::seed_from_u64(4);
    for bench in benches {
        let (curves, remarks) = read_turns(&bench.measure(&mut random), 400.0).unwrap();
        let [curve] = &curves[..] else { panic!("{bench:?}: {remarks:?}") };
        assert_eq!(curve.curve.direction, if bench.backwards { -1.0 } else { 1.0 });
        let spectrum = curve.spectrum.as_ref().unwrap_or_else(|| panic!("{bench:?}: {remarks:?}"));
        // A count of the encoder averages over its width: order 156 is reduced by 1.5 % at 2000 counts.
        for (order, amplitude, _) in waves() {
            let (found, doubt) = (spectrum.lines[order].amplitude, spectrum.uncertainty[order]);
            let allowed = 1.5 * doubt + 0.02 * amplitude + 1e-4 * ARCMIN;
            assert!(
                (found - amplitude).abs() < allowed,
                "{bench:?} {order}: {found:e} ± {doubt:e}, {amplitude:e} {remarks:?}"
            );
            assert!(doubt < 0.02 * ARCMIN, "{bench:?} {order}: {doubt:e}");
        }
        let off = (curve.peak_to_peak - peak_to_peak).abs();
        let allowed = 1.5 * curve.peak_to_peak_uncertainty + 0.02 * peak_to_peak;
        assert!(
            off < allowed,
            "{bench:?}: {} {} ± {}",
            peak_to_peak / ARCMIN,
            curve.peak_to_peak / ARCMIN,
            curve.peak_to_peak_uncertainty / ARCMIN
        );
        let words = |words: &str| remarks.iter().any(|remark| remark.text.contains(words));
        assert_eq!(words("drifts by"), bench.drift != 0.0, "{bench:?} {remarks:?}");
    }
}

/// A forward and a backward turn in one file without a column of directions are two curves; a part of a turn is
/// read and has no spectrum, which is reported; directions in the file have priority over the signs of the
/// angles; noisy torques belong to one curve.
#[test]
fn files_of_several_curves_and_parts_of_turns() {
    let at = |degrees: f64, direction, torque| TurnRow {
        angle: degrees.to_radians(),
        error: error_at(degrees.to_radians()),
        direction,
        torque,
    };
    let forward: Vec<TurnRow> = (0..=720).map(|i| at(0.5 * f64::from(i), None, None)).collect();
    let there_and_back: Vec<TurnRow> = forward.iter().chain(forward.iter().rev()).copied().collect();
    let (curves, remarks) = read_turns(&there_and_back, 400.0).unwrap();
    assert_eq!(curves.iter().map(|curve| curve.curve.direction).collect::<Vec<_>>(), [1.0, -1.0]);
    assert!(remarks.is_empty() && curves.iter().all(|curve| curve.spectrum.is_some()));
    let (curves, remarks) = read_turns(&forward[..600], 400.0).unwrap();
    assert!(
        curves[0].spectrum.is_none() && remarks[0].text.contains("299.5°") && remarks[0].rows == Some(0..600)
    );
    let travelled: Vec<TurnRow> = (0..=720)
        .map(|i| at(0.5 * f64::from(i), Some(-1.0), Some(if i % 2 == 0 { 100.0 } else { 103.0 })))
        .collect();
    let (curves, remarks) = read_turns(&travelled, 400.0).unwrap();
    assert!(
        curves.len() == 1
            && curves[0].curve.direction == -1.0
            && (curves[0].curve.torque - 101.5).abs() < 0.1
    );
    assert!(remarks[0].text.contains("contradicts the direction given"));
    let still: Vec<TurnRow> = (0..20).map(|_| at(3.0, None, None)).collect();
    assert!(read_turns(&still, 400.0).unwrap_err().what.contains("does not change"));
    assert!(read_turns(&forward[..5], 400.0).is_err());
}
