//! Damping of the exported joint: what the machine has, and what a time step needs.

use super::{Hysteresis, JointExport, JointState, SlipElement};

/// Damping ratio of the flange alone on the gear, as in the map of the FMU: what rings on while all sliders
/// stick.
pub(in crate::exchange) const FLANGE_DAMPING_RATIO: f64 = 0.02;
/// A load may weigh so many times what the motor's side weighs, all seen from the same side; servo makers
/// call more than this hard to control.
const INERTIA_RATIO: f64 = 10.0;
/// Elements that hold less than this part of half the rated torque are left out; the fit leaves such specks.
const LEAST_SLIP: f64 = 1e-9;
/// Steps of the elastic wind-up over which a swing is followed.
const STEPS: f64 = 2000.0;
/// Damping ratio of what does not swing back.
const MOST: f64 = 1.0;
/// Square of frequency × time step up to which a spring is stepped explicitly; 4 is where it becomes
/// unstable.
const EXPLICIT: f64 = 2.0;

/// Damping ratio that the hysteresis gives to what swings freely about half of the rated torque after a
/// quarter of it was let go: the logarithm of its first against its third half swing over 2 π. It does not
/// depend on the inertia: a half swing ends where the work of the torque beyond the load, ∫ (T − T₀) dφ, is
/// used up.
pub(super) fn damping_ratio(hysteresis: &Hysteresis, rated: f64) -> f64 {
    let load = 0.5 * rated;
    if hysteresis.elements.iter().all(|element| element.torque_n_m + element.torque_per_load == 0.0) {
        return 0.0;
    }
    let mut states = vec![0.0; hysteresis.elements.len()];
    let step = 0.25 * rated / hysteresis.stiffest() / STEPS;
    // Wound up to three quarters of the rated torque.
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
                // The part of the step that the energy is enough for.
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

    /// Torque in N·m at which an element slips at half the rated load, where a loop is about widest: for
    /// tools whose sliders know no load.
    pub(super) fn slip_torque(&self, element: &SlipElement) -> f64 {
        element.torque_n_m + element.torque_per_load * self.half_rated()
    }

    /// The elements that hold something, with their slip torque.
    pub(super) fn slipping(&self) -> impl Iterator<Item = (&SlipElement, f64)> {
        let least = LEAST_SLIP * self.half_rated();
        let all = self.hysteresis.elements.iter().map(|element| (element, self.slip_torque(element)));
        all.filter(move |(_, torque)| *torque > least)
    }

    /// Stiffness in N·m/rad right after a reversal: that of the stiffest piece and all elements that stick.
    fn stuck_stiffness(&self) -> f64 {
        let stuck: f64 = self.slipping().map(|(element, torque)| torque / element.slip_rad).sum();
        self.hysteresis.stiffest() + stuck
    }

    /// Moment of inertia in kg·m² that an explicit time step (s) needs on the gear's springs.
    pub(super) fn inertia_for(&self, timestep: f64) -> f64 {
        self.stuck_stiffness() * timestep * timestep / EXPLICIT
    }

    /// Damping in N·m·s/rad that gives an inertia (kg·m²) on the gear the ratio of the flange alone. A larger
    /// inertia has less: in proportion to its −½th power.
    pub(super) fn rest_damping(&self, inertia: f64) -> f64 {
        2.0 * FLANGE_DAMPING_RATIO * (self.hysteresis.stiffest() * inertia).sqrt()
    }
}

impl JointExport {
    /// Inertia in kg·m² that a load may have by the usual rule for servo motors.
    pub fn usual_load(&self) -> f64 {
        INERTIA_RATIO * self.reflected_inertia()
    }

    /// Damping in N·m·s/rad for tools without hysteresis: d = 2 ζ √(K₃ J) gives the load that the export is
    /// meant for the damping ratio of the hysteresis. Another load J′ asks for √(J′/J) of it.
    pub fn damping(&self, state: &JointState) -> f64 {
        let stiffness = state.hysteresis.curve.stiffness_n_m_per_rad[2];
        2.0 * state.damping_ratio * (stiffness * self.load_inertia_kg_m2).sqrt()
    }
}
