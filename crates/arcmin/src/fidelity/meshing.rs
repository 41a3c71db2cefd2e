//! One type of load sharing for all fidelities.

use crate::contact::{PinContact, PinContacts};
use crate::dynamics::BearingMeshing;
use crate::geometry::Relief;
use crate::load::{Cycle, FlexibleMeshing, FreeTravel, LoadError, LoadSharing, Meshing, ShareLoad};
use crate::machine::{CrankAngle, OutputAngle, OutputForces, PartWear};

/// Load sharing with ideal joints, on elastic discs, or of the machine in its bearings.
#[derive(Debug, Clone)]
pub enum MachineMeshing {
    /// Rigid bodies on ideal joints.
    Ideal(Meshing),
    /// Elastic discs on ideal joints.
    Elastic(Box<FlexibleMeshing>),
    /// Bodies in their bearings, rigid or elastic.
    Bearings(Box<BearingMeshing>),
}

/// Start of the iteration from a neighbouring solution.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshingStart {
    /// Output error of an ideal-joint model.
    Error(OutputAngle),
    /// Coordinates of a model in bearings, less their nominal values, m and rad.
    Deviation(Vec<f64>),
}

impl MeshingStart {
    fn error(&self) -> Option<&OutputAngle> {
        match self {
            MeshingStart::Error(error) => Some(error),
            MeshingStart::Deviation(_) => None,
        }
    }

    fn deviation(&self) -> Option<&Vec<f64>> {
        match self {
            MeshingStart::Error(_) => None,
            MeshingStart::Deviation(deviation) => Some(deviation),
        }
    }
}

macro_rules! each {
    ($self:ident, $meshing:ident => $body:expr) => {
        match $self {
            MachineMeshing::Ideal($meshing) => $body,
            MachineMeshing::Elastic($meshing) => {
                let $meshing = $meshing.as_ref();
                $body
            }
            MachineMeshing::Bearings($meshing) => {
                let $meshing = $meshing.as_ref();
                $body
            }
        }
    };
    (mut $self:ident, $meshing:ident => $body:expr) => {
        match $self {
            MachineMeshing::Ideal($meshing) => $body,
            MachineMeshing::Elastic($meshing) => {
                let $meshing = $meshing.as_mut();
                $body
            }
            MachineMeshing::Bearings($meshing) => {
                let $meshing = $meshing.as_mut();
                $body
            }
        }
    };
}

/// Solution of a mesh of either kind from a start of its own kind, with the solution as a start.
macro_rules! started {
    ($self:ident, $meshing:ident, $start:ident => $found:expr) => {
        match $self {
            MachineMeshing::Ideal($meshing) => {
                let $start = $start.and_then(MeshingStart::error);
                $found.map(|(found, error)| (found, MeshingStart::Error(error)))
            }
            MachineMeshing::Elastic($meshing) => {
                let $start = $start.and_then(MeshingStart::error);
                $found.map(|(found, error)| (found, MeshingStart::Error(error)))
            }
            MachineMeshing::Bearings($meshing) => {
                let $start = $start.and_then(MeshingStart::deviation);
                $found.map(|(found, deviation)| (found, MeshingStart::Deviation(deviation)))
            }
        }
    };
}

impl MachineMeshing {
    /// Rolling elements of a turning-arm bearing, as [`BearingMeshing::turning_arm_elements`]; ideal joints have none.
    pub fn turning_arm_elements(
        &self,
        crank: CrankAngle,
        solution: &MeshingStart,
        crankshaft: usize,
        disc: usize,
    ) -> Vec<(f64, f64)> {
        match (self, solution) {
            (MachineMeshing::Bearings(meshing), MeshingStart::Deviation(solution)) => {
                meshing.turning_arm_elements(crank, solution, crankshaft, disc)
            }
            _ => Vec::new(),
        }
    }
}

impl ShareLoad for MachineMeshing {
    type Start = MeshingStart;

    fn pattern_period(&self) -> f64 {
        each!(self, meshing => ShareLoad::pattern_period(meshing))
    }

    fn disc_speed(&self, input_speed: f64) -> f64 {
        each!(self, meshing => ShareLoad::disc_speed(meshing, input_speed))
    }

    fn contacts(&self) -> &PinContacts {
        each!(self, meshing => ShareLoad::contacts(meshing))
    }

    fn set_relief(&mut self, relief: Relief) {
        each!(mut self, meshing => ShareLoad::set_relief(meshing, relief));
    }

    fn set_pin_relief(&mut self, relief: Relief) {
        each!(mut self, meshing => ShareLoad::set_pin_relief(meshing, relief));
    }

    fn set_surfaces(&mut self, flanks: Vec<Relief>, pins: Vec<Relief>) {
        each!(mut self, meshing => ShareLoad::set_surfaces(meshing, flanks, pins));
    }

    fn set_part_wear(&mut self, wear: &PartWear) {
        each!(mut self, meshing => ShareLoad::set_part_wear(meshing, wear));
    }

    fn set_output_forces(&mut self, forces: OutputForces) {
        each!(mut self, meshing => ShareLoad::set_output_forces(meshing, forces));
    }

    fn pitches(&self) -> usize {
        each!(self, meshing => ShareLoad::pitches(meshing))
    }

    fn share(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&MeshingStart>,
    ) -> Result<(LoadSharing, MeshingStart), LoadError> {
        started!(self, meshing, start => meshing.share(crank, torque, start))
    }

    fn stiffness(&mut self, sharing: &LoadSharing) -> f64 {
        each!(mut self, meshing => ShareLoad::stiffness(meshing, sharing))
    }

    fn pin_contacts(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&MeshingStart>,
    ) -> Result<(Vec<Vec<PinContact>>, MeshingStart), LoadError> {
        started!(self, meshing, start => meshing.pin_contacts(crank, torque, start))
    }

    fn twin(&self) -> Self {
        match self {
            MachineMeshing::Ideal(meshing) => MachineMeshing::Ideal(meshing.twin()),
            MachineMeshing::Elastic(meshing) => MachineMeshing::Elastic(Box::new(meshing.twin())),
            MachineMeshing::Bearings(meshing) => MachineMeshing::Bearings(Box::new(meshing.twin())),
        }
    }

    fn travel(&mut self, crank: CrankAngle) -> Result<FreeTravel, LoadError> {
        each!(mut self, meshing => ShareLoad::travel(meshing, crank))
    }

    fn crank_position(&self, index: usize, count: usize, offset: f64, shift: usize) -> CrankAngle {
        each!(self, meshing => ShareLoad::crank_position(meshing, index, count, offset, shift))
    }

    fn discs_alike(&self) -> bool {
        each!(self, meshing => ShareLoad::discs_alike(meshing))
    }

    fn pitch_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        each!(mut self, meshing => ShareLoad::pitch_cycle(meshing, torque, count))
    }

    fn whole_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        each!(mut self, meshing => ShareLoad::whole_cycle(meshing, torque, count))
    }

    fn free_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        each!(mut self, meshing => ShareLoad::free_cycle(meshing, torque, count))
    }

    fn loaded_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        each!(mut self, meshing => ShareLoad::loaded_cycle(meshing, torque, count))
    }
}
