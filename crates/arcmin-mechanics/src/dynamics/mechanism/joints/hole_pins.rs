use std::ops::Range;

use smallvec::{SmallVec, smallvec};

use super::{Cause, Distance, Joint, JointWear, Limit, Nominal, Part, Sink, State, damp};
use crate::contact::{ContactSpring, Sliding};
use crate::dynamics::Contact;
use crate::dynamics::mechanism::Arm;
use crate::dynamics::mechanism::assembly::Element;
use crate::dynamics::mechanism::elastic::{add_with_modes, along_displacements};
use crate::geometry::{Vec2, quarter_turn, turned, unit};
use crate::machine::Around;

/// Pins of one body in wider holes of another, such as the output pins of a single stage. The distance of the
/// axes is u = pin − hole, and the contact force is F = k (|u| − c − w(α)) if positive, with the difference c
/// of the radii and the wear w in the direction α of u relative to the angle of the pin on its circle. The
/// sliding speed along the wall is ṡ = |u| φ̇ + r ω − (r + |u|) ω', with the direction φ of u, the radius r of
/// the pin and the angular speeds ω and ω' of the bodies with pins and holes; friction is μ F ṡ/√(ṡ² + v_r²).
///
/// The modes of an elastic body also displace its holes: a modal coordinate q_m displaces a hole by b_m q_m in
/// the frame of the body, which acts like the same displacement of the body.
#[derive(Debug, Clone, PartialEq)]
pub struct HolePins {
    /// Part to which the compliance is assigned.
    pub part: Part,
    /// Cause of lost motion to which the play c − `nominal_distance` is assigned.
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
    /// Ratio of damping to stiffness of loaded pins, s.
    pub loss_time: f64,
    /// w in m.
    pub worn: Around,
    /// r in m: of the pin, or its roller.
    pub radius: f64,
    /// Coordinates of the modes of the body with the holes.
    pub modes: Range<usize>,
    /// b_m of every hole per unit of a mode in the frame of the body, hole after hole.
    pub displacements: Vec<Vec2>,
    /// Friction of the pin in its hole, or the equivalent friction of a roller on its pin; none at first.
    pub sliding: Option<Sliding>,
}

/// One pin on its hole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HolePinLoad {
    /// N.
    pub force: f64,
    /// Direction (rad) from hole to pin.
    pub direction: f64,
    /// The same relative to the direction of the pin on its circle.
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
    /// w in this direction with its first two derivatives, and |u| − c − w.
    worn: [f64; 3],
    depth: f64,
    /// From the axis of either body to pin and hole.
    pin: Vec2,
    hole: Vec2,
    /// b_m in space.
    displacements: Vec<Vec2>,
}

/// Over the coordinates of both bodies, then the modes; on the heap only with modes.
type Row<T> = SmallVec<[T; PLACES]>;
type Square = SmallVec<[f64; PLACES * PLACES]>;
/// Coordinates of both bodies.
const PLACES: usize = 6;

impl Pair {
    /// A row over both bodies, extended by the modes.
    fn expand(&self, row: &[f64; 6]) -> Row<f64> {
        row.iter().copied().chain(along_displacements(row, self.displacements.iter().copied())).collect()
    }

    /// Adds a matrix over both bodies to one over these and the modes.
    fn add_expanded(&self, matrix: &[f64; 36], into: &mut [f64]) {
        add_with_modes(matrix, PLACES, self.displacements.iter().copied(), into);
    }

    /// Adds the second derivatives with respect to modes and rotation of the body with the holes, because the
    /// modal displacements rotate with it; `gradient` is that over both bodies.
    fn add_rotation_terms(&self, gradient: &[f64; 6], into: &mut [f64]) {
        let width = PLACES + self.displacements.len();
        let turned = self.displacements.iter().map(|shift| quarter_turn(*shift));
        for (mode, entry) in along_displacements(gradient, turned).enumerate() {
            into[5 * width + PLACES + mode] += entry;
            into[(PLACES + mode) * width + 5] += entry;
        }
    }

    /// ∂|u|/∂q.
    fn stretch(&self) -> [f64; 6] {
        let (n, turn) = (self.normal, |arm: Vec2| self.normal.dot(&quarter_turn(arm)));
        [n.x, n.y, turn(self.pin), -n.x, -n.y, -turn(self.hole)]
    }

