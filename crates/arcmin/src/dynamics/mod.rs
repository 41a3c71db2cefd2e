//! Multibody dynamics: equations of motion, their integration in time, static equilibrium, and the models.

mod equilibrium;
mod error;
mod integrator;
mod system;

pub use equilibrium::{Equilibrium, EquilibriumControl, solve_equilibrium};
pub use error::DynamicsError;
pub use integrator::{EnergyAccount, Integrator, IntegratorState, Node, StepControl, StepCounts};
pub use system::{Balance, DenseLinearisation, Linearisation, Singular, System, Weights};
