//! The whole machine with its bearings on worn surfaces: lost motion by cause, and the wear of bearings and
//! gears.

use super::whole::POSITIONS;
use super::{MachineInBearings, OtherParts, WholeDrive};
use crate::dynamics::{BearingMeshing, LostMotionSplit};
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::{Machine, PartWear};
use crate::wear::{WearError, WearSnapshot};

/// The machine with bearings at one time of its life.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartsPoint {
    /// Wear of bearings and gears.
    pub wear: PartWear,
    /// Frictionless lost motion of the whole machine at ±3 % of rated torque, by cause.
    pub lost_motion: LostMotionSplit,
}

/// Wear of bearings and gears together with that of flanks and pins.
///
/// Their clearance grows at the rate at the beginning of each interval: the loads on rollers hardly depend on a few
/// micrometres of clearance, so halving the intervals changes little (tested).
#[derive(Debug)]
pub struct PartsFollower<'a> {
    machine: &'a Machine,
    meshing: BearingMeshing,
    designed: Relief,
    wear: PartWear,
}

impl<'a> PartsFollower<'a> {
    /// New bearings and gears in the given joints.
    pub fn with(machine: &'a Machine, meshing: BearingMeshing) -> PartsFollower<'a> {
        PartsFollower { machine, meshing, designed: machine.designed_relief(), wear: PartWear::default() }
    }
}

impl OtherParts for PartsFollower<'_> {
    fn wear_at_all(&self) -> bool {
        self.machine.wear.parts.any()
    }

    fn set_surfaces(&mut self, surfaces: &WearSnapshot) {
        surfaces.apply_to(&self.designed, &mut self.meshing);
    }

    fn advance(&mut self, time: f64) -> Result<(), WearError> {
        let rates = self.meshing.part_wear_rates(self.machine, POSITIONS)?;
        self.wear = self.wear.plus(&rates, time);
        self.meshing.set_part_wear(&self.wear);
        Ok(())
    }

    fn wear(&self) -> PartWear {
        self.wear
    }
}

/// Lost motion by cause of a machine in the given state, without friction.
///
/// # Errors
/// [`WearError::Load`] where no balance is found.
pub fn lost_motion_causes(
    machine: &Machine,
    joints: BearingMeshing,
    state: &super::WornState,
) -> Result<PartsPoint, WearError> {
    MachineInBearings::new(machine, joints).split(state)
}

