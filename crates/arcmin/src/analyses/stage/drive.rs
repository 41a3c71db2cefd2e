//! What analyses ask a drive of eccentrics, discs and rings of pins, whatever its family.

use std::f64::consts::TAU;

use super::AnyDesign;
use super::findings;
use super::keys::{OfParts, SINGLE, StageKeys, TWO_RING, TWO_STAGE};
use super::made::{Made, MadeOptions, MadePlay};
use super::meshing::{self, LoadedRing, OfRing, WearingRing};
use crate::analyses::AnalysisError;
use crate::checks::Finding;
use crate::contact::{Damping, LineContact};
use crate::design::{Family, StageDesign, TwoRingDesign, TwoStageDesign};
use crate::dynamics::{DynamicsError, EccentricJoints, HeldDrive, StageLosses, StageMeshing};
use crate::exchange::{JointInertia, Stamp};
use crate::life::{Beside, Seen};
use crate::machine::{
    DutyPoint, GapChain, Limits, Overlap, PlayChain, RingMesh, SingleStage, StageFriction, TwoStage, Wear,
    gcd,
};
use crate::progress::Progress;
use crate::scene::{self, Scene};
use crate::units::MM;

fn output_law(stage: &SingleStage) -> Option<(LineContact, f64)> {
    Some((stage.output_contact, stage.output_pins.equivalent_radius(stage.profile.eccentricity)))
}

/// Output work over input work, and the other way with the output driving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Efficiency {
    pub forward: f64,
    /// At zero and below the drive holds by itself.
    pub backward: f64,
}

impl Efficiency {
    /// With what is lost over the work of the output: as much is lost backwards.
    pub fn of(lost: f64) -> Efficiency {
        Efficiency { forward: 1.0 / (1.0 + lost), backward: 1.0 - lost }
    }
}

