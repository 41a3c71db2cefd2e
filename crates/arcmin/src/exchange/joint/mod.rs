//! The reducer as a joint of a robot model: its parameters with source and units, for each age.

mod damping;
mod document;
mod fit;
mod friction;
mod inertia;
mod mjcf;
mod modelica;
mod names;
mod robot;
#[cfg(test)]
pub(super) mod tests;

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

pub(super) use damping::FLANGE_DAMPING_RATIO;
pub use fit::{Hysteresis, SlipElement, TorsionCurve};
pub use friction::RunningFriction;
pub use inertia::JointInertia;

use super::{ExchangeError, Stamp};
use crate::rig::{Branch, ErrorCurve, LoopFigures, LoopPoint, LossLine, evaluate_loop};

/// One wave of the transmission error: amplitude × cos(order × output angle + phase).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Wave {
    /// Waves per turn of the output; a fraction if the period of the error is several turns of the output.
    pub order: f64,
    /// Amplitude of the wave.
    pub amplitude_rad: f64,
    /// Phase at the output angle 0.
    pub phase_rad: f64,
}

/// Transmission error of one direction and torque: θ_out − θ_in/i without its mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TransmissionWaves {
    /// 1 forward, −1 backward.
    pub direction: f64,
    /// Torque in N·m, against the motion.
    pub torque_n_m: f64,
    /// Mean error in rad: wind-up and backlash.
    pub mean_rad: f64,
    /// The largest waves in descending order.
    pub waves: Vec<Wave>,
    /// Peak to peak of the curve, rad.
    pub peak_to_peak_rad: f64,
    /// Peak to peak value of the curve less the waves, rad.
    pub left_rad: f64,
}

/// Number of waves kept of each curve, and the amplitude in rad below which they are omitted: 1e-5′.
const WAVES: usize = 24;
const LEAST_WAVE: f64 = 3e-9;

impl TransmissionWaves {
    /// Fourier coefficients of a curve at equal steps over one turn of the output, or over the fraction or
    /// number of turns that is the period of the error.
    pub fn of(curve: &ErrorCurve) -> TransmissionWaves {
        let n = curve.points.len().saturating_sub(1);
        let mean = curve.mean();
        let span = curve.points.last().map_or(TAU, |last| (last.0 - curve.points[0].0).abs());
        let slowest = TAU / span;
        // Rounded to an integer if it is one within rounding.
        let slowest =
            if (slowest - slowest.round()).abs() < 1e-9 * slowest { slowest.round() } else { slowest };
        let mut waves: Vec<Wave> = (1..n / 2)
            .map(|order| {
                let (mut re, mut im) = (0.0, 0.0);
                for (i, (_, error)) in curve.points.iter().take(n).enumerate() {
                    // The index is reduced first, so that large orders do not lose digits.
                    let angle = TAU * ((order * i) % n) as f64 / n as f64;
                    re += (error - mean) * angle.cos();
                    im += (error - mean) * angle.sin();
                }
                let scale = 2.0 / n as f64;
                Wave {
                    order: slowest * order as f64,
                    amplitude_rad: scale * re.hypot(im),
                    phase_rad: curve.direction * f64::atan2(-im, re),
                }
            })
            .filter(|wave| wave.amplitude_rad > LEAST_WAVE)
            .collect();
        waves.sort_by(|a, b| b.amplitude_rad.total_cmp(&a.amplitude_rad));
        waves.truncate(WAVES);
        let mut kept = TransmissionWaves {
            direction: curve.direction,
            torque_n_m: curve.torque,
            mean_rad: mean,
            waves,
            peak_to_peak_rad: curve.peak_to_peak(),
            left_rad: 0.0,
        };
        let left = curve.points.iter().map(|(angle, error)| error - mean - kept.at(*angle));
        let (low, high) =
            left.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        kept.left_rad = if n > 0 { high - low } else { 0.0 };
        kept
    }

    /// The waves at an output angle in rad.
    pub fn at(&self, angle: f64) -> f64 {
        self.waves.iter().map(|w| w.amplitude_rad * (w.order * angle + w.phase_rad).cos()).sum()
    }
}

