use smallvec::{SmallVec, smallvec};

use super::{Cause, Distance, Joint, JointWear, Limit, Losses, Nominal, PlayLabel, Sink, State, damp};
use crate::contact::Sliding;
use crate::dynamics::Contact;
use crate::dynamics::mechanism::assembly::Element;
use crate::dynamics::mechanism::elastic::{BoreMode, WithModes};
use crate::dynamics::mechanism::rim::{OutOfRound, RIM};
use crate::dynamics::mechanism::roller::{BODY, CAGE, OVALITY, PARALLEL, RingPose, SLOPE, TILT, VARIABLES};
use crate::dynamics::mechanism::{Arm, BearingState, RollingBearing};
use crate::geometry::{Vec2, quarter_turn, turned, unit};

/// Number of coordinates of the positions of shaft and body: (x, y, θ) of either.
const PLACES: usize = 6;
/// Number of coordinates that tilt the rings of a bearing: two of the shaft, two of the body.
pub(in crate::dynamics) const SLOPES: usize = 4;

/// Row over the coordinates of a bearing, on the heap only if bodies tilt or deform.
type Row<T> = SmallVec<[T; PLACES]>;
type Square = SmallVec<[f64; PLACES * PLACES]>;

/// A rolling bearing between a shaft with its inner ring and a body with a bore.
#[derive(Debug, Clone, PartialEq)]
pub struct Journal {
    /// Names of its compliance, clearance and wear.
    pub label: PlayLabel,
    /// Force law of its rolling elements.
    pub law: RollingBearing,
    /// (x, y, θ) of the shaft, (x, y, θ) of the body.
    pub index: [usize; 6],
    /// Centre of the inner ring relative to the shaft's axis.
    pub arm: Arm,
    /// Centre of the bore relative to the body's centre.
    pub bore: Arm,
    /// Modes that displace the bore in addition to the body's position, in the frame of the body if they rotate
    /// with it.
    pub modes: Vec<BoreMode>,
    /// Whether modes ovalise the rim of the bore.
    pub has_rim: bool,
    /// Coordinates of the tilt of shaft and body, and the slope (x, y) of the inner ring relative to the bore
    /// per unit of each.
    pub slopes: Option<[(usize, Vec2); SLOPES]>,
    /// Increase of the diametral clearance by wear, m.
    pub worn: f64,
    /// Damping, and rolling friction at the mean radius.
    pub losses: Losses,
}

/// Positions of the rings of a bearing on shaft and body.
#[derive(Clone, Copy)]
struct Arms {
    /// Centre of the inner ring relative to the shaft's axis.
    inner: Vec2,
    /// Centre of the bore relative to the body's centre, rotated with the body.
    bore: Vec2,
    /// Additional displacement of the bore that is fixed in space while the body rotates.
    aside: Vec2,
}

impl Journal {
    /// The modes with their displacements in the housing frame.
    fn modes_at(&self, q: &[f64]) -> Vec<BoreMode> {
        if self.modes.is_empty() {
            return Vec::new();
        }
        let rotation = unit(q[self.index[5]]);
        let now = |mode: &BoreMode| BoreMode {
            by: if mode.turns { turned(mode.by, rotation) } else { mode.by },
            ..*mode
        };
        self.modes.iter().map(now).collect()
    }

    fn arms(&self, q: &[f64], modes: &[BoreMode]) -> Arms {
        let moved = |turns: bool| -> Vec2 {
            modes.iter().filter(|mode| mode.turns == turns).map(|mode| q[mode.at] * mode.by).sum()
        };
        Arms {
            inner: self.arm.at(q[self.index[2]]),
            bore: self.bore.at(q[self.index[5]]) + moved(true),
            aside: moved(false),
        }
    }

