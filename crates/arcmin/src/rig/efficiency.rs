use std::f64::consts::TAU;

use super::RigError;
use super::settle::run;
use crate::dynamics::{BearingJoints, JointSettings};
use crate::machine::Machine;

/// Efficiency over output torque and input speed.
#[derive(Debug, Clone, PartialEq)]
pub struct EfficiencyMap {
    /// N·m.
    pub torques: Vec<f64>,
    /// rad/s at the input.
    pub speeds: Vec<f64>,
    /// Row per speed, column per torque.
    pub efficiency: Vec<Vec<f64>>,
    /// At rated torque and speed.
    pub rated: f64,
}

/// Torques without load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningTorques {
    /// At the input, running at rated speed without load, N·m.
    pub no_load: f64,
    /// At the input, to start without load, N·m.
    pub starting: f64,
    /// At the output, to turn the free input backwards, N·m.
    pub back_driving: f64,
}

/// Crank positions over which torques are averaged.
const POSITIONS: usize = 8;

/// The running model, and its balances by torque (N·m), position by position: where the next search at the same place
/// starts.
struct Bench {
    model: BearingJoints,
    known: [Vec<(f64, Vec<f64>)>; POSITIONS],
}

impl Bench {
    fn new(machine: &Machine, settings: &JointSettings) -> Result<Bench, RigError> {
        let settings = JointSettings { damped: false, ..settings.clone() };
        Ok(Bench { model: BearingJoints::held(machine, &settings)?, known: Default::default() })
    }

    /// At an operating point; where the design gives a temperature, with the friction of that point.
    fn at(machine: &Machine, settings: &JointSettings, speed: f64, torque: f64) -> Result<Bench, RigError> {
        match machine.thermal.temperature {
            None => Bench::new(machine, settings),
            Some(celsius) => {
                let mut warm = machine.clone();
                warm.friction = machine.friction_at(celsius, speed, torque).friction;
                Bench::new(&warm, settings)
            }
        }
    }

    /// i, without its sign.
    fn ratio(&self) -> f64 {
        self.model.kinematics().ratio().abs()
    }

    /// Mean torque (N·m) that the drive puts in at the speed (rad/s) and output torque (N·m), both signed.
    fn input_torque(&mut self, rated: f64, torque: f64, speed: f64) -> Result<f64, RigError> {
        let model = &mut self.model;
        let ratio = model.kinematics().ratio();
        let lobes = model.kinematics().lobe_count;
        // The load opposes the motion of the output, which a carrier at rest turns round.
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
                // Bodies go into the flank with the rated torque first.
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

/// η = T_out/(i T_in), from the balance of the running machine with friction at pins, needles, supports,
/// meshes, seals and oil.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn efficiency_map(machine: &Machine, settings: &JointSettings) -> Result<EfficiencyMap, RigError> {
    let mut bench = Bench::new(machine, settings)?;
    let rated = machine.rated.torque.abs();
    let ratio = bench.ratio();
    let warm = machine.thermal.temperature.is_some();
    let speed = machine.rated.input_speed.abs();
    let torques: Vec<f64> = [0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0].map(|share| share * rated).to_vec();
    let speeds: Vec<f64> = [0.1, 0.25, 0.5, 0.75, 1.0, 1.5].map(|share| share * speed).to_vec();
    let mut efficiency = Vec::with_capacity(speeds.len());
    for speed in &speeds {
        let mut row = Vec::with_capacity(torques.len());
        for torque in &torques {
            if warm {
                bench.model = Bench::at(machine, settings, *speed, *torque)?.model;
            }
            row.push(torque / (ratio * bench.input_torque(rated, *torque, *speed)?));
        }
        efficiency.push(row);
    }
    if warm {
        bench.model = Bench::at(machine, settings, speed, rated)?.model;
    }
    let at_rated = rated / (ratio * bench.input_torque(rated, rated, speed)?);
    Ok(EfficiencyMap { torques, speeds, efficiency, rated: at_rated })
}

/// What a machine at a temperature does, and where it settles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatBalance {
    /// η of the oil in Pa·s, mean film ratio of the loaded flanks and their friction coefficient, at the
    /// temperature given, rated torque and speed.
    pub viscosity: f64,
    pub film_ratio: f64,
    pub flank_friction: f64,
    /// Loss there in W.
    pub loss: f64,
    /// Temperature in °C at which loss and cooling balance, running steadily at rated torque and speed.
    pub steady: f64,
}

/// Temperature beyond which nothing is looked for, in K above the surroundings.
const HOTTEST: f64 = 200.0;

/// Loss (W) at rated torque and speed against what the surface gives off, h A (T − T_a): the temperature at
/// which both are equal, by bisection to 0.05 K. `None` without a temperature in the design; infinite if even
/// 200 K above the surroundings do not carry the loss away.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn heat_balance(machine: &Machine, settings: &JointSettings) -> Result<Option<HeatBalance>, RigError> {
    let thermal = &machine.thermal;
    let Some(celsius) = thermal.temperature else { return Ok(None) };
    let (rated, speed) = (machine.rated.torque.abs(), machine.rated.input_speed.abs());
    let loss = |celsius: f64| -> Result<f64, RigError> {
        let mut at = machine.clone();
        at.thermal.temperature = Some(celsius);
        let mut bench = Bench::at(&at, settings, speed, rated)?;
        Ok((bench.input_torque(rated, rated, speed)? - rated / bench.ratio()) * speed)
    };
    let steady = settle(thermal.ambient, thermal.transfer * thermal.surface, loss)?;
    let warm = machine.friction_at(celsius, speed, rated);
    Ok(Some(HeatBalance {
        viscosity: thermal.oil.viscosity(celsius),
        film_ratio: warm.film_ratio,
        flank_friction: warm.friction.flank,
        loss: loss(celsius)?,
        steady,
    }))
}