/// The joint after some hours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Running hours since new.
    pub hours: f64,
    /// Lost motion as computed by `rig`, mean over the crank positions, rad.
    pub lost_motion_rad: f64,
    /// Width of the loop at zero torque, mean over the crank positions, rad.
    pub backlash_rad: f64,
    /// Stiffness from 50 % to 100 % of rated torque.
    pub stiffness_n_m_per_rad: f64,
    /// Stiffness from 3 % to 15 % of rated torque.
    pub soft_stiffness_n_m_per_rad: f64,
    /// Energy lost in one cycle of the loop to ± rated torque, J.
    pub hysteresis_loss_j: f64,
    /// Largest width of the loop outside of the dead band, as an angle at equal torque, rad.
    pub hysteresis_width_rad: f64,
    /// Maxwell-slip model of the mean loop.
    pub hysteresis: Hysteresis,
    /// Damping ratio of a free oscillation about half of the rated torque, released at three quarters, from the
    /// hysteresis.
    pub damping_ratio: f64,
    /// The mean loop over the crank positions: torque in N·m, angle in rad; decreasing, then increasing.
    pub torsion_loop: Vec<(f64, f64)>,
    /// Waves by direction and torque.
    pub transmission_error: Vec<TransmissionWaves>,
    /// Losses as functions of torque, one line for each speed.
    pub losses: Vec<LossLine>,
    /// Load-dependent friction of the running joint, fitted to `losses` and the loop.
    pub friction: RunningFriction,
    /// The same with its four parameters only, without the constant c.
    pub friction_without_constant: RunningFriction,
    /// Efficiency at rated torque and speed.
    pub efficiency: f64,
    /// Torque at the input at rated speed without load, N·m.
    pub no_load_torque_n_m: f64,
    /// Starting torque at the input without load, N·m.
    pub starting_torque_n_m: f64,
    /// Torque at the output that starts backward motion of the input, N·m; `None` if no torque does.
    pub back_driving_torque_n_m: Option<f64>,
}

/// Below this fraction of the rated torque the loop may still be within the backlash.
const ACROSS: f64 = crate::rig::LOST_MOTION_SHARE;

/// Results of a test bench for a drive of any kind at one age.
#[derive(Debug, Clone)]
pub struct JointBench {
    /// Running hours since new.
    pub hours: f64,
    /// One loop for each position of the input, all with the same torques.
    pub loops: Vec<Vec<LoopPoint>>,
    /// Mean results over these positions.
    pub figures: LoopFigures,
    /// Transmission error in both directions, at the same torques at every age.
    pub curves: Vec<ErrorCurve>,
    /// Losses as functions of torque, one line for each speed.
    pub losses: Vec<LossLine>,
    /// Efficiency at rated torque and speed.
    pub efficiency: f64,
    /// Torque at the input at rated speed without load, N·m.
    pub no_load: f64,
    /// Starting torque at the input without load, N·m.
    pub starting: f64,
    /// Torque at the output that starts backward motion of the input, N·m; infinite if no torque does.
    pub back_driving: f64,
}

/// Data of a drive of any kind for an export, in addition to the results of the test bench.
#[derive(Debug, Clone)]
pub struct JointDrive {
    /// Version and design.
    pub stamp: Stamp,
    /// Description of the model.
    pub model: String,
    /// Turns of the input per turn of the output; negative if they have opposite directions.
    pub ratio: f64,
    /// Rated torque, N·m.
    pub rated_torque: f64,
    /// Rated input speed, rad/s.
    pub rated_input_speed: f64,
    /// Moments of inertia and masses.
    pub inertia: JointInertia,
    /// Whether friction is assumed because the design gives none.
    pub friction_assumed: bool,
    /// Whether mass and inertia of the output are assumed because the design gives none.
    pub inertia_assumed: bool,
}

