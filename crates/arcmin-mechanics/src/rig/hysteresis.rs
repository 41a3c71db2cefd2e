use super::RigError;
use super::settle::{CONTROL, SlowLoad, tangent};
use crate::dynamics::labels::{PARTS, PIN_RING};
use crate::dynamics::mechanism::Mechanism;
use crate::dynamics::{BearingJoints, HeldDrive, JointSettings, Part};
use crate::load::LOST_MOTION_SHARE;
use crate::machine::{Machine, StageFriction};

/// Branch of a hysteresis loop: direction in which the torque changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// From + rated to − rated.
    Falling,
    /// From − rated to + rated.
    Rising,
}

impl Branch {
    /// Word in tables and files.
    pub fn word(self) -> &'static str {
        match self {
            Branch::Falling => "falling",
            Branch::Rising => "rising",
        }
    }
}

/// One point of a hysteresis loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopPoint {
    /// Torque applied to the output in N·m, positive along positive rotation.
    pub torque: f64,
    /// Angle of the output in rad relative to its nominal position.
    pub angle: f64,
    /// Direction of change of the torque.
    pub branch: Branch,
}

/// Values read from a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopFigures {
    /// Angle between the mid-points of the branches at ± 3 % of rated torque, rad.
    pub lost_motion: f64,
    /// Width of the loop at zero torque, rad.
    pub backlash: f64,
    /// Mean slope of both branches between 50 % and 100 % of rated torque, both signs, N·m/rad.
    pub stiffness: f64,
    /// The same between 3 % and 15 %, where only a part of the rollers is loaded.
    pub soft_stiffness: f64,
    /// The same between 15 % and 50 %.
    pub middle_stiffness: f64,
    /// Energy loss per cycle, J.
    pub work: f64,
}

impl LoopFigures {
    /// The values in the order of their declaration.
    pub(super) fn all(&self) -> [f64; 6] {
        [
            self.lost_motion,
            self.backlash,
            self.stiffness,
            self.soft_stiffness,
            self.middle_stiffness,
            self.work,
        ]
    }

    /// Mean of the loops of several positions.
    pub fn mean(loops: &[LoopFigures]) -> LoopFigures {
        let all: Vec<[f64; 6]> = loops.iter().map(LoopFigures::all).collect();
        let mean = |index: usize| all.iter().map(|one| one[index]).sum::<f64>() / all.len() as f64;
        LoopFigures::from_all(std::array::from_fn(mean))
    }

    pub(super) fn from_all(all: [f64; 6]) -> LoopFigures {
        let [lost_motion, backlash, stiffness, soft_stiffness, middle_stiffness, work] = all;
        LoopFigures { lost_motion, backlash, stiffness, soft_stiffness, middle_stiffness, work }
    }
}

/// Shares of rated torque between which the torsional stiffness is read.
pub const STIFFNESS_WINDOW: (f64, f64) = (0.5, 1.0);
/// The backlash is read at this share of rated torque before zero on each branch, where the flank is still in
/// contact.
const ZERO_SHARE: f64 = 1e-4;

/// Torques of one branch as shares of the rated torque, falling.
pub fn shares() -> Vec<f64> {
    const STEPS: i32 = 24;
    let mut shares: Vec<f64> = (-STEPS..=STEPS)
        .filter(|i| *i != 0)
        .map(|i| f64::from(i) / f64::from(STEPS))
        // More points near zero, where the curvature of the loop is largest.
        .map(|x| x * x.abs().sqrt())
        .chain([0.5, -0.5, LOST_MOTION_SHARE, -LOST_MOTION_SHARE, ZERO_SHARE, -ZERO_SHARE])
        .collect();
    shares.sort_by(|a, b| b.total_cmp(a));
    shares
}