/// Lost motion of a machine in the given state in rad, without friction.
///
/// # Errors
/// [`WearError::Load`] where no balance is found.
pub(crate) fn lost_motion_of(
    machine: &Machine,
    joints: BearingMeshing,
    state: &super::WornState,
) -> Result<f64, WearError> {
    MachineInBearings::new(machine, joints).lost_motion(std::slice::from_ref(state))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::labels::{CAUSES, GEARS, TURNING_ARM};
    use crate::dynamics::{Cause, JointSettings};
    use crate::fidelity::Fidelity;
    use crate::life::{WornState, worn_after};
    use crate::machine::{ManufacturingErrors, RollingWear, RunOut, Tolerances};
    use crate::progress::Silent;
    use crate::rig::{TransmissionSettings, transmission_error_curves};
    use crate::units::{ARCMIN, HOUR, UM};
    use crate::wear::{CoupledOptions, CoupledWear};

    fn split(machine: &Machine, settings: &JointSettings, state: &WornState) -> LostMotionSplit {
        let joints = BearingMeshing::new(machine, settings).unwrap();
        lost_motion_causes(machine, joints, state).unwrap().lost_motion
    }

    /// The new machine, in the joints of the settings.
    fn split_new(machine: &Machine, settings: &JointSettings) -> LostMotionSplit {
        split(machine, settings, &WornState { part_wear: settings.part_wear, ..WornState::new() })
    }

    /// New, after 7500 h with pins without wear and with pins that wear like the discs, with a uniform wear of
    /// 10 µm, and with worn bearings and gears: the sum of the causes equals the whole within the tolerance of
    /// the equilibria, and second-order contributions are small.
    #[test]
    fn causes_add_up_to_the_lost_motion() {
        let machine = crate::templates::tao2024();
        let mut worn_pins = machine.clone();
        worn_pins.wear.pin_ratio = 1.0;
        let part_wear = PartWear {
            turning_arm: 6.0 * UM,
            crank_support: 4.0 * UM,
            gears: [5.0 * UM, 2.0 * UM],
            ..PartWear::default()
        };
        let after = |machine: &Machine| worn_after(machine, &Fidelity::ideal(), 7500.0, &Silent).unwrap();
        let states = [
            (WornState::new(), TURNING_ARM.play),
            (after(&machine), Cause::FLANK_WEAR),
            (after(&worn_pins), Cause::PIN_WEAR),
            (WornState::uniform(10.0 * UM), Cause::FLANK_WEAR),
            (WornState { part_wear, ..WornState::new() }, TURNING_ARM.wear),
        ];
        for (state, cause) in states {
            let split = split(&machine, &JointSettings::default(), &state);
            assert!(
                split.residual().abs() < 1e-6 * split.whole,
                "{cause:?}: {} of {}",
                split.residual(),
                split.whole
            );
            assert!(split.of(cause) > 0.1 * split.whole, "{cause:?}: {split:?}");
            assert!(split.of(Cause::CURVATURE).abs() < 0.06 * split.whole, "{cause:?}: {split:?}");
            let signed = CAUSES.iter().zip(&split.causes).filter(|(cause, _)| **cause != Cause::CURVATURE);
            assert!(signed.into_iter().all(|(_, share)| *share > -1e-9), "{split:?}");
        }
    }

    /// Machines drawn from every tolerance of the shipped design, and one error of each kind separately: the
    /// causes, errors among them, add up to the lost motion. Without the errors as a cause the difference would
    /// be many times the whole, since parts of tight machines are preloaded without load.
    #[test]
    fn manufacturing_errors_are_a_cause_of_their_own() {
        let machine = crate::templates::tao2024();
        let tolerances = Tolerances {
            pin_position: 3.0 * UM,
            pin_radius: UM,
            pin_circle_radius: 3.0 * UM,
            pin_circle_offset: 4.0 * UM,
            eccentricity: 2.0 * UM,
            bore_position: 4.0 * UM,
            bore_diameter: 3.0 * UM,
            flank_run_out: 4.0 * UM,
            flank_pitch: 3.0 * UM,
            flank_profile: 2.0 * UM,
            journal_run_out: 2.0 * UM,
            planet_run_out: 8.0 * UM,
            carrier_run_out: 4.0 * UM,
            sun_run_out: 8.0 * UM,
            ..Tolerances::default()
        };
        let run_out = RunOut { amplitude: 4.0 * UM, phase: 0.7 };
        let nothing = ManufacturingErrors::default();
        let cases = [
            ManufacturingErrors::draw(&machine, &tolerances, 1),
            ManufacturingErrors::draw(&machine, &tolerances, 7),
            ManufacturingErrors { pin_circle_radius: 2.0 * UM, ..nothing.clone() },
            ManufacturingErrors {
                planets: vec![run_out; 2],
                sun: run_out,
                carrier: run_out,
                ..nothing.clone()
            },
            ManufacturingErrors { journals: vec![run_out], pin_circle_offset: run_out, ..nothing.clone() },
        ];
        for errors in cases {
            let settings = JointSettings { errors, ..JointSettings::default() };
            let split = split_new(&machine, &settings);
            let (left, errors) =
                (split.residual() / split.whole, split.of(Cause::MANUFACTURING_ERRORS) / split.whole);
            assert!(left.abs() < 1e-6, "{left} {errors} {split:?}");
            assert!(split.of(Cause::CURVATURE).abs() < 1e-3 * split.whole, "{split:?}");
            assert!(errors.abs() > 0.1, "{errors}");
        }
    }

    /// Preloaded pins hold the discs, while the crankshafts turn through the backlash of the gears: the lost
    /// motion is this backlash and the elastic part. Discs on circular paths and flanks that turn relative to
    /// the pins each do much work against the preload, but for conjugate flanks the sum is zero.
    #[test]
    fn conjugate_flanks_under_preload_have_no_curvature() {
        let mut machine = crate::templates::tao2024();
        machine.disc.modification.equidistant_offset = -8.0 * UM;
        machine.bearings.turning_arm.clearance = 0.0;
        machine.gear_stage.backlash = 200.0 * UM;
        let split = split_new(&machine, &JointSettings::default());
        assert!(split.residual().abs() < 1e-6 * split.whole, "{split:?}");
        assert!(split.of(GEARS.play) > 0.5 * split.whole, "{split:?}");
        assert!(split.of(Cause::CURVATURE).abs() < 0.01 * split.whole, "{split:?}");
    }

    /// A backlash g on the driving sides of all sun–planet meshes turns the output by g/(r_b2 z_c + r_b1 +
    /// r_b2), independent of the bearings: the cause and the growth of the whole equal this within 1 % and 2 %
    /// (in the whole the bearings are loaded at a slightly different position).
    #[test]
    fn val_gear_wear_opens_the_lost_motion_by_its_closed_form() {
        let machine = crate::templates::tao2024();
        let gap = 5.0 * UM;
        let (r1, r2) = (machine.gear_stage.sun_base_radius(), machine.gear_stage.planet_base_radius());
        let expected = gap / (r2 * 39.0 + r1 + r2);
        let of = |part_wear: PartWear| {
            split(&machine, &JointSettings::default(), &WornState { part_wear, ..WornState::new() })
        };
        let (new, worn) =
            (of(PartWear::default()), of(PartWear { gears: [gap, 0.0], ..PartWear::default() }));
        assert!((worn.of(GEARS.wear) / expected - 1.0).abs() < 0.01, "{} {expected}", worn.of(GEARS.wear));
        assert!(
            ((worn.whole - new.whole) / expected - 1.0).abs() < 0.02,
            "{} {expected}",
            worn.whole - new.whole
        );
    }

    fn with_laws() -> Machine {
        let mut machine = crate::templates::tao2024();
        let law = RollingWear { coefficient: 1e-18, slip: 0.01 };
        machine.wear.parts.turning_arm = Some(law);
        machine.wear.parts.crank_support = Some(law);
        (machine.wear.parts.sun, machine.wear.parts.planet) = (1e-18, 1e-18);
        machine
    }

    /// Support bearings without clearance: ΣQ follows from the radial force by the load integrals of the line
    /// contact (exponent 10/9), ΣQ/F = ∫cos^n/∫cos^(n+1) over the loaded half, within 2 % (15 rollers in place
    /// of a continuum). The growth per hour follows from the closed form.
    #[test]
    fn support_wear_follows_from_the_radial_force() {
        let machine = with_laws();
        let positions = POSITIONS;
        let mut meshing = BearingMeshing::new(&machine, &JointSettings::default()).unwrap();
        let rates = meshing.part_wear_rates(&machine, positions).unwrap();
        let loads = crate::rig::bearing_loads(&machine, &JointSettings::default(), 72).unwrap();
        let supports: Vec<f64> =
            loads.iter().filter(|load| load.name.contains("support")).map(|load| load.mean_force()).collect();
        let radial = supports.iter().sum::<f64>() / supports.len() as f64;
        let n = 10.0 / 9.0;
        let integral = |power: f64| {
            (0..2000)
                .map(|i| ((f64::from(i) + 0.5) / 2000.0 * std::f64::consts::FRAC_PI_2).cos().powf(power))
                .sum::<f64>()
        };
        let bearing = &machine.bearings.crank_support;
        let forces = radial / bearing.contact_angle.cos() * integral(n) / integral(n + 1.0);
        let relative = machine.kinematics().speeds(machine.rated.input_speed).2;
        let expected = 1e-18 * crate::wear::parts::clearance_rate(bearing, 0.01, forces, relative);
        assert!((rates.crank_support / expected - 1.0).abs() < 0.02, "{} {expected}", rates.crank_support);
        assert!(rates.turning_arm > 0.0);
        // Rated torque loads one side of the gear teeth only.
        assert!(rates.gears.iter().filter(|rate| **rate > 0.0).count() == 1, "{:?}", rates.gears);
    }

    /// Twice as many intervals change the growth of the clearances by less than 1 %.
    #[test]
    fn intervals_of_the_part_wear_hardly_matter() {
        let machine = with_laws();
        let growth = |steps: usize| {
            let mut parts = PartsFollower::with(
                &machine,
                BearingMeshing::new(&machine, &JointSettings::default()).unwrap(),
            );
            for _ in 0..steps {
                parts.advance(7500.0 * HOUR / steps as f64).unwrap();
            }
            parts.wear()
        };
        let (coarse, fine) = (growth(3), growth(6));
        assert!(coarse.turning_arm > UM, "{coarse:?}");
        assert!((coarse.turning_arm / fine.turning_arm - 1.0).abs() < 0.01, "{coarse:?} {fine:?}");
        assert!((coarse.crank_support / fine.crank_support - 1.0).abs() < 0.01, "{coarse:?} {fine:?}");
    }

    /// With wear of pins like that of the discs, of bearings and gears, and of the flank with the machine in
    /// these bearings: an equilibrium is found at every step to 5000 h and then over a whole turn of the
    /// crankshafts, at rated torque with a residual of 1e-6 of it, and at no load.
    #[test]
    fn worn_pins_and_parts_leave_every_balance_exact() {
        let mut machine = with_laws();
        machine.wear.pin_ratio = 1.0;
        let options = CoupledOptions { depth_increment: 0.25 * UM, ..CoupledOptions::default() };
        let exposure = machine.coupled_exposure(options).unwrap();
        let mut parts =
            PartsFollower::with(&machine, BearingMeshing::new(&machine, &JointSettings::default()).unwrap());
        let mut wear = CoupledWear::with(
            &machine,
            BearingMeshing::new(&machine, &JointSettings::default()).unwrap(),
            options,
        );
        for step in 1..=4 {
            let time = 1250.0 * HOUR;
            parts.set_surfaces(wear.state());
            parts.advance(time).unwrap();
            wear.set_part_wear(&parts.wear());
            wear.advance_to(exposure.at(time * f64::from(step))).unwrap();
        }
        assert!(
            wear.state().pin().deepest().0 > 8.0 * UM && parts.wear().turning_arm > UM,
            "{:?}",
            parts.wear()
        );
        let cycle = wear.meshing_mut().whole_cycle(machine.rated.torque, 24).unwrap();
        let largest = cycle.positions.iter().map(|position| position.residual.abs()).fold(0.0, f64::max);
        assert!(largest < 1e-6 * machine.rated.torque, "{largest}");
        assert!(cycle.mean_play().arcmin() > 0.3, "{}", cycle.mean_play().arcmin());
    }

    /// Wear that more than doubles the growth measured in 600 h (0.18′) increases the lost motion of the
    /// machine with bearings but not its transmission error: the peak-to-peak value at rated torque (0.096′)
    /// changes by less than a tenth, and by less than a fiftieth of the increase of the lost motion (0.55′).
    #[test]
    fn val_transmission_error_stays_while_lost_motion_grows() {
        let mut machine = crate::templates::tao2024();
        // The coefficient fitted to 600 h in `val_measured_growth_needs_running_in`.
        machine.wear.coupled = crate::machine::WearCoefficient::Given(7.64e-18);
        let test = TransmissionSettings { positions: 480, ..TransmissionSettings::new(&machine) };
        let state = |worn: &WornState| {
            let settings = worn.on(JointSettings::default());
            let curves = transmission_error_curves(&machine, &settings, test).unwrap();
            let joints = BearingMeshing::new(&machine, &JointSettings::default()).unwrap();
            (
                lost_motion_causes(&machine, joints, worn).unwrap().lost_motion.whole / ARCMIN,
                curves[2].peak_to_peak() / ARCMIN,
            )
        };
        let new = state(&WornState::new());
        let worn = state(&worn_after(&machine, &Fidelity::ideal(), 1550.0, &Silent).unwrap());
        assert!(worn.0 - new.0 > 0.25, "{new:?} {worn:?}");
        assert!(
            (worn.1 - new.1).abs() < 0.1 * new.1 && (worn.1 - new.1).abs() < 0.02 * (worn.0 - new.0),
            "{new:?} {worn:?}"
        );
    }
}