impl JointState {
    /// From the test bench results of a drive with this ratio and rated torque (N·m).
    ///
    /// # Errors
    /// [`ExchangeError::Fit`] for loops that cannot be fitted.
    pub fn of(measured: &JointBench, (ratio, rated): (f64, f64)) -> Result<JointState, ExchangeError> {
        let no_fit = |message: &str| ExchangeError::Fit {
            message: format!("the hysteresis loop at {} h cannot be fitted: {message}", measured.hours),
            remedy: "check it with `arcmin rig`".into(),
        };
        let points = mean_loop(&measured.loops).ok_or_else(|| no_fit("its loops differ in their torques"))?;
        let figures = evaluate_loop(&points, rated).map_err(|error| no_fit(&error.to_string()))?;
        let hysteresis =
            Hysteresis::fit(&points, rated, ACROSS).ok_or_else(|| no_fit("it does not stiffen"))?;
        let losses = &measured.losses;
        let friction =
            |constant| RunningFriction::fit(losses, (&hysteresis, &points), ratio, rated, constant);
        let (friction, friction_without_constant) = (friction(true), friction(false));
        let half = points.len() / 2;
        let width = points[..half]
            .iter()
            .filter(|p| p.torque.abs() >= ACROSS * rated)
            .filter_map(|p| Some(p.angle - points[half..].iter().find(|q| q.torque == p.torque)?.angle))
            .fold(0.0, |most: f64, width| most.max(width.abs()));
        let mut curves: Vec<TransmissionWaves> = measured.curves.iter().map(TransmissionWaves::of).collect();
        let key = |waves: &TransmissionWaves| (-waves.direction, waves.torque_n_m);
        curves.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
        Ok(JointState {
            hours: measured.hours,
            lost_motion_rad: measured.figures.lost_motion,
            backlash_rad: measured.figures.backlash,
            stiffness_n_m_per_rad: measured.figures.stiffness,
            soft_stiffness_n_m_per_rad: measured.figures.soft_stiffness,
            hysteresis_loss_j: figures.work.abs(),
            hysteresis_width_rad: width,
            damping_ratio: damping::damping_ratio(&hysteresis, rated),
            hysteresis,
            torsion_loop: points.iter().map(|p| (p.torque, p.angle)).collect(),
            transmission_error: curves,
            losses: losses.clone(),
            friction,
            friction_without_constant,
            efficiency: measured.efficiency,
            no_load_torque_n_m: measured.no_load,
            starting_torque_n_m: measured.starting,
            back_driving_torque_n_m: Some(measured.back_driving).filter(|torque| torque.is_finite()),
        })
    }

    /// The mean loop with its branches.
    pub fn loop_points(&self) -> Vec<LoopPoint> {
        let half = self.torsion_loop.len() / 2;
        let point = |(index, (torque, angle)): (usize, &(f64, f64))| LoopPoint {
            torque: *torque,
            angle: *angle,
            branch: if index < half { Branch::Falling } else { Branch::Rising },
        };
        self.torsion_loop.iter().enumerate().map(point).collect()
    }
}

/// Mean point by point; `None` if the torques of the loops differ.
fn mean_loop(loops: &[Vec<LoopPoint>]) -> Option<Vec<LoopPoint>> {
    let (first, rest) = loops.split_first()?;
    let mut mean = first.clone();
    for other in rest {
        if other.len() != mean.len() {
            return None;
        }
        for (sum, point) in mean.iter_mut().zip(other) {
            if sum.torque != point.torque || sum.branch != point.branch {
                return None;
            }
            sum.angle += point.angle;
        }
    }
    mean.iter_mut().for_each(|point| point.angle /= loops.len() as f64);
    Some(mean)
}

/// All parameters of the reducer as a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointExport {
    /// Version of the program.
    pub arcmin_version: String,
    /// Name from the design file.
    pub design_name: String,
    /// Short hash of the design.
    pub design_hash: String,
    /// Description of the model.
    pub model: String,
    /// Whether the friction is assumed because the design gives none.
    pub friction_assumed: bool,
    /// Whether mass and inertia of the output are assumed.
    #[serde(default)]
    pub inertia_assumed: bool,
    /// Turns of the input per turn of the output; negative if they have opposite directions.
    pub ratio: f64,
    /// Rated torque at the output, magnitude, N·m.
    pub rated_torque_n_m: f64,
    /// Rated input speed, rad/s.
    pub rated_input_speed_rad_per_s: f64,
    /// Moments of inertia and masses.
    pub inertia: JointInertia,
    /// Time step in s of the robot simulation.
    pub timestep_s: f64,
    /// Inertia at the output in kg·m² that the joint moves, for the damping of programs without hysteresis.
    pub load_inertia_kg_m2: f64,
    /// States in the order of age.
    pub states: Vec<JointState>,
}

