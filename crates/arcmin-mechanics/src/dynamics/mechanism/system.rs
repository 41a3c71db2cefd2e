use super::assembly::{Assembly, ContactRequest, Sink};
use super::joints::State;
use super::{Input, Mechanism};
use crate::contact::ContactSpring;
use crate::dynamics::{
    Balance, Columns, Contact, Contacts, DenseLinearisation, Drive, ElasticCoordinates, Evaluation,
    FlankPlace, ForceSummary, OutputLoad, Reducer, System,
};

impl Mechanism {
    /// All coordinates and velocities, including held or prescribed ones.
    pub(in crate::dynamics) fn full(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
    ) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut v) =
            (Vec::with_capacity(self.coordinates.whole), Vec::with_capacity(self.coordinates.whole));
        q.extend_from_slice(position);
        v.extend_from_slice(velocity);
        q.extend_from_slice(&self.held);
        v.resize(self.coordinates.whole, 0.0);
        if !self.has_free_input() {
            let input = self.flanges.input;
            (q[input], v[input]) = self.input_motion(time);
        }
        if let Some(motion) = self.load.motion() {
            let output = self.flanges.output;
            (q[output], v[output]) = motion.at(time);
        }
        (q, v)
    }

    fn input_motion(&self, time: f64) -> (f64, f64) {
        match &self.input {
            Input::Held { angle, speed } => (*angle, *speed),
            Input::Driven(drive) => {
                let motion = drive.motion(time);
                (motion.angle, motion.speed)
            }
        }
    }

    /// Forces at one state, with tangents if required; returns powers and the torque (N·m) of the drive on the
    /// input.
    pub fn evaluate_with_input(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        linearisation: Option<&mut DenseLinearisation>,
    ) -> (Balance, f64) {
        self.evaluate_for(time, position, velocity, force, linearisation, None)
    }

    /// As [`Mechanism::evaluate_with_input`], with single contacts if required.
    fn evaluate_for(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        mut linearisation: Option<&mut DenseLinearisation>,
        contacts: Option<(ContactRequest, &mut Contacts, &Columns)>,
    ) -> (Balance, f64) {
        let columns = contacts.as_ref().map(|(.., columns)| *columns);
        let interval = contacts.as_ref().and_then(|(wanted, ..)| wanted.slip_interval);
        let (q, v) = self.full(time, position, velocity);
        if let Some(linearisation) = linearisation.as_deref_mut() {
            linearisation.clear();
        }
        force.fill(0.0);
        let (size, input) = (self.coordinates.size, self.flanges.input);
        let mut assembly = Assembly {
            force,
            linearisation: linearisation.as_deref_mut(),
            size,
            input,
            prescribed_torque: 0.0,
            balance: Balance::default(),
            contacts,
        };
        self.visit(&q, &v, &mut assembly);
        let output = self.flanges.output;
        let load = self.load.torque(time);
        assembly.add_force(output, -load);
        assembly.balance.load_torque = load;
        assembly.balance.load_power = load * v[output];
        if self.resistance.drag > 0.0 {
            let reach = 1.0 / v[output].hypot(self.resistance.drag_speed);
            let torque = self.resistance.drag * v[output] * reach;
            let slope = match interval {
                None => self.resistance.drag * self.resistance.drag_speed.powi(2) * reach.powi(3),
                Some(interval) => {
                    let presliding = self.resistance.drag_speed * interval;
                    let spring = ContactSpring::Slip { limit: self.resistance.drag, presliding };
                    assembly.contact(&Contact::new(&[output], &[1.0], v[output] * interval, spring));
                    0.0
                }
            };
            assembly.damper(&[output], &[-torque], &[slope], torque * v[output]);
        }
        let (at, oil) = self.resistance.oil;
        if oil > 0.0 {
            assembly.damper(&[at], &[-oil * v[at]], &[oil], oil * v[at] * v[at]);
        }
        let input_torque = match &self.input {
            Input::Driven(drive) if self.has_free_input() => {
                let (torque, slope) = drive.torque(time, v[input]);
                assembly.damper(&[input], &[torque], &[slope], 0.0);
                torque
            }
            _ => -assembly.prescribed_torque,
        };
        assembly.balance.input_torque = input_torque;
        assembly.balance.input_power = input_torque * v[input];
        let mut balance = assembly.balance;
        if let Some(motion) = self.load.motion() {
            // A search with held output has no column for it.
            let column = columns.map_or(Some(output), |columns| columns.column(output));
            let held = linearisation.zip(column);
            motion.impose(time, output, self.mass[output], force, held, &mut balance);
        }
        (balance, input_torque)
    }
}

