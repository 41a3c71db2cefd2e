//! The reducer as a joint of a robot model, at several ages: what `arcmin export joint` writes.

use super::{AnalysisError, Host};
use crate::design::Design;
use crate::exchange::fmu::PinLoadAt;
use crate::exchange::{JointExport, JointInertia, JointState, Stamp};
use crate::fidelity::{Fidelity, FidelityOptions, Joints};
use crate::life::{WornState, worn_after};
use crate::load::ShareLoad;
use crate::rig::{Curves, RigPlan, RigState, error_curve, loss_lines};

/// What to measure.
#[derive(Debug, Clone)]
pub struct JointOptions {
    pub fidelity: FidelityOptions,
    /// Ages in hours.
    pub hours: Vec<f64>,
    /// Crank positions of the loops and places over the turn of the output, as in `rig`.
    pub positions: usize,
    pub error_positions: usize,
    /// Time step in s of the robot simulation.
    pub timestep: f64,
    /// Inertia in kg·m² of what the output moves; the usual one for the motor if none is given.
    pub load_inertia: Option<f64>,
}

/// Torque of a further pair of error curves as a share of the rated one.
const BETWEEN: f64 = 0.5;

/// Runs the test bench at each age, the youngest first.
///
/// # Errors
/// [`AnalysisError`]: ideal joints, ages without a result, states without balance, loops that cannot be fitted.
pub fn joint(design: &Design, options: &JointOptions, host: &dyn Host) -> Result<JointExport, AnalysisError> {
    if options.fidelity.joints.value == Joints::Ideal {
        return Err(AnalysisError::usage(
            "the exported joint needs a machine in bearings",
            "choose joints = bearings",
        ));
    }
    let nominal = design.machine();
    let (machine, friction_assumed) = super::rig::with_friction(&nominal, false);
    let fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let inertia = JointInertia::of(&machine).map_err(AnalysisError::compute("find the inertias"))?;
    let mut hours = options.hours.clone();
    hours.sort_by(f64::total_cmp);
    hours.dedup();
    let rated = machine.rated.torque.abs();
    let plan = RigPlan {
        loop_positions: options.positions,
        error_positions: options.error_positions,
        curves: Curves::Every,
        pins: false,
        running: true,
    };
    let bench = |error| AnalysisError::compute("run the test bench")(error);
    let mut states = Vec::with_capacity(hours.len());
    for age in hours {
        let worn = match age {
            0.0 => WornState::new(),
            // Wear belongs to the duty; friction on the bench does not change it.
            age => worn_after(&nominal, &fidelity, age, host)?,
        };
        let settings = worn.on(fidelity.joint_settings()?);
        let measured = RigState::measure(&machine, &settings, age, plan, host)
            .map_err(bench)?
            .ok_or(AnalysisError::Stopped)?;
        let curve = |direction: f64| {
            error_curve(&machine, &settings, options.error_positions, direction, BETWEEN * rated)
                .map_err(bench)
        };
        let further = [curve(1.0)?, curve(-1.0)?];
        let losses = loss_lines(&machine, &settings).map_err(bench)?;
        let state = JointState::of(&measured, &further, losses, (machine.kinematics().ratio(), rated));
        states.push(state.map_err(AnalysisError::compute("describe the joint"))?);
    }
    let sentence = fidelity.sentence();
    let stamp = Stamp::of(design);
    let robot = (options.timestep, options.load_inertia);
    Ok(JointExport::new(&machine, &stamp, sentence, friction_assumed, inertia, robot, states))
}

/// Torques at which pin loads are mapped, as shares of the rated one, and crank positions of each.
const PIN_SHARES: [f64; 6] = [0.1, 0.25, 0.5, 0.75, 1.0, 2.0];
const PIN_POSITIONS: usize = 24;

/// Largest force and pressure of a pin over torque at each age, from the load sharing in bearings.
///
/// # Errors
/// [`AnalysisError`] where no load sharing is found.
pub fn pin_loads(
    design: &Design,
    options: &JointOptions,
    hours: &[f64],
    host: &dyn Host,
) -> Result<Vec<Vec<PinLoadAt>>, AnalysisError> {
    let machine = design.machine();
    let fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let mut all = Vec::with_capacity(hours.len());
    for age in hours {
        let worn = worn_after(&machine, &fidelity, *age, host)?;
        let mut meshing = fidelity.in_bearings(&machine)?;
        worn.put_on(&machine.designed_relief(), &mut meshing);
        let mut loads = Vec::with_capacity(PIN_SHARES.len());
        for share in PIN_SHARES {
            let torque = share * machine.rated.torque.abs();
            let cycle = meshing
                .whole_cycle(torque.copysign(machine.rated.torque), PIN_POSITIONS)
                .map_err(AnalysisError::compute("share the load"))?;
            loads.push(PinLoadAt {
                torque_n_m: torque,
                force_n: cycle.max_force(),
                pressure_pa: cycle.max_pressure(meshing.contacts().contact()),
            });
        }
        all.push(loads);
    }
    Ok(all)
}
