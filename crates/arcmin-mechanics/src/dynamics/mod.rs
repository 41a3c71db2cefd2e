//! Multibody dynamics: equations of motion, their integration in time, static equilibrium, and the models.

mod bearing_drag;
mod bearing_joints;
mod drive;
mod eccentrics;
mod elastic_carrier;
mod elastic_disc;
mod elastic_housing;
mod error;
mod gear_mesh;
mod ideal_joints;
mod inputs;
mod integrator;
mod load;
pub mod mechanism;
mod model;
mod reducer;
mod ring_bearing;
mod run;
mod simulation;
mod single_stage;
mod spectrum;
mod statics;
mod statistics;
mod study;
mod system;
mod table;

pub use bearing_drag::BearingDrag;
pub use bearing_joints::{
    BearingJoints, BearingMeshing, JointSettings, LostMotionSplit, TiltingOutput, labels,
};
pub use drive::{Drive, InputMotion};
pub use eccentrics::{EccentricJoints, HeldDrive, StageLosses, StageParts};
pub use elastic_carrier::ElasticCarrier;
pub use elastic_disc::{ElasticDiscs, FlexibleOptions};
pub use elastic_housing::ElasticHousing;
pub use error::DynamicsError;
pub use ideal_joints::{FlexibleJoints, IdealJoints};
pub use inputs::{GivenMotion, GivenTorque, LoadInput, MotorInput};
pub use integrator::{EnergyAccount, Integrator, IntegratorState, Node, StepControl, StepCounts};
pub use load::OutputLoad;
pub use mechanism::{Cause, ElementLoad, HolePinLoad, Part, RollingBearing};
pub(crate) use mechanism::{Motion, QuasiStatic};
pub use model::Model;
pub use reducer::{ForceSummary, Reducer};
pub use ring_bearing::{MainBalance, MainBearings, RingState, RingVector};
pub use run::{Checkpoint, ForceSample, Run, RunPlan, RunResult, Sample};
pub use simulation::{Outputs, Simulation, SimulationState};
pub use single_stage::StageMeshing;
#[cfg(test)]
pub(crate) use single_stage::elastic_tests::two_discs as two_elastic_discs;
pub use spectrum::{OrderWaves, SpectrumLine, order_spectrum};
pub(crate) use statics::continue_from_larger_loads;
pub use statics::{Equilibrium, EquilibriumControl, solve_equilibrium, solve_equilibrium_unless};
pub use statistics::{ErrorIntegrals, ErrorStatistics};
pub use study::{
    StartSpread, StudyPoint, StudySettings, TransmissionErrorStudy, flexible_transmission_error_study,
    simulate_rigid, spread_over_starts, transmission_error_study,
};
pub use system::{
    Balance, Columns, Contact, Contacts, DenseLinearisation, ElasticCoordinates, Evaluation, FlankPlace,
    RoundSupport, Singular, System, Weights,
};
pub use table::TimeTable;
