use super::{Cycle, FreeTravel, LoadError, LoadSharing, Meshing};
use crate::contact::{PinContact, PinContacts};
use crate::geometry::Relief;
use crate::machine::{CrankAngle, OutputAngle, OutputForces, PartWear};

/// Models that find the forces of all pins at a crank position with the input locked: ideal joints
/// ([`Meshing`]) or bearings ([`BearingMeshing`](crate::dynamics::BearingMeshing)). Wear and accuracy over life
/// use this interface.
pub trait ShareLoad: Send + Sync {
    /// A solution kept as the start value of a neighbouring one.
    type Start: Clone + Send + Sync;

    /// Crank angle over which the pattern of pins and discs repeats in rad.
    fn pattern_period(&self) -> f64;

    /// Speed (rad/s) of the discs relative to the ring for a speed of the input (rad/s).
    fn disc_speed(&self, input_speed: f64) -> f64;

    /// Flank and contact law of a disc.
    fn contacts(&self) -> &PinContacts;

    /// Replaces the relief of the flanks in m (designed relief included).
    fn set_relief(&mut self, relief: Relief);

    /// Replaces the relief of the pins in m.
    fn set_pin_relief(&mut self, relief: Relief);

    /// Replaces the relief in m of the flanks (designed relief included) and of the pins: one for all, or one
    /// per disc and, for every pin, per disc. Joints without errors take one for all only.
    fn set_surfaces(&mut self, mut flanks: Vec<Relief>, mut pins: Vec<Relief>) {
        self.set_relief(flanks.swap_remove(0));
        self.set_pin_relief(pins.swap_remove(0));
    }

    /// The same for another ring of pins, by its number among the rings of the equilibrium; ignored by joints
    /// with one ring.
    fn set_other_surfaces(&mut self, _ring: usize, _flanks: Vec<Relief>, _pins: Vec<Relief>) {}

    /// Replaces the wear of bearings and gears; ignored by ideal joints, which have neither clearance nor
    /// backlash.
    fn set_part_wear(&mut self, _wear: &PartWear) {}

    /// Replaces the external forces and moments on the output; ignored by joints with an ideally guided output.
    fn set_output_forces(&mut self, _forces: OutputForces) {}

    /// Period of the whole state in pin pitches of the crank angle.
    fn pitches(&self) -> usize;

    /// Shares the output torque (N·m) at a crank angle.
    ///
    /// # Errors
    /// [`LoadError`] where no equilibrium is found.
    fn share(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Self::Start>,
    ) -> Result<(LoadSharing, Self::Start), LoadError>;

    /// Torsional stiffness at the output, in N·m/rad, at the load sharing found last; 0 without contact.
    fn stiffness(&mut self, sharing: &LoadSharing) -> f64 {
        sharing.stiffness.unwrap_or(0.0)
    }

    /// The part of [`ShareLoad::share`] that wear needs: the contacts of every disc, and the solution.
    ///
    /// # Errors
    /// As there.
    fn pin_contacts(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Self::Start>,
    ) -> Result<(Vec<Vec<PinContact>>, Self::Start), LoadError> {
        self.share(crank, torque, start).map(|(sharing, found)| (sharing.discs, found))
    }

    /// A copy with the same surfaces, for use in another thread.
    fn twin(&self) -> Self
    where
        Self: Sized;

    /// Play of the output in both directions at no load, negative with interference, and the forces of the
    /// preload: see [`FreeTravel`].
    ///
    /// # Errors
    /// [`LoadError`] where no pin touches or no load-free equilibrium is found.
    fn travel(&mut self, crank: CrankAngle) -> Result<FreeTravel, LoadError>;

    /// Crank angle number `index` of `count`, for means over one full period: the fractions of a pin pitch are
    /// equidistant, and so are, within one pitch, the positions in the whole period. `offset` (0 to 1) shifts
    /// the fractions, `shift` shifts the positions in the period with the same fractions: with a single
    /// position per fraction, differences between the positions would appear as properties of the flank.
    fn crank_position(&self, index: usize, count: usize, offset: f64, shift: usize) -> CrankAngle {
        turn_position(self.pattern_period(), self.pitches(), index, count, offset, shift)
    }

    /// Whether all discs wear equally, as in a machine without errors.
    fn discs_alike(&self) -> bool {
        true
    }

    /// Load sharing at `count` crank positions over one pin pitch, in order; the play is not computed.
    ///
    /// # Errors
    /// [`LoadError`] of the first position that has no solution.
    fn pitch_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        let period = self.pattern_period();
        let angles = (0..count).map(|index| CrankAngle::from_radians(period * index as f64 / count as f64));
        sample(self, torque, period, angles)
    }

    /// Load sharing at `count` crank positions over one full period, and the play at every third of them.
    ///
    /// # Errors
    /// [`LoadError`] of the first position that has no solution.
    fn whole_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        let free = self.free_cycle(torque, count)?;
        Ok(Cycle { positions: self.loaded_cycle(torque, count)?.positions, ..free })
    }

    /// [`ShareLoad::whole_cycle`] without the play.
    ///
    /// # Errors
    /// As there.
    fn loaded_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        let angles: Vec<CrankAngle> =
            (0..count).map(|index| self.crank_position(index, count, 0.0, 0)).collect();
        sample(self, torque, self.pattern_period() * self.pitches() as f64, angles)
    }

    /// The play of [`ShareLoad::whole_cycle`] only, towards the flank that carries `torque`.
    ///
    /// # Errors
    /// [`LoadError`] of the first position without a load-free equilibrium.
    fn free_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        let mut cycle = Cycle::empty(self.pattern_period() * self.pitches() as f64);
        for index in (0..count).step_by(3) {
            let crank = self.crank_position(index, count, 0.0, 0);
            cycle.add_travel(self.travel(crank)?, torque);
        }
        Ok(cycle)
    }
}

