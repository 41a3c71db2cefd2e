use super::{Cause, Distance, Joint, Limit, Nominal, Part, Sink, State, damp};
use crate::dynamics::RoundSupport;
use crate::dynamics::mechanism::Arm;
use crate::dynamics::mechanism::assembly::Element;
use crate::geometry::{Vec2, quarter_turn, unit};

/// Linear support with radial clearance between two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// Part to which the compliance is assigned.
    pub part: Part,
    /// Cause to which the lost motion of the clearance is assigned; `None` without clearance.
    pub cause: Option<Cause>,
    /// (x, y, θ) of the first body, (x, y) of the second.
    pub index: [usize; 5],
    /// Radial stiffness, N/m.
    pub stiffness: f64,
    /// Radial clearance, m.
    pub clearance: f64,
    /// Position on the first body, relative to the body's centre.
    pub seat: Arm,
    /// Ratio of damping to stiffness in s.
    pub loss_time: f64,
}

/// Number of tangents that approximate a circle.
const TANGENTS: usize = 8;

impl Support {
    fn seat_at(&self, q: &[f64]) -> Vec2 {
        if self.seat.radius == 0.0 { Vec2::zeros() } else { self.seat.at(q[self.index[2]]) }
    }

    /// Displacement of the supported point on the first body relative to the second, m.
    fn displacement(&self, q: &[f64]) -> Vec2 {
        let [x, y, _, hx, hy] = self.index;
        Vec2::new(q[x] - q[hx], q[y] - q[hy]) + self.seat_at(q)
    }
}

impl Joint for Support {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let (index, stiffness, clearance) = (self.index, self.stiffness, self.clearance);
        let seat = self.seat_at(at.q);
        let u = self.displacement(at.q);
        let distance = u.norm();
        let is_requested = sink.contact_request().is_some() && clearance > 0.0;
        if is_requested {
            let along = quarter_turn(seat);
            let gradient = vec![[1.0, 0.0], [0.0, 1.0], [along.x, along.y], [-1.0, 0.0], [0.0, -1.0]];
            let (index, shift) = (index.to_vec(), [u.x, u.y]);
            sink.round_support(RoundSupport { index, gradient, shift, stiffness, clearance });
        }
        if distance < clearance {
            return;
        }
        let open = if distance > 0.0 { clearance / distance } else { 0.0 };
        let normal = if distance > 0.0 { u / distance } else { Vec2::zeros() };
        let depth = distance - clearance;
        let force = stiffness * (1.0 - open) * u;
        let along = quarter_turn(seat);
        let rows = [[1.0, 0.0, along.x, -1.0, 0.0], [0.0, 1.0, along.y, 0.0, -1.0]];
        let entry = |i: usize, j: usize| {
            stiffness * ((1.0 - open) * f64::from(u8::from(i == j)) + open * normal[i] * normal[j])
        };
        let radial = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
        let mut hessian = [0.0; 25];
        for a in 0..5 {
            for b in 0..5 {
                for i in 0..2 {
                    for j in 0..2 {
                        hessian[a * 5 + b] += rows[i][a] * radial[i][j] * rows[j][b];
                    }
                }
            }
        }
        damp(&index, &hessian, self.loss_time, at, sink);
        if is_requested {
            hessian.fill(0.0);
        }
        hessian[12] -= force.dot(&seat);
        let gradient: [f64; 5] = std::array::from_fn(|a| force.x * rows[0][a] + force.y * rows[1][a]);
        sink.element(&Element {
            part: self.part,
            index: &index,
            gradient: &gradient,
            hessian: &hessian,
            stored: 0.5 * stiffness * depth * depth,
        });
    }

    /// Within a clearance: tangents all around the circle, and one at the position of the body, which alone
    /// carries force.
    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        let (u, seat) = (self.displacement(q), self.seat_at(q));
        let gradient = |n: Vec2| [n.x, n.y, n.dot(&quarter_turn(seat)), -n.x, -n.y];
        let index = &self.index;
        let stiffness = self.stiffness;
        if self.clearance <= 0.0 {
            for n in [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)] {
                add(Limit::Bond(Distance { index, gradient: &gradient(n), value: n.dot(&u), stiffness }));
            }
            return;
        }
        let here = u.try_normalize(0.0).unwrap_or(Vec2::new(1.0, 0.0));
        let around = (0..TANGENTS).map(|i| unit(std::f64::consts::TAU * i as f64 / TANGENTS as f64));
        for n in around.chain([here]) {
            let value = self.clearance - n.dot(&u);
            if value < reach {
                add(Limit::Gap(Distance { index, gradient: &gradient(-n), value, stiffness }));
            }
        }
    }

    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        add(Cause::ELASTIC, 2.0 * self.stored(at));
        let Some(cause) = self.cause else { return };
        let shift = self.displacement(at.q);
        let force = self.stiffness * (shift.norm() - self.clearance).max(0.0);
        add(cause, force * self.clearance);
        if let Some(nominal) = nominal.of_errors().filter(|_| force > 0.0) {
            add(Cause::MANUFACTURING_ERRORS, -force * shift.normalize().dot(&self.displacement(nominal)));
        }
    }

    fn set_loss_time(&mut self, time: f64) {
        self.loss_time = time;
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