    /// Relative displacement of inner ring and bore (m) and cage angle (rad).
    fn displacement(&self, q: &[f64], arms: Arms) -> ([f64; 2], f64) {
        let [x, y, turn, bx, by, angle] = self.index;
        let u = Vec2::new(q[x] - q[bx], q[y] - q[by]) + arms.inner - arms.bore - arms.aside;
        let w = self.law.inner_share;
        ([u.x, u.y], w * q[turn] + (1.0 - w) * q[angle])
    }

    /// Rows u_x, u_y, ψ over shaft and body.
    fn jacobian(&self, arms: Arms) -> [[f64; 6]; 3] {
        let (a, b) = (quarter_turn(arms.inner), quarter_turn(arms.bore));
        let w = self.law.inner_share;
        [[1.0, 0.0, a.x, -1.0, 0.0, -b.x], [0.0, 1.0, a.y, 0.0, -1.0, -b.y], [0.0, 0.0, w, 0.0, 0.0, 1.0 - w]]
    }

    fn displacement_at(&self, q: &[f64]) -> ([f64; 2], f64) {
        self.displacement(q, self.arms(q, &self.modes_at(q)))
    }

    /// Ovalisation of the rim at this state.
    fn rim_at(&self, q: &[f64]) -> Option<OutOfRound> {
        self.has_rim.then(|| {
            let mut amplitudes = [0.0; RIM];
            for mode in &self.modes {
                amplitudes
                    .iter_mut()
                    .zip(&mode.rim)
                    .for_each(|(amplitude, by)| *amplitude += q[mode.at] * by);
            }
            OutOfRound { angle: q[self.index[5]], amplitudes }
        })
    }

    /// Relative position of inner ring and bore.
    fn ring_pose_at(&self, q: &[f64], (shift, cage): ([f64; 2], f64)) -> RingPose {
        let slope = self.slopes.map(|slopes| {
            let slope: Vec2 = slopes.iter().map(|(at, by)| q[*at] * by).sum();
            [slope.x, slope.y]
        });
        RingPose { shift, cage, slope, rim: self.rim_at(q), ..RingPose::default() }
    }

    fn ring_pose(&self, q: &[f64]) -> RingPose {
        self.ring_pose_at(q, self.displacement_at(q))
    }

    /// Radial force (N) of every rolling element on the bore, with its angular position (rad).
    pub fn radial_element_forces(&self, q: &[f64]) -> Vec<(f64, f64)> {
        self.law
            .loads(self.ring_pose(q))
            .map(|element| (element.angle, element.contact.x * element.force))
            .collect()
    }

    /// Force (N) on the inner ring, and forces of the rolling elements.
    pub fn load(&self, q: &[f64]) -> (BearingState<VARIABLES>, Vec<f64>) {
        let ring_pose = self.ring_pose(q);
        (
            self.law.react_at(&ring_pose, false),
            self.law.loads(ring_pose).map(|element| element.force).collect(),
        )
    }

    /// Work Σ Q_i w(ψ_i) (N·m) of the rollers on the ovalisation of their rim, 0 for a round one.
    fn rim_work(&self, q: &[f64]) -> f64 {
        let Some(rim) = self.rim_at(q) else { return 0.0 };
        self.radial_element_forces(q).iter().map(|(angle, force)| force * rim.at(*angle)).sum()
    }