impl Mechanism {
    /// Linearisation for the static solver if friction depends on velocities, which are given or follow from
    /// displacements over an interval.
    pub(crate) fn evaluate_in_motion(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        wanted: ContactRequest,
        evaluation: &mut Evaluation,
    ) {
        let Evaluation { force, smooth, contacts, columns } = evaluation;
        contacts.clear();
        self.evaluate_for(time, position, velocity, force, Some(smooth), Some((wanted, contacts, columns)));
    }
}

impl System for Mechanism {
    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(self.coordinates.size)
    }

    fn linearisation_at_rest(&self) -> DenseLinearisation {
        DenseLinearisation::at_rest(self.coordinates.size)
    }

    fn mass(&self) -> &[f64] {
        &self.mass
    }

    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance {
        self.evaluate_with_input(time, position, velocity, force, Some(linearisation)).0
    }

    fn evaluate_forces(&self, time: f64, position: &[f64], velocity: &[f64], force: &mut [f64]) -> Balance {
        self.evaluate_with_input(time, position, velocity, force, None).0
    }

    fn evaluate_statics(&self, time: f64, position: &[f64], reach: f64, evaluation: &mut Evaluation) {
        let rest = vec![0.0; position.len()];
        self.evaluate_in_motion(
            time,
            position,
            &rest,
            ContactRequest { reach, slip_interval: None },
            evaluation,
        );
    }

    fn elastic(&self) -> Option<&ElasticCoordinates> {
        (!self.elastic.is_empty()).then_some(&self.elastic)
    }

    fn flank_compliance(&self, of: &FlankPlace, force: &FlankPlace) -> f64 {
        let elastic = self.rings.first().and_then(|ring| ring.elastic.as_ref());
        elastic.map_or(0.0, |modes| modes.body.flank_compliance(of, force))
    }

    fn next_breakpoint(&self, time: f64) -> Option<f64> {
        self.load.next_jump(time)
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        position[self.flanges.phase]
    }
}

impl Reducer for Mechanism {
    fn input(&self, time: f64, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        if self.has_free_input() {
            let input = self.flanges.input;
            return (position[input], velocity[input]);
        }
        self.input_motion(time)
    }

    fn output_index(&self) -> usize {
        self.flanges.output
    }

    fn ratio(&self) -> f64 {
        self.flanges.ratio
    }

    fn drive(&self) -> Option<&Drive> {
        match &self.input {
            Input::Driven(drive) => Some(drive),
            Input::Held { .. } => None,
        }
    }

    fn set_drive(&mut self, drive: Drive) {
        self.input = Input::Driven(drive);
    }

    fn output_load(&self) -> &OutputLoad {
        &self.load
    }

    fn set_output_load(&mut self, load: OutputLoad) {
        self.load = load;
    }

    fn free_input(&self) -> Option<usize> {
        self.has_free_input().then_some(self.flanges.input)
    }

    fn nominal_position_at(&self, input: f64) -> Vec<f64> {
        self.coordinates.nominal(input)
    }

    fn forces(&self, time: f64, position: &[f64], velocity: &[f64]) -> ForceSummary {
        let (q, v) = self.full(time, position, velocity);
        let mut summary = ForceSummary::default();
        self.elements().for_each(|joint| joint.add_forces(State { q: &q, v: &v }, &mut summary));
        summary
    }
}
