//! The reducer as a joint of a robot model, at several ages, for `arcmin export joint`.

use super::stage::{self, AnyDesign};
use super::{AnalysisError, Host};
use crate::design::Design;
use crate::dynamics::JointSettings;
use crate::exchange::fmu::PinLoadAt;
use crate::exchange::{JointBench, JointDrive, JointExport, JointInertia, JointState, Stamp};
use crate::fidelity::{Fidelity, FidelityOptions, Joints};
use crate::life::{WornState, worn_after};
use crate::load::ShareLoad;
use crate::machine::Machine;
use crate::progress::Progress;
use crate::rig::{Curves, LoopFigures, RigPlan, RigState, error_curve, loss_lines};

/// Options of the measurement.
#[derive(Debug, Clone)]
pub struct JointOptions {
    /// Joints, bodies and errors.
    pub fidelity: FidelityOptions,
    /// Ages in hours.
    pub hours: Vec<f64>,
    /// Crank positions of the loops, as in `rig`.
    pub positions: usize,
    /// Places over the turn of the output, as in `rig`.
    pub error_positions: usize,
    /// Time step in s of the robot simulation.
    pub timestep: f64,
    /// Load inertia at the output in kg·m²; by default the usual one for the motor.
    pub load_inertia: Option<f64>,
    /// Masses and inertias where the design gives none.
    pub masses: GivenMasses,
}

/// Masses and inertias for drives whose design gives none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GivenMasses {
    /// Moment of inertia of input shaft and motor, kg·m².
    pub input_inertia: Option<f64>,
    /// Moment of inertia of the output, kg·m².
    pub output_inertia: Option<f64>,
    /// Mass of the output, kg.
    pub output_mass: Option<f64>,
}

/// Torque of the second pair of error curves as a share of the rated one.
pub(super) const BETWEEN: f64 = 0.5;

impl JointOptions {
    /// Ages, the youngest first.
    pub(super) fn ages(&self) -> Vec<f64> {
        let mut hours = self.hours.clone();
        hours.sort_by(f64::total_cmp);
        hours.dedup();
        hours
    }

    pub(super) fn require_bearings(&self) -> Result<(), AnalysisError> {
        if self.fidelity.joints.value == Joints::Ideal {
            return Err(AnalysisError::usage(
                "the exported joint needs a machine in bearings",
                "choose joints = bearings",
            ));
        }
        Ok(())
    }
}

/// Runs the test bench at each age, the youngest first.
///
/// # Errors
/// [`AnalysisError`]: ideal joints, ages without a result, states without balance, loops that cannot be fitted.
pub fn joint(
    design: &AnyDesign,
    options: &JointOptions,
    host: &dyn Host,
) -> Result<JointExport, AnalysisError> {
    match design {
        AnyDesign::Rv(design) => of_rv(design, options, host),
        AnyDesign::Eccentric(design) => stage::joint::joint(&**design, options, (host, host)),
        AnyDesign::TwoRing(design) => stage::joint::joint(&**design, options, (host, host)),
        AnyDesign::TwoStage(design) => stage::joint::joint(&**design, options, (host, host)),
    }
}

fn of_rv(design: &Design, options: &JointOptions, host: &dyn Host) -> Result<JointExport, AnalysisError> {
    options.require_bearings()?;
    if options.masses != GivenMasses::default() {
        return Err(AnalysisError::usage(
            "the design of an RV reducer gives masses and inertias itself",
            "set gear_stage.sun_inertia_kg_m2, gear_stage.motor_inertia_kg_m2 and the carrier's there",
        ));
    }
    let nominal = design.machine();
    let bench = RvBench::new(design, &options.fidelity, host)?;
    let positions = (options.positions, options.error_positions);
    let mut states = Vec::new();
    for age in options.ages() {
        let worn = match age {
            0.0 => WornState::new(),
            // The wear is that of the duty; friction on the bench does not change it.
            age => worn_after(&nominal, &bench.fidelity, age, host)?,
        };
        states.push(bench.state(&worn, age, positions, host)?);
    }
    Ok(JointExport::new(&bench.drive, (options.timestep, options.load_inertia), states))
}