    /// Passes on the bearing with N of its variables: first those over the coordinates of shaft and body, then
    /// the tilts, then the modes with their displacements in the housing frame.
    fn add_element<const N: usize>(&self, at: State<'_>, sink: &mut dyn Sink) {
        let modes = self.modes_at(at.q);
        let arms = self.arms(at.q, &modes);
        let displacement = self.displacement(at.q, arms);
        let tangents = sink.takes_stiffness() || self.losses.time > 0.0;
        let jacobian = self.jacobian(arms);
        let slopes = self.slopes.as_ref().map_or(&[][..], |slopes| &slopes[..]);
        let bent = PLACES + slopes.len();
        let width = bent + modes.len();
        let coordinates = self.index.iter().copied().chain(slopes.iter().map(|(at, _)| *at));
        let index: Row<usize> = coordinates.chain(modes.iter().map(|mode| mode.at)).collect();
        // Transformation from the variables to the coordinates.
        let expand = |by: &[f64; N], into: &mut [f64]| {
            for i in 0..PLACES {
                into[i] = by[0] * jacobian[0][i] + by[1] * jacobian[1][i] + by[CAGE] * jacobian[2][i];
            }
            for (into, (_, slope)) in into[PLACES..].iter_mut().zip(slopes) {
                *into = by[SLOPE] * slope.x + by[SLOPE + 1] * slope.y;
            }
            for (into, mode) in into[bent..].iter_mut().zip(&modes) {
                *into = -(by[0] * mode.by.x + by[1] * mode.by.y);
                if N > BODY {
                    *into += by[OVALITY..]
                        .iter()
                        .zip(&mode.rim)
                        .map(|(by, amplitude)| by * amplitude)
                        .sum::<f64>();
                }
            }
            if N > BODY {
                into[5] += by[BODY];
            }
        };
        let ring_pose = self.ring_pose_at(at.q, displacement);
        let wanted = sink.contact_request();
        let mut along: Row<f64> = smallvec![0.0; width];
        let (mut state, along_gaps) = match wanted {
            None => (self.law.react_at::<N>(&ring_pose, tangents), [[0.0; N]; N]),
            Some(wanted) => {
                let spring = self.law.spring_at(&ring_pose);
                self.law.react_within::<N>(
                    &ring_pose,
                    tangents,
                    wanted.reach,
                    |approach, gradient, pressed| {
                        expand(gradient, &mut along);
                        along.iter_mut().for_each(|by| *by = -*by);
                        let (index, gradient, gap) = (&index, &along, -approach);
                        let push = gradient;
                        sink.contact(&Contact { index, gradient, push, gap, spring, pressed, place: None });
                    },
                )
            }
        };
        // Single contacts contribute their own stiffness along the gaps.
        let without_gaps = state.hessian;
        let entries = state.hessian.as_flattened_mut().iter_mut().zip(along_gaps.as_flattened());
        entries.for_each(|(entry, along)| *entry += along);
        let BearingState { stored, ref gradient, ref hessian, .. } = state;
        if stored == 0.0 {
            return;
        }
        self.damp_tilt(&state, at, sink);
        // Modes that are unknowns of the solver come first.
        let known = bent + modes.iter().take_while(|mode| sink.searches(mode.at)).count();
        let mut matrix: Square = smallvec![0.0; if sink.takes_stiffness() { known * known } else { 0 }];
        if !matrix.is_empty() {
            // Jᵀ H J, row by row of the Jacobian J: terms common to all columns are computed outside of the
            // inner loop.
            let mut rows: Square = smallvec![0.0; 2 * N * known];
            let (motions, forces) = rows.split_at_mut(N * known);
            for (a, row) in motions.chunks_exact_mut(known).enumerate() {
                let mut unit = [0.0; N];
                unit[a] = 1.0;
                expand(&unit, row);
            }
            for (line, by) in forces.chunks_exact_mut(known).zip(&without_gaps) {
                expand(by, line);
            }
            for (row, line) in motions.chunks_exact(known).zip(forces.chunks_exact(known)) {
                for (into, factor) in
                    matrix.chunks_exact_mut(known).zip(row).filter(|(_, factor)| **factor != 0.0)
                {
                    into.iter_mut().zip(line).for_each(|(entry, by)| *entry += factor * by);
                }
            }
            let force = Vec2::new(gradient[0], gradient[1]);
            matrix[2 * known + 2] -= force.dot(&arms.inner);
            matrix[5 * known + 5] += force.dot(&arms.bore);
            // Displacements of modes rotate with the body.
            for (m, mode) in modes[..known - bent].iter().enumerate().filter(|(_, mode)| mode.turns) {
                let turning = force.dot(&quarter_turn(mode.by));
                matrix[5 * known + bent + m] -= turning;
                matrix[(bent + m) * known + 5] -= turning;
            }
        }
        expand(gradient, &mut along);
        let whole = if known == width { &matrix[..] } else { &[] };
        let (part, index, gradient) = (self.label.part, &index[..], gradient);
        sink.element(&Element { part, index, gradient: &along, hessian: whole, stored });
        if known < width {
            sink.stiffness(&index[..known], &matrix);
        }
        let mut rate = self.index.map(|i| at.v[i]);
        for BoreMode { at: mode, by, .. } in &modes {
            rate[3] += at.v[*mode] * by.x;
            rate[4] += at.v[*mode] * by.y;
        }
        let Losses { time: loss_time, sliding } = self.losses;
        let (mut force, mut damping, mut dissipation) = ([0.0; PLACES], [0.0; PLACES * PLACES], 0.0);
        if loss_time > 0.0 {
            let u = [0, 1].map(|row: usize| jacobian[row].iter().zip(&rate).map(|(j, v)| j * v).sum::<f64>());
            for i in 0..6 {
                let pull = [0, 1]
                    .map(|c| loss_time * (hessian[c][0] * jacobian[0][i] + hessian[c][1] * jacobian[1][i]));
                force[i] -= pull[0] * u[0] + pull[1] * u[1];
                for j in 0..6 {
                    damping[i * 6 + j] += pull[0] * jacobian[0][j] + pull[1] * jacobian[1][j];
                }
            }
            for c in 0..2 {
                dissipation += loss_time * u[c] * (hessian[c][0] * u[0] + hessian[c][1] * u[1]);
            }
        }
        if sliding.coefficient > 0.0 {
            // Rolling friction: μ F r_m against the relative rotation.
            let load = gradient[0].hypot(gradient[1]);
            let speed = rate[2] - rate[5];
            let radius = self.law.pitch_radius;
            let (share, slope) = sliding.share(speed * radius);
            let torque = load * radius;
            force[2] -= torque * share;
            force[5] += torque * share;
            if let Some(interval) = wanted.and_then(|wanted| wanted.slip_interval) {
                let spring = sliding.slip(load, interval);
                let (index, gradient) = ([self.index[2], self.index[5]], [radius, -radius]);
                sink.contact(&Contact::new(&index, &gradient, speed * radius * interval, spring));
            } else {
                let c = torque * slope * radius;
                for (i, j, sign) in [(2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)] {
                    damping[i * 6 + j] += sign * c;
                }
            }
            dissipation += torque * share * speed;
            if load > 0.0 && sink.takes_stiffness() {
                let factor = radius * share / load;
                let by_load: [f64; N] = std::array::from_fn(|d| {
                    factor * (gradient[0] * hessian[0][d] + gradient[1] * hessian[1][d])
                });
                expand(&by_load, &mut along);
                let mut by_place = vec![0.0; width * width];
                by_place[2 * width..][..width].copy_from_slice(&along);
                by_place[5 * width..][..width].iter_mut().zip(&along).for_each(|(into, by)| *into = -by);
                sink.friction_slope(index, &by_place);
            }
        }
        if loss_time > 0.0 || sliding.coefficient > 0.0 {
            WithModes { sink, modes: &modes }.damper(&self.index, &force, &damping, dissipation);
        }
    }