/// A drive as contact, bench and checks ask it. Torques in N·m and angles in rad are those at the output.
pub trait EccentricDrive: Sized + 'static {
    const FAMILY: Family;
    /// Its stages from the input.
    const STAGES: &'static [StageKeys];
    /// Whether drives of the family have manufacturing errors.
    const IS_DRAWN: bool = false;

    /// A design of any family, and the design in one where it is of this family.
    fn any(&self) -> AnyDesign;
    fn of_any(any: &AnyDesign) -> Option<&Self>;
    fn name(&self) -> &str;
    fn ratio(&self) -> f64;
    fn text(&self) -> &str;
    fn rated(&self) -> DutyPoint;
    /// Load spectrum.
    fn duty_points(&self) -> Vec<DutyPoint>;
    /// Where the file gives it.
    fn wear(&self) -> Option<&Wear>;
    fn limits(&self) -> Limits;
    /// The drive as solids that move.
    fn scene(&self) -> Scene;
    /// Flanks in their rings, stage by stage.
    fn meshes(&self) -> Vec<RingMesh>;
    /// Of output pins in holes, with the equivalent radius in m.
    fn output_laws(&self) -> Vec<Option<(LineContact, f64)>>;
    /// As [`check_design`](crate::checks::check_design).
    fn findings(&self) -> Vec<Finding>;

    /// Coefficients of friction stage by stage, and whether they are assumed.
    fn friction(&self) -> (Vec<StageFriction>, bool);

    /// Turns of the input after which an answer begins again: those in which all eccentrics go round, or, with errors of single
    /// pins and lobes, those of a turn of the output.
    fn turns(&self) -> usize {
        1
    }

    /// Angles (rad) of the input, evenly over these turns. Where there are several, their number is the next from `positions` on
    /// that has no divisor in common with them and with the pins of the first ring: else that ring would always be seen in the
    /// same few places.
    fn angles(&self, positions: usize) -> Vec<f64> {
        let turns = self.turns();
        let period = if turns > 1 { turns * self.meshes()[0].profile.pin_count } else { 1 };
        let count = (positions..).find(|count| gcd(*count, period) == 1);
        let count = count.unwrap_or(positions);
        (0..count).map(|step| TAU * turns as f64 * step as f64 / count as f64).collect()
    }

    /// Two-sided play by part, input held.
    fn play(&self) -> Vec<OfParts>;

    /// Largest forces in N with equal springs.
    fn closed_forms(&self, torque: f64) -> Vec<OfParts>;

    /// Of first order: with what friction takes of the forces without friction under a torque.
    fn efficiency(&self, torque: f64, losses: &[StageLosses]) -> Efficiency {
        let lost: f64 = losses.iter().map(StageLosses::total).sum();
        Efficiency::of(self.ratio().abs() * lost / torque.abs())
    }

    /// The new drive.
    ///
    /// # Errors
    /// [`AnalysisError`] for values without meaning.
    fn new_drive(&self) -> Result<HeldDrive, AnalysisError>;

    /// The rings of the new drive.
    ///
    /// # Errors
    /// [`AnalysisError`] for values without meaning.
    fn rings(&self) -> Result<Vec<LoadedRing<'_>>, AnalysisError>;

    /// The rings of the new drive as their wear sees them.
    ///
    /// # Errors
    /// As [`rings`](EccentricDrive::rings); [`AnalysisError::Usage`] where the design gives no wear.
    fn wearing_rings(&self) -> Result<Vec<WearingRing>, AnalysisError> {
        let wearing = |LoadedRing { of, meshing, beside, seen, passes }: LoadedRing<'_>| {
            Ok(WearingRing { case: meshing::wear_case(self, of)?, meshing, beside, seen, passes })
        };
        self.rings()?.into_iter().map(wearing).collect()
    }

    /// The drive after some hours of its duty.
    ///
    /// # Errors
    /// [`AnalysisError`] for values without meaning, and where the design gives no wear.
    fn held(&self, hours: f64, progress: &dyn Progress) -> Result<HeldDrive, AnalysisError> {
        let mut held = self.new_drive()?;
        meshing::wear_down(self, hours, progress, |stage, surfaces, parts| {
            held.put_on(stage, surfaces, parts)
        })?;
        Ok(held)
    }

    /// The new drive as it moves: with its fixed member at rest.
    ///
    /// # Errors
    /// As [`EccentricDrive::new_drive`].
    fn moving(&self) -> Result<EccentricJoints, AnalysisError>;

    /// Damping of ring pins on flanks.
    fn contact_damping(&self) -> Damping;

    /// The drive with the errors that the options ask for.
    ///
    /// # Errors
    /// [`AnalysisError::Usage`] where there are none.
    fn as_made(&self, options: &MadeOptions, hours: f64) -> Result<Made<Self>, AnalysisError>;

    /// Play of drives drawn from the tolerances; `None` where there are none.
    fn made_play(&self) -> Option<MadePlay> {
        None
    }

    /// Least play over a turn of the output by the gaps of every pin, rad; `None` where the drive jams, and where it is not
    /// computed.
    fn gap_play(&self) -> Option<f64> {
        None
    }

    /// By how much a drive that jams overlaps; `None` for others, and where it is not computed.
    fn overlap(&self) -> Option<Overlap> {
        None
    }

    /// Whether the ring carries the output while the output pins are at rest.
    fn is_driven_housing(&self) -> bool {
        false
    }

    /// Turns of the input against the ring for one of the output.
    fn turns_against_ring(&self) -> f64 {
        if self.is_driven_housing() { self.ratio() - 1.0 } else { self.ratio() }
    }

    /// Waves of the error in a turn of the output of which all others are multiples: after a turn by their part eccentrics, pins and
    /// discs stand as before, seen from the output.
    fn order(&self) -> f64;

    /// Name and hash of the design.
    fn stamp(&self) -> Stamp;

    /// Masses and moments of inertia. Shaft and motor have none, and the output is taken as a plain body of steel: the design
    /// gives neither.
    fn inertia(&self) -> JointInertia;
}

/// Of discs that go round on an eccentric (m) and turn by so much per turn of it: n (m e² + I w²), seen from the eccentric.
fn discs_inertia(count: usize, (mass, inertia): (f64, f64), eccentricity: f64, turns: f64) -> f64 {
    count as f64 * (mass * eccentricity * eccentricity + inertia * turns * turns)
}

