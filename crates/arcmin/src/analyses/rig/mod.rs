//! Virtual test bench: hysteresis, lost motion, backlash, stiffness, efficiency as makers define them.

mod declared;
mod measured;
mod page;

pub(crate) use declared::{SUMMARY, tables};

use super::causes::{CausesAt, HasCauses};
use super::{AnalysisError, Attachment, Host, elastic_disc, outcome};
use crate::design::{Design, InputFile, default, optional, options};
use crate::fidelity::{Fidelity, FidelityOptions, Joints};
use crate::life::{PartsPoint, WornState, lost_motion_causes, worn_after};
use crate::machine::{Friction, Machine, OutputForces};
use crate::rig::{
    Curves, MainBearingLoad, MeasuredOnBench, RigPlan, RigState, assumed_friction, main_bearing_load,
};

pub(crate) const ABOUT: &str =
    "Test bench: hysteresis loop, lost motion, stiffness, transmission error, efficiency";
pub(crate) const GUIDE: &str = "Virtual test bench for the machine in its bearings, without inertia.\n\nHysteresis loop with the \
    input locked and the output torque cycled to ± rated torque: lost motion (mid-points at ±3 %), \
    backlash (width at zero torque), torsional stiffness (50–100 % of rated torque). One output turn in \
    both directions, at 1 % and at 100 % of rated torque: transmission error. Further results: \
    efficiency, running torques, loads and lives of the bearings.\n\nIf the design gives no friction, \
    coefficients are assumed and the run states it; --frictionless omits friction. With --hours the new \
    and the worn machine are tested. --bodies elastic includes the compliance of carrier, housing, pin \
    grooves, crank seats and rims. --moment-nm, --axial-n and --radial-n load the main bearings.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin rig my-reducer.toml",
    "arcmin rig my-reducer.toml --hours 2000",
    "arcmin rig my-reducer.toml --discs elastic",
    "arcmin rig my-reducer.toml --bodies elastic",
    "arcmin rig my-reducer.toml --moment-nm 400 --axial-n 1000",
    "arcmin rig my-reducer.toml --measured loop.csv",
];

options! {
    /// Options of `rig`.
    pub struct Options {
        [fidelity: FidelityOptions, joints = "bearings"]
        /// Age of the machine in hours of its duty: flanks, pins, bearings and gears are worn accordingly, with the same
        /// model of the machine.
        hours: f64 => default(0.0, 0.0, 1e7),
        /// Measured curve, evaluated by the same code and drawn over the computed one; may be given several times. Columns of
        /// a hysteresis loop: torque_n_m, angle_arcmin; optional: branch (falling or rising), time_s, position (of the
        /// crankshafts). Columns of a transmission error: output_angle_deg, te_arcmin; optional: direction, torque_n_m,
        /// time_s. Other columns are ignored.
        measured: Vec<InputFile> => optional(0.0, 0.0),
        // With two crankshafts every position occurs twice in a turn: four positions would be two.
        /// Number of crank positions for the hysteresis loop, evenly over a turn of the crankshafts.
        positions: usize => default(5.0, 1.0, 360.0),
        /// Number of points of the transmission error over one output turn.
        te_positions: usize => default(1024.0, 64.0, 65536.0),
        /// External tilting moment on the output. The run computes tilt, forces and life of the main bearings.
        moment_nm: f64 => default(0.0, 0.0, 1e7),
        /// External axial force on the output, positive out of the machine.
        axial_n: f64 => default(0.0, -1e8, 1e8),
        /// External radial force on the output, in the middle of the main bearings and in the plane of the moment.
        radial_n: f64 => default(0.0, -1e8, 1e8),
        /// Without friction. Otherwise coefficients are assumed if the design gives none.
        frictionless: bool => optional(0.0, 0.0),
    }
}

/// Results from the loads of the pins over the output turn.
const PIN_LOADS: &[&str] = &["max_force_n", "max_pressure_mpa"];
/// Results from the transmission error forward under small load.
const HELD_CURVE: &[&str] = &["te_held_peak_to_peak_arcmin"];
/// Results and tables with all transmission errors; the others use only the one forward at rated torque.
const EVERY_CURVE: &[&str] = &["transmission_error", "te"];
/// Results and tables from the one forward at rated torque.
const RATED_CURVE: &[&str] =
    &["te_rated_peak_to_peak_arcmin", "orders", "spectrum", "max_force_n", "max_pressure_mpa", "report"];
/// Results and tables from the hysteresis loops.
const LOOPS: &[&str] = &[
    "lost_motion_arcmin",
    "backlash_arcmin",
    "stiffness_n_m_per_arcmin",
    "soft_stiffness_n_m_per_arcmin",
    "middle_stiffness_n_m_per_arcmin",
    "new",
    "hysteresis",
    "stiffness",
    "report",
];
/// Results and tables from the running machine; "new" contains its efficiency.
const RUNNING: &[&str] = &[
    "efficiency",
    "new",
    "no_load_running_torque_n_m",
    "no_load_at_output_n_m",
    "running_torques",
    "starting_torque_n_m",
    "back_driving_torque_n_m",
    "shortest_bearing_life_h",
    "thermal",
    "bearings",
    "bearing_forces",
];

