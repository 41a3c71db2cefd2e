use std::f64::consts::TAU;

use super::RigError;
use super::settle::run;
use crate::dynamics::{BearingDrag, BearingJoints, JointSettings};
use crate::machine::{Friction, Machine, REFERENCE_C};

/// Efficiency over output torque and input speed.
#[derive(Debug, Clone, PartialEq)]
pub struct EfficiencyMap {
    /// Output torques in N·m.
    pub torques: Vec<f64>,
    /// Input speeds in rad/s.
    pub speeds: Vec<f64>,
    /// Row per speed, column per torque.
    pub efficiency: Vec<Vec<f64>>,
    /// Efficiency at rated torque and speed.
    pub rated: f64,
}

/// Input speeds of the map as shares of the rated one.
pub(super) const SPEEDS: [f64; 6] = [0.1, 0.25, 0.5, 0.75, 1.0, 1.5];

/// Friction at an operating point where it depends on it: with the film at the temperature of the design, and
/// with the drag of the bearings at that speed and temperature (20 °C where none is given). `None` if friction
/// is the same at all points.
fn friction_at(machine: &Machine, speed: f64, torque: f64) -> Result<Option<Friction>, RigError> {
    let celsius = machine.thermal.temperature;
    if celsius.is_none() && !machine.friction.bearings_drag() {
        return Ok(None);
    }
    let filmed =
        celsius.map_or(machine.friction, |celsius| machine.friction_at(celsius, speed, torque).friction);
    let drag = BearingDrag::of(machine, celsius.unwrap_or(REFERENCE_C), speed)?;
    Ok(Some(drag.added_to(filmed, speed)))
}

/// Crank positions over which torques are averaged.
const POSITIONS: usize = 8;

/// The running model, and its equilibria by output torque (N·m) at every crank position: the start values of
/// the next search at the same position.
pub(super) struct Bench {
    model: BearingJoints,
    known: [Vec<(f64, Vec<f64>)>; POSITIONS],
}

impl Bench {
    pub(super) fn new(machine: &Machine, settings: &JointSettings) -> Result<Bench, RigError> {
        let settings = JointSettings { damped: false, ..settings.clone() };
        Ok(Bench { model: BearingJoints::held(machine, &settings)?, known: Default::default() })
    }

    /// The bench at an operating point, with the friction of that point.
    pub(super) fn at(
        machine: &Machine,
        settings: &JointSettings,
        speed: f64,
        torque: f64,
    ) -> Result<Bench, RigError> {
        let friction = friction_at(machine, speed, torque)?.unwrap_or(machine.friction);
        Bench::new(&Machine { friction, ..machine.clone() }, settings)
    }

    /// Changes to another operating point; the start values are kept.
    pub(super) fn set_operating_point(
        &mut self,
        machine: &Machine,
        settings: &JointSettings,
        speed: f64,
        torque: f64,
    ) -> Result<(), RigError> {
        if let Some(friction) = friction_at(machine, speed, torque)? {
            self.model = Bench::new(&Machine { friction, ..machine.clone() }, settings)?.model;
        }
        Ok(())
    }

    /// Size of the ratio i.
    pub(super) fn ratio(&self) -> f64 {
        self.model.kinematics().ratio().abs()
    }

    /// Mean input torque (N·m) at an input speed (rad/s) and an output torque (N·m), both signed.
    pub(super) fn input_torque(&mut self, rated: f64, torque: f64, speed: f64) -> Result<f64, RigError> {
        let model = &mut self.model;
        let ratio = model.kinematics().ratio();
        let lobes = model.kinematics().lobe_count;
        // The load opposes the motion of the output, whose sense is reversed if the carrier is fixed.
        let torque = ratio.signum() * torque;
        let mut sum = 0.0;
        for (i, known) in self.known.iter_mut().enumerate() {
            let sun = TAU * i as f64 / POSITIONS as f64 * ratio / lobes;
            model.hold_sun(sun, speed);
            let nominal = model.nominal_position_at(sun);
            let velocity = model.nominal_velocity_at(sun, speed);
            let mut settle = |torque: f64, start: &[f64]| {
                model.set_load(torque);
                run(model, start, velocity.clone())
            };
            let near =
                |known: &[(f64, Vec<f64>)], torque: f64| known.iter().position(|(at, _)| *at == torque);
            let mut number = near(known, torque);
            if number.is_none() {
                // Contacts are closed at rated torque first.
                let loaded = rated.copysign(torque);
                if near(known, loaded).is_none() {
                    known.push((loaded, settle(loaded, &nominal)?));
                }
                number = near(known, loaded);
            }
            let q = settle(torque, number.map_or(&nominal, |number| &known[number].1))?;
            match near(known, torque) {
                Some(number) => known[number].1.clone_from(&q),
                None => known.push((torque, q.clone())),
            }
            let mut force = vec![0.0; q.len()];
            sum += model.evaluate_with_input(0.0, &q, &velocity, &mut force, None).1;
        }
        Ok(sum / POSITIONS as f64)
    }
}