    /// Damping of the tilt proportional to its stiffness, without the coupling to the displacement.
    fn damp_tilt<const N: usize>(&self, state: &BearingState<N>, at: State<'_>, sink: &mut dyn Sink) {
        let Some(slopes) = &self.slopes else { return };
        let stiffness: [f64; SLOPES * SLOPES] = std::array::from_fn(|k| {
            let [a, b] = [k / SLOPES, k % SLOPES].map(|i| [slopes[i].1.x, slopes[i].1.y]);
            let along = |c: usize| (0..2).map(|d| state.hessian[SLOPE + c][SLOPE + d] * b[d]).sum::<f64>();
            (0..2).map(|c| a[c] * along(c)).sum()
        });
        damp(&slopes.map(|(at, _)| at), &stiffness, self.losses.time, at, sink);
    }
}

impl Joint for Journal {
    /// A gap at every rolling element; without clearance the elements hold the shaft in the centre.
    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        let arms = self.arms(q, &self.modes_at(q));
        let (u, cage) = self.displacement(q, arms);
        let [x, y, _] = self.jacobian(arms);
        let index = &self.index;
        if self.law.half_clearance <= 0.0 {
            let stiffness = self.law.centring_stiffness();
            add(Limit::Bond(Distance { index, gradient: &x, value: u[0], stiffness }));
            add(Limit::Bond(Distance { index, gradient: &y, value: u[1], stiffness }));
            return;
        }
        let [_, _, turn] = self.jacobian(arms);
        let stiffness = self.law.stiffness_of_an_element();
        for e in self.law.directions(cage) {
            let value = self.law.half_clearance - (u[0] * e.x + u[1] * e.y);
            if value < reach {
                let across = u[1] * e.x - u[0] * e.y;
                let slope = |i: usize| -(e.x * x[i] + e.y * y[i] + across * turn[i]);
                let gradient = &std::array::from_fn::<f64, 6, _>(slope);
                add(Limit::Gap(Distance { index, gradient, value, stiffness }));
            }
        }
    }

    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        match (self.has_rim, self.slopes) {
            (true, _) => self.add_element::<VARIABLES>(at, sink),
            (false, Some(_)) => self.add_element::<TILT>(at, sink),
            (false, None) => self.add_element::<PARALLEL>(at, sink),
        }
    }

    /// Exact for springs: Q δ = (n + 1) U for a roller. The gap is divided in proportion among its
    /// contributions: clearance of the drawing, wear, and deviations of the bores' diameters.
    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        let law = &self.law;
        let ring_pose = self.ring_pose(at.q);
        let state = self.law.react_at::<VARIABLES>(&ring_pose, false);
        let elastic = (law.exponent + 1.0) * state.stored;
        // Work of the forces on the displacement of the middle, and of the couples on the tilt.
        let shifted = state.gradient[0] * ring_pose.shift[0] + state.gradient[1] * ring_pose.shift[1];
        let leaned = ring_pose
            .slope
            .map_or(0.0, |slope| slope[0] * state.gradient[SLOPE] + slope[1] * state.gradient[SLOPE + 1]);
        let gap = shifted + leaned - elastic - self.rim_work(at.q);
        let share = |part: f64| if law.half_clearance == 0.0 { 0.0 } else { part / law.half_clearance };
        let PlayLabel { play, wear, .. } = self.label;
        add(Cause::ELASTIC, elastic);
        add(play, gap * share(law.drawn_half_clearance));
        add(wear, gap * share(0.5 * self.worn));
        let made = law.half_clearance - law.drawn_half_clearance - 0.5 * self.worn;
        add(Cause::MANUFACTURING_ERRORS, gap * share(made));
        if let Some(nominal) = nominal.of_errors() {
            let made = self.displacement_at(nominal).0;
            add(Cause::MANUFACTURING_ERRORS, -(state.gradient[0] * made[0] + state.gradient[1] * made[1]));
        }
    }

    fn set_wear(&mut self, wear: JointWear) {
        if let JointWear::Clearance(worn) = wear {
            self.law.widen(worn - self.worn);
            self.worn = worn;
        }
    }

    fn wearing_forces(&self, at: State<'_>) -> [f64; 2] {
        [self.law.loads(self.ring_pose(at.q)).map(|element| element.force).sum(), 0.0]
    }

    fn bearing(&self) -> Option<&Journal> {
        Some(self)
    }

    fn scale_friction(&mut self, share: f64) {
        self.losses.sliding.coefficient *= share;
    }

    fn set_friction(&mut self, sliding: Sliding) {
        self.losses.sliding = sliding;
    }

    fn set_loss_time(&mut self, time: f64) {
        self.losses.time = time;
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