/// Cycles the output torque to ± rated with the sun fixed at `sun` (rad). Friction opposes every change;
/// without friction both branches coincide except for the clearance.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn hysteresis_loop(
    machine: &Machine,
    settings: &JointSettings,
    sun: f64,
) -> Result<Vec<LoopPoint>, RigError> {
    let rated = machine.rated.torque.abs();
    if !(rated > 0.0) {
        return Err(RigError::NoTorque);
    }
    let settings = JointSettings { damped: false, ..settings.clone() };
    let mut model = BearingJoints::held(machine, &settings)?;
    model.hold_sun(sun, 0.0);
    let speed = machine.friction.regularisation_speed;
    let start = model.nominal_position_at(sun);
    let mut machine = SlowLoad::new((Mechanism::clone(&model), rated, CONTROL), speed, start);
    cycle(&mut machine, rated, 1.0)
}

/// Cycles the output torque of a drive of eccentrics to ± rated with the input fixed at an angle (rad) relative
/// to the ring, with the friction of the parts of each stage.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn eccentric_loop(
    drive: &HeldDrive,
    friction: &[StageFriction],
    angle: f64,
) -> Result<Vec<LoopPoint>, RigError> {
    let (rated, seen) = (drive.rated_torque(), drive.ratio_to_ring());
    if !(rated > 0.0) {
        return Err(RigError::NoTorque);
    }
    cycle(&mut slow_load(drive, friction, angle), rated, seen)
}

/// The drive under a slowly changing load, starting at its nominal position.
pub(super) fn slow_load(drive: &HeldDrive, friction: &[StageFriction], angle: f64) -> SlowLoad {
    let model = Mechanism::clone(&drive.with_friction(angle, friction, REGULARISATION_SPEED));
    let start = model.nominal_position_at(angle);
    SlowLoad::new((model, drive.rated_torque(), HeldDrive::CONTROL), REGULARISATION_SPEED, start)
}

/// Regularisation speed in m/s of the friction of drives of eccentrics. In quasi-static loops the speeds are
/// displacements over the interval, so that its value does not affect a loop.
const REGULARISATION_SPEED: f64 = 1e-3;

/// Cycles the torque of a machine to ± rated (N·m); `seen` is the ratio of torque and angle at the output to
/// those of the model.
fn cycle(machine: &mut SlowLoad, rated: f64, seen: f64) -> Result<Vec<LoopPoint>, RigError> {
    // First loading, not recorded; in steps, so that the friction forces get their right direction.
    for share in [0.05, 0.3, 0.6, 1.0] {
        machine.change_to(-share * rated)?;
    }
    let mut points = Vec::new();
    let falling = shares();
    let rising: Vec<f64> = falling.iter().rev().copied().collect();
    for (branch, shares) in [(Branch::Falling, falling), (Branch::Rising, rising)] {
        for share in shares {
            // The load of the model acts against positive motion.
            machine.change_to(-share * rated)?;
            let angle = seen * machine.model.output_error(&machine.place);
            points.push(LoopPoint { torque: share * rated / seen, angle, branch });
        }
    }
    Ok(points)
}

/// Angle of a branch at a torque, interpolated linearly.
pub(super) fn angle_at(branch: &[LoopPoint], torque: f64) -> Option<f64> {
    branch.windows(2).find_map(|pair| {
        let (a, b) = (pair[0], pair[1]);
        let between = (a.torque - torque) * (b.torque - torque) <= 0.0 && a.torque != b.torque;
        between.then(|| a.angle + (torque - a.torque) / (b.torque - a.torque) * (b.angle - a.angle))
    })
}

/// Least-squares slope dT/dφ of the points whose torque lies in the window.
fn slope(branch: &[LoopPoint], low: f64, high: f64) -> Option<f64> {
    let points: Vec<&LoopPoint> = branch.iter().filter(|p| p.torque >= low && p.torque <= high).collect();
    let n = points.len() as f64;
    if points.len() < 2 {
        return None;
    }
    let (t, a) =
        (points.iter().map(|p| p.torque).sum::<f64>() / n, points.iter().map(|p| p.angle).sum::<f64>() / n);
    let covariance: f64 = points.iter().map(|p| (p.torque - t) * (p.angle - a)).sum();
    let variance: f64 = points.iter().map(|p| (p.torque - t).powi(2)).sum();
    (covariance != 0.0).then(|| variance / covariance)
}