/// η = T_out/(i T_in) from the equilibrium of the running machine with friction at pins, needles, supports,
/// gear meshes, seals, oil and bearing lubricant.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn efficiency_map(machine: &Machine, settings: &JointSettings) -> Result<EfficiencyMap, RigError> {
    let mut bench = Bench::new(machine, settings)?;
    let rated = machine.rated.torque.abs();
    let ratio = bench.ratio();
    let speed = machine.rated.input_speed.abs();
    let torques: Vec<f64> = [0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0].map(|share| share * rated).to_vec();
    let speeds: Vec<f64> = SPEEDS.map(|share| share * speed).to_vec();
    let mut efficiency = Vec::with_capacity(speeds.len());
    for speed in &speeds {
        let mut row = Vec::with_capacity(torques.len());
        for torque in &torques {
            bench.set_operating_point(machine, settings, *speed, *torque)?;
            row.push(torque / (ratio * bench.input_torque(rated, *torque, *speed)?));
        }
        efficiency.push(row);
    }
    bench.set_operating_point(machine, settings, speed, rated)?;
    let at_rated = rated / (ratio * bench.input_torque(rated, rated, speed)?);
    Ok(EfficiencyMap { torques, speeds, efficiency, rated: at_rated })
}

/// Losses at one speed as a straight line over the torque.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LossLine {
    /// Speed of the input in rad/s for which the line holds.
    pub input_speed_rad_per_s: f64,
    /// Slope of the lines as an efficiency: with the motor driving, and with the load driving.
    pub efficiency: [f64; 2],
    /// Friction torque at the input in N·m that does not depend on the torque, in either case.
    pub friction_n_m: [f64; 2],
    /// Largest deviation of an equilibrium from its line, N·m at the input.
    pub left_n_m: f64,
}

/// Input speeds of [`loss_lines`] as shares of the rated one.
pub const LOSS_SPEEDS: [f64; 4] = [0.1, 0.5, 1.0, 1.5];
/// Output torques of the fit as shares of the rated one.
pub const LOSS_SHARES: [f64; 3] = [0.1, 0.5, 1.0];

impl LossLine {
    /// Lines τ_in = T/(i η₁) + τ₁ (the motor drives) and τ_in = τ₂ − T η₂/i (the load drives) through pairs of
    /// output torque (absolute value) and input torque (signed), N·m. `ratio` is |i|.
    pub fn through(speed: f64, ratio: f64, [driving, driven]: [&[(f64, f64)]; 2]) -> LossLine {
        let line = |points: &[(f64, f64)]| {
            let n = points.len() as f64;
            let (x, y) = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
            let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
                / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
            let (slope, free) = match y - slope * x {
                // The friction torque without load cannot be negative: the line passes through zero.
                free if free < 0.0 => {
                    let both = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>();
                    (both(|p| p.0 * p.1) / both(|p| p.0 * p.0), 0.0)
                }
                free => (slope, free),
            };
            let left = points.iter().map(|p| (p.1 - free - slope * p.0).abs()).fold(0.0, f64::max);
            (slope, free, left)
        };
        let ((driving, friction, first), (driven, back, second)) = (line(driving), line(driven));
        LossLine {
            input_speed_rad_per_s: speed,
            efficiency: [1.0 / (driving * ratio), -driven * ratio],
            friction_n_m: [friction, back],
            left_n_m: first.max(second),
        }
    }
}