    /// Displacement perpendicular to u: |u| ∂α/∂q without the rotation of the pins.
    fn sideways(&self) -> [f64; 6] {
        let across = quarter_turn(self.normal);
        let turn = |arm: Vec2| across.dot(&quarter_turn(arm));
        [across.x, across.y, turn(self.pin), -across.x, -across.y, -turn(self.hole)]
    }

    /// ∂α/∂q.
    fn turn(&self) -> [f64; 6] {
        let mut turn = self.sideways().map(|slope| slope / self.distance);
        turn[2] -= 1.0;
        turn
    }

    /// ∂(|u| − c − w(α))/∂q.
    fn gradient(&self) -> [f64; 6] {
        let (stretch, turn) = (self.stretch(), self.turn());
        std::array::from_fn(|a| stretch[a] - self.worn[1] * turn[a])
    }

    /// Its derivative, row by row: t tᵀ/|u| perpendicular to u, the rotation of the arms, and −w″ ∂α ∂αᵀ − w′
    /// ∂²α.
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

/// Friction of all pins: forces (N, N·m), −∂(force)/∂(coordinate) and −∂(force)/∂(velocity) row by row, and the
/// dissipated power (W).
struct PinFriction {
    force: Vec<f64>,
    by_place: Vec<f64>,
    by_speed: Vec<f64>,
    dissipation: f64,
}

impl PinFriction {
    /// For a number of coordinates.
    fn new(width: usize) -> PinFriction {
        let matrix = || vec![0.0; width * width];
        PinFriction { force: vec![0.0; width], by_place: matrix(), by_speed: matrix(), dissipation: 0.0 }
    }

    /// Adds a pin that slides along ∂s/∂q with a speed (m/s) under a force (N), with ∂(force)/∂q for the change
    /// of friction with pressure and the force for its change with speed.
    fn add(
        &mut self,
        sliding: &Sliding,
        (slide, speed): (&[f64], f64),
        force: f64,
        (follows, grows): (&[f64], f64),
    ) {
        let ((share, slope), width) = (sliding.share(speed), slide.len());
        for (a, along) in slide.iter().enumerate() {
            self.force[a] -= share * force * along;
            for b in 0..width {
                self.by_place[a * width + b] += share * along * follows[b];
                self.by_speed[a * width + b] += slope * grows * along * slide[b];
            }
        }
        self.dissipation += share * force * speed;
    }
}

impl HolePins {
    /// Every pin in its hole.
    fn pairs_at<'a>(&'a self, q: &'a [f64]) -> impl Iterator<Item = Pair> + 'a {
        let clearances = self.pairs.iter().zip(&self.clearances).enumerate();
        clearances.map(|(number, (arms, clearance))| self.pair(q, number, arms, *clearance))
    }

    fn pair(&self, q: &[f64], number: usize, [pin, hole]: &[Arm; 2], clearance: f64) -> Pair {
        let [x, y, turn, ox, oy, other] = self.index;
        let count = self.modes.len();
        let (rotation, own) = (unit(q[other]), &self.displacements[number * count..][..count]);
        let displacements: Vec<Vec2> = own.iter().map(|shift| turned(*shift, rotation)).collect();
        let moved: Vec2 = self.modes.clone().zip(&displacements).map(|(at, shift)| q[at] * shift).sum();
        let (pin, hole) = (pin.at(q[turn]), hole.at(q[other]) + moved);
        let u = Vec2::new(q[x] - q[ox], q[y] - q[oy]) + pin - hole;
        let distance = u.norm();
        let normal = if distance > 0.0 { u / distance } else { Vec2::new(1.0, 0.0) };
        let around = quarter_turn(pin).dot(&normal).atan2(pin.dot(&normal));
        let worn = self.worn.at(around);
        let depth = distance - clearance - worn[0];
        Pair { normal, distance, around, worn, depth, pin, hole, displacements }
    }

    /// All coordinates: of both bodies, then the modes.
    fn coordinates(&self) -> Row<usize> {
        self.index.iter().copied().chain(self.modes.clone()).collect()
    }

    /// ∂s/∂q; zero for a common rotation of both bodies.
    fn slide(&self, pair: &Pair) -> [f64; 6] {
        let mut slide = pair.sideways();
        slide[2] += self.radius;
        slide[5] -= self.radius + pair.distance;
        slide
    }

