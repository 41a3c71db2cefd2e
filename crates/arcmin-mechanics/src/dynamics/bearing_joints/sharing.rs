//! Load sharing with bearings: the static balance of the very model that `simulate` integrates.

mod balance;

pub(super) use self::balance::Known;
use super::labels::CAUSES;
use super::preload::Freed;
use super::{BearingJoints, JointSettings};
use crate::contact::{PinContact, PinContacts};
use crate::dynamics::DynamicsError;
use crate::dynamics::mechanism::Cause;
use crate::geometry::Relief;
use crate::load::{FreeTravel, LOST_MOTION_SHARE, LoadError, LoadSharing, Preload, ShareLoad, turn_position};
use crate::machine::{CrankAngle, Friction, Machine, OutputAngle, OutputForces, PartWear};
use crate::wear::parts;

/// Discs and pins with the whole machine free in its bearings, input locked, friction aside.
///
/// The counterpart of [`Meshing`](crate::load::Meshing): same questions, same answers, forces from
/// [`BearingJoints`] without inertia. The pattern of pins and eccentrics repeats every pin pitch, but the
/// crankshafts stand elsewhere on the carrier then; everything repeats after a turn of the crankshafts
/// against the carrier, z_c pin pitches; with errors of single pins after a turn of the output
/// ([`ManufacturingErrors::crank_turns`](crate::machine::ManufacturingErrors::crank_turns)).
#[derive(Debug, Clone)]
pub struct BearingMeshing {
    pub(super) model: BearingJoints,
    /// Turns of the crankshafts after which everything repeats.
    crank_turns: usize,
    discs_alike: bool,
    /// Deviations of the last balances at no load, lag and lead: where the next ones start.
    loose: [Option<Vec<f64>>; 2],
    /// Speed of the sun in rad/s that friction sees; `None` with friction aside.
    running: Option<f64>,
    /// How exact a balance is, as a share of each coordinate's scale.
    tolerance: f64,
    /// Deviations of balances.
    known: Known<balance::Deviations>,
    /// Prediction of the last balance against the balance found.
    missed: Option<balance::Missed>,
    /// Number of the state of wear, by which what is known is told apart.
    state: usize,
    /// Reliefs that freed a preloaded machine.
    pub(super) freed: Known<Freed>,
}

/// Lost motion and what makes it up, in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostMotionSplit {
    /// Lost motion read from the places of the output, whatever its causes.
    pub whole: f64,
    /// In the order of [`CAUSES`].
    pub causes: [f64; CAUSES.len()],
}

impl LostMotionSplit {
    /// Part with one cause, rad; some causes may take away from the whole.
    pub fn of(&self, cause: Cause) -> f64 {
        CAUSES.iter().zip(self.causes).filter(|(own, _)| **own == cause).map(|(_, part)| part).sum()
    }

    fn add(&mut self, works: &[f64; CAUSES.len()], weight: f64) {
        self.causes.iter_mut().zip(works).for_each(|(sum, work)| *sum += weight * work);
    }

    /// Unexplained remainder: the whole less the sum of the causes.
    pub fn residual(&self) -> f64 {
        self.whole - self.causes.iter().sum::<f64>()
    }
}

/// Torque, as a share of the rated one, at which no-load places are read: at exactly zero the bodies would
/// lie anywhere in their clearance.
const ZERO_SHARE: f64 = 1e-4;
/// 1/ρ with ρ³ = ρ + 1.
const SPREAD: f64 = 0.754_877_666_246_692_8;
impl BearingMeshing {
    /// # Errors
    /// [`DynamicsError`] for a machine with a fixed carrier or values without meaning.
    pub fn new(machine: &Machine, settings: &JointSettings) -> Result<BearingMeshing, DynamicsError> {
        let mut machine = machine.clone();
        machine.friction =
            Friction { regularisation_speed: machine.friction.regularisation_speed, ..Friction::default() };
        BearingMeshing::with_friction(&machine, settings, None)
    }

    /// In steady running at the rated input speed, with the machine's friction at pins, bearings, gears and
    /// seals. Play stays that of the machine without friction.
    ///
    /// # Errors
    /// As [`BearingMeshing::new`].
    pub fn running(machine: &Machine, settings: &JointSettings) -> Result<BearingMeshing, DynamicsError> {
        BearingMeshing::with_friction(machine, settings, Some(machine.rated.input_speed))
    }

