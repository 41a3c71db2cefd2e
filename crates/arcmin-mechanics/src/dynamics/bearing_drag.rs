//! Load-independent drag of the bearings of a running machine.

use super::{DynamicsError, MainBearings, RingVector};
use crate::machine::{Friction, Machine, REFERENCE_C, RollerBearing, RollerKind};
use crate::tribology::lubricant_moment;

/// Torques in N·m against the motion, which the bearings have without load.
///
/// At the input those of turning-arm bearings and crank supports, which rotate with the crankshafts relative to
/// discs and carrier; at the output those of the main bearings. Each bearing has Palmgren's M₀ of the lubricant
/// ([`lubricant_moment`]); preloaded ones also M₁ = f₁ F_β d_m (Harris, Rolling Bearing Analysis, ch. 10): F_β
/// = 0.9 F_a cot α for balls, 0.8 F_a cot α for rollers, F_a the axial preload of the row. The equations are
/// valid for steady rolling. Within some tens of micrometres of rolling, the range of a main bearing in a
/// hysteresis loop, a bearing acts like a spring instead; hysteresis loops therefore do not include this drag.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BearingDrag {
    /// Drag of turning-arm bearings and crank supports, as a torque at the input, N·m.
    pub input: f64,
    /// Drag of the main bearings, as a torque at the output, N·m.
    pub output: f64,
}

/// Ratio of the starting to the running moment of preloaded bearings (SKF General Catalogue 4000).
const STARTING: f64 = 2.0;

impl BearingDrag {
    /// At a temperature in °C and an input speed in rad/s; at speed 0 the starting drag.
    ///
    /// # Errors
    /// [`DynamicsError`] if the equilibrium of the main bearings is not found.
    pub fn of(machine: &Machine, celsius: f64, input_speed: f64) -> Result<BearingDrag, DynamicsError> {
        let friction = &machine.friction;
        if !friction.bearings_drag() {
            return Ok(BearingDrag::default());
        }
        let (factor, starts) = (friction.bearing_drag, input_speed == 0.0);
        // Ratios of speeds do not depend on the speed; for the starting drag they are those of the rated one.
        let reference = if starts { 1.0 } else { input_speed.abs() };
        let (output, _, crank) = machine.kinematics().speeds(reference);
        let (output, crank) = (output.abs(), crank.abs());
        let viscosity = machine.thermal.oil.kinematic_viscosity(celsius);
        let lubricant = |bearing: &RollerBearing, speed: f64| {
            let speed = if starts { 0.0 } else { speed };
            factor * lubricant_moment(lubrication_factor(bearing), viscosity, speed, bearing.pitch_diameter)
        };
        let pressed = if starts { STARTING } else { 1.0 };

        let (arm, support) = (&machine.bearings.turning_arm, &machine.bearings.crank_support);
        let axial = friction.crank_support_preload;
        let each = 2.0
            * (lubricant(support, crank)
                + pressed * preload_moment(support, axial, support.contact_angle, support.roller_count))
            + machine.disc_count as f64 * lubricant(arm, crank);
        let rows = MainBearings::of(machine).balance(&RingVector::zeros())?;
        let row = &machine.solids.main_rows.row;
        let main: f64 = rows
            .elements
            .iter()
            .map(|elements| {
                let axial: f64 = elements.iter().map(|e| e.force * e.contact.y).sum();
                let loaded = elements.iter().filter(|e| e.force > 0.0).count();
                lubricant(row, output)
                    + pressed * factor * preload_moment(row, axial, row.contact_angle, loaded)
            })
            .sum();
        Ok(BearingDrag {
            input: machine.crankshafts.count as f64 * each * crank / reference,
            output: main * output / reference * machine.kinematics().ratio().abs(),
        })
    }

    /// The friction of a machine including this drag, as torques at one input speed (rad/s, not 0).
    pub fn added_to(self, friction: Friction, input_speed: f64) -> Friction {
        Friction {
            seal_drag: friction.seal_drag + self.output,
            oil_drag: friction.oil_drag + self.input / input_speed.abs(),
            bearing_drag: 0.0,
            crank_support_preload: 0.0,
            ..friction
        }
    }