/// Slope dT/dφ between two torques of a branch with fewer than two points between them.
fn chord(branch: &[LoopPoint], low: f64, high: f64) -> Option<f64> {
    let turn = angle_at(branch, high)? - angle_at(branch, low)?;
    (turn != 0.0).then(|| (high - low) / turn)
}

/// Reads lost motion, backlash, stiffness and energy loss from a computed or measured loop; `rated` in N·m. The
/// points of a branch are in the order of the test.
///
/// # Errors
/// [`RigError::BadLoop`] if a branch is missing or does not cover ± rated torque (at least 50 %).
pub fn evaluate_loop(points: &[LoopPoint], rated: f64) -> Result<LoopFigures, RigError> {
    let of = |branch: Branch| -> Vec<LoopPoint> {
        points.iter().filter(|p| p.branch == branch).copied().collect()
    };
    let branches = [of(Branch::Falling), of(Branch::Rising)];
    let at = |torque: f64| -> Result<[f64; 2], RigError> {
        let mut angles = [0.0; 2];
        for (angle, branch) in angles.iter_mut().zip(&branches) {
            *angle = angle_at(branch, torque)
                .ok_or(RigError::BadLoop("a branch does not cover ± 3 % of the rated torque"))?;
        }
        Ok(angles)
    };
    let (plus, minus) = (at(LOST_MOTION_SHARE * rated)?, at(-LOST_MOTION_SHARE * rated)?);
    let lost_motion = 0.5 * ((plus[0] + plus[1]) - (minus[0] + minus[1]));
    let zero = |branch: &[LoopPoint], side: f64| {
        // The last point before zero if its torque is close enough to zero; otherwise the line through zero.
        let near = branch
            .iter()
            .filter(|p| p.torque * side >= 0.0)
            .min_by(|a, b| a.torque.abs().total_cmp(&b.torque.abs()));
        match near {
            Some(point) if point.torque.abs() <= 2.0 * ZERO_SHARE * rated => Some(point.angle),
            _ => angle_at(branch, 0.0),
        }
    };
    let missing = RigError::BadLoop("a branch does not pass zero torque");
    let backlash =
        zero(&branches[0], 1.0).ok_or(missing.clone())? - zero(&branches[1], -1.0).ok_or(missing)?;
    let mean = |from: f64, to: f64| -> Result<f64, RigError> {
        let mut sum = 0.0;
        for branch in &branches {
            for (low, high) in [(from, to), (-to, -from)] {
                // Compliances of equal windows are averaged, hence the harmonic mean of the stiffnesses.
                let (low, high) = (low * rated, high * rated);
                let k = slope(branch, low * (1.0 - 1e-9), high * (1.0 + 1e-9))
                    .or_else(|| chord(branch, low, high));
                sum += 1.0 / k.ok_or(RigError::BadLoop("a branch does not reach the rated torque"))?;
            }
        }
        Ok(4.0 / sum)
    };
    let mut work = 0.0;
    for pair in points.windows(2) {
        work += 0.5 * (pair[0].torque + pair[1].torque) * (pair[1].angle - pair[0].angle);
    }
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        work += 0.5 * (first.torque + last.torque) * (first.angle - last.angle);
    }
    Ok(LoopFigures {
        lost_motion,
        backlash,
        stiffness: mean(STIFFNESS_WINDOW.0, STIFFNESS_WINDOW.1)?,
        soft_stiffness: mean(LOST_MOTION_SHARE, 0.15)?,
        middle_stiffness: mean(0.15, STIFFNESS_WINDOW.0)?,
        work,
    })
}

/// Compliance between 50 % and 100 % of rated torque, per part.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessSplit {
    /// Compliance in rad/(N·m) per part, the mean over the window and over both signs of torque.
    pub parts: Vec<(Part, f64)>,
    /// (φ(100 %) − φ(50 %))/(T/2) from two equilibria: a check of the sum of the parts.
    pub whole: f64,
    /// Number of crank positions averaged.
    pub positions: usize,
}