/// An RV reducer on the bench, for its joint.
pub(crate) struct RvBench {
    machine: Machine,
    pub fidelity: Fidelity,
    pub drive: JointDrive,
}

impl RvBench {
    /// # Errors
    /// [`AnalysisError`] if the design cannot be modelled with these options.
    pub fn new(
        design: &Design,
        fidelity: &FidelityOptions,
        host: &dyn Host,
    ) -> Result<RvBench, AnalysisError> {
        let (machine, friction_assumed) = super::rig::with_friction(&design.machine(), false);
        let fidelity = Fidelity::resolve(design, fidelity, host)?;
        let drive = JointDrive {
            stamp: Stamp::of(design),
            model: fidelity.sentence(),
            ratio: machine.kinematics().ratio(),
            rated_torque: machine.rated.torque.abs(),
            rated_input_speed: machine.rated.input_speed.abs(),
            inertia: JointInertia::of(&machine).map_err(AnalysisError::compute("find the inertias"))?,
            friction_assumed,
            inertia_assumed: false,
        };
        Ok(RvBench { machine, fidelity, drive })
    }

    /// The joint after some hours, with positions of the loops and over the turn of the output.
    ///
    /// # Errors
    /// [`AnalysisError`]: states without balance, loops that cannot be fitted.
    pub fn state(
        &self,
        worn: &WornState,
        hours: f64,
        (positions, error_positions): (usize, usize),
        progress: &dyn Progress,
    ) -> Result<JointState, AnalysisError> {
        let bench = |error| AnalysisError::compute("run the test bench")(error);
        let (machine, rated) = (&self.machine, self.drive.rated_torque);
        let settings: JointSettings = worn.on(self.fidelity.joint_settings()?);
        let plan = RigPlan {
            loop_positions: positions,
            error_positions,
            curves: Curves::Every,
            pins: false,
            running: true,
        };
        let measured = RigState::measure(machine, &settings, hours, plan, progress)
            .map_err(bench)?
            .ok_or(AnalysisError::Stopped)?;
        let curve = |direction: f64| {
            error_curve(machine, &settings, error_positions, direction, BETWEEN * rated).map_err(bench)
        };
        let further = [curve(1.0)?, curve(-1.0)?];
        let losses = loss_lines(machine, &settings).map_err(bench)?;
        let figures = LoopFigures::mean(&measured.figures);
        let RigState { loops, curves, efficiency: Some(efficiency), torques: Some(torques), .. } = measured
        else {
            return Err(AnalysisError::compute("run the test bench")(crate::rig::RigError::NoTorque));
        };
        let found = JointBench {
            hours,
            loops,
            figures,
            curves: curves.into_iter().chain(further).collect(),
            losses,
            efficiency: efficiency.rated,
            no_load: torques.no_load,
            starting: torques.starting,
            back_driving: torques.back_driving,
        };
        JointState::of(&found, (self.drive.ratio, rated))
            .map_err(AnalysisError::compute("describe the joint"))
    }
}

/// Torques at which pin loads are mapped, as shares of the rated one, and crank positions of each.
pub(super) const PIN_SHARES: [f64; 6] = [0.1, 0.25, 0.5, 0.75, 1.0, 2.0];
pub(super) const PIN_POSITIONS: usize = 24;

/// Largest force and pressure of a pin over torque at each age, from the load sharing in bearings.
///
/// # Errors
/// [`AnalysisError`] where no load sharing is found.
pub fn pin_loads(
    design: &AnyDesign,
    options: &JointOptions,
    hours: &[f64],
    host: &dyn Host,
) -> Result<Vec<Vec<PinLoadAt>>, AnalysisError> {
    match design {
        AnyDesign::Rv(design) => pin_loads_of_rv(design, options, hours, host),
        AnyDesign::Eccentric(design) => stage::joint::pin_loads(&**design, options, hours, host),
        AnyDesign::TwoRing(design) => stage::joint::pin_loads(&**design, options, hours, host),
        AnyDesign::TwoStage(design) => stage::joint::pin_loads(&**design, options, hours, host),
    }
}

fn pin_loads_of_rv(
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
        worn.apply_to(&machine.designed_relief(), &mut meshing);
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
