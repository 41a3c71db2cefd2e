use super::{Cause, Distance, Joint, Limit, Nominal, Part, Sink, State, damp};
use crate::contact::ContactSpring;
use crate::dynamics::Contact;
use crate::dynamics::mechanism::Arm;
use crate::dynamics::mechanism::assembly::Element;
use crate::geometry::{Vec2, quarter_turn};

/// Pins of one body in wider holes of another, as the output pins of a single stage: the axes stand apart by u = pin −
/// hole, and a pin presses where |u| exceeds the difference c of the radii, F = k (|u| − c) along u. Without friction.
#[derive(Debug, Clone, PartialEq)]
pub struct HolePins {
    pub part: Part,
    /// Under which name the play shows as lost motion: that of c beyond `nominal_distance`.
    pub cause: Option<Cause>,
    /// (x, y, θ) of the body with the pins, then of the one with the holes.
    pub index: [usize; 6],
    /// Axes of pin and hole, each in its body.
    pub pairs: Vec<[Arm; 2]>,
    /// c: radius of the hole less that of the pin, m.
    pub clearance: f64,
    /// |u| of the nominal mechanism in m: the eccentricity of a disc.
    pub nominal_distance: f64,
    /// k in N/m, of pin, roller and hole in series.
    pub stiffness: f64,
    /// Damping of pins that press over their stiffness, s.
    pub loss_time: f64,
}

/// One pin in its hole.
struct Pair {
    /// Unit vector from hole to pin and their distance.
    normal: Vec2,
    distance: f64,
    /// From the axis of either body to pin and hole.
    pin: Vec2,
    hole: Vec2,
}

impl Pair {
    /// ∂|u|/∂q.
    fn gradient(&self) -> [f64; 6] {
        let (n, turn) = (self.normal, |arm: Vec2| self.normal.dot(&quarter_turn(arm)));
        [n.x, n.y, turn(self.pin), -n.x, -n.y, -turn(self.hole)]
    }
}

impl HolePins {
    fn pair(&self, q: &[f64], [pin, hole]: &[Arm; 2]) -> Pair {
        let [x, y, turn, ox, oy, other] = self.index;
        let (pin, hole) = (pin.at(q[turn]), hole.at(q[other]));
        let u = Vec2::new(q[x] - q[ox], q[y] - q[oy]) + pin - hole;
        let distance = u.norm();
        let normal = if distance > 0.0 { u / distance } else { Vec2::new(1.0, 0.0) };
        Pair { normal, distance, pin, hole }
    }

    /// Force (N) of every pin on its hole with the direction (rad) from hole to pin, and the gap (m) that is left.
    pub fn loads(&self, q: &[f64]) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let pairs: Vec<Pair> = self.pairs.iter().map(|pair| self.pair(q, pair)).collect();
        pairs.into_iter().map(|pair| {
            let depth = pair.distance - self.clearance;
            (self.stiffness * depth.max(0.0), pair.normal.y.atan2(pair.normal.x), -depth)
        })
    }
}

impl Joint for HolePins {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let wanted = sink.wants_contacts();
        let spring = ContactSpring::Linear { stiffness: self.stiffness };
        let (mut gradient, mut hessian, mut stored) = ([0.0; 6], [0.0; 36], 0.0);
        let mut along_gaps = [0.0; 36];
        for arms in &self.pairs {
            let pair = self.pair(at.q, arms);
            let (way, depth) = (pair.gradient(), pair.distance - self.clearance);
            if let Some(wanted) = wanted
                && -depth < wanted.reach
            {
                sink.contact(&Contact::new(&self.index, &way.map(|way| -way), -depth, spring));
            }
            if !(depth > 0.0) {
                continue;
            }
            let force = self.stiffness * depth;
            stored += 0.5 * force * depth;
            gradient.iter_mut().zip(way).for_each(|(sum, way)| *sum += force * way);
            // ∂²|u| = t tᵀ/|u| across the line of the axes, and the arms as they turn. Contacts bring k n nᵀ along it
            // themselves.
            let across = quarter_turn(pair.normal);
            let turn = |arm: Vec2| across.dot(&quarter_turn(arm));
            let sideways = [across.x, across.y, turn(pair.pin), -across.x, -across.y, -turn(pair.hole)];
            let along = if wanted.is_some() { 0.0 } else { self.stiffness };
            for a in 0..6 {
                for b in 0..6 {
                    along_gaps[a * 6 + b] += self.stiffness * way[a] * way[b];
                    hessian[a * 6 + b] +=
                        along * way[a] * way[b] + force * sideways[a] * sideways[b] / pair.distance;
                }
            }
            hessian[2 * 6 + 2] -= force * pair.normal.dot(&pair.pin);
            hessian[5 * 6 + 5] += force * pair.normal.dot(&pair.hole);
        }
        let (part, index) = (self.part, &self.index[..]);
        sink.element(&Element { part, index, gradient: &gradient, hessian: &hessian, stored });
        damp(index, &along_gaps, self.loss_time, at, sink);
    }

    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        for arms in &self.pairs {
            let pair = self.pair(q, arms);
            let value = self.clearance - pair.distance;
            if value < reach {
                let gradient = &pair.gradient().map(|way| -way);
                let (index, stiffness) = (&self.index, self.stiffness);
                add(Limit::Gap(Distance { index, gradient, value, stiffness }));
            }
        }
    }

    fn work(&self, at: State<'_>, _: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        for (force, _, _) in self.loads(at.q) {
            add(Cause::Elastic, force * force / self.stiffness);
            if let Some(cause) = self.cause {
                add(cause, force * (self.clearance - self.nominal_distance));
            }
        }
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