/// Lines of loss for some speeds, fitted to equilibria of the running machine between 10 % and 100 % of the
/// rated torque.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn loss_lines(machine: &Machine, settings: &JointSettings) -> Result<Vec<LossLine>, RigError> {
    use rayon::prelude::*;
    let rated = machine.rated.torque.abs();
    LOSS_SPEEDS
        .into_par_iter()
        .map(|share| {
            let speed = share * machine.rated.input_speed.abs();
            let mut bench = Bench::at(machine, settings, speed, rated)?;
            let ratio = bench.ratio();
            let mut points = |side: f64| -> Result<Vec<(f64, f64)>, RigError> {
                let balance =
                    |share: f64| Ok((share * rated, bench.input_torque(rated, side * share * rated, speed)?));
                LOSS_SHARES.into_iter().map(balance).collect()
            };
            let (driving, driven) = (points(1.0)?, points(-1.0)?);
            Ok(LossLine::through(speed, ratio, [&driving, &driven]))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The efficiency of the shipped machine falls with speed at 20 °C (drag of the oil) and rises with load;
    /// the no-load torque falls by the drag of the oil when the machine warms up.
    #[test]
    fn efficiency_over_speed_load_and_temperature() {
        let mut machine = crate::templates::tao2024();
        machine.friction = crate::machine::Friction {
            regularisation_speed: machine.friction.regularisation_speed,
            oil_drag: 1e-3,
            ..crate::rig::assumed_friction(&machine)
        };
        let settings = JointSettings::default();
        let (rated, speed) = (machine.rated.torque, machine.rated.input_speed);
        let at = |celsius: f64, share: f64, load: f64| {
            let mut warm = machine.clone();
            warm.thermal.temperature = Some(celsius);
            let mut bench = Bench::at(&warm, &settings, share * speed, load * rated).unwrap();
            let torque = bench.input_torque(rated, load * rated, share * speed).unwrap();
            load * rated / (bench.ratio() * torque)
        };
        let (cold, warm) = (at(20.0, 1.0, 1.0), at(60.0, 1.0, 1.0));
        assert!(warm > cold && cold > 0.5 && warm < 1.0, "{cold} {warm}");
        assert!(at(20.0, 1.5, 1.0) < at(20.0, 0.5, 1.0));
        assert!(at(40.0, 1.0, 0.2) < at(40.0, 1.0, 1.0));
    }

    /// The drag of the bearings alone has a closed form: torques of the unloaded machine at input and output at
    /// every speed, its starting torques, and the loss under load as the power of these torques.
    #[test]
    fn drag_of_bearings_has_a_closed_form() {
        use crate::rig::running_torques;
        let mut machine = crate::templates::tao2024();
        machine.friction.bearing_drag = 3.0;
        machine.friction.crank_support_preload = 800.0;
        let settings = JointSettings::default();
        let torques = running_torques(&machine, &settings).unwrap();
        let at = |speed: f64| {
            let drag = BearingDrag::of(&machine, REFERENCE_C, speed).unwrap();
            (drag.input + drag.output / 81.0, drag)
        };
        assert_eq!(torques.over_speed.len(), SPEEDS.len());
        for (speed, found) in &torques.over_speed {
            let expected = at(*speed).0;
            // The friction torque at the output is regularised at 1 % of the rated speed: 0.5 % too small at a
            // tenth of this speed.
            assert!((found / expected - 1.0).abs() < 6e-3, "{speed}: {found} {expected}");
        }
        assert!(torques.over_speed.windows(2).all(|pair| pair[1].1 > pair[0].1), "{torques:?}");
        assert!((torques.starting / at(0.0).0 - 1.0).abs() < 3e-3, "{torques:?} {:?}", at(0.0));
        let back = 81.0 * at(0.0).0;
        assert!((torques.back_driving / back - 1.0).abs() < 3e-3, "{torques:?} {back}");
        let map = efficiency_map(&machine, &settings).unwrap();
        let useful = machine.rated.torque / 81.0;
        assert!(
            (map.rated - useful / (useful + at(machine.rated.input_speed).0)).abs() < 1e-3,
            "{}",
            map.rated
        );
        // The efficiency falls with speed at every torque and rises with torque at every speed.
        for (slow, fast) in map.efficiency.iter().zip(&map.efficiency[1..]) {
            assert!(slow.iter().zip(fast).all(|(slow, fast)| fast < slow), "{map:?}");
        }
        assert!(map.efficiency.iter().all(|row| row.windows(2).all(|pair| pair[1] > pair[0])), "{map:?}");
    }
}
