use super::{Cause, Distance, Joint, Limit, Nominal, Part, Sink, State, damp};
use crate::dynamics::mechanism::Arm;
use crate::dynamics::mechanism::assembly::Element;
use crate::dynamics::{MainBearings, RingVector};
use crate::geometry::{Vec2, quarter_turn};
use crate::machine::OutputForces;

/// Two rows of rolling elements between a tilting body and another one.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::dynamics) struct MainPair {
    /// Part to which the compliance is assigned.
    pub part: Part,
    pub rows: MainBearings,
    /// (x, y, θ) of the tilting body, (x, y) of the other; (φ_x, φ_y, z) of the first relative to the second.
    pub index: [usize; 8],
    /// Position of the rows on the tilting body, relative to its centre.
    pub seat: Arm,
    /// Ratio of damping to stiffness in s.
    pub loss_time: f64,
}

/// Rows of x, y, z, φ_x, φ_y over the coordinates.
type Rows = [[f64; 8]; 5];

impl MainPair {
    fn seat_at(&self, q: &[f64]) -> Vec2 {
        if self.seat.radius == 0.0 { Vec2::zeros() } else { self.seat.at(q[self.index[2]]) }
    }

    fn displacement(&self, q: &[f64]) -> RingVector {
        let [x, y, _, hx, hy, lean_x, lean_y, z] = self.index;
        let seat = self.seat_at(q);
        RingVector::from([q[x] - q[hx] + seat.x, q[y] - q[hy] + seat.y, q[z], q[lean_x], q[lean_y]])
    }

    fn rows(&self, q: &[f64]) -> Rows {
        let along = quarter_turn(self.seat_at(q));
        let mut rows = [[0.0; 8]; 5];
        (rows[0][0], rows[0][2], rows[0][3]) = (1.0, along.x, -1.0);
        (rows[1][1], rows[1][2], rows[1][4]) = (1.0, along.y, -1.0);
        (rows[2][7], rows[3][5], rows[4][6]) = (1.0, 1.0, 1.0);
        rows
    }
}

impl Joint for MainPair {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let (state, rows) = (self.rows.react(&self.displacement(at.q)), self.rows(at.q));
        let by = |a: usize, b: usize| -> f64 {
            (0..5)
                .map(|i| rows[i][a] * (0..5).map(|j| state.stiffness[(i, j)] * rows[j][b]).sum::<f64>())
                .sum()
        };
        let mut hessian: [f64; 64] = std::array::from_fn(|k| by(k / 8, k % 8));
        damp(&self.index, &hessian, self.loss_time, at, sink);
        let seat = self.seat_at(at.q);
        hessian[2 * 8 + 2] -= state.load[0] * seat.x + state.load[1] * seat.y;
        let gradient: [f64; 8] = std::array::from_fn(|a| (0..5).map(|i| state.load[i] * rows[i][a]).sum());
        sink.element(&Element {
            part: self.part,
            index: &self.index,
            gradient: &gradient,
            hessian: &hessian,
            stored: state.stored,
        });
    }

    /// As for rows without radial clearance: their clearance is axial.
    fn limits(&self, q: &[f64], _: f64, add: &mut dyn FnMut(Limit<'_>)) {
        let (at, rows) = (self.displacement(q), self.rows(q));
        let stiffness = self.rows.react(&RingVector::zeros()).stiffness;
        for axis in 0..2 {
            let (gradient, value) = (&rows[axis][..5], at[axis]);
            let stiffness = stiffness[(axis, axis)].max(1.0);
            add(Limit::Bond(Distance { index: &self.index[..5], gradient, value, stiffness }));
        }
        self.index[5..].iter().for_each(|tilt| add(Limit::Held(*tilt)));
    }

    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        let here = self.displacement(at.q);
        let load = self.rows.react(&here).load;
        add(Cause::ELASTIC, load.dot(&here));
        if let Some(nominal) = nominal.of_errors() {
            add(Cause::MANUFACTURING_ERRORS, -load.dot(&self.displacement(nominal)));
        }
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}

/// Constant external forces on the output.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::dynamics) struct OutsideForces {
    /// Part to which they are assigned; they have no compliance.
    part: Part,
    /// Coordinates and the force (N, N·m) on each.
    index: [usize; 5],
    force: [f64; 5],
    /// −1 if the output is the other body of a pair of rows, whose tilt has the opposite sign.
    sense: f64,
}

impl OutsideForces {
    pub fn new(part: Part, index: [usize; 5], sense: f64, forces: OutputForces) -> OutsideForces {
        let mut outside = OutsideForces { part, index, force: [0.0; 5], sense };
        outside.set_output_forces(forces);
        outside
    }
}

impl Joint for OutsideForces {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let gradient = self.force.map(|force| -force);
        let stored = gradient.iter().zip(&self.index).map(|(g, i)| g * at.q[*i]).sum();
        sink.element(&Element {
            part: self.part,
            index: &self.index,
            gradient: &gradient,
            hessian: &[0.0; 25],
            stored,
        });
    }

    fn limits(&self, _: &[f64], _: f64, _: &mut dyn FnMut(Limit<'_>)) {}

    fn set_output_forces(&mut self, OutputForces { moment, axial, radial }: OutputForces) {
        self.force = [radial, 0.0, 0.0, self.sense * moment, self.sense * axial];
    }

    /// Their work appears in the elastic approaches of all joints.
    fn work(&self, at: State<'_>, _: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        add(Cause::ELASTIC, self.stored(at));
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