/// Results of the bench.
#[derive(Debug, Clone)]
pub struct Rig {
    /// The machine with the friction of the test.
    pub machine: Machine,
    /// Joints, bodies and errors.
    pub fidelity: Fidelity,
    /// Whether the design gives no friction and some was assumed.
    pub friction_assumed: bool,
    /// Results of the new machine.
    pub new: RigState,
    /// Lost motion of the new machine by cause, if the run requests it.
    pub new_causes: Option<PartsPoint>,
    /// Results after the given hours.
    pub worn: Option<(RigState, Option<PartsPoint>)>,
    /// Curves of a real bench, evaluated in the same way.
    pub measured: Option<MeasuredOnBench>,
    /// The main bearings under the given forces.
    pub main_bearings: MainBearingLoad,
    /// Seconds of the computation, if the host has a clock.
    pub wall: f64,
}

/// Tests the machine.
///
/// # Errors
/// [`AnalysisError`]: invalid measured curves, states without equilibrium.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Rig, AnalysisError> {
    let started = host.seconds();
    if options.fidelity.joints.value == Joints::Ideal {
        return Err(AnalysisError::usage(
            "the bench needs a machine in bearings",
            "leave joints = ideal out; for ideal joints use `arcmin contact`",
        ));
    }
    let nominal_friction = design.machine();
    let (machine, friction_assumed) = with_friction(&nominal_friction, options.frictionless);
    let measured = measured::read(&options.measured, &machine, host)?;
    let forces = OutputForces { moment: options.moment_nm, axial: options.axial_n, radial: options.radial_n };
    let main_bearings =
        main_bearing_load(&machine, forces).map_err(AnalysisError::compute("load the main bearings"))?;
    let mut fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    fidelity.errors = machine.thermal.on(fidelity.errors, &machine);
    // External forces act on the bench only; the wear is that of the duty.
    let unpushed = fidelity.clone();
    fidelity.push_output(&machine, forces)?;
    let wanted = |results: &[&str]| results.iter().any(|result| host.needs(result));
    let curves = if wanted(EVERY_CURVE) {
        Curves::Every
    } else if wanted(HELD_CURVE) {
        Curves::Forward
    } else if wanted(RATED_CURVE) {
        Curves::Rated
    } else {
        Curves::Nothing
    };
    let plan = RigPlan {
        // The split of the stiffness and the report need one.
        loop_positions: if wanted(LOOPS) { options.positions } else { 1 },
        error_positions: options.te_positions,
        curves,
        pins: wanted(PIN_LOADS),
        running: wanted(RUNNING),
    };
    let test = |state: &WornState| -> Result<(RigState, Option<PartsPoint>), AnalysisError> {
        let settings = state.on(fidelity.joint_settings()?);
        let tested = RigState::measure(&machine, &settings, state.hours, plan, host)
            .map_err(AnalysisError::compute("run the test bench"))?
            .ok_or(AnalysisError::Stopped)?;
        if !wanted(&["lost_motion_causes"]) {
            return Ok((tested, None));
        }
        let causes = lost_motion_causes(&machine, fidelity.in_bearings(&machine)?, state)
            .map_err(AnalysisError::wear("split the lost motion"))?;
        Ok((tested, Some(causes)))
    };
    let (new, new_causes) = test(&WornState::new())?;
    let worn = if options.hours > 0.0 {
        // The wear is that of the duty; friction on the bench does not change it.
        Some(test(&worn_after(&nominal_friction, &unpushed, options.hours, host)?)?)
    } else {
        None
    };
    Ok(Rig {
        wall: host.seconds() - started,
        machine,
        fidelity,
        friction_assumed,
        new,
        new_causes,
        worn,
        measured,
        main_bearings,
    })
}

/// The tested machine, and whether its friction is assumed because the design gives none.
pub(crate) fn with_friction(machine: &Machine, frictionless: bool) -> (Machine, bool) {
    let mut tested = machine.clone();
    let f = &machine.friction;
    let none = [f.flank, f.pin_seat, f.bearing, f.gear_mesh, f.seal_drag, f.oil_drag]
        .iter()
        .all(|coefficient| *coefficient == 0.0)
        && !f.bearings_drag();
    let friction = match (frictionless, none) {
        (true, _) => Friction::default(),
        (false, true) => assumed_friction(machine),
        (false, false) => return (tested, false),
    };
    tested.friction = Friction { regularisation_speed: f.regularisation_speed, ..friction };
    (tested, none && !frictionless)
}

impl Rig {
    /// The selected state: worn, or new.
    pub fn state(&self) -> &RigState {
        self.worn.as_ref().map_or(&self.new, |(state, _)| state)
    }

    fn causes_at(&self) -> Vec<CausesAt> {
        let new = self.new_causes.map(|point| CausesAt { hours: 0.0, point });
        let worn = self.worn.as_ref().and_then(|(state, point)| Some((state.hours, (*point)?)));
        new.into_iter().chain(worn.map(|(hours, point)| CausesAt { hours, point })).collect()
    }
}

impl HasCauses for Rig {
    fn causes(&self) -> Option<&PartsPoint> {
        self.worn.as_ref().map_or(&self.new_causes, |(_, point)| point).as_ref()
    }
}

outcome!(Rig {
    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        elastic_disc::attachments(&self.machine, &self.fidelity)
    }
});
