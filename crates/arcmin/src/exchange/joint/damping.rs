//! Damping of the exported joint: that of the machine, and that required by a time step.

use super::{ACROSS, Hysteresis, JointExport, JointState, SlipElement};

/// Damping ratio of the flange alone on the gear, as in the map of the FMU: it acts while all slip elements
/// stick.
pub(in crate::exchange) const FLANGE_DAMPING_RATIO: f64 = 0.02;
/// Ratio of the load's inertia to that of the motor side, both referred to the same side, up to which servo
/// drives are usually considered controllable.
const INERTIA_RATIO: f64 = 10.0;
/// Elements with a smaller torque than this fraction of half the rated torque are omitted; the fit produces
/// such elements.
const LEAST_SLIP: f64 = 1e-9;
/// Constant slip torque of all elements at most, as a fraction of the torque at which lost motion is measured.
const HOLDING: f64 = 0.5;
/// Number of steps of the elastic wind-up in the integration of an oscillation.
const STEPS: f64 = 2000.0;
/// Damping ratio if there is no backward oscillation.
const MOST: f64 = 1.0;
/// Square of frequency × time step up to which a spring is integrated explicitly; the stability limit is 4.
const EXPLICIT: f64 = 2.0;

/// Damping ratio by the hysteresis for a free oscillation about half of the rated torque, released at three
/// quarters: logarithm of the ratio of the first to the third half oscillation, divided by 2 π. It does not
/// depend on the inertia: a half oscillation ends when the work of the torque in excess of the load, ∫ (T − T₀)
/// dφ, is zero.
pub(super) fn damping_ratio(hysteresis: &Hysteresis, rated: f64) -> f64 {
    let load = 0.5 * rated;
    if hysteresis.elements.iter().all(|element| element.torque(load) == 0.0) {
        return 0.0;
    }
    let mut states = vec![0.0; hysteresis.elements.len()];
    let step = 0.25 * rated / hysteresis.stiffest() / STEPS;
    // Initial state: wound up to three quarters of the rated torque.
    let mut angle = 0.0;
    while hysteresis.torque(angle, &states) < 0.75 * rated {
        angle += step;
        hysteresis.follow(&mut states, step);
    }
    let mut half_swing = |sign: f64| {
        let (mut energy, mut way) = (0.0, 0.0);
        loop {
            let before = hysteresis.torque(angle, &states) - load;
            hysteresis.follow(&mut states, sign * step);
            angle += sign * step;
            let work = 0.5 * sign * step * (before + hysteresis.torque(angle, &states) - load);
            if energy - work <= 0.0 {
                // The fraction of the step for which the energy is sufficient.
                return way + if work > 0.0 { step * energy / work } else { 0.0 };
            }
            energy -= work;
            way += step;
        }
    };
    let [first, _, third] = [-1.0, 1.0, -1.0].map(&mut half_swing);
    if third > 0.0 { (first / third).ln() / std::f64::consts::TAU } else { MOST }
}

impl JointState {
    /// Half of the largest torque of the loop, N·m.
    fn half_rated(&self) -> f64 {
        0.5 * self.torsion_loop.iter().map(|point| point.0).fold(0.0, f64::max)
    }

    /// Elastic torque in N·m for slip elements of programs in which they do not depend on the load: half the rated
    /// torque, where a loop is approximately widest. It is smaller if friction would then hold the joint within its
    /// play at the torque at which lost motion is measured.
    fn load_of_constant_slip(&self) -> f64 {
        let sum = |of: fn(&SlipElement) -> f64| self.hysteresis.elements.iter().map(of).sum::<f64>();
        let allowed = HOLDING * ACROSS * 2.0 * self.half_rated();
        let load = (allowed - sum(|e| e.torque_n_m)) / sum(|e| e.torque_per_load);
        // NaN or infinity without friction that grows with the load.
        if load < self.half_rated() { load.max(0.0) } else { self.half_rated() }
    }

    /// The elements with a noticeable torque, with the torque in N·m of programs in which it is constant.
    pub(super) fn slipping(&self) -> impl Iterator<Item = (&SlipElement, f64)> {
        let (half, load) = (self.half_rated(), self.load_of_constant_slip());
        let elements = self.hysteresis.elements.iter();
        let noticeable = elements.filter(move |element| element.torque(half) > LEAST_SLIP * half);
        noticeable.map(move |element| (element, element.torque(load)))
    }

    /// Moment of inertia in kg·m² that an explicit time step (s) requires on the gear's springs.
    pub(super) fn inertia_for(&self, timestep: f64) -> f64 {
        self.hysteresis.stuck_stiffness(self.half_rated()) * timestep * timestep / EXPLICIT
    }

    /// Damping in N·m·s/rad that gives an inertia (kg·m²) on the gear the damping ratio of the flange alone.
    /// The ratio decreases with the inertia to the power −½.
    pub(super) fn rest_damping(&self, inertia: f64) -> f64 {
        2.0 * FLANGE_DAMPING_RATIO * (self.hysteresis.stiffest() * inertia).sqrt()
    }
}

impl JointExport {
    /// Inertia in kg·m² of a load by the usual rule for servo motors.
    pub fn usual_load(&self) -> f64 {
        INERTIA_RATIO * self.reflected_inertia()
    }

    /// Damping in N·m·s/rad for programs without hysteresis: d = 2 ζ √(K₃ J) gives the load of the export the
    /// damping ratio of the hysteresis. For another load J′ it is multiplied by √(J′/J).
    pub fn damping(&self, state: &JointState) -> f64 {
        let stiffness = state.hysteresis.curve.stiffness_n_m_per_rad[2];
        2.0 * state.damping_ratio * (stiffness * self.load_inertia_kg_m2).sqrt()
    }
}
