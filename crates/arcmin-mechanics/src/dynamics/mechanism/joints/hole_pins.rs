use super::{Cause, Distance, Joint, JointWear, Limit, Nominal, Part, Sink, State, damp};
use crate::contact::{ContactSpring, Sliding};
use crate::dynamics::Contact;
use crate::dynamics::mechanism::Arm;
use crate::dynamics::mechanism::assembly::Element;
use crate::geometry::{Vec2, quarter_turn};
use crate::machine::Around;

/// Pins of one body in wider holes of another, as the output pins of a single stage: the axes stand apart by u = pin −
/// hole, and a pin presses where |u| exceeds the difference c of the radii and what wear adds to it in the direction α of u
/// against that of the pin on its circle, F = k (|u| − c − w(α)). It slides along the wall by s, ṡ = |u| φ̇ + r ω − (r + |u|) ω',
/// with the direction φ of u, the radius r of the pin and the speeds ω and ω' of the bodies with pins and holes; friction is
/// μ F ṡ/√(ṡ² + v_r²).
#[derive(Debug, Clone, PartialEq)]
pub struct HolePins {
    /// Part that the compliance is counted under.
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
    /// Damping of pins that press over their stiffness, s.
    pub loss_time: f64,
    /// w in m.
    pub worn: Around,
    /// r in m: of the pin, or its roller.
    pub radius: f64,
    /// Friction of the pin in its hole, or what that of a roller on its pin comes to there; none at first.
    pub sliding: Option<Sliding>,
}

/// One pin on its hole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HolePinLoad {
    /// N.
    pub force: f64,
    /// Direction (rad) from hole to pin.
    pub direction: f64,
    /// The same against that of the pin on its circle.
    pub around: f64,
    /// Remaining clearance in m; negative where it presses.
    pub gap: f64,
}

/// One pin in its hole.
struct Pair {
    /// Unit vector from hole to pin and their distance.
    normal: Vec2,
    distance: f64,
    around: f64,
    /// w there with its derivatives, and |u| − c − w.
    worn: [f64; 3],
    depth: f64,
    /// From the axis of either body to pin and hole.
    pin: Vec2,
    hole: Vec2,
}

impl Pair {
    /// ∂|u|/∂q.
    fn stretch(&self) -> [f64; 6] {
        let (n, turn) = (self.normal, |arm: Vec2| self.normal.dot(&quarter_turn(arm)));
        [n.x, n.y, turn(self.pin), -n.x, -n.y, -turn(self.hole)]
    }

    /// The way across the line of the axes: ∂α/∂q times |u|, but for the turn of the pins.
    fn sideways(&self) -> [f64; 6] {
        let across = quarter_turn(self.normal);
        let turn = |arm: Vec2| across.dot(&quarter_turn(arm));
        [across.x, across.y, turn(self.pin), -across.x, -across.y, -turn(self.hole)]
    }

    /// ∂α/∂q.
    fn turn(&self) -> [f64; 6] {
        let mut turn = self.sideways().map(|way| way / self.distance);
        turn[2] -= 1.0;
        turn
    }

    /// ∂(|u| − c − w(α))/∂q.
    fn gradient(&self) -> [f64; 6] {
        let (stretch, turn) = (self.stretch(), self.turn());
        std::array::from_fn(|a| stretch[a] - self.worn[1] * turn[a])
    }

    /// Its derivative, row by row: t tᵀ/|u| across the line of the axes and the arms as they turn; −w″ ∂α ∂αᵀ − w′ ∂²α.
    fn bend(&self) -> [f64; 36] {
        let (stretch, sideways, turn, distance) =
            (self.stretch(), self.sideways(), self.turn(), self.distance);
        let across = quarter_turn(self.normal);
        let [_, slope, curve] = self.worn;
        let mut bend: [f64; 36] = std::array::from_fn(|at| {
            let (a, b) = (at / 6, at % 6);
            let mixed = (stretch[a] * sideways[b] + sideways[a] * stretch[b]) / (distance * distance);
            sideways[a] * sideways[b] / distance - curve * turn[a] * turn[b] + slope * mixed
        });
        bend[2 * 6 + 2] += (slope / distance * across - self.normal).dot(&self.pin);
        bend[5 * 6 + 5] -= (slope / distance * across - self.normal).dot(&self.hole);
        bend
    }
}

/// Friction of all pins: forces (N, N·m), −∂(force)/∂(coordinate) and −∂(force)/∂(velocity) row by row, and the power that it
/// takes (W).
struct PinFriction {
    force: [f64; 6],
    by_place: [f64; 36],
    by_speed: [f64; 36],
    dissipation: f64,
}

impl Default for PinFriction {
    fn default() -> Self {
        PinFriction { force: [0.0; 6], by_place: [0.0; 36], by_speed: [0.0; 36], dissipation: 0.0 }
    }
}

impl PinFriction {
    /// Adds a pin that slides along ∂s/∂q with a speed (m/s) under a force (N); ∂(force)/∂q with which the friction follows,
    /// and the force with which it grows with the speed.
    fn add(
        &mut self,
        sliding: &Sliding,
        (slide, speed): (&[f64; 6], f64),
        force: f64,
        (follows, grows): (&[f64; 6], f64),
    ) {
        let (share, slope) = sliding.share(speed);
        for (a, way) in slide.iter().enumerate() {
            self.force[a] -= share * force * way;
            for b in 0..6 {
                self.by_place[a * 6 + b] += share * way * follows[b];
                self.by_speed[a * 6 + b] += slope * grows * way * slide[b];
            }
        }
        self.dissipation += share * force * speed;
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
        let around = quarter_turn(pin).dot(&normal).atan2(pin.dot(&normal));
        let worn = self.worn.at(around);
        let depth = distance - clearance - worn[0];
        Pair { normal, distance, around, worn, depth, pin, hole }
    }

