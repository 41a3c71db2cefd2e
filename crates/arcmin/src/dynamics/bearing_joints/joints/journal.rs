use super::{Cause, Distance, Joint, Limit, Losses, Nominal, Part, Sink, State, damp};
use crate::contact::ContactSpring;
use crate::dynamics::bearing_joints::assembly::Element;
use crate::dynamics::bearing_joints::elastic::{BoreMode, WithModes};
use crate::dynamics::bearing_joints::rim::{
    BODY, CAGE, OutOfRound, RIM, SLOPE, Stand, StandState, VARIABLES, WAYS,
};
use crate::dynamics::bearing_joints::{Arm, BearingState, RadialBearing};
use crate::geometry::{Vec2, quarter_turn, turned, unit};
use crate::machine::PartWear;
use crate::wear::PartLoads;

/// Which of the rolling bearings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Place {
    TurningArm,
    CrankSupport,
}

impl Place {
    fn part(self) -> Part {
        match self {
            Place::TurningArm => Part::TurningArm,
            Place::CrankSupport => Part::CrankSupport,
        }
    }

    /// What the clearance as drawn and its growth are called where they show as lost motion.
    fn causes(self) -> (Cause, Cause) {
        match self {
            Place::TurningArm => (Cause::TurningArmClearance, Cause::TurningArmWear),
            Place::CrankSupport => (Cause::CrankSupportClearance, Cause::CrankSupportWear),
        }
    }

    fn worn(self, wear: &PartWear) -> f64 {
        match self {
            Place::TurningArm => wear.turning_arm,
            Place::CrankSupport => wear.crank_support,
        }
    }

    fn load(self, loads: &mut PartLoads) -> &mut f64 {
        match self {
            Place::TurningArm => &mut loads.turning_arm,
            Place::CrankSupport => &mut loads.crank_support,
        }
    }
}

/// Coordinates that lean the rings of a bearing: two of the shaft, two of the body.
pub(in super::super) const SLOPES: usize = 4;

/// A rolling bearing between a shaft that carries its inner ring around and a body with a bore.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Journal {
    pub place: Place,
    pub law: RadialBearing,
    /// (x, y, θ) of the shaft, (x, y, θ) of the body.
    pub index: [usize; 6],
    /// Centre of the inner ring from the shaft's axis.
    pub arm: Arm,
    /// Centre of the bore from the body's centre.
    pub bore: Arm,
    /// What moves the bore beside the body's place and bends its rim, seen from the body where it turns with it.
    pub modes: Vec<BoreMode>,
    /// Whether the bore's rim goes out of round by its modes.
    pub has_rim: bool,
    /// Coordinates by which shaft and body lean, and the slope (x, y) of the inner ring against the bore per unit of
    /// each.
    pub slopes: Option<[(usize, Vec2); SLOPES]>,
    /// What the clearance has grown by wear, m.
    pub worn: f64,
    /// Bearings of this kind.
    pub alike: usize,
    pub losses: Losses,
}

/// Where the rings of a bearing are on shaft and body.
#[derive(Clone, Copy)]
struct Arms {
    /// Inner ring's centre from the shaft's axis.
    inner: Vec2,
    /// Bore from the body's centre, as it turns with the body.
    bore: Vec2,
    /// What else moves the bore, and stands in space while the body turns.
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

    /// The rim at this state.
    fn rim_at(&self, q: &[f64]) -> Option<OutOfRound> {
        self.has_rim.then(|| {
            let mut ways = [0.0; RIM];
            for mode in &self.modes {
                ways.iter_mut().zip(&mode.rim).for_each(|(way, by)| *way += q[mode.at] * by);
            }
            OutOfRound { angle: q[self.index[5]], ways }
        })
    }

    /// How inner ring and bore stand to each other.
    fn stand_at(&self, q: &[f64], (shift, cage): ([f64; 2], f64)) -> Stand {
        let slope = self.slopes.map(|slopes| {
            let slope: Vec2 = slopes.iter().map(|(at, by)| q[*at] * by).sum();
            [slope.x, slope.y]
        });
        Stand { shift, cage, rim: self.rim_at(q), slope }
    }