    fn with_friction(
        machine: &Machine,
        settings: &JointSettings,
        running: Option<f64>,
    ) -> Result<BearingMeshing, DynamicsError> {
        let model = BearingJoints::held(machine, &JointSettings { damped: false, ..settings.clone() })?;
        let errors = &settings.errors;
        // Forces that stand still in space while discs and crankshafts go round meet every pin in another place, and
        // carry the discs apart.
        let leans = settings.lean.is_some() && machine.duty_tilts();
        let crank_turns = if leans { machine.ring.pin_count } else { errors.crank_turns(machine) };
        let discs_alike = !leans && errors.discs_alike();
        Ok(BearingMeshing {
            model,
            crank_turns,
            discs_alike,
            loose: [None, None],
            running,
            tolerance: balance::TOLERANCE,
            known: Known::nothing(),
            missed: None,
            state: 0,
            freed: Known::nothing(),
        })
    }

    /// The balances of this model hold the loads of the bearings as well.
    pub fn model(&self) -> &BearingJoints {
        &self.model
    }

    /// Rolling elements of a turning-arm bearing in a solution of [`ShareLoad::share`]: direction (rad) from the middle of
    /// the eccentric in the frame of the ring, and radial force (N) on the disc.
    pub fn turning_arm_elements(
        &self,
        crank: CrankAngle,
        solution: &[f64],
        crankshaft: usize,
        disc: usize,
    ) -> Vec<(f64, f64)> {
        let place = self.place(crank, solution);
        // Where the carrier is at rest, the ring is the output.
        let ring = if self.model.layout.housing_moves() { place[self.model.output_index()] } else { 0.0 };
        let mut elements = self.model.turning_arm_elements(crankshaft, disc, &place);
        elements.iter_mut().for_each(|(direction, _)| *direction -= ring);
        elements
    }

    /// Angle of the sun at which the nominal crankshafts stand at this angle against the ring.
    pub(super) fn sun(&self, crank: CrankAngle) -> f64 {
        let kinematics = self.model.kinematics();
        // The output turns by −θ_k/z_c against the ring where it is the carrier, the ring by the opposite of
        // it where that is the output.
        kinematics.ratio().abs() * -crank.radians() / kinematics.lobe_count
    }

    /// Output error of a balance found at this crank angle just before.
    fn error(&self, position: &[f64]) -> OutputAngle {
        OutputAngle::from_radians(self.model.output_error(position))
    }

    /// Lost motion between −3 % and +3 % of rated torque, mean over `positions` crank positions, and what
    /// makes it up. `starts` holds the balances of an earlier call with as many positions, empty at first.
    ///
    /// Under preload the forces of a balance are mostly those that the parts put on each other, whose works on
    /// gaps and on elastic approaches cancel. So the causes of the load-free balance, which add up to nothing,
    /// are taken off those of either side: what is left is the work of what the load changes.
    ///
    /// # Errors
    /// [`LoadError`] where no balance is found.
    pub fn lost_motion_causes(
        &mut self,
        positions: usize,
        starts: &mut Vec<Vec<f64>>,
    ) -> Result<LostMotionSplit, LoadError> {
        let small = LOST_MOTION_SHARE * self.model.rated;
        let mut split = LostMotionSplit { whole: 0.0, causes: [0.0; CAUSES.len()] };
        let per_position = 1.0 / (small * positions as f64);
        split.whole = self.lightly_loaded(positions, starts, |model, position| {
            split.add(&model.causes(position), per_position);
        })?;
        for index in 0..positions {
            let crank = self.crank_position(index, positions, 0.0, 0);
            let ends = [&starts[index], &starts[positions + index]];
            if let Some((position, _)) = self.load_free(crank, ends, small)? {
                split.add(&self.model.causes(&position), -2.0 * per_position);
            }
        }
        Ok(split)
    }

    /// Lost motion in rad as [`BearingMeshing::lost_motion_causes`] has it, without its causes, which take as long again.
    ///
    /// # Errors
    /// [`LoadError`] where no balance is found.
    pub fn lost_motion(&mut self, positions: usize) -> Result<f64, LoadError> {
        self.lightly_loaded(positions, &mut Vec::new(), |_, _| ())
    }