    /// ∂s/∂q. Bodies that turn as one do not slide on each other.
    fn slide(&self, pair: &Pair) -> [f64; 6] {
        let mut way = pair.sideways();
        way[2] += self.radius;
        way[5] -= self.radius + pair.distance;
        way
    }

    /// Every pin on its hole.
    pub fn loads<'a>(&'a self, q: &'a [f64]) -> impl Iterator<Item = HolePinLoad> + 'a {
        self.pairs_at(q).map(|Pair { normal, around, depth, .. }| {
            let (force, direction) = (self.stiffness * depth.max(0.0), normal.y.atan2(normal.x));
            HolePinLoad { force, direction, around, gap: -depth }
        })
    }

    /// Σ F |v| in W, v = |u| dα/dt the speed of the pin along its hole.
    pub fn sliding_power(&self, q: &[f64], v: &[f64]) -> f64 {
        let power = |pair: Pair| {
            let turn: f64 = pair.turn().iter().zip(self.index).map(|(turn, i)| turn * v[i]).sum();
            self.stiffness * pair.depth.max(0.0) * pair.distance * turn.abs()
        };
        self.pairs_at(q).map(power).sum()
    }
}

impl Joint for HolePins {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let wanted = sink.wants_contacts();
        let spring = ContactSpring::Linear { stiffness: self.stiffness };
        let (mut gradient, mut hessian, mut stored) = ([0.0; 6], [0.0; 36], 0.0);
        let mut along_gaps = [0.0; 36];
        let mut friction = PinFriction::default();
        for pair in self.pairs_at(at.q) {
            let (way, depth) = (pair.gradient(), pair.depth);
            let slides = self.sliding.as_ref().filter(|_| depth > 0.0).map(|sliding| {
                let slide = self.slide(&pair);
                let speed = slide.iter().zip(self.index).map(|(way, i)| way * at.v[i]).sum::<f64>();
                (sliding, slide, speed)
            });
            if let Some(wanted) = wanted
                && -depth < wanted.reach
            {
                let gradient = way.map(|way| -way);
                let mut contact = Contact::new(&self.index, &gradient, -depth, spring);
                let push = slides.as_ref().map(|(sliding, slide, speed)| {
                    let share = sliding.share(*speed).0;
                    std::array::from_fn::<f64, 6, _>(|a| gradient[a] - share * slide[a])
                });
                if let Some(push) = &push {
                    contact.push = push;
                }
                sink.contact(&contact);
            }
            if !(depth > 0.0) {
                continue;
            }
            let force = self.stiffness * depth;
            if let Some((sliding, slide, speed)) = slides {
                let interval = wanted.and_then(|wanted| wanted.slip_interval);
                if let Some(interval) = interval {
                    let slip = sliding.slip(force, interval);
                    sink.contact(&Contact::new(&self.index, &slide, speed * interval, slip));
                }
                // Single contacts bring how friction follows the pressure, and how it grows with what slides.
                let follows = if wanted.is_some() { 0.0 } else { self.stiffness };
                let grows = if interval.is_some() { 0.0 } else { force };
                friction.add(sliding, (&slide, speed), force, (&way.map(|way| follows * way), grows));
            }
            stored += 0.5 * force * depth;
            gradient.iter_mut().zip(way).for_each(|(sum, way)| *sum += force * way);
            // Contacts bring k n nᵀ along the gap themselves.
            let along = if wanted.is_some() { 0.0 } else { self.stiffness };
            for (at, bend) in pair.bend().into_iter().enumerate() {
                along_gaps[at] += self.stiffness * way[at / 6] * way[at % 6];
                hessian[at] += along * way[at / 6] * way[at % 6] + force * bend;
            }
        }
        let (part, index) = (self.part, &self.index[..]);
        sink.element(&Element { part, index, gradient: &gradient, hessian: &hessian, stored });
        damp(index, &along_gaps, self.loss_time, at, sink);
        if self.sliding.is_some() {
            if sink.takes_stiffness() {
                sink.friction_slope(index, &friction.by_place);
            }
            sink.damper(index, &friction.force, &friction.by_speed, friction.dissipation);
        }
    }

    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        for pair in self.pairs_at(q) {
            let value = -pair.depth;
            if value < reach {
                let gradient = &pair.gradient().map(|way| -way);
                let (index, stiffness) = (&self.index, self.stiffness);
                add(Limit::Gap(Distance { index, gradient, value, stiffness }));
            }
        }
    }

    fn work(&self, at: State<'_>, _: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        for (HolePinLoad { force, gap, .. }, clearance) in self.loads(at.q).zip(&self.clearances) {
            add(Cause::ELASTIC, -force * gap);
            if let Some(cause) = self.cause {
                add(cause, force * (clearance - self.nominal_distance));
            }
        }
    }

    fn set_wear(&mut self, wear: JointWear) {
        if let JointWear::Holes(worn) = wear {
            self.worn = worn;
        }
    }

    fn set_friction(&mut self, sliding: Sliding) {
        self.sliding = (sliding.coefficient > 0.0).then_some(sliding);
    }

    fn scale_friction(&mut self, share: f64) {
        if let Some(sliding) = &mut self.sliding {
            sliding.coefficient *= share;
        }
    }

    fn set_loss_time(&mut self, time: f64) {
        self.loss_time = time;
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