    fn stand(&self, q: &[f64]) -> Stand {
        self.stand_at(q, self.displacement_at(q))
    }

    /// Radial force (N) of every rolling element on the bore with the angle (rad) where it stands.
    pub fn radial_element_forces(&self, q: &[f64]) -> Vec<(f64, f64)> {
        let forces = self.law.element_forces_at(self.stand(q));
        forces.map(|(angle, force)| (angle, self.law.contact_cosine * force)).collect()
    }

    /// Force (N) on the inner ring and forces of the rolling elements.
    pub fn load(&self, q: &[f64]) -> (BearingState, Vec<f64>) {
        let stand = self.stand(q);
        let forces = self.law.element_forces_at(stand).map(|(_, force)| force).collect();
        (self.state(&stand, true).0, forces)
    }

    /// The bearing's energy with its derivatives, and those by rim and slopes where it has any.
    fn state(&self, stand: &Stand, tangents: bool) -> (BearingState, Option<StandState>) {
        if stand.rim.is_none() && stand.slope.is_none() {
            return (self.law.react(stand.shift, stand.cage), None);
        }
        let state = self.law.react_at(stand, tangents);
        (state.plain(), Some(state))
    }

    /// Work Σ Q_i w(ψ_i) (N·m) of the rollers on their rim, 0 for a round one.
    fn rim_work(&self, q: &[f64]) -> f64 {
        let Some(rim) = self.rim_at(q) else { return 0.0 };
        self.radial_element_forces(q).iter().map(|(angle, force)| force * rim.at(*angle)).sum()
    }

    /// Hands on the bearing in its rim or with rings that lean: coordinates of shaft and body, then what leans, then the
    /// modes, with their displacements in the housing frame.
    fn visit_whole(
        &self,
        state: &StandState,
        jacobian: &[[f64; 6]; 3],
        Arms { inner, bore, .. }: Arms,
        modes: &[BoreMode],
        sink: &mut dyn Sink,
    ) {
        let slopes = self.slopes.as_ref().map_or(&[][..], |slopes| &slopes[..]);
        let (lean, bent) = (6, 6 + slopes.len());
        let width = bent + modes.len();
        let leaning = slopes.iter().map(|(at, _)| *at);
        let index: Vec<usize> =
            self.index.iter().copied().chain(leaning).chain(modes.iter().map(|mode| mode.at)).collect();
        // What each coordinate moves: rows of the bearing's variables.
        let mut rows = vec![0.0; VARIABLES * width];
        let at = |variable: usize, coordinate: usize| variable * width + coordinate;
        for (row, variable) in jacobian.iter().zip([0, 1, CAGE]) {
            rows[at(variable, 0)..][..6].copy_from_slice(row);
        }
        rows[at(BODY, 5)] = 1.0;
        for (i, (_, by)) in slopes.iter().enumerate() {
            (rows[at(SLOPE, lean + i)], rows[at(SLOPE + 1, lean + i)]) = (by.x, by.y);
        }
        for (m, mode) in modes.iter().enumerate() {
            (rows[at(0, bent + m)], rows[at(1, bent + m)]) = (-mode.by.x, -mode.by.y);
            mode.rim.iter().enumerate().for_each(|(r, way)| rows[at(WAYS + r, bent + m)] = *way);
        }
        let mut gradient = vec![0.0; width];
        for (row, slope) in rows.chunks_exact(width).zip(&state.gradient) {
            gradient.iter_mut().zip(row).for_each(|(sum, by)| *sum += slope * by);
        }
        let mut hessian = vec![0.0; if sink.takes_stiffness() { width * width } else { 0 }];
        if !hessian.is_empty() {
            let mut bend = vec![0.0; width];
            for (row, by) in rows.chunks_exact(width).zip(&state.hessian) {
                bend.fill(0.0);
                for (other, share) in rows.chunks_exact(width).zip(by).filter(|(_, share)| **share != 0.0) {
                    bend.iter_mut().zip(other).for_each(|(sum, by)| *sum += share * by);
                }
                for (line, by) in hessian.chunks_exact_mut(width).zip(row).filter(|(_, by)| **by != 0.0) {
                    line.iter_mut().zip(&bend).for_each(|(entry, bend)| *entry += by * bend);
                }
            }
            let force = Vec2::new(state.gradient[0], state.gradient[1]);
            hessian[2 * width + 2] -= force.dot(&inner);
            hessian[5 * width + 5] += force.dot(&bore);
            // Displacements by modes turn with the body.
            for (m, mode) in modes.iter().enumerate().filter(|(_, mode)| mode.turns) {
                let turning = force.dot(&quarter_turn(mode.by));
                hessian[5 * width + bent + m] -= turning;
                hessian[(bent + m) * width + 5] -= turning;
            }
        }
        sink.element(&Element {
            part: self.place.part(),
            index: &index,
            gradient: &gradient,
            hessian: &hessian,
            stored: state.stored,
        });
    }

