//! Load sharing of a ring of pins, of a single stage or of a drive of two rings, with the input held.

use std::f64::consts::TAU;
use std::ops::{Deref, DerefMut, Range};

use crate::contact::{PinContact, PinContacts};
use crate::dynamics::{DynamicsError, ElasticDiscs, HeldDrive};
use crate::fem::DiscShape;
use crate::geometry::Relief;
use crate::load::{FreeTravel, LoadError, LoadSharing, Preload, ShareLoad, turn_position};
use crate::machine::{CrankAngle, OutputAngle, PartWear, SingleStage, StageErrors, TwoRing, gcd};

/// A drive that shares torques among the pins of one of its rings. The crank angle is that of the input against the ring at
/// rest; torques and output errors are those at the output.
#[derive(Debug, Clone)]
pub struct StageMeshing {
    held: HeldDrive,
    /// The stage whose ring it is.
    number: usize,
    /// Turns of the input relative to the ring at rest for one turn of a disc relative to this ring.
    ratio: f64,
    /// rad.
    pattern_period: f64,
    /// Of them, after which everything repeats.
    pitches: usize,
    /// Turns of the input after which all parts return to their positions, if errors distinguish them;
    /// otherwise 1.
    turns: usize,
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

/// Torque relative to the rated one at which the play is read: elastic displacements are negligible.
const ZERO_SHARE: f64 = 1e-4;
/// Relative difference below which stiffnesses of output pins are equal except for rounding.
const SAME: f64 = 1e-9;

impl StageMeshing {
    /// The ring of a single stage. `rated_torque` (N·m) is that at the output, `ratio_to_ring` the ratio of
    /// torque and angle relative to the ring to those at the output: 1, or z_c/z_p if the ring rotates.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for values without meaning.
    pub fn new(
        stage: &SingleStage,
        elastic: Option<&ElasticDiscs>,
        rated_torque: f64,
        ratio_to_ring: f64,
    ) -> Result<StageMeshing, DynamicsError> {
        let (lobes, pins) = (stage.profile.lobe_count(), stage.profile.pin_count);
        let turns = stage.turns_to_repeat();
        let (first, even) = (stage.output_pin_stiffness[0], stage.errors.is_even());
        let same = |stiffness: &f64| (stiffness / first - 1.0).abs() < SAME;
        let one_part = |discs: &ElasticDiscs| (0..discs.count()).all(|disc| discs.discs().is_shared(0, disc));
        // A crank angle of one pin pitch rotates the pattern of contacts by one pin and the output by 1/z_c of
        // a turn relative to it.
        let pitches = match elastic {
            Some(_) => DiscShape::all_of_stage(stage)[0].lobes_to_repeat(),
            None => lobes / gcd(lobes, stage.output_pins.count),
        };
        Ok(StageMeshing {
            held: HeldDrive::new(stage.joints_with(elastic)?, rated_torque, ratio_to_ring),
            number: 0,
            ratio: stage.ratio(),
            pattern_period: TAU / stage.profile.pin_count as f64,
            pitches: if even { pitches } else { turns * pins },
            turns: if even { 1 } else { turns },
            discs_alike: even && stage.output_pin_stiffness.iter().all(same) && elastic.is_none_or(one_part),
        })
    }

    /// One of the rings of a drive of two.
    ///
    /// # Errors
    /// As [`StageMeshing::new`].
    pub fn of_ring(drive: &TwoRing, rated_torque: f64, ring: usize) -> Result<StageMeshing, DynamicsError> {
        let profile = &drive.meshes[ring].profile;
        let [first, second] = drive.meshes.each_ref().map(|mesh| mesh.profile.lobe_count());
        let lobes = profile.lobe_count();
        let disc_turns = drive.turns()[ring];
        let even = drive.errors.iter().all(StageErrors::is_even);
        let turns = drive.turns_to_repeat();
        // Relative to this ring the eccentric passes the pins z_c/m times as fast as the disc rotates.
        let passed = profile.pin_count as f64 * profile.lobes_per_turn() * disc_turns;
        Ok(StageMeshing {
            held: HeldDrive::new(drive.joints()?, rated_torque, 1.0),
            number: ring,
            ratio: 1.0 / disc_turns,
            pattern_period: TAU / passed,
            pitches: if even { lobes / gcd(first, second) } else { (passed * turns as f64).round() as usize },
            turns: if even { 1 } else { turns },
            discs_alike: even,
        })
    }

