use super::{Cause, Distance, Joint, Limit, Nominal, Part, Sink, State};
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
    /// c of each: radius of the hole less that of the pin, m.
    pub clearances: Vec<f64>,
    /// |u| of the nominal mechanism in m: the eccentricity of a disc.
    pub nominal_distance: f64,
    /// k in N/m, of pin, roller and hole in series.
    pub stiffness: f64,
}

/// One pin in its hole.
struct Pair {
    /// c in m.
    clearance: f64,
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
    /// Every pin in its hole.
    fn pairs_at<'a>(&'a self, q: &'a [f64]) -> impl Iterator<Item = Pair> + 'a {
        self.pairs.iter().zip(&self.clearances).map(|(arms, clearance)| self.pair(q, arms, *clearance))
    }

    fn pair(&self, q: &[f64], [pin, hole]: &[Arm; 2], clearance: f64) -> Pair {
        let [x, y, turn, ox, oy, other] = self.index;
        let (pin, hole) = (pin.at(q[turn]), hole.at(q[other]));
        let u = Vec2::new(q[x] - q[ox], q[y] - q[oy]) + pin - hole;
        let distance = u.norm();
        let normal = if distance > 0.0 { u / distance } else { Vec2::new(1.0, 0.0) };
        Pair { clearance, normal, distance, pin, hole }
    }

    /// Force (N) of every pin on its hole with the direction (rad) from hole to pin, and the gap (m) that is left.
    pub fn loads(&self, q: &[f64]) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let pairs: Vec<Pair> = self.pairs_at(q).collect();
        pairs.into_iter().map(|pair| {
            let depth = pair.distance - pair.clearance;
            (self.stiffness * depth.max(0.0), pair.normal.y.atan2(pair.normal.x), -depth)
        })
    }
}

impl Joint for HolePins {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let wanted = sink.wants_contacts();
        let spring = ContactSpring::Linear { stiffness: self.stiffness };
        let (mut gradient, mut hessian, mut stored) = ([0.0; 6], [0.0; 36], 0.0);
        for pair in self.pairs_at(at.q) {
            let (way, depth) = (pair.gradient(), pair.distance - pair.clearance);
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
                    hessian[a * 6 + b] +=
                        along * way[a] * way[b] + force * sideways[a] * sideways[b] / pair.distance;
                }
            }
            hessian[2 * 6 + 2] -= force * pair.normal.dot(&pair.pin);
            hessian[5 * 6 + 5] += force * pair.normal.dot(&pair.hole);
        }
        let (part, index) = (self.part, &self.index[..]);
        sink.element(&Element { part, index, gradient: &gradient, hessian: &hessian, stored });
    }

    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        for pair in self.pairs_at(q) {
            let value = pair.clearance - pair.distance;
            if value < reach {
                let gradient = &pair.gradient().map(|way| -way);
                let (index, stiffness) = (&self.index, self.stiffness);
                add(Limit::Gap(Distance { index, gradient, value, stiffness }));
            }
        }
    }

    fn work(&self, at: State<'_>, _: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        for ((force, _, _), clearance) in self.loads(at.q).zip(&self.clearances) {
            add(Cause::Elastic, force * force / self.stiffness);
            if let Some(cause) = self.cause {
                add(cause, force * (clearance - self.nominal_distance));
            }
        }
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