    /// Damping of the lean in proportion to its stiffness, as if it were apart from that of the shift.
    fn damp_lean(&self, state: &StandState, at: State<'_>, sink: &mut dyn Sink) {
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
    /// A gap at every rolling element; without clearance the elements hold the shaft in the middle.
    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        let arms = self.arms(q, &self.modes_at(q));
        let (u, _) = self.displacement(q, arms);
        let [x, y, _] = self.jacobian(arms);
        let index = &self.index;
        if self.law.half_clearance <= 0.0 {
            let stiffness = self.law.centring_stiffness();
            add(Limit::Bond(Distance { index, gradient: &x, value: u[0], stiffness }));
            add(Limit::Bond(Distance { index, gradient: &y, value: u[1], stiffness }));
            return;
        }
        self.contacts(q, reach, &mut |distance, spring| add(Limit::Gap(distance, spring)));
    }

    /// A contact at every rolling element.
    fn contacts(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Distance<'_>, ContactSpring)) {
        let arms = self.arms(q, &self.modes_at(q));
        let (u, cage) = self.displacement(q, arms);
        let [x, y, turn] = self.jacobian(arms);
        let (index, stiffness) = (&self.index, self.law.stiffness_of_an_element());
        for (e, along, across) in self.law.elements(u, cage) {
            let value = self.law.half_clearance - along;
            if value >= reach {
                continue;
            }
            let gradient =
                &std::array::from_fn::<f64, 6, _>(|i| -(e.x * x[i] + e.y * y[i] + across * turn[i]));
            add(Distance { index, gradient, value, stiffness }, self.law.element_spring());
        }
    }

    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let modes = self.modes_at(at.q);
        let arms = self.arms(at.q, &modes);
        let (u, cage) = self.displacement(at.q, arms);
        let tangents = sink.takes_stiffness() || self.losses.time > 0.0;
        let (plain, whole) = self.state(&self.stand_at(at.q, (u, cage)), tangents);
        let BearingState { stored, gradient, hessian, .. } = plain;
        if stored == 0.0 {
            return;
        }
        if let Some(state) = &whole {
            self.damp_lean(state, at, sink);
        }
        let jacobian = self.jacobian(arms);
        if let Some(state) = &whole {
            self.visit_whole(state, &jacobian, arms, &modes, sink);
        }
        let mut sink = WithModes { sink, modes: &modes };
        let mut slope = [0.0; 6];
        let mut matrix = [0.0; 36];
        let mut damping = [0.0; 36];
        for i in 0..if whole.is_some() { 0 } else { 6 } {
            let mut column = [0.0; 3];
            for c in 0..3 {
                slope[i] += gradient[c] * jacobian[c][i];
                column[c] = (0..3).map(|d| hessian[c][d] * jacobian[d][i]).sum();
            }
            for j in 0..6 {
                matrix[j * 6 + i] =
                    jacobian[0][j] * column[0] + jacobian[1][j] * column[1] + jacobian[2][j] * column[2];
            }
        }
        matrix[2 * 6 + 2] -= gradient[0] * arms.inner.x + gradient[1] * arms.inner.y;
        matrix[5 * 6 + 5] += gradient[0] * arms.bore.x + gradient[1] * arms.bore.y;
        if whole.is_none() {
            sink.element(&Element {
                part: self.place.part(),
                index: &self.index,
                gradient: &slope,
                hessian: &matrix,
                stored,
            });
        }
        let mut rate = self.index.map(|i| at.v[i]);
        for BoreMode { at: mode, by, .. } in &modes {
            rate[3] += at.v[*mode] * by.x;
            rate[4] += at.v[*mode] * by.y;
        }
        let Losses { time: loss_time, friction } = self.losses;
        let mut force = [0.0; 6];
        let mut dissipation = 0.0;
        if loss_time > 0.0 {
            let spread = |row: usize| jacobian[row].iter().zip(&rate).map(|(j, v)| j * v).sum::<f64>();
            let u = [spread(0), spread(1)];
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
        if friction.bearing > 0.0 {
            // Rolling friction: μ F r_m against the relative turn.
            let load = gradient[0].hypot(gradient[1]);
            let speed = rate[2] - rate[5];
            let radius = self.law.mean_radius;
            let (share, slope) = self.losses.coulomb(speed * radius);
            let torque = friction.bearing * load * radius;
            force[2] -= torque * share;
            force[5] += torque * share;
            let c = torque * slope * radius;
            for (i, j, sign) in [(2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)] {
                damping[i * 6 + j] += sign * c;
            }
            dissipation += torque * share * speed;
            // ∂F/∂(u_x, u_y, ψ), which lead on to the coordinates.
            let by_load = [0, 1, 2].map(|d| {
                if load == 0.0 {
                    0.0
                } else {
                    (gradient[0] * hessian[0][d] + gradient[1] * hessian[1][d]) / load
                }
            });
            let mut by_place = [0.0; 36];
            for j in 0..6 {
                let slope: f64 = (0..3).map(|d| by_load[d] * jacobian[d][j]).sum();
                let change = friction.bearing * radius * share * slope;
                by_place[2 * 6 + j] = change;
                by_place[5 * 6 + j] = -change;
            }
            sink.friction_slope(&self.index, &by_place);
        }
        if loss_time > 0.0 || friction.bearing > 0.0 {
            sink.damper(&self.index, &force, &damping, dissipation);
        }
    }