fn joint_inertia(gear: f64, gear_mass: f64, (output_kg, output_kg_m2): (f64, f64)) -> JointInertia {
    JointInertia {
        motor_kg_m2: 0.0,
        sun_kg_m2: 0.0,
        gear_kg_m2: gear,
        output_kg_m2,
        output_kg,
        gear_kg: gear_mass,
    }
}

fn parts_of(play: PlayChain) -> OfParts {
    [play.ring, play.output, play.eccentric_bearing]
}

fn closed_forms_of(stage: &SingleStage, torque: f64) -> OfParts {
    [stage.ring_force(torque), stage.output_pin_force(torque), stage.eccentric_force(torque)]
}

fn held(
    joints: Result<EccentricJoints, DynamicsError>,
    rated: f64,
    seen_from_ring: f64,
) -> Result<HeldDrive, AnalysisError> {
    let joints = joints.map_err(AnalysisError::compute(BUILD))?;
    Ok(HeldDrive::new(joints, rated, seen_from_ring))
}

const BUILD: &str = "build the drive from its design";

/// What the design files of all families give in the same words.
macro_rules! of_file {
    ($Design:ident, $Variant:ident) => {
        fn any(&self) -> AnyDesign {
            AnyDesign::$Variant(Box::new(self.clone()))
        }

        fn of_any(any: &AnyDesign) -> Option<&$Design> {
            match any {
                AnyDesign::$Variant(design) => Some(design),
                _ => None,
            }
        }

        fn name(&self) -> &str {
            &self.name
        }

        fn text(&self) -> &str {
            $Design::text(self)
        }

        fn rated(&self) -> DutyPoint {
            $Design::rated(self)
        }

        fn duty_points(&self) -> Vec<DutyPoint> {
            $Design::duty_points(self)
        }

        fn wear(&self) -> Option<&Wear> {
            $Design::wear(self)
        }

        fn limits(&self) -> Limits {
            $Design::limits(self)
        }

        fn contact_damping(&self) -> Damping {
            $Design::contact_damping(self)
        }

        fn stamp(&self) -> Stamp {
            Stamp::named(&self.name, &self.hash())
        }
    };
}

impl EccentricDrive for StageDesign {
    const FAMILY: Family = Family::Eccentric;
    const STAGES: &'static [StageKeys] = &SINGLE;
    const IS_DRAWN: bool = true;

    of_file! { StageDesign, Eccentric }

    fn scene(&self) -> Scene {
        scene::of_stage(self)
    }

    fn ratio(&self) -> f64 {
        StageDesign::ratio(self)
    }

    fn meshes(&self) -> Vec<RingMesh> {
        vec![self.stage().mesh.clone()]
    }

    fn output_laws(&self) -> Vec<Option<(LineContact, f64)>> {
        vec![output_law(self.stage())]
    }

    fn findings(&self) -> Vec<Finding> {
        findings::findings(self)
    }

    fn friction(&self) -> (Vec<StageFriction>, bool) {
        let (friction, assumed) = StageDesign::friction(self);
        (vec![friction], assumed)
    }

    fn play(&self) -> Vec<OfParts> {
        vec![parts_of(self.play_chain())]
    }

    fn closed_forms(&self, torque: f64) -> Vec<OfParts> {
        vec![closed_forms_of(self.stage(), torque * self.seen_from_ring())]
    }

    /// Losses are those seen from the ring: η = T/(T + z_c M), the same with the ring turning.
    fn efficiency(&self, torque: f64, losses: &[StageLosses]) -> Efficiency {
        Efficiency::of(self.stage().ratio().abs() * losses[0].total() / torque.abs())
    }

    fn new_drive(&self) -> Result<HeldDrive, AnalysisError> {
        held(self.stage().joints(), self.rated().torque, self.seen_from_ring())
    }

    fn moving(&self) -> Result<EccentricJoints, AnalysisError> {
        let stage = self.stage();
        let joints = if self.is_driven_housing() { stage.driven_housing() } else { stage.joints() };
        joints.map_err(AnalysisError::compute(BUILD))
    }