impl JointExport {
    /// Combines the results; states in the order of their hours. The default load is that of
    /// [`JointExport::usual_load`].
    pub fn new(
        drive: &JointDrive,
        (timestep_s, load_inertia_kg_m2): (f64, Option<f64>),
        states: Vec<JointState>,
    ) -> JointExport {
        let joint = JointExport {
            arcmin_version: drive.stamp.version.clone(),
            design_name: drive.stamp.design_name.clone(),
            design_hash: drive.stamp.design_hash.clone(),
            model: drive.model.clone(),
            friction_assumed: drive.friction_assumed,
            inertia_assumed: drive.inertia_assumed,
            ratio: drive.ratio,
            rated_torque_n_m: drive.rated_torque,
            rated_input_speed_rad_per_s: drive.rated_input_speed,
            inertia: drive.inertia,
            timestep_s,
            load_inertia_kg_m2: 0.0,
            states,
        };
        let load_inertia_kg_m2 = load_inertia_kg_m2.unwrap_or_else(|| joint.usual_load());
        JointExport { load_inertia_kg_m2, ..joint }
    }

    /// Lines at the beginning of every file.
    fn stamps(&self) -> Vec<String> {
        let friction = if self.friction_assumed { "assumed: the design gives none" } else { "of the design" };
        let assumed = "; mass and inertia of the output assumed: the design gives none";
        let masses = if self.inertia_assumed { assumed } else { "" };
        let mut stamps = vec![
            format!("arcmin {}, design {} ({})", self.arcmin_version, self.design_hash, self.design_name),
            format!("{}; friction {friction}{masses}", self.model),
            "Angles are turns of the output flange, input held; torques are those at the output if not stated otherwise.".into(),
        ];
        if self.states.iter().any(|state| !state.can_be_driven()) {
            stamps.push(
                "The output cannot drive the input at every age: this is contained in the losses only; friction in proportion to the motor's torque \
                 does not hold the joint."
                    .into(),
            );
        }
        stamps
    }

    /// The design's name in a form that is valid in every format.
    fn identifier(&self) -> String {
        names::identifier(&self.design_name)
    }

    /// Inertia of all parts before the elastic element, referred to the output, kg·m².
    fn reflected_inertia(&self) -> f64 {
        let inertia = &self.inertia;
        (inertia.motor_kg_m2 + inertia.sun_kg_m2 + inertia.gear_kg_m2) * self.ratio * self.ratio
    }
}

impl JointState {
    /// Number of slip elements with a noticeable torque.
    #[cfg(test)]
    pub(crate) fn slipping_elements(&self) -> usize {
        self.slipping().count()
    }

    /// Whether the output can drive the input.
    fn can_be_driven(&self) -> bool {
        self.losses.iter().all(|line| line.efficiency[1] > 0.0)
    }

    /// `h2000`: the age as part of a name.
    fn label(&self) -> String {
        names::label(self.hours)
    }

    /// Friction of the running input without load, referred to the output, N·m.
    fn running_friction(&self, ratio: f64) -> f64 {
        (self.no_load_torque_n_m * ratio).abs()
    }
}

/// A number with at most nine digits, in the shortest form.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let text = format!("{value:.8e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let rounded: f64 = text.parse().unwrap_or(value);
    match power.parse::<i32>() {
        Ok(power) if (-4..9).contains(&power) => format!("{rounded}"),
        _ => format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.')),
    }
}

/// Text for XML comments and attributes.
fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    // Twice, because three hyphens in sequence leave two.
    text.replace("--", "- -").replace("--", "- -")
}
