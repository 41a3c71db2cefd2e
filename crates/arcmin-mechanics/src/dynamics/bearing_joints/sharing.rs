//! Load sharing with bearings: static equilibrium of the same model that `simulate` integrates.

mod balance;

pub(super) use self::balance::KnownPositions;
use super::labels::CAUSES;
use super::preload::ReliefWithoutLoad;
use super::{BearingJoints, JointSettings};
use crate::contact::{PinContact, PinContacts};
use crate::dynamics::DynamicsError;
use crate::dynamics::mechanism::Cause;
use crate::dynamics::statics::WEAR_TOLERANCE;
use crate::geometry::Relief;
use crate::load::{FreeTravel, LOST_MOTION_SHARE, LoadError, LoadSharing, Preload, ShareLoad, turn_position};
use crate::machine::{CrankAngle, Friction, Machine, OutputAngle, OutputForces, PartWear};
use crate::wear::parts;

/// Discs and pins with all bodies free in their bearings, with locked input and without friction.
///
/// The counterpart of [`Meshing`](crate::load::Meshing) with the same interface, with forces from
/// [`BearingJoints`] without inertia. The pattern of pins and eccentrics repeats every pin pitch, but with
/// other positions of the crankshafts on the carrier. All positions repeat after a turn of the crankshafts
/// relative to the carrier, z_c pin pitches; with errors of single pins after a turn of the output
/// ([`ManufacturingErrors::crank_turns`](crate::machine::ManufacturingErrors::crank_turns)).
#[derive(Debug, Clone)]
pub struct BearingMeshing {
    pub(super) model: BearingJoints,
    /// Turns of the crankshafts after which all positions repeat.
    crank_turns: usize,
    discs_alike: bool,
    /// Deviations of the last no-load equilibria, lag and lead, from which the next ones start.
    loose: [Option<Vec<f64>>; 2],
    /// Speed of the sun in rad/s for friction; `None` without friction.
    running: Option<f64>,
    /// Tolerance of an equilibrium relative to each coordinate's scale.
    tolerance: f64,
    /// Deviations of equilibria.
    known: KnownPositions<balance::Deviations>,
    /// Difference between the last predicted and the actual equilibrium.
    prediction_error: Option<balance::PredictionError>,
    /// Number of the state of wear, which distinguishes stored results.
    state: usize,
    /// Reliefs that remove the load of a preloaded machine.
    pub(super) freed: KnownPositions<ReliefWithoutLoad>,
}

/// Lost motion and its causes, in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostMotionSplit {
    /// Lost motion from the output positions, independent of the causes.
    pub whole: f64,
    /// Contributions in the order of [`CAUSES`].
    pub causes: [f64; CAUSES.len()],
}

impl LostMotionSplit {
    /// Contribution of one cause, rad; it may be negative.
    pub fn of(&self, cause: Cause) -> f64 {
        CAUSES.iter().zip(self.causes).filter(|(own, _)| **own == cause).map(|(_, part)| part).sum()
    }

    fn add(&mut self, works: &[f64; CAUSES.len()], weight: f64) {
        self.causes.iter_mut().zip(works).for_each(|(sum, work)| *sum += weight * work);
    }

    /// Unexplained remainder in rad: the whole less the sum of the causes.
    pub fn residual(&self) -> f64 {
        self.whole - self.causes.iter().sum::<f64>()
    }
}

/// Torque at which no-load positions are computed, relative to the rated one: at exactly zero the positions of
/// the bodies within their clearances would be arbitrary.
const ZERO_SHARE: f64 = 1e-4;
/// 1/ρ with ρ³ = ρ + 1.
const INVERSE_PLASTIC_NUMBER: f64 = 0.754_877_666_246_692_8;
impl BearingMeshing {
    /// # Errors
    /// [`DynamicsError`] for a machine with a fixed carrier or values outside of their ranges.
    pub fn new(machine: &Machine, settings: &JointSettings) -> Result<BearingMeshing, DynamicsError> {
        let mut machine = machine.clone();
        machine.friction =
            Friction { regularisation_speed: machine.friction.regularisation_speed, ..Friction::default() };
        BearingMeshing::with_friction(&machine, settings, None)
    }