    fn rings(&self) -> Result<Vec<LoadedRing<'_>>, AnalysisError> {
        let (stage, seen_from_ring) = (self.stage(), self.seen_from_ring());
        let meshing = StageMeshing::new(stage, self.rated().torque, seen_from_ring);
        let beside = meshing::beside(stage, self.has_rollers());
        Ok(vec![LoadedRing {
            of: OfRing {
                mesh: &stage.mesh,
                discs: stage.phases.len(),
                width: *self.disc.width_mm * MM,
                pin_mounting: *self.ring.pin_mounting,
                friction: StageDesign::friction(self).0.ring,
                torque: 1.0,
                speed: 1.0,
                largest_force: Box::new(move |torque| stage.ring_force(torque * seen_from_ring)),
                error: 1.0,
            },
            meshing: meshing.map_err(AnalysisError::compute(BUILD))?,
            // The input is held to what is at rest.
            beside: Beside { turns: self.eccentric_turns(), ..beside },
            seen: Seen::ALONE,
            passes: self.eccentric_turns(),
        }])
    }

    fn is_driven_housing(&self) -> bool {
        StageDesign::is_driven_housing(self)
    }

    fn as_made(&self, options: &MadeOptions, hours: f64) -> Result<Made<StageDesign>, AnalysisError> {
        Made::of(self, options, hours)
    }

    fn made_play(&self) -> Option<MadePlay> {
        MadePlay::of(self)
    }

    fn turns(&self) -> usize {
        if self.stage().errors.is_even() { 1 } else { self.stage().profile.lobe_count() }
    }

    /// So many for every turn of the input: each meets other pins.
    fn angles(&self, positions: usize) -> Vec<f64> {
        (0..self.turns() * positions).map(|step| TAU * step as f64 / positions as f64).collect()
    }

    /// The next ring pin stands where the one before stood; with errors of single parts all of them have passed.
    fn order(&self) -> f64 {
        if self.stage().errors.is_even() { self.stage().profile.pin_count as f64 } else { 1.0 }
    }

    fn inertia(&self) -> JointInertia {
        let stage = self.stage();
        let (count, e) = (stage.phases.len(), stage.profile.eccentricity);
        // With the output at rest the discs do not turn.
        let (turns, output) = match self.is_driven_housing() {
            true => (0.0, stage.ring_body),
            false => (1.0 / stage.ratio(), stage.output),
        };
        joint_inertia(discs_inertia(count, stage.disc, e, turns), count as f64 * stage.disc.0, output)
    }

    fn overlap(&self) -> Option<Overlap> {
        GapChain::new(self.stage()).overlap(&self.stage().errors)
    }

    fn gap_play(&self) -> Option<f64> {
        let stage = self.stage();
        GapChain::new(stage).least(&stage.errors).map(|play| play * self.seen_from_ring())
    }
}

impl EccentricDrive for TwoRingDesign {
    const FAMILY: Family = Family::TwoRing;
    const STAGES: &'static [StageKeys] = &TWO_RING;

    of_file! { TwoRingDesign, TwoRing }

    fn scene(&self) -> Scene {
        scene::of_two_rings(self)
    }

    fn ratio(&self) -> f64 {
        self.drive().ratio()
    }

    fn meshes(&self) -> Vec<RingMesh> {
        self.drive().meshes.to_vec()
    }

    fn output_laws(&self) -> Vec<Option<(LineContact, f64)>> {
        vec![None; 2]
    }

    fn findings(&self) -> Vec<Finding> {
        findings::of_two_rings(self)
    }

    fn friction(&self) -> (Vec<StageFriction>, bool) {
        let (friction, assumed) = TwoRingDesign::friction(self);
        (friction.into(), assumed)
    }

    fn play(&self) -> Vec<OfParts> {
        let [first, second, bearing] = self.drive().play();
        vec![[first, 0.0, bearing], [second, 0.0, 0.0]]
    }

    fn closed_forms(&self, torque: f64) -> Vec<OfParts> {
        let ([first, second], bearing) =
            (self.drive().ring_forces(torque), self.drive().eccentric_force(torque));
        vec![[first, 0.0, bearing], [second, 0.0, 0.0]]
    }

