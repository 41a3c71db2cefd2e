//! Steady temperature from losses and cooling.

use super::RigError;
use super::efficiency::Bench;
use crate::dynamics::JointSettings;
use crate::machine::Machine;

/// State of a machine at the temperature of the design, and its steady temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatBalance {
    /// Viscosity η of the oil in Pa·s at the temperature of the design.
    pub viscosity: f64,
    /// Mean film ratio of the loaded flanks at this temperature, at rated torque and speed.
    pub film_ratio: f64,
    /// Friction coefficient of the loaded flanks at this temperature.
    pub flank_friction: f64,
    /// Loss at this temperature in W.
    pub loss: f64,
    /// Steady state at rated torque and speed; `None` if the loss exceeds the cooling even at 200 K above the
    /// ambient.
    pub steady: Option<Steady>,
}

/// Steady state: loss equals cooling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steady {
    /// Temperature in °C.
    pub temperature: f64,
    /// Loss in W.
    pub loss: f64,
    /// Heat given off by the surface in W.
    pub convection: f64,
    /// Heat into the mounting in W.
    pub conduction: f64,
}

/// Upper end of the search for the temperature in K above the ambient.
const HOTTEST: f64 = 200.0;

/// Loss (W) at rated torque and speed equal to the cooling by surface and mounting, (h A + G) (T − T_a): the
/// temperature by bisection to 0.01 K. Oil, housing and flange have one temperature, and the far end of the
/// mounting is at ambient temperature. `None` without a temperature in the design.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
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
    let steady = match settle(thermal.ambient, thermal.cooling(), loss)? {
        Some(temperature) => {
            let above = temperature - thermal.ambient;
            Some(Steady {
                temperature,
                loss: loss(temperature)?,
                convection: thermal.transfer * thermal.surface * above,
                conduction: thermal.mounting * above,
            })
        }
        None => None,
    };
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
fn settle<E>(ambient: f64, cooling: f64, loss: impl Fn(f64) -> Result<f64, E>) -> Result<Option<f64>, E> {
    let (mut low, mut high) = (ambient, ambient + HOTTEST);
    if loss(high)? > cooling * HOTTEST {
        return Ok(None);
    }
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if loss(middle)? > cooling * (middle - ambient) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(Some(0.5 * (low + high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loss independent of temperature: T = T_a + P/G; a loss that falls with it, P₀ − c (T − T_a): T = T_a +
    /// P₀/(G + c); a loss above all cooling has no steady temperature.
    #[test]
    fn heat_settles_in_closed_form() {
        let at = |slope: f64, power: f64| {
            settle(25.0, 2.0, |celsius| Ok::<_, ()>(power - slope * (celsius - 25.0))).unwrap()
        };
        assert!((at(0.0, 90.0).unwrap() - 70.0).abs() < 0.01);
        assert!((at(1.0, 90.0).unwrap() - 55.0).abs() < 0.01);
        assert_eq!(at(0.0, 500.0), None);
    }

    /// The same for random machines of all families; a steady temperature is above the ambient.
    #[test]
    fn losses_of_random_machines_leave_as_heat() {
        let mut found = 0;
        for seed in 0..4 {
            let mut machine = crate::random_designs::sound_design(seed).0.machine();
            let floor = machine.friction.regularisation_speed;
            let assumed = crate::rig::assumed_friction(&machine);
            machine.friction =
                crate::machine::Friction { regularisation_speed: floor, bearing_drag: 1.0, ..assumed };
            machine.thermal.temperature = Some(30.0);
            let heat = heat_balance(&machine, &JointSettings::default()).unwrap().unwrap();
            assert!(heat.loss > 0.0 && heat.film_ratio > 0.0, "{seed}: {heat:?}");
            let Some(steady) = heat.steady else { continue };
            let away = steady.convection + steady.conduction;
            assert!((steady.loss - away).abs() < 0.02 * machine.thermal.cooling(), "{seed}: {steady:?}");
            assert!(steady.temperature > machine.thermal.ambient, "{seed}: {steady:?}");
            found += 1;
        }
        assert!(found > 0);
    }

    /// The loss of the machine equals the heat given off; a mounting with a larger conductance gives the lower
    /// temperature of the closed form; seals alone have a closed form: P = T_s ω/i with Linke's share.
    #[test]
    fn losses_leave_as_heat() {
        let mut machine = crate::templates::tao2024();
        let floor = machine.friction.regularisation_speed;
        machine.friction = crate::machine::Friction {
            regularisation_speed: floor,
            ..crate::rig::assumed_friction(&machine)
        };
        machine.friction.bearing_drag = 1.0;
        machine.thermal.temperature = Some(40.0);
        let settings = JointSettings::default();
        let steady = |machine: &Machine| heat_balance(machine, &settings).unwrap().unwrap().steady.unwrap();
        let insulated = {
            let mut alone = machine.clone();
            alone.thermal.mounting = 0.0;
            steady(&alone)
        };
        let mounted = steady(&machine);
        for found in [insulated, mounted] {
            let away = found.convection + found.conduction;
            // Tolerance of the bisection, 0.01 K.
            assert!((found.loss - away).abs() < 0.02 * machine.thermal.cooling(), "{found:?}");
            let above = found.temperature - machine.thermal.ambient;
            assert!(above > 5.0 && found.convection > 0.0, "{found:?}");
        }
        assert!(insulated.conduction == 0.0 && mounted.conduction > 0.0);
        assert!(mounted.temperature < insulated.temperature - 5.0, "{mounted:?} {insulated:?}");

        let mut sealed = machine.clone();
        sealed.friction =
            crate::machine::Friction { seal_drag: 10.0, regularisation_speed: floor, ..Default::default() };
        let found = steady(&sealed);
        let share = crate::tribology::seal_share(found.temperature, sealed.thermal.oil.at_40c);
        let power = 10.0 * share * sealed.rated.input_speed / 81.0;
        assert!((found.loss / power - 1.0).abs() < 2e-3, "{found:?} {power}");
    }
}