    /// A machine at its rated speed, with the drag of its bearings at its temperature included in seals and
    /// oil.
    ///
    /// # Errors
    /// [`DynamicsError`] if the equilibrium of the main bearings is not found.
    pub fn at_rated(machine: &Machine) -> Result<Machine, DynamicsError> {
        let speed = machine.rated.input_speed;
        let mut running = machine.clone();
        if machine.friction.bearings_drag() && speed != 0.0 {
            let celsius = machine.thermal.temperature.unwrap_or(REFERENCE_C);
            running.friction = BearingDrag::of(machine, celsius, speed)?.added_to(machine.friction, speed);
        }
        Ok(running)
    }
}

/// Ratio of length to diameter that defines needles, and fraction of the pitch circle that defines a full
/// complement.
const NEEDLE: f64 = 2.5;
const FULL: f64 = 0.95;

/// f₀ of Palmgren's formula with grease: angular contact balls 2, tapered rollers 6, needles 12, cylindrical rollers
/// 1 in a cage (0.6 to 1) and 7.5 in a full complement (5 to 10). Harris, table 10.3; SKF General Catalogue 4000.
fn lubrication_factor(bearing: &RollerBearing) -> f64 {
    let circle = std::f64::consts::PI * bearing.pitch_diameter;
    match bearing.kind {
        RollerKind::Ball => 2.0,
        RollerKind::Tapered => 6.0,
        RollerKind::Cylindrical if bearing.roller_length >= NEEDLE * bearing.roller_diameter => 12.0,
        RollerKind::Cylindrical if bearing.roller_count as f64 * bearing.roller_diameter > FULL * circle => {
            7.5
        }
        RollerKind::Cylindrical => 1.0,
    }
}

