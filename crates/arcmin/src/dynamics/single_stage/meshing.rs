//! Load sharing of a single stage with its input held.

use std::ops::{Deref, DerefMut};

use crate::contact::{PinContact, PinContacts};
use crate::dynamics::{DynamicsError, HeldDrive};
use crate::geometry::Relief;
use crate::load::{FreeTravel, LoadError, LoadSharing, Preload, ShareLoad};
use crate::machine::{CrankAngle, OutputAngle, PartWear, SingleStage, gcd};

/// A single stage that shares torques among its pins. The crank angle is that of the input against the ring; torques and
/// output errors are those at the output.
#[derive(Debug, Clone)]
pub struct StageMeshing {
    held: HeldDrive,
    pin_count: usize,
    /// Pin pitches after which everything repeats.
    pitches: usize,
    discs_alike: bool,
}

impl Deref for StageMeshing {
    type Target = HeldDrive;

    fn deref(&self) -> &HeldDrive {
        &self.held
    }
}

impl DerefMut for StageMeshing {
    fn deref_mut(&mut self) -> &mut HeldDrive {
        &mut self.held
    }
}

/// Torque, as a share of the rated one, at which play is read: nothing but gaps gives way.
const ZERO_SHARE: f64 = 1e-4;
/// Stiffnesses of output pins that differ by less are the same: rounding.
const SAME: f64 = 1e-9;

impl StageMeshing {
    /// `rated_torque` (N·m) is that at the output, `seen_from_ring` torque and angle of the drive seen from its ring over
    /// those at the output: 1, or z_c/z_p where the ring turns.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for values without meaning.
    pub fn new(
        stage: &SingleStage,
        rated_torque: f64,
        seen_from_ring: f64,
    ) -> Result<StageMeshing, DynamicsError> {
        let lobes = stage.profile.lobe_count();
        let first = stage.output_pin_stiffness[0];
        Ok(StageMeshing {
            held: HeldDrive::new(stage.joints()?, rated_torque, seen_from_ring),
            pin_count: stage.profile.pin_count,
            // A pin pitch of crank angle turns the pattern of the ring by a pin and the output by 1/z_c of a turn against it.
            pitches: lobes / gcd(lobes, stage.output_pins.count),
            discs_alike: stage.output_pin_stiffness.iter().all(|k| (k / first - 1.0).abs() < SAME),
        })
    }

    /// What is held, without its load sharing.
    pub fn into_held(self) -> HeldDrive {
        self.held
    }

    fn all_pin_contacts(&self, place: &[f64]) -> Vec<Vec<PinContact>> {
        (0..self.joints.rings.len()).map(|disc| self.joints.pin_contacts(disc, place)).collect()
    }
}

impl ShareLoad for StageMeshing {
    type Start = Vec<f64>;

    fn pattern_period(&self) -> f64 {
        std::f64::consts::TAU / self.pin_count as f64
    }

    /// 1/z_c of the input with the ring at rest, 1/z_p with the output at rest.
    fn disc_speed(&self, input_speed: f64) -> f64 {
        input_speed * self.seen_from_ring / self.joints.flanges().ratio
    }

    fn contacts(&self) -> &PinContacts {
        &self.joints.rings[0].contacts
    }

    fn set_relief(&mut self, relief: Relief) {
        self.joints.rings.iter_mut().for_each(|ring| ring.contacts.set_relief(relief.clone()));
    }

    fn set_pin_relief(&mut self, relief: Relief) {
        self.joints.rings.iter_mut().for_each(|ring| ring.contacts.set_pin_relief(relief.clone()));
    }

    fn set_surfaces(&mut self, flanks: Vec<Relief>, pins: Vec<Relief>) {
        self.joints.set_surfaces(&flanks, &pins);
    }

    fn set_part_wear(&mut self, wear: &PartWear) {
        self.joints.set_part_wear(wear);
    }

    fn pitches(&self) -> usize {
        self.pitches
    }

    fn discs_alike(&self) -> bool {
        self.discs_alike
    }

    fn share(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Vec<f64>>,
    ) -> Result<(LoadSharing, Vec<f64>), LoadError> {
        let angle = crank.radians();
        let (place, residual) = self.rest(angle, torque, start.map(Vec::as_slice))?;
        let sharing = LoadSharing {
            crank_angle: crank,
            torque,
            output_error: OutputAngle::from_radians(self.output_error(&place)),
            residual,
            stiffness: None,
            discs: self.all_pin_contacts(&place),
        };
        Ok((sharing, self.deviation(angle, &place)))
    }

    fn stiffness(&mut self, sharing: &LoadSharing) -> f64 {
        let Ok((place, _)) = self.rest(sharing.crank_angle.radians(), sharing.torque, None) else {
            return 0.0;
        };
        let motion = self.joints.motion_per_torque(&place);
        let output = self.joints.output_index();
        motion.map_or(0.0, |motion| 1.0 / (self.seen_from_ring * self.seen_from_ring * motion[output]))
    }

    fn twin(&self) -> StageMeshing {
        self.clone()
    }

    /// Read at ±1e-4 of the rated torque. Pins that press without load are those of states in which pins carry on both
    /// flanks; the ways are then those that the small torques bend.
    fn travel(&mut self, crank: CrankAngle) -> Result<FreeTravel, LoadError> {
        let angle = crank.radians();
        let small = ZERO_SHARE * self.rated / self.seen_from_ring;
        let (lag, _) = self.rest(angle, small, None)?;
        let lag_error = self.output_error(&lag);
        let pins = self.all_pin_contacts(&lag);
        let carries =
            |flank: f64| pins.iter().flatten().any(|pin| pin.force > 0.0 && flank * pin.meshing_angle > 0.0);
        let preload = match carries(1.0) && carries(-1.0) {
            true => Preload::of(&pins, self.contacts()),
            false => Preload::default(),
        };
        let start = self.deviation(angle, &lag);
        let (lead, _) = self.rest(angle, -small, Some(&start))?;
        Ok(FreeTravel {
            lag: OutputAngle::from_radians(lag_error),
            lead: OutputAngle::from_radians(self.output_error(&lead)),
            preload,
        })
    }
}