/// T with loss(T) = `cooling` (W/K) · (T − `ambient`).
fn settle<E>(ambient: f64, cooling: f64, loss: impl Fn(f64) -> Result<f64, E>) -> Result<f64, E> {
    let (mut low, mut high) = (ambient, ambient + HOTTEST);
    if loss(high)? > cooling * HOTTEST {
        return Ok(f64::INFINITY);
    }
    while high - low > 0.05 {
        let middle = 0.5 * (low + high);
        if loss(middle)? > cooling * (middle - ambient) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(0.5 * (low + high))
}

/// Torques of the unloaded machine. Without load means 1 % of the rated torque taken off again along the line
/// through 1 % and 2 %, as bodies that hang free in their clearance have no definite place.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn running_torques(machine: &Machine, settings: &JointSettings) -> Result<RunningTorques, RigError> {
    let rated = machine.rated.torque.abs();
    let speed = machine.rated.input_speed.abs();
    let line = |bench: &mut Bench, speed: f64, side: f64| -> Result<(f64, f64), RigError> {
        let one = bench.input_torque(rated, side * 0.01 * rated, speed)?;
        let two = bench.input_torque(rated, side * 0.02 * rated, speed)?;
        Ok((2.0 * one - two, (two - one) / (0.01 * rated)))
    };
    let (no_load, _) = line(&mut Bench::at(machine, settings, speed, 0.01 * rated)?, speed, 1.0)?;
    // A machine that starts has no speed for the oil to drag at, yet Coulomb friction is to be fully
    // developed.
    let mut still = machine.clone();
    still.friction.oil_drag = 0.0;
    let slow = 0.2 * speed;
    let mut bench = Bench::at(&still, settings, slow, 0.01 * rated)?;
    let (starting, _) = line(&mut bench, slow, 1.0)?;
    // Output driving: the load pushes along the motion, the input torque falls to zero.
    let (offset, slope) = line(&mut bench, slow, -1.0)?;
    let back_driving = if slope < 0.0 { offset / -slope } else { f64::INFINITY };
    Ok(RunningTorques { no_load, starting, back_driving })
}

/// Losses at one speed as a straight line over the torque.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LossLine {
    pub input_speed_rad_per_s: f64,
    /// Share of the torque that arrives: the motor drives, the load drives.
    pub efficiency: [f64; 2],
    /// Friction torque at the input in N·m that does not depend on the torque, in either case.
    pub friction_n_m: [f64; 2],
    /// Largest distance of a balance from its line, N·m at the input.
    pub left_n_m: f64,
}

/// Lines τ_in = T/(i η₁) + τ₁ (the motor drives) and τ_in = τ₂ − T η₂/i (the load drives) through balances of
/// the running machine between 10 % and 100 % of the rated torque, for some speeds.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn loss_lines(machine: &Machine, settings: &JointSettings) -> Result<Vec<LossLine>, RigError> {
    use rayon::prelude::*;
    const SPEEDS: [f64; 4] = [0.1, 0.5, 1.0, 1.5];
    const SHARES: [f64; 3] = [0.1, 0.5, 1.0];
    let rated = machine.rated.torque.abs();
    SPEEDS
        .into_par_iter()
        .map(|share| {
            let mut bench = Bench::new(machine, settings)?;
            let ratio = bench.ratio();
            let speed = share * machine.rated.input_speed.abs();
            let mut line = |side: f64| -> Result<(f64, f64, f64), RigError> {
                let mut points = [(0.0, 0.0); SHARES.len()];
                for (point, share) in points.iter_mut().zip(SHARES) {
                    *point = (share * rated, bench.input_torque(rated, side * share * rated, speed)?);
                }
                let n = points.len() as f64;
                let (x, y) = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
                let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
                    / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
                let left = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).abs()).fold(0.0, f64::max);
                Ok((slope, y - slope * x, left))
            };
            let (driving, friction, first) = line(1.0)?;
            let (driven, back, second) = line(-1.0)?;
            Ok(LossLine {
                input_speed_rad_per_s: speed,
                efficiency: [1.0 / (driving * ratio), -driven * ratio],
                friction_n_m: [friction, back],
                left_n_m: first.max(second),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loss that does not know of temperature: T = T_a + P/(hA); one that falls with it, P₀ − c (T − T_a): T
    /// = T_a + P₀/(hA + c); one beyond all cooling finds no end.
    #[test]
    fn heat_settles_in_closed_form() {
        let at = |slope: f64, power: f64| {
            settle(25.0, 2.0, |celsius| Ok::<_, ()>(power - slope * (celsius - 25.0))).unwrap()
        };
        assert!((at(0.0, 90.0) - 70.0).abs() < 0.05);
        assert!((at(1.0, 90.0) - 55.0).abs() < 0.05);
        assert_eq!(at(0.0, 500.0), f64::INFINITY);
    }

    /// Warm and slow against cold: efficiency of the shipped machine falls with speed at 20 °C (drag of the
    /// oil), rises with load, and the oil's drag is what the no-load torque loses when it warms up.
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
        machine.thermal.temperature = Some(40.0);
        let balance = heat_balance(&machine, &settings).unwrap().unwrap();
        let cooling = machine.thermal.transfer * machine.thermal.surface;
        assert!(balance.steady > 20.0 && balance.loss > 0.0, "{balance:?} {cooling}");
    }
}