    /// Exact for springs: Q δ = (n + 1) U of a roller. The gap is what the clearance as drawn, wear, and
    /// bores made too wide or too narrow have made of it, in proportion.
    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        let law = &self.law;
        let stand = self.stand(at.q);
        let (state, whole) = self.state(&stand, false);
        let elastic = (law.exponent + 1.0) * state.stored;
        // Of the forces on the way of the middle, of the couples on the lean.
        let shifted = state.gradient[0] * stand.shift[0] + state.gradient[1] * stand.shift[1];
        let leaned = stand.slope.zip(whole).map_or(0.0, |(slope, whole)| {
            slope[0] * whole.gradient[SLOPE] + slope[1] * whole.gradient[SLOPE + 1]
        });
        let gap = shifted + leaned - elastic - self.rim_work(at.q);
        let share = |part: f64| if law.half_clearance == 0.0 { 0.0 } else { part / law.half_clearance };
        let (clearance, wear) = self.place.causes();
        add(Cause::Elastic, elastic);
        add(clearance, gap * share(law.drawn_half_clearance));
        add(wear, gap * share(0.5 * self.worn));
        let made = law.half_clearance - law.drawn_half_clearance - 0.5 * self.worn;
        add(Cause::ManufacturingErrors, gap * share(made));
        if let Some(nominal) = nominal.of_errors() {
            let made = self.displacement_at(nominal).0;
            add(Cause::ManufacturingErrors, -(state.gradient[0] * made[0] + state.gradient[1] * made[1]));
        }
    }

    fn set_wear(&mut self, wear: &PartWear) {
        let worn = self.place.worn(wear);
        self.law.widen(worn - self.worn);
        self.worn = worn;
    }

    fn add_loads(&self, at: State<'_>, loads: &mut PartLoads) {
        let forces = self.law.element_forces_at(self.stand(at.q)).map(|(_, force)| force);
        *self.place.load(loads) += forces.sum::<f64>() / self.alike as f64;
    }

    fn bearing(&self) -> Option<&Journal> {
        Some(self)
    }

    fn scale_friction(&mut self, share: f64) {
        self.losses.scale_friction(share);
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