    /// Every pin on its hole.
    pub fn loads<'a>(&'a self, q: &'a [f64]) -> impl Iterator<Item = HolePinLoad> + 'a {
        self.pairs_at(q).map(|Pair { normal, around, depth, .. }| {
            let (force, direction) = (self.stiffness * depth.max(0.0), normal.y.atan2(normal.x));
            HolePinLoad { force, direction, around, gap: -depth }
        })
    }

    /// Σ F |v| in W with the speed v = |u| dα/dt of the pin along the wall of its hole.
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
        let wanted = sink.contact_request();
        let spring = ContactSpring::Linear { stiffness: self.stiffness };
        let index = &self.coordinates()[..];
        let width = index.len();
        let matrix = || -> Square { smallvec![0.0; width * width] };
        let mut gradient: Row<f64> = smallvec![0.0; width];
        let (mut hessian, mut along_gaps) = (matrix(), matrix());
        let mut stored = 0.0;
        let mut friction = self.sliding.as_ref().map(|sliding| (sliding, PinFriction::new(width)));
        for pair in self.pairs_at(at.q) {
            let (by_bodies, depth) = (pair.gradient(), pair.depth);
            let along_depth = pair.expand(&by_bodies);
            let slides = friction.as_mut().filter(|_| depth > 0.0).map(|(sliding, friction)| {
                let slide = pair.expand(&self.slide(&pair));
                let speed = slide.iter().zip(index).map(|(slope, i)| slope * at.v[*i]).sum::<f64>();
                (*sliding, friction, slide, speed)
            });
            if let Some(wanted) = wanted
                && -depth < wanted.reach
            {
                let gradient: Row<f64> = along_depth.iter().map(|slope| -slope).collect();
                let mut contact = Contact::new(index, &gradient, -depth, spring);
                let push = slides.as_ref().map(|(sliding, _, slide, speed)| {
                    let share = sliding.share(*speed).0;
                    gradient
                        .iter()
                        .zip(slide)
                        .map(|(along, slide)| along - share * slide)
                        .collect::<Row<f64>>()
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
            if let Some((sliding, friction, slide, speed)) = slides {
                let interval = wanted.and_then(|wanted| wanted.slip_interval);
                if let Some(interval) = interval {
                    let slip = sliding.slip(force, interval);
                    sink.contact(&Contact::new(index, &slide, speed * interval, slip));
                }
                // For single contacts, the receiver adds the derivatives of friction with respect to pressure
                // and sliding.
                let follows = if wanted.is_some() { 0.0 } else { self.stiffness };
                let grows = if interval.is_some() { 0.0 } else { force };
                let follows: Row<f64> = along_depth.iter().map(|slope| follows * slope).collect();
                friction.add(sliding, (&slide, speed), force, (&follows, grows));
            }
            stored += 0.5 * force * depth;
            gradient.iter_mut().zip(&along_depth).for_each(|(sum, slope)| *sum += force * slope);
            if !sink.takes_stiffness() && self.loss_time == 0.0 {
                continue;
            }
            let along: [f64; 36] =
                std::array::from_fn(|at| self.stiffness * by_bodies[at / 6] * by_bodies[at % 6]);
            pair.add_expanded(&along, &mut along_gaps);
            pair.add_expanded(&pair.bend().map(|bend| force * bend), &mut hessian);
            pair.add_rotation_terms(&by_bodies.map(|slope| force * slope), &mut hessian);
        }
        // For single contacts, the receiver adds k n nᵀ along the gap.
        if wanted.is_none() {
            hessian.iter_mut().zip(&along_gaps).for_each(|(sum, along)| *sum += along);
        }
        sink.element(&Element { part: self.part, index, gradient: &gradient, hessian: &hessian, stored });
        damp(index, &along_gaps, self.loss_time, at, sink);
        if let Some((_, friction)) = &friction {
            if sink.takes_stiffness() {
                sink.friction_slope(index, &friction.by_place);
            }
            sink.damper(index, &friction.force, &friction.by_speed, friction.dissipation);
        }
    }

    /// Gaps of the bodies: their modes stay.
    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        for pair in self.pairs_at(q) {
            let value = -pair.depth;
            if value < reach {
                let gradient = &pair.gradient().map(|slope| -slope);
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