    fn new_drive(&self) -> Result<HeldDrive, AnalysisError> {
        held(self.drive().joints(), self.rated().torque, 1.0)
    }

    fn moving(&self) -> Result<EccentricJoints, AnalysisError> {
        self.drive().joints().map_err(AnalysisError::compute(BUILD))
    }

    /// Either looks at the same states of rest.
    fn rings(&self) -> Result<Vec<LoadedRing<'_>>, AnalysisError> {
        let drive = self.drive();
        let (friction, turns) = (TwoRingDesign::friction(self).0, drive.turns()[2]);
        let beside = Beside {
            eccentric: drive.eccentric.clone(),
            eccentricity: drive.meshes[0].profile.eccentricity,
            output_pins: None,
            has_rollers: false,
            turns,
            period: TAU / turns,
        };
        let ring = |k: usize| {
            let section = [&self.ring, &self.second_ring][k];
            let meshing = StageMeshing::of_ring(drive, self.rated().torque, k);
            Ok(LoadedRing {
                of: OfRing {
                    mesh: &drive.meshes[k],
                    discs: drive.phases.len(),
                    width: drive.widths[k],
                    pin_mounting: *section.pin_mounting,
                    friction: friction[k].ring,
                    torque: 1.0,
                    speed: 1.0,
                    largest_force: Box::new(move |torque| drive.ring_forces(torque)[k]),
                    error: drive.per_disc(),
                },
                meshing: meshing.map_err(AnalysisError::compute(BUILD))?,
                beside: beside.clone(),
                seen: Seen { error: [1.0, 0.0][k], friction: 1.0 / drive.per_disc() },
                passes: turns,
            })
        };
        (0..2).map(ring).collect()
    }

    /// The eccentrics pass z_p1 i pins of the first ring in a turn of the output and z_p2 (i − 1) of the second: z_p1 z_p2/(z_c1 −
    /// z_c2) times z_c1 and z_c2.
    fn order(&self) -> f64 {
        let [first, second] = self.drive().meshes.each_ref().map(|mesh| mesh.profile.lobe_count());
        let both = (first + 1) * (second + 1) * gcd(first, second);
        both as f64 / first.abs_diff(second) as f64
    }

    fn inertia(&self) -> JointInertia {
        let drive = self.drive();
        let (count, e) = (drive.phases.len(), drive.meshes[0].profile.eccentricity);
        let turns = 1.0 / drive.meshes[0].profile.lobe_count() as f64;
        let output = drive.output_body();
        joint_inertia(discs_inertia(count, drive.disc, e, turns), count as f64 * drive.disc.0, output)
    }

    fn as_made(&self, options: &MadeOptions, _: f64) -> Result<Made<TwoRingDesign>, AnalysisError> {
        Made::nominal(self, options)
    }
}

impl EccentricDrive for TwoStageDesign {
    const FAMILY: Family = Family::TwoStage;
    const STAGES: &'static [StageKeys] = &TWO_STAGE;

    of_file! { TwoStageDesign, TwoStage }

    fn scene(&self) -> Scene {
        scene::of_two_stages(self)
    }

    fn ratio(&self) -> f64 {
        self.drive().ratio()
    }

    fn meshes(&self) -> Vec<RingMesh> {
        vec![self.drive().first.mesh.clone(), self.drive().second.mesh.clone()]
    }

    fn output_laws(&self) -> Vec<Option<(LineContact, f64)>> {
        vec![output_law(&self.drive().first), output_law(&self.drive().second)]
    }

    fn findings(&self) -> Vec<Finding> {
        findings::of_two_stages(self)
    }

    fn friction(&self) -> (Vec<StageFriction>, bool) {
        let (friction, assumed) = TwoStageDesign::friction(self);
        (friction.into(), assumed)
    }

    /// Of the eccentrics of the second stage.
    fn turns(&self) -> usize {
        self.drive().first.profile.lobe_count()
    }

    fn play(&self) -> Vec<OfParts> {
        self.drive().play().map(parts_of).into()
    }

    fn closed_forms(&self, torque: f64) -> Vec<OfParts> {
        let drive = self.drive();
        let [first, second] = drive.torques(torque);
        vec![closed_forms_of(&drive.first, first), closed_forms_of(&drive.second, second)]
    }