/// M₁ = f₁ F_β d_m in N·m of a row under an axial force (N) on `loaded` elements.
///
/// Rollers: f₁ = 0.0004. Balls: f₁ = z (P₀/C₀)^0.33, z = 0.001 at 30° to 0.0013 at 40°, P₀ = 0.22 cot α F_a
/// (ISO 76: 0.26 at 40°), C₀ = 15 MPa Z D² cos α; in P₀/C₀ only the force Q = F_a/(Z sin α) on one ball
/// remains.
fn preload_moment(row: &RollerBearing, axial: f64, contact_angle: f64, loaded: usize) -> f64 {
    if !(axial > 0.0) || loaded == 0 || !(contact_angle > 0.0) {
        return 0.0;
    }
    let slant = axial / contact_angle.tan();
    let (f1, load) = match row.kind {
        RollerKind::Ball => {
            let element = axial / (loaded as f64 * contact_angle.sin());
            let steep = ((contact_angle.to_degrees() - 30.0) / 10.0).clamp(0.0, 1.0);
            let share = 0.22 * element / (15e6 * row.roller_diameter.powi(2));
            ((1e-3 + 0.3e-3 * steep) * share.powf(0.33), 0.9 * slant)
        }
        RollerKind::Tapered | RollerKind::Cylindrical => (4e-4, 0.8 * slant),
    };
    f1 * load * row.pitch_diameter
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::templates::tao2024;
    use crate::units::RPM;

    fn greased() -> Machine {
        let mut machine = tao2024();
        machine.friction.bearing_drag = 1.0;
        machine
    }

    /// Computed by hand at 40 °C (VG 150: 150 mm²/s) and 1500 rpm: the crankshafts rotate at 1500 · 40/81 =
    /// 740.7 rpm relative to discs and carrier, ν n = 1.111e5, its 2/3 power 2311. Supports 6 · 2311 · 26³ ·
    /// 1e-7 = 24.37 N·mm, turning-arm bearings 1 · 2311 · 22.5³ · 1e-7 = 2.633 N·mm; four of each, times
    /// 740.7/1500.
    #[test]
    fn crank_bearings_by_hand() {
        let machine = greased();
        let drag = BearingDrag::of(&machine, 40.0, 1500.0 * RPM).unwrap();
        let expected = 4.0 * (24.37e-3 + 2.633e-3) * 40.0 / 81.0;
        assert!((drag.input / expected - 1.0).abs() < 1e-3, "{drag:?} {expected}");
        // Rows of 83 balls of 4.6 mm on 136 mm, preloaded by 5 µm: about 0.25 N·m each.
        assert!((0.1..1.5).contains(&drag.output), "{drag:?}");
        let reverse = BearingDrag::of(&machine, 40.0, -1500.0 * RPM).unwrap();
        assert_eq!(drag, reverse);
    }

    /// The drag increases with viscosity as (ν₁/ν₂)^(2/3); a preload of the supports adds f₁ 0.8 F_a cot α d_m
    /// each, twice that at the start; without the keys there is none.
    #[test]
    fn temperature_preload_and_start() {
        let machine = greased();
        let speed = machine.rated.input_speed;
        let at =
            |machine: &Machine, celsius: f64, speed: f64| BearingDrag::of(machine, celsius, speed).unwrap();
        let oil = machine.thermal.oil;
        let colder = (oil.kinematic_viscosity(0.0) / oil.kinematic_viscosity(60.0)).powf(2.0 / 3.0);
        let ratio = at(&machine, 0.0, speed).input / at(&machine, 60.0, speed).input;
        assert!((ratio / colder - 1.0).abs() < 1e-9 && ratio > 5.0, "{ratio} {colder}");
        let mut pressed = machine.clone();
        pressed.friction.crank_support_preload = 500.0;
        let moment = 4e-4 * 0.8 * 500.0 / 12f64.to_radians().tan() * 26e-3;
        let crank = 40.0 / 81.0;
        let more = |speed: f64| at(&pressed, 40.0, speed).input - at(&machine, 40.0, speed).input;
        assert!((more(speed) / (4.0 * moment * crank) - 1.0).abs() < 1e-9, "{}", more(speed));
        assert!((more(0.0) / (8.0 * moment * crank) - 1.0).abs() < 1e-9, "{}", more(0.0));
        assert_eq!(BearingDrag::of(&tao2024(), -20.0, speed).unwrap(), BearingDrag::default());
    }

    /// For random machines of all kinds the drag is finite, the same in both directions, not smaller at higher
    /// speed or lower temperature, and its power as torques at input and output equals that of the bearings.
    #[test]
    fn drag_of_random_machines() {
        for seed in 0..40 {
            let mut machine = crate::random_designs::sound_design(seed).0.machine();
            machine.friction.bearing_drag = 1.0;
            let speed = machine.rated.input_speed;
            let at = |celsius: f64, share: f64| BearingDrag::of(&machine, celsius, share * speed).unwrap();
            let (slow, rated, fast, cold) = (at(40.0, 0.1), at(40.0, 1.0), at(40.0, 2.0), at(0.0, 1.0));
            for drag in [slow, rated, fast, cold, at(40.0, 0.0)] {
                assert!(drag.input > 0.0 && drag.output > 0.0, "{seed}: {drag:?}");
                assert!((drag.input + drag.output).is_finite(), "{seed}: {drag:?}");
            }
            let no_less = |more: f64, less: f64| more >= less * (1.0 - 1e-12);
            for (more, less) in [(rated, slow), (fast, rated), (cold, rated)] {
                assert!(no_less(more.input, less.input) && no_less(more.output, less.output), "{seed}");
            }
            assert_eq!(at(40.0, -1.0), rated);
            let friction = rated.added_to(machine.friction, speed);
            let more = (friction.oil_drag - machine.friction.oil_drag) * speed * speed;
            assert!((more / (rated.input * speed.abs()) - 1.0).abs() < 1e-9 && !friction.bearings_drag());
        }
    }

    /// 40° angular contact balls with P₀/C₀ = 0.1: f₁ = 0.0013 · 0.1^0.33.
    #[test]
    fn balls_by_hand() {
        let row = RollerBearing {
            kind: RollerKind::Ball,
            roller_count: 20,
            roller_diameter: 10e-3,
            roller_length: 10e-3,
            pitch_diameter: 100e-3,
            contact_angle: 40f64.to_radians(),
            clearance: 0.0,
            dynamic_load_rating: None,
        };
        let (sin, cos) = row.contact_angle.sin_cos();
        let rating = 15e6 * 20.0 * 1e-4 * cos;
        let axial = 0.1 * rating / (0.22 * cos / sin);
        let expected = 1.3e-3 * 0.1f64.powf(0.33) * 0.9 * axial * cos / sin * 0.1;
        let found = preload_moment(&row, axial, row.contact_angle, 20);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
}