    /// Output errors at −3 % minus those at +3 % of rated torque in rad, mean over the positions; `see` is shown every
    /// balance. `starts` as in [`BearingMeshing::lost_motion_causes`].
    fn lightly_loaded(
        &mut self,
        positions: usize,
        starts: &mut Vec<Vec<f64>>,
        mut see: impl FnMut(&BearingJoints, &[f64]),
    ) -> Result<f64, LoadError> {
        let small = LOST_MOTION_SHARE * self.model.rated;
        let mut whole = 0.0;
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            for index in 0..positions {
                let crank = self.crank_position(index, positions, 0.0, 0);
                let slot = side * positions + index;
                let start =
                    starts.get(slot).or_else(|| starts.get(slot.wrapping_sub(1)).filter(|_| index > 0));
                let (position, _) = self.balance_again(crank, sign * small, start.map(Vec::as_slice))?;
                whole -= sign * self.model.output_error(&position) / positions as f64;
                see(&self.model, &position);
                let deviation = self.deviation(crank, &position);
                if slot < starts.len() {
                    starts[slot] = deviation;
                } else {
                    starts.push(deviation);
                }
            }
        }
        Ok(whole)
    }

    /// Rates at which the wear laws of the machine let bearings and gears lose metal at its duty, mean over
    /// `positions` crank positions; in m/s. Zero without laws.
    ///
    /// # Errors
    /// [`LoadError`] where no balance is found.
    pub fn part_wear_rates(&mut self, machine: &Machine, positions: usize) -> Result<PartWear, LoadError> {
        let mut rates = PartWear::default();
        if !machine.wear.parts.any() {
            return Ok(rates);
        }
        let kinematics = machine.kinematics();
        for duty in machine.duty.iter().filter(|duty| duty.wears()) {
            if machine.duty_tilts() {
                self.model.set_output_forces(duty.forces);
            }
            let (output, _, relative) = kinematics.speeds(duty.input_speed);
            // Sun and planets against the carrier.
            let speeds = [output * (kinematics.housing_fixed_ratio() - 1.0), relative];
            let mut start: Option<Vec<f64>> = None;
            for index in 0..positions {
                let crank = self.crank_position(index, positions, 0.0, 0);
                let (position, _) = self.balance_again(crank, duty.torque, start.as_deref())?;
                let loads = self.model.part_loads(&position);
                rates = rates
                    .plus(&parts::rates(machine, &loads, relative, speeds), duty.share / positions as f64);
                start = Some(self.deviation(crank, &position));
            }
        }
        if machine.duty_tilts() {
            self.model.set_output_forces(OutputForces::default());
        }
        Ok(rates)
    }

    /// Coordinates of a deviation from the nominal machine, seen from its carrier.
    pub(super) fn place(&self, crank: CrankAngle, deviation: &[f64]) -> Vec<f64> {
        let mut deviation = deviation.to_vec();
        self.turn(&mut deviation, self.carrier_angle(crank));
        let nominal = self.model.nominal_position_at(self.sun(crank));
        nominal.iter().zip(&deviation).map(|(n, d)| n + d).collect()
    }

    pub(super) fn deviation(&self, crank: CrankAngle, position: &[f64]) -> Vec<f64> {
        let mut deviation: Vec<f64> = position
            .iter()
            .zip(self.model.nominal_position_at(self.sun(crank)))
            .map(|(q, n)| q - n)
            .collect();
        self.turn(&mut deviation, -self.carrier_angle(crank));
        deviation
    }

    /// Angle of the carrier in the frame of the coordinates: what the crankshafts do at one place of the ring
    /// they do at all of them.
    fn carrier_angle(&self, crank: CrankAngle) -> f64 {
        if self.model.layout.housing_moves() {
            0.0
        } else {
            -crank.radians() / self.model.kinematics().lobe_count
        }
    }

    fn turn(&self, deviation: &mut [f64], angle: f64) {
        self.model.turn_ways(deviation, angle);
    }
}

impl ShareLoad for BearingMeshing {
    type Start = Vec<f64>;

    fn pattern_period(&self) -> f64 {
        self.model.kinematics().pattern_period()
    }

    fn disc_speed(&self, input_speed: f64) -> f64 {
        self.model.kinematics().speeds(input_speed).0
    }

    fn contacts(&self) -> &PinContacts {
        &self.model.rings[0].contacts
    }

    fn set_relief(&mut self, relief: Relief) {
        self.state += 1;
        for ring in &mut self.model.rings {
            ring.contacts.set_relief(relief.clone());
        }
    }

    fn set_pin_relief(&mut self, relief: Relief) {
        self.state += 1;
        for ring in &mut self.model.rings {
            ring.contacts.set_pin_relief(relief.clone());
        }
    }

    fn set_surfaces(&mut self, flanks: Vec<Relief>, pins: Vec<Relief>) {
        self.state += 1;
        self.model.set_surfaces(&flanks, &pins);
    }

    fn set_part_wear(&mut self, wear: &PartWear) {
        self.state += 1;
        self.model.set_part_wear(*wear);
    }

    fn set_output_forces(&mut self, forces: OutputForces) {
        self.model.set_output_forces(forces);
    }

    fn pitches(&self) -> usize {
        self.crank_turns * self.model.kinematics().lobe_count as usize
    }

    fn discs_alike(&self) -> bool {
        self.discs_alike
    }