    /// The first stage bears what the second loses, too: efficiencies multiply. Backwards as well, where both can be driven.
    fn efficiency(&self, torque: f64, losses: &[StageLosses]) -> Efficiency {
        let drive = self.drive();
        // Losses are those at the input, per radian of it.
        let [first, second] =
            [0, 1].map(|k| Efficiency::of(drive.ratio().abs() * losses[k].total() / torque.abs()));
        let backward = match first.backward.min(second.backward) {
            least if least > 0.0 => first.backward * second.backward,
            least => least,
        };
        Efficiency { forward: first.forward * second.forward, backward }
    }

    fn new_drive(&self) -> Result<HeldDrive, AnalysisError> {
        held(self.drive().joints(), self.rated().torque, 1.0)
    }

    fn moving(&self) -> Result<EccentricJoints, AnalysisError> {
        self.drive().joints().map_err(AnalysisError::compute(BUILD))
    }

    /// Each stage by itself under its torque, at its speed. The shaft between them is in the bearings of both.
    fn rings(&self) -> Result<Vec<LoadedRing<'_>>, AnalysisError> {
        let drive = self.drive();
        let (friction, torques) = (TwoStageDesign::friction(self).0, drive.torques(1.0));
        let between = drive.first.output_support + drive.second.input_support;
        let stages = [
            SingleStage { output_support: between, ..drive.first.clone() },
            SingleStage { input_support: between, ..drive.second.clone() },
        ];
        let speeds = [1.0, 1.0 / drive.first.ratio()];
        let errors = [1.0 / drive.second.ratio(), 1.0];
        let first = &self.first_stage;
        let sections =
            [(&first.ring, &first.disc, &first.output_pins), (&self.ring, &self.disc, &self.output_pins)];
        let ring = |k: usize| {
            let (stage, (ring, disc, pins)) = (&stages[k], sections[k]);
            let as_designed = [&drive.first, &drive.second][k];
            let meshing = StageMeshing::new(stage, torques[k] * self.rated().torque, 1.0);
            let beside = meshing::beside(stage, *pins.roller_radius_mm > *pins.pin_radius_mm);
            Ok(LoadedRing {
                of: OfRing {
                    mesh: &as_designed.mesh,
                    discs: stage.phases.len(),
                    width: *disc.width_mm * MM,
                    pin_mounting: *ring.pin_mounting,
                    friction: friction[k].ring,
                    torque: torques[k],
                    speed: speeds[k],
                    largest_force: Box::new(move |torque| as_designed.ring_force(torque)),
                    error: errors[k].abs(),
                },
                meshing: meshing.map_err(AnalysisError::compute(BUILD))?,
                seen: Seen { error: errors[k], friction: 1.0 / errors[k].abs() },
                passes: beside.turns * speeds[k].abs(),
                beside,
            })
        };
        (0..2).map(ring).collect()
    }

    /// Of the second stage, whose error comes to the output whole. That of the first, less by the ratio of the second, does not
    /// repeat with it within a turn of the output, which is too long to follow.
    fn order(&self) -> f64 {
        self.drive().second.profile.pin_count as f64
    }

    /// Both stages; the shaft between them counts as the plates of the first stage's output pins.
    fn inertia(&self) -> JointInertia {
        let TwoStage { first, second } = self.drive();
        let of = |stage: &SingleStage| {
            let (count, e) = (stage.phases.len(), stage.profile.eccentricity);
            (discs_inertia(count, stage.disc, e, 1.0 / stage.ratio()), count as f64 * stage.disc.0)
        };
        let ((fast, first_mass), (slow, second_mass)) = (of(first), of(second));
        let (shaft_mass, shaft) = first.output;
        joint_inertia(
            fast + (shaft + slow) / first.ratio().powi(2),
            first_mass + shaft_mass + second_mass,
            second.output,
        )
    }

    fn as_made(&self, options: &MadeOptions, _: f64) -> Result<Made<TwoStageDesign>, AnalysisError> {
        Made::nominal(self, options)
    }
}