impl StiffnessSplit {
    /// The mean of splits at several crank positions; `None` if there are none.
    pub fn mean(splits: &[StiffnessSplit]) -> Option<StiffnessSplit> {
        let mut mean = splits.first()?.clone();
        let count = splits.len() as f64;
        mean.whole = splits.iter().map(|split| split.whole).sum::<f64>() / count;
        for (at, (_, part)) in mean.parts.iter_mut().enumerate() {
            *part = splits.iter().map(|split| split.parts[at].1).sum::<f64>() / count;
        }
        mean.positions = splits.iter().map(|split| split.positions).sum();
        Some(mean)
    }
}

/// The sum of the parts agrees with the whole within this relative tolerance, if the largest number of
/// intervals suffices.
const SPLIT_TOLERANCE: f64 = 9e-4;
const MOST_PIECES: usize = 16;

/// Splits the compliance of the machine without friction: dφ/dT = gᵀ K g with g = dq/dT, where K is the sum of
/// the tangent stiffnesses of the parts. The mean over the window is Gauss's three-point rule in torque. The
/// tangents jump where contacts of pins or rollers open or close; the window is then divided into as many
/// intervals as are needed for the parts to add up to the whole within 0.09 % (at most sixteen).
///
/// # Errors
/// [`RigError`] where no equilibrium is found or a body is not constrained.
pub fn stiffness_split(
    machine: &Machine,
    settings: &JointSettings,
    sun: f64,
) -> Result<StiffnessSplit, RigError> {
    let rated = machine.rated.torque.abs();
    let settings = JointSettings { damped: false, ..settings.clone() };
    let mut frictionless = machine.clone();
    frictionless.friction = crate::machine::Friction {
        regularisation_speed: machine.friction.regularisation_speed,
        ..Default::default()
    };
    let mut model = BearingJoints::held(&frictionless, &settings)?;
    model.hold_sun(sun, 0.0);
    let speed = machine.friction.regularisation_speed;
    let node = 0.5 * 0.6_f64.sqrt();
    let gauss = [(0.5 - node, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + node, 5.0 / 18.0)];
    let over = |pieces: usize| -> Result<([(Part, f64); PARTS.len()], f64), RigError> {
        let (mut parts, mut whole) = (PARTS.map(|part| (part, 0.0)), 0.0);
        for sign in [1.0, -1.0] {
            let mut machine = SlowLoad::new(
                (Mechanism::clone(&model), rated, CONTROL),
                speed,
                model.nominal_position_at(sun),
            );
            let mut ends = [0.0; 2];
            machine.change_to(-sign * 0.5 * rated)?;
            ends[0] = model.output_error(&machine.place);
            for piece in 0..pieces {
                for (place, weight) in gauss {
                    let place = (piece as f64 + place) / pieces as f64;
                    machine.change_to(-sign * (0.5 + 0.5 * place) * rated)?;
                    let (model, q) = (&machine.model, &machine.place);
                    let motion = tangent(model, q)?;
                    for (part, share) in model.split(q, &motion) {
                        let sums = parts.iter_mut().filter(|(own, _)| *own == part);
                        sums.for_each(|(_, sum)| *sum += 0.5 * weight * share / pieces as f64);
                    }
                }
            }
            machine.change_to(-sign * rated)?;
            ends[1] = model.output_error(&machine.place);
            whole += 0.5 * sign * (ends[1] - ends[0]) / (0.5 * rated);
        }
        Ok((parts, whole))
    };
    let mut pieces = 1;
    let (parts, whole) = loop {
        let (parts, whole) = over(pieces)?;
        let adds_up =
            (parts.iter().map(|part| part.1).sum::<f64>() - whole).abs() <= SPLIT_TOLERANCE * whole.abs();
        if adds_up || pieces == MOST_PIECES {
            break (parts, whole);
        }
        pieces *= 2;
    };
    // Rigid discs and a rigid housing are not listed as parts.
    let has = |part: Part| match part {
        Part::DISC => settings.discs.is_some(),
        PIN_RING => settings.housing.is_some(),
        _ => true,
    };
    Ok(StiffnessSplit {
        parts: parts.into_iter().filter(|(part, _)| has(*part)).collect(),
        whole,
        positions: 1,
    })
}
