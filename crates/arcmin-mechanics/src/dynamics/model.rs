use super::mechanism::Mechanism;
use super::{
    Balance, BearingJoints, DenseLinearisation, Drive, ElasticCoordinates, Evaluation, FlankPlace,
    FlexibleJoints, ForceSummary, IdealJoints, OutputLoad, Reducer, System,
};

/// One of the models of the reducer, owned by a [`Simulation`](super::Simulation).
#[derive(Debug, Clone)]
pub enum Model {
    /// Rigid discs in ideal joints.
    Ideal(Box<IdealJoints>),
    /// Elastic discs in ideal joints.
    Flexible(Box<FlexibleJoints>),
    /// Bodies in bearings, gears and pins.
    Mechanism(Box<Mechanism>),
}

impl From<IdealJoints> for Model {
    fn from(model: IdealJoints) -> Model {
        Model::Ideal(Box::new(model))
    }
}

impl From<FlexibleJoints> for Model {
    fn from(model: FlexibleJoints) -> Model {
        Model::Flexible(Box::new(model))
    }
}

impl From<BearingJoints> for Model {
    fn from(model: BearingJoints) -> Model {
        model.into_mechanism().into()
    }
}

impl From<Mechanism> for Model {
    fn from(model: Mechanism) -> Model {
        Model::Mechanism(Box::new(model))
    }
}

/// Calls a method of the present variant.
macro_rules! each {
    ($model:expr, $inner:ident => $call:expr) => {
        match $model {
            Model::Ideal($inner) => $call,
            Model::Flexible($inner) => $call,
            Model::Mechanism($inner) => $call,
        }
    };
}

impl Model {
    /// Number of the variant, for saved states.
    pub(super) fn kind(&self) -> u8 {
        match self {
            Model::Ideal(_) => 0,
            Model::Flexible(_) => 1,
            Model::Mechanism(_) => 2,
        }
    }
}

impl System for Model {
    fn linearisation(&self) -> DenseLinearisation {
        each!(self, model => model.linearisation())
    }

    fn linearisation_at_rest(&self) -> DenseLinearisation {
        each!(self, model => model.linearisation_at_rest())
    }

    fn mass(&self) -> &[f64] {
        each!(self, model => model.mass())
    }

    fn scale(&self) -> &[f64] {
        each!(self, model => model.scale())
    }

    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance {
        each!(self, model => model.evaluate(time, position, velocity, force, linearisation))
    }

    fn evaluate_forces(&self, time: f64, position: &[f64], velocity: &[f64], force: &mut [f64]) -> Balance {
        each!(self, model => model.evaluate_forces(time, position, velocity, force))
    }

    fn evaluate_statics(&self, time: f64, position: &[f64], reach: f64, evaluation: &mut Evaluation) {
        each!(self, model => model.evaluate_statics(time, position, reach, evaluation));
    }

    fn elastic(&self) -> Option<&ElasticCoordinates> {
        each!(self, model => model.elastic())
    }

    fn flank_compliance(&self, of: &FlankPlace, force: &FlankPlace) -> f64 {
        each!(self, model => model.flank_compliance(of, force))
    }

    fn next_breakpoint(&self, time: f64) -> Option<f64> {
        each!(self, model => model.next_breakpoint(time))
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        each!(self, model => model.crank_angle(position))
    }
}

impl Reducer for Model {
    fn input(&self, time: f64, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        each!(self, model => model.input(time, position, velocity))
    }

    fn output_index(&self) -> usize {
        each!(self, model => model.output_index())
    }

    fn ratio(&self) -> f64 {
        each!(self, model => model.ratio())
    }

    fn drive(&self) -> Option<&Drive> {
        each!(self, model => model.drive())
    }

    fn set_drive(&mut self, drive: Drive) {
        each!(self, model => model.set_drive(drive));
    }

    fn output_load(&self) -> &OutputLoad {
        each!(self, model => model.output_load())
    }

    fn set_output_load(&mut self, load: OutputLoad) {
        each!(self, model => model.set_output_load(load));
    }

    fn free_input(&self) -> Option<usize> {
        each!(self, model => model.free_input())
    }

    fn nominal_position_at(&self, input: f64) -> Vec<f64> {
        each!(self, model => model.nominal_position_at(input))
    }

    fn forces(&self, time: f64, position: &[f64], velocity: &[f64]) -> ForceSummary {
        each!(self, model => model.forces(time, position, velocity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::JointSettings;

    /// A model passes the contacts of its mechanism one by one to the search for static equilibrium.
    #[test]
    fn a_model_passes_on_the_contacts_of_its_mechanism() {
        let machine = crate::templates::tao2024();
        let mechanism = BearingJoints::held(&machine, &JointSettings::default()).unwrap().into_mechanism();
        let model = Model::from(mechanism.clone());
        let place = mechanism.nominal_position_at(0.0);
        let (mut of_model, mut of_mechanism) = (Evaluation::default(), Evaluation::default());
        of_model.fit(&model, None);
        of_mechanism.fit(&mechanism, None);
        model.evaluate_statics(0.0, &place, 1e-4, &mut of_model);
        mechanism.evaluate_statics(0.0, &place, 1e-4, &mut of_mechanism);
        let gaps = |evaluation: &Evaluation| {
            evaluation.contacts.list.iter().map(|contact| contact.gap).collect::<Vec<_>>()
        };
        assert_eq!(gaps(&of_model), gaps(&of_mechanism));
        assert!(gaps(&of_model).len() > 10);
    }
}
