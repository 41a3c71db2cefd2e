use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::{DynamicsError, GivenMotion, GivenTorque, TimeTable};

/// External torque at the output in N·m, positive against positive (counter-clockwise) output motion: a
/// function of time, or values set from outside during the simulation.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub enum OutputLoad {
    /// No torque.
    #[default]
    None,
    /// The same torque at all times.
    Constant {
        /// N·m.
        torque: f64,
    },
    /// amplitude × sin(2π t/period), period in s.
    Sine {
        /// N·m.
        amplitude: f64,
        /// s.
        period: f64,
    },
    /// Linear interpolation between given times.
    Table(TimeTable),
    /// Steps: each torque is valid from its time (s), 0 before the first.
    Stepped(Vec<(f64, f64)>),
    /// Phases (duration in s, torque) that repeat periodically, with jumps between them.
    DutyCycle(Vec<(f64, f64)>),
    /// Torque set from outside ([`Simulation::set_load`](super::Simulation::set_load)).
    GivenTorque(GivenTorque),
    /// Motion of the output set from outside; the torque is a result.
    GivenMotion(GivenMotion),
}

impl OutputLoad {
    /// # Errors
    /// [`DynamicsError`] for torques, periods and times without meaning.
    pub fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        let torque_check =
            |torque: f64| check(torque.is_finite(), "load torque", torque, "N·m", "must be finite");
        match self {
            OutputLoad::None | OutputLoad::Table(_) => Ok(()),
            OutputLoad::Constant { torque } => torque_check(*torque),
            OutputLoad::Sine { amplitude, period } => {
                torque_check(*amplitude)?;
                check(*period > 0.0 && period.is_finite(), "load period", *period, "s", "must be positive")
            }
            OutputLoad::GivenTorque(given) => given.validate("load torque"),
            OutputLoad::GivenMotion(motion) => motion.validate("output angle"),
            OutputLoad::Stepped(steps) => TimeTable::new("stepped load", steps).map(|_| ()),
            OutputLoad::DutyCycle(phases) => {
                if phases.is_empty() {
                    return Err(DynamicsError::BadTable { table: "duty cycle", message: "it has no rows" });
                }
                for &(duration, torque) in phases {
                    torque_check(torque)?;
                    check(
                        duration > 0.0 && duration.is_finite(),
                        "duration of a duty phase",
                        duration,
                        "s",
                        "must be positive",
                    )?;
                }
                Ok(())
            }
        }
    }

    /// Prescribed motion of the output, if any.
    pub fn motion(&self) -> Option<&GivenMotion> {
        match self {
            OutputLoad::GivenMotion(motion) => Some(motion),
            _ => None,
        }
    }

    /// Torque in N·m at `time` (s); at a jump, the value after it. 0 for a prescribed motion.
    pub fn torque(&self, time: f64) -> f64 {
        match self {
            OutputLoad::None | OutputLoad::GivenMotion(_) => 0.0,
            OutputLoad::GivenTorque(given) => given.at(time),
            OutputLoad::Constant { torque } => *torque,
            OutputLoad::Sine { amplitude, period } => amplitude * (TAU * time / period).sin(),
            OutputLoad::Table(table) => table.value(time),
            OutputLoad::Stepped(steps) => {
                let index = steps.partition_point(|(from, _)| *from <= time);
                if index == 0 { 0.0 } else { steps[index - 1].1 }
            }
            OutputLoad::DutyCycle(phases) => phase_ends(phases, time)
                .into_iter()
                .zip(phases)
                .find(|(end, _)| time < *end)
                .map_or(phases[0].1, |(_, phase)| phase.1),
        }
    }

    /// First jump after `time` (s).
    pub fn next_jump(&self, time: f64) -> Option<f64> {
        match self {
            OutputLoad::Stepped(steps) => steps.iter().map(|(from, _)| *from).find(|from| *from > time),
            OutputLoad::DutyCycle(phases) => phase_ends(phases, time).into_iter().find(|end| *end > time),
            OutputLoad::Table(table) => table.next_jump(time),
            _ => None,
        }
    }
}

/// Ends of the phases of the cycle that contains `time`. A cycle ends at an exact multiple of its length,
/// consistently for value and next jump.
fn phase_ends(phases: &[(f64, f64)], time: f64) -> Vec<f64> {
    let length: f64 = phases.iter().map(|(duration, _)| duration).sum();
    let mut cycle = (time / length).floor();
    // The division may be rounded up to the next whole number, or stay below it.
    if cycle * length > time {
        cycle -= 1.0;
    } else if (cycle + 1.0) * length <= time {
        cycle += 1.0;
    }
    let mut end = cycle * length;
    let mut ends: Vec<f64> = phases
        .iter()
        .map(|(duration, _)| {
            end += duration;
            end
        })
        .collect();
    if let Some(last) = ends.last_mut() {
        *last = (cycle + 1.0) * length;
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_and_values_agree() {
        let stepped = OutputLoad::Stepped(vec![(0.1, 5.0), (0.2, -3.0)]);
        assert_eq!((stepped.torque(0.05), stepped.torque(0.1), stepped.torque(0.3)), (0.0, 5.0, -3.0));
        assert_eq!(stepped.next_jump(0.1), Some(0.2));
        let duty = OutputLoad::DutyCycle(vec![(0.1, 1.0), (0.2, 2.0)]);
        let mut time = 0.0;
        for i in 0..40 {
            assert_eq!(duty.torque(time), if i % 2 == 0 { 1.0 } else { 2.0 }, "{time}");
            let jump = duty.next_jump(time).unwrap();
            assert!(jump > time);
            assert_eq!(duty.torque(jump.next_down()), duty.torque(time));
            time = jump;
        }
        assert!((time - 6.0).abs() < 1e-9);
    }

    #[test]
    fn loads_without_meaning_are_refused() {
        assert!(OutputLoad::Sine { amplitude: 1.0, period: 0.0 }.validate().is_err());
        assert!(OutputLoad::Constant { torque: f64::NAN }.validate().is_err());
        assert!(OutputLoad::Stepped(vec![(0.2, 1.0), (0.1, 1.0)]).validate().is_err());
        assert!(OutputLoad::DutyCycle(vec![(-0.2, 1.0)]).validate().is_err());
    }
}