    /// Angle (rad) of the input for position `index` of `count`, for means over a period (rad) and, if errors
    /// distinguish parts, over all their combinations: the fractions of the period are equidistant.
    pub fn position(&self, period: f64, index: usize, count: usize) -> f64 {
        let periods = if self.turns > 1 { (TAU * self.turns as f64 / period).round() as usize } else { 1 };
        turn_position(period, periods, index, count, 0.0, 0).radians()
    }

    /// The stage whose ring it is.
    pub fn number(&self) -> usize {
        self.number
    }

    fn rings(&self) -> Range<usize> {
        self.joints.stages()[self.number].rings.clone()
    }

    fn all_pin_contacts(&self, place: &[f64]) -> Vec<Vec<PinContact>> {
        self.rings().map(|ring| self.joints.pin_contacts(ring, place)).collect()
    }
}

impl ShareLoad for StageMeshing {
    type Start = Vec<f64>;

    fn pattern_period(&self) -> f64 {
        self.pattern_period
    }

    /// For a single stage m/z_c of the input speed with the ring at rest, m/z_p with the output at rest.
    fn disc_speed(&self, input_speed: f64) -> f64 {
        input_speed * self.ratio_to_ring / self.ratio
    }

    fn contacts(&self) -> &PinContacts {
        &self.joints.rings[self.rings().start].contacts
    }

    fn set_relief(&mut self, relief: Relief) {
        let rings = self.rings();
        self.joints.rings[rings].iter_mut().for_each(|ring| ring.contacts.set_relief(relief.clone()));
    }

    fn set_pin_relief(&mut self, relief: Relief) {
        let rings = self.rings();
        self.joints.rings[rings].iter_mut().for_each(|ring| ring.contacts.set_pin_relief(relief.clone()));
    }

    fn set_surfaces(&mut self, flanks: Vec<Relief>, pins: Vec<Relief>) {
        let number = self.number;
        self.joints.set_stage_surfaces(number, &flanks, &pins);
    }

    fn set_other_surfaces(&mut self, ring: usize, flanks: Vec<Relief>, pins: Vec<Relief>) {
        if self.joints.stages().len() > 1 {
            self.joints.set_stage_surfaces(ring, &flanks, &pins);
        }
    }

    /// Two rings share one set of eccentric bearings.
    fn set_part_wear(&mut self, wear: &PartWear) {
        (0..self.joints.stages().len()).for_each(|stage| self.joints.set_part_wear(stage, wear));
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

    fn pin_contacts(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Vec<f64>>,
    ) -> Result<(Vec<Vec<PinContact>>, Vec<f64>), LoadError> {
        let angle = crank.radians();
        let (place, _) = self.rest_for_wear(angle, torque, start.map(Vec::as_slice))?;
        Ok((self.all_pin_contacts(&place), self.deviation(angle, &place)))
    }

    fn stiffness(&mut self, sharing: &LoadSharing) -> f64 {
        let Ok((place, _)) = self.rest(sharing.crank_angle.radians(), sharing.torque, None) else {
            return 0.0;
        };
        let motion = self.joints.motion_per_torque(&place);
        let output = self.joints.output_index();
        motion.map_or(0.0, |motion| 1.0 / (self.ratio_to_ring * self.ratio_to_ring * motion[output]))
    }

    fn twin(&self) -> StageMeshing {
        self.clone()
    }

    /// Read at ±1e-4 of the rated torque. Preloaded pins are those of states with loaded pins on both flanks;
    /// the rotations are then elastic ones under the small torques.
    fn travel(&mut self, crank: CrankAngle) -> Result<FreeTravel, LoadError> {
        let angle = crank.radians();
        let small = ZERO_SHARE * self.rated / self.ratio_to_ring;
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