/// [`ShareLoad::crank_position`] for a pattern with the period `period` (rad) and a whole state with a period
/// of `pitches` of it.
pub(crate) fn turn_position(
    period: f64,
    pitches: usize,
    index: usize,
    count: usize,
    offset: f64,
    shift: usize,
) -> CrankAngle {
    let whole = (index + shift) % count * pitches / count;
    CrankAngle::from_radians(period * (whole as f64 + (index as f64 + offset) / count as f64))
}

/// Load sharing at the angles, each with the solution before as start value.
fn sample<S: ShareLoad + ?Sized>(
    sharer: &mut S,
    torque: f64,
    period: f64,
    angles: impl IntoIterator<Item = CrankAngle>,
) -> Result<Cycle, LoadError> {
    let mut cycle = Cycle::empty(period);
    let mut start = None;
    for crank in angles {
        let (sharing, found) = sharer.share(crank, torque, start.as_ref())?;
        cycle.positions.push(sharing);
        start = Some(found);
    }
    Ok(cycle)
}

/// Share of rated torque, of both signs, at which lost motion is read: the ±3 % of the makers' definition.
pub const LOST_MOTION_SHARE: f64 = 0.03;

/// Output errors at −3 % minus those at +3 % of rated torque, mean over `positions` crank positions, rad.
/// Without friction both branches of the hysteresis loop coincide, so that the mid-points are on the branch.
///
/// # Errors
/// [`LoadError`] of the first position that has no solution.
pub fn lost_motion<S: ShareLoad>(
    sharer: &mut S,
    rated_torque: f64,
    positions: usize,
) -> Result<OutputAngle, LoadError> {
    let small = LOST_MOTION_SHARE * rated_torque.abs();
    let mut sum = 0.0;
    for sign in [1.0, -1.0] {
        let mut start = None;
        for index in 0..positions {
            let (sharing, found) = sharer.share(
                sharer.crank_position(index, positions, 0.0, 0),
                sign * small,
                start.as_ref(),
            )?;
            sum -= sign * sharing.output_error.radians();
            start = Some(found);
        }
    }
    Ok(OutputAngle::from_radians(sum / positions as f64))
}

impl ShareLoad for Meshing {
    type Start = OutputAngle;

    fn pattern_period(&self) -> f64 {
        self.kinematics().pattern_period()
    }

    fn disc_speed(&self, input_speed: f64) -> f64 {
        self.kinematics().speeds(input_speed).0
    }

    fn contacts(&self) -> &PinContacts {
        Meshing::contacts(self)
    }

    fn twin(&self) -> Self {
        self.clone()
    }

    fn set_relief(&mut self, relief: Relief) {
        Meshing::set_relief(self, relief);
    }

    fn set_pin_relief(&mut self, relief: Relief) {
        Meshing::set_pin_relief(self, relief);
    }

    fn pitches(&self) -> usize {
        1
    }

    fn share(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&OutputAngle>,
    ) -> Result<(LoadSharing, OutputAngle), LoadError> {
        let sharing = match start {
            Some(start) => self.load_sharing_near(crank, torque, *start)?,
            None => self.load_sharing(crank, torque)?,
        };
        let error = sharing.output_error;
        Ok((sharing, error))
    }

    fn travel(&mut self, crank: CrankAngle) -> Result<FreeTravel, LoadError> {
        self.free_travel(crank)
    }

    /// At every position, since the computation is cheap with ideal joints.
    fn free_cycle(&mut self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        let mut cycle = Cycle::empty(self.pattern_period());
        for index in 0..count {
            cycle.add_travel(self.free_travel(self.crank_position(index, count, 0.0, 0))?, torque);
        }
        Ok(cycle)
    }
}

impl LoadSharing {
    /// Moment of the pin forces on a disc about its own centre in N·m: the torque of the disc.
    pub fn disc_moment(&self, disc: usize) -> f64 {
        self.discs
            .get(disc)
            .map_or(0.0, |pins| pins.iter().map(|contact| contact.force * contact.gradient[2]).sum())
    }
}

impl Cycle {
    /// Mean share of a disc in the torque: moment of its pins about its centre over T. With ideal joints and
    /// equal discs all shares are equal, 1/(n (1 + (z_1+z_2)/(z_2 z_c))), or z_c/(n z_p) with a fixed carrier.
    pub fn disc_share(&self, disc: usize) -> f64 {
        // With the carrier at rest the ring carries the torque and the discs its reaction.
        self.positions
            .iter()
            .map(|position| (position.disc_moment(disc) / position.torque).abs())
            .sum::<f64>()
            / self.positions.len().max(1) as f64
    }
}
