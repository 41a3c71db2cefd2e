//! Static equilibria of a drive with its input held.

use super::EccentricJoints;
use crate::dynamics::statics::WEAR_TOLERANCE;
use crate::dynamics::{DynamicsError, EquilibriumControl, continue_from_larger_loads, solve_equilibrium};
use crate::geometry::Relief;
use crate::load::LoadError;
use crate::machine::{CrankAngle, PartWear, StageFriction};

/// A drive and the search for its static equilibria. Torques and errors are those at the output.
#[derive(Debug, Clone)]
pub struct HeldDrive {
    pub(in crate::dynamics) joints: EccentricJoints,
    /// N·m, relative to the ring.
    pub(in crate::dynamics) rated: f64,
    /// Ratio of torque and angle relative to the ring to those at the output.
    pub(in crate::dynamics) ratio_to_ring: f64,
}

/// A static equilibrium: coordinates, and the largest residual force in N.
pub(in crate::dynamics) type Rest = (Vec<f64>, f64);

impl HeldDrive {
    /// Steps of 1e-7′ at the output, forces of 1e-9 N.
    pub(crate) const CONTROL: EquilibriumControl =
        EquilibriumControl { tolerance: 1e-7, force_tolerance: 1e-9, held: None };

    /// `rated_torque` (N·m) is that at the output, `ratio_to_ring` the ratio of torque and angle relative to
    /// the ring to those at the output: 1, or z_c/z_p for a single stage with rotating ring.
    pub fn new(joints: EccentricJoints, rated_torque: f64, ratio_to_ring: f64) -> HeldDrive {
        HeldDrive { joints, rated: rated_torque.abs() * ratio_to_ring, ratio_to_ring }
    }

    /// Bodies and joints of the drive.
    pub fn joints(&self) -> &EccentricJoints {
        &self.joints
    }

    /// Ratio of torque and angle relative to the ring to those at the output.
    pub(crate) fn ratio_to_ring(&self) -> f64 {
        self.ratio_to_ring
    }

    /// Rated torque in N·m, relative to the ring.
    pub(crate) fn rated_torque(&self) -> f64 {
        self.rated
    }

    /// Bodies and joints with the input held at an angle (rad), with friction regularised over a sliding speed (m/s), stage by
    /// stage, and without damping.
    pub(crate) fn with_friction(
        &self,
        angle: f64,
        friction: &[StageFriction],
        regularisation_speed: f64,
    ) -> EccentricJoints {
        let mut joints = self.joints.clone().with_friction(friction, regularisation_speed);
        joints.hold_input(angle, 0.0);
        joints
    }

    /// Sets the wear of a stage; the wear of its surfaces is added to the designed relief of the flank.
    pub fn set_stage_wear(&mut self, stage: usize, surfaces: (&[Relief], &[Relief]), parts: &PartWear) {
        self.joints.set_stage_wear(stage, surfaces, parts);
    }

    /// Coordinates of the static equilibrium with the input held at an angle (rad) relative to the ring, under
    /// an output torque in N·m against positive motion, and the largest residual force. `start` is the
    /// deviation of another state from its nominal position, in the frame of its crank.
    ///
    /// # Errors [`LoadError`] if no equilibrium is found.
    pub fn rest(&mut self, angle: f64, torque: f64, start: Option<&[f64]>) -> Result<Rest, LoadError> {
        self.find_rest(HeldDrive::CONTROL, angle, torque, start)
    }

    /// [`HeldDrive::rest`] with the tolerance of wear.
    ///
    /// # Errors
    /// As there.
    pub(in crate::dynamics) fn rest_for_wear(
        &mut self,
        angle: f64,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Rest, LoadError> {
        let control = EquilibriumControl { tolerance: WEAR_TOLERANCE, ..HeldDrive::CONTROL };
        self.find_rest(control, angle, torque, start)
    }

    fn find_rest(
        &mut self,
        control: EquilibriumControl,
        angle: f64,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Rest, LoadError> {
        if !torque.is_finite() {
            return Err(LoadError::BadTorque(torque));
        }
        self.joints.hold_input(angle, 0.0);
        let nominal = self.joints.nominal_position_at(angle);
        let place = match start {
            None => nominal.clone(),
            Some(start) => {
                let mut displacements = start.to_vec();
                self.joints.rotate_displacements(&mut displacements, angle);
                nominal.iter().zip(displacements).map(|(q, shift)| q + shift).collect()
            }
        };
        let joints = &mut self.joints;
        let mut left = 0.0;
        let mut find = |load: f64, start: &[f64]| {
            joints.set_load(load);
            solve_equilibrium(&**joints, 0.0, start, control).map(|found| {
                left = found.residual;
                found.position
            })
        };
        let load = torque * self.ratio_to_ring;
        let found = match find(load, &place) {
            Err(DynamicsError::NoEquilibrium { .. }) => {
                continue_from_larger_loads(load, self.rated, |load, near| {
                    find(load, near.unwrap_or(&nominal))
                })
            }
            found => found,
        };
        match found {
            Ok(place) => Ok((place, left)),
            Err(error) => Err(error.of_load_sharing(CrankAngle::from_radians(angle), torque)),
        }
    }

    /// Deviation of an equilibrium at an angle from the nominal position, in the frame of its crank.
    pub fn deviation(&self, angle: f64, place: &[f64]) -> Vec<f64> {
        let nominal = self.joints.nominal_position_at(angle);
        let mut displacements: Vec<f64> = place.iter().zip(nominal).map(|(q, nominal)| q - nominal).collect();
        self.joints.rotate_displacements(&mut displacements, -angle);
        displacements
    }

    /// Angle in rad of the output less its nominal angle, in the last equilibrium.
    pub fn output_error(&self, place: &[f64]) -> f64 {
        self.ratio_to_ring * self.joints.output_error(place)
    }
}