    fn crank_position(&self, index: usize, count: usize, offset: f64, shift: usize) -> CrankAngle {
        let kinematics = self.model.kinematics();
        let within = turn_position(
            kinematics.pattern_period(),
            kinematics.lobe_count as usize,
            index,
            count,
            offset,
            shift,
        );
        // Which turn of the crankshafts: spread over all of them by a number that is far from any fraction
        // (R2 sequence), so that neither the places within a turn nor the updates of a wear computation
        // (whose offsets go by the golden section) keep meeting the same pins.
        let turn = ((index as f64 * SPREAD + 7.0 * offset).fract() * self.crank_turns as f64).floor();
        CrankAngle::from_radians(
            within.radians() + turn * kinematics.lobe_count * kinematics.pattern_period(),
        )
    }

    /// An output that nothing holds has the stiffness 0.
    fn share(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Vec<f64>>,
    ) -> Result<(LoadSharing, Vec<f64>), LoadError> {
        let (position, residual) = self.balance_again(crank, torque, start.map(Vec::as_slice))?;
        let discs = self.model.all_pin_contacts(&position);
        let sharing = LoadSharing {
            crank_angle: crank,
            torque,
            output_error: self.error(&position),
            residual,
            stiffness: None,
            discs,
        };
        Ok((sharing, self.deviation(crank, &position)))
    }

    fn stiffness(&mut self, sharing: &LoadSharing) -> f64 {
        let LoadSharing { crank_angle, torque, .. } = *sharing;
        let Ok((position, _)) = self.balance_again(crank_angle, torque, None) else { return 0.0 };
        let motion = self.model.motion_per_torque(&position);
        motion.map_or(0.0, |motion| 1.0 / motion[self.model.output_index()])
    }

    /// Nothing is kept: wear never comes back to a place. Nor does it ask for more than forces to some 1e-5.
    fn pin_contacts(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Vec<f64>>,
    ) -> Result<(Vec<Vec<PinContact>>, Vec<f64>), LoadError> {
        let usual = std::mem::replace(&mut self.tolerance, balance::WEAR_TOLERANCE);
        let found = self.balance_from_afar(crank, torque, start.map(Vec::as_slice));
        self.tolerance = usual;
        let (position, _) = found?;
        Ok((self.model.all_pin_contacts(&position), self.deviation(crank, &position)))
    }

    /// Knows nothing of what was found before.
    fn twin(&self) -> Self {
        BearingMeshing {
            model: self.model.clone(),
            loose: [None, None],
            known: Known::nothing(),
            missed: None,
            freed: Known::nothing(),
            ..*self
        }
    }

    /// Read at ±1e-4 of rated torque. Where a machine with errors, so tight that its pins press without load,
    /// leaves no balance there, at ±1e-3, and within 2e-3 of rated torque if need be: some 0.005'. Where the
    /// pins press without load, the relief of all flanks that would just free them is taken off, as an angle.
    fn travel(&mut self, crank: CrankAngle) -> Result<FreeTravel, LoadError> {
        if let Some(speed) = self.running.take() {
            let smooth = self.model.with_friction(0.0);
            let rough = std::mem::replace(&mut self.model, smooth);
            let travel = self.travel(crank);
            (self.model, self.running) = (rough, Some(speed));
            return travel;
        }
        let small = ZERO_SHARE * self.model.rated;
        let mut ends = [0.0; 2];
        let mut deviations = [Vec::new(), Vec::new()];
        let pressed = self.still_pressed(crank, small)?;
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let start = match &pressed {
                Some((position, _)) => Some(self.deviation(crank, position)),
                None => self.loose[side].take(),
            };
            let (position, _) = self.balance_again(crank, sign * small, start.as_deref())?;
            ends[side] = self.model.output_error(&position);
            deviations[side] = self.deviation(crank, &position);
        }
        let mut missing = 0.0;
        let mut preload = Preload::default();
        let [lag, lead] = &deviations;
        let pressed = match pressed {
            None => self.load_free(crank, [lag, lead], small)?,
            pressed => pressed,
        };
        if let Some((position, found)) = pressed {
            let deviation = self.deviation(crank, &position);
            (missing, preload) = (self.freeing_relief(crank, &deviation, found, small)?, found);
        }
        self.loose = deviations.map(Some);
        let kinematics = self.model.kinematics();
        let angle =
            missing * kinematics.locked_play_factor() / (kinematics.eccentricity * kinematics.lobe_count);
        Ok(FreeTravel {
            lag: OutputAngle::from_radians(ends[0] + angle),
            lead: OutputAngle::from_radians(ends[1] - angle),
            preload,
        })
    }
}

#[cfg(test)]
mod tests;