    /// For steady running at the rated input speed, with the machine's friction at pins, bearings, gears and
    /// seals. Backlash remains that of the machine without friction.
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
        // Forces fixed in space act on every pin in a different position while discs and crankshafts rotate,
        // and load the discs differently.
        let tilts = settings.tilt.is_some() && machine.duty_tilts();
        let crank_turns = if tilts { machine.ring.pin_count } else { errors.crank_turns(machine) };
        let discs_alike = !tilts && errors.discs_alike();
        Ok(BearingMeshing {
            model,
            crank_turns,
            discs_alike,
            loose: [None, None],
            running,
            tolerance: balance::TOLERANCE,
            known: KnownPositions::new(),
            prediction_error: None,
            state: 0,
            freed: KnownPositions::new(),
        })
    }

    /// The model of these equilibria, which also has the loads of the bearings.
    pub fn model(&self) -> &BearingJoints {
        &self.model
    }

    /// Rolling elements of a turning-arm bearing in a solution of [`ShareLoad::share`]: direction (rad) from
    /// the centre of the eccentric in the frame of the ring, and radial force (N) on the disc.
    pub fn turning_arm_elements(
        &self,
        crank: CrankAngle,
        solution: &[f64],
        crankshaft: usize,
        disc: usize,
    ) -> Vec<(f64, f64)> {
        let place = self.place(crank, solution);
        // If the carrier is fixed, the ring is the output.
        let ring = if self.model.layout.housing_moves() { place[self.model.output_index()] } else { 0.0 };
        let mut elements = self.model.turning_arm_elements(crankshaft, disc, &place);
        elements.iter_mut().for_each(|(direction, _)| *direction -= ring);
        elements
    }

    /// Angle of the sun at which the nominal crankshafts have this angle relative to the ring.
    pub(super) fn sun(&self, crank: CrankAngle) -> f64 {
        let kinematics = self.model.kinematics();
        // If the carrier is the output it rotates by −θ_k/z_c relative to the ring; if the ring is the output,
        // it rotates by the opposite relative to the carrier.
        kinematics.ratio().abs() * -crank.radians() / kinematics.lobe_count
    }

    /// Output error of an equilibrium just computed at this crank angle.
    fn error(&self, position: &[f64]) -> OutputAngle {
        OutputAngle::from_radians(self.model.output_error(position))
    }

    /// Lost motion between −3 % and +3 % of rated torque, mean over `positions` crank positions, with its
    /// causes. `starts` contains the equilibria of an earlier call with the same number of positions, or is
    /// empty.
    ///
    /// Under preload, the forces in equilibrium are mostly internal ones, whose works on gaps and on elastic
    /// approaches cancel. Therefore the causes of the no-load equilibrium, whose sum is zero, are subtracted
    /// from those of either side; the remainder is the work of the changes by the load.
    ///
    /// # Errors
    /// [`LoadError`] if an equilibrium is not found.
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

    /// Lost motion in rad as in [`BearingMeshing::lost_motion_causes`], without its causes, whose computation
    /// takes as long again.
    ///
    /// # Errors
    /// [`LoadError`] if an equilibrium is not found.
    pub fn lost_motion(&mut self, positions: usize) -> Result<f64, LoadError> {
        self.lightly_loaded(positions, &mut Vec::new(), |_, _| ())
    }

    /// Output errors at −3 % minus those at +3 % of rated torque in rad, mean over the positions; `visit` is
    /// called with every equilibrium. `starts` as in [`BearingMeshing::lost_motion_causes`].
    fn lightly_loaded(
        &mut self,
        positions: usize,
        starts: &mut Vec<Vec<f64>>,
        mut visit: impl FnMut(&BearingJoints, &[f64]),
    ) -> Result<f64, LoadError> {
        let small = LOST_MOTION_SHARE * self.model.rated;
        let mut whole = 0.0;
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            for index in 0..positions {
                let crank = self.crank_position(index, positions, 0.0, 0);
                let slot = side * positions + index;
                let start =
                    starts.get(slot).or_else(|| starts.get(slot.wrapping_sub(1)).filter(|_| index > 0));
                let (position, _) = self.balance_from_last(crank, sign * small, start.map(Vec::as_slice))?;
                whole -= sign * self.model.output_error(&position) / positions as f64;
                visit(&self.model, &position);
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

    /// Wear rates of bearings and gears by the machine's wear laws at its duty, mean over `positions` crank
    /// positions; in m/s. Zero without laws.
    ///
    /// # Errors
    /// [`LoadError`] if an equilibrium is not found.
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
            // Sun and planets relative to the carrier.
            let speeds = [output * (kinematics.housing_fixed_ratio() - 1.0), relative];
            let mut start: Option<Vec<f64>> = None;
            for index in 0..positions {
                let crank = self.crank_position(index, positions, 0.0, 0);
                let (position, _) = self.balance_from_last(crank, duty.torque, start.as_deref())?;
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

    /// Coordinates of a deviation from the nominal machine, given in the frame of its carrier.
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

    /// Angle of the carrier in the frame of the coordinates: the crankshafts are in the same state at all equal
    /// positions of the ring.
    fn carrier_angle(&self, crank: CrankAngle) -> f64 {
        if self.model.layout.housing_moves() {
            0.0
        } else {
            -crank.radians() / self.model.kinematics().lobe_count
        }
    }

    fn turn(&self, deviation: &mut [f64], angle: f64) {
        self.model.rotate_displacements(deviation, angle);
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
        // Number of the turn of the crankshafts: distributed over all turns by an irrational number (R2
        // sequence), so that neither the positions within a turn nor the updates of a wear computation (whose
        // offsets follow the golden section) are repeatedly at the same pins.
        let turn = ((index as f64 * INVERSE_PLASTIC_NUMBER + 7.0 * offset).fract() * self.crank_turns as f64)
            .floor();
        CrankAngle::from_radians(
            within.radians() + turn * kinematics.lobe_count * kinematics.pattern_period(),
        )
    }

    /// An output without stiffness has the stiffness 0.
    fn share(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Vec<f64>>,
    ) -> Result<(LoadSharing, Vec<f64>), LoadError> {
        let (position, residual) = self.balance_from_last(crank, torque, start.map(Vec::as_slice))?;
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
        let Ok((position, _)) = self.balance_from_last(crank_angle, torque, None) else { return 0.0 };
        let motion = self.model.motion_per_torque(&position);
        motion.map_or(0.0, |motion| 1.0 / motion[self.model.output_index()])
    }

    /// Nothing is stored, because wear does not return to a position.
    fn pin_contacts(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&Vec<f64>>,
    ) -> Result<(Vec<Vec<PinContact>>, Vec<f64>), LoadError> {
        let usual = std::mem::replace(&mut self.tolerance, WEAR_TOLERANCE);
        let found = self.balance_from_afar(crank, torque, start.map(Vec::as_slice));
        self.tolerance = usual;
        let (position, _) = found?;
        Ok((self.model.all_pin_contacts(&position), self.deviation(crank, &position)))
    }

    /// The copy has no stored results.
    fn twin(&self) -> Self {
        BearingMeshing {
            model: self.model.clone(),
            loose: [None, None],
            known: KnownPositions::new(),
            prediction_error: None,
            freed: KnownPositions::new(),
            ..*self
        }
    }

    /// Computed at ±1e-4 of rated torque. If a machine with errors and preloaded pins has no equilibrium there,
    /// at ±1e-3, and if necessary at 2e-3 of rated torque: about 0.005'. If pins are loaded without torque, the
    /// relief of all flanks that removes this load, as an angle, is subtracted.
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
        let pressed = self.loaded_equilibrium(crank, small)?;
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let start = match &pressed {
                Some((position, _)) => Some(self.deviation(crank, position)),
                None => self.loose[side].take(),
            };
            let (position, _) = self.balance_from_last(crank, sign * small, start.as_deref())?;
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
