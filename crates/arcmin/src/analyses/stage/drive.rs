//! Trait of drives of eccentrics of any family, used by the analyses.

use std::f64::consts::TAU;

use super::AnyDesign;
use super::keys::{OfParts, StageKeys};
use super::made::{Made, MadeOptions, SectionOfWidths};
use super::meshing::{self, LoadedRing, WearingRing};
use super::strength::{StageBody, Strength};
use crate::analyses::{AnalysisError, Host};
use crate::checks::Finding;
use crate::contact::{Damping, LineContact};
use crate::design::{Family, StageProcess};
use crate::dynamics::{DynamicsError, EccentricJoints, ElasticDiscs, HeldDrive, StageLosses};
use crate::exchange::{JointInertia, Stamp};
use crate::fem::DiscShape;
use crate::machine::{
    DutyPoint, GapChain, Limits, PartCounts, PlayChain, RingMesh, SingleStage, StageErrors, StageFriction,
    StageThermal, StageTolerances, Wear, gcd,
};
use crate::progress::Progress;
use crate::scene::Scene;

fn output_law(stage: &SingleStage) -> Option<(LineContact, f64)> {
    Some((stage.output_contact, stage.output_pins.equivalent_radius(stage.profile.eccentricity)))
}

fn hole_diameter(stage: &SingleStage) -> Option<f64> {
    Some(2.0 * stage.output_pins.hole_radius(stage.profile.eccentricity))
}

/// Efficiency with the input driving, and with the output driving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Efficiency {
    /// The input drives.
    pub forward: f64,
    /// At zero or below the drive is self-locking.
    pub backward: f64,
}

impl Efficiency {
    /// From the loss over the work of the output; the loss is the same with the output driving.
    pub fn of(lost: f64) -> Efficiency {
        Efficiency { forward: 1.0 / (1.0 + lost), backward: 1.0 - lost }
    }
}

/// A drive of eccentrics. Torques in N·m and angles in rad are those at the output.
pub trait EccentricDrive: Sized + Send + Sync + 'static {
    /// Family of its design files.
    const FAMILY: Family;
    /// Its stages from the input.
    const STAGES: &'static [StageKeys];
    /// Sections of the design file from which drives are drawn.
    const TOLERANCES: &'static [SectionOfWidths];

    /// A design of any family from one of this family.
    fn any(&self) -> AnyDesign;
    /// The design of this family in one of any family; `None` of others.
    fn of_any(any: &AnyDesign) -> Option<&Self>;
    /// Name from the design file.
    fn name(&self) -> &str;
    /// Turns of the input for one turn of the output; negative if they turn in opposite directions.
    fn ratio(&self) -> f64;
    /// Text of the design file.
    fn text(&self) -> &str;
    /// Rated operating point.
    fn rated(&self) -> DutyPoint;
    /// Load spectrum.
    fn duty_points(&self) -> Vec<DutyPoint>;
    /// Laws of wear; `None` if the file gives none.
    fn wear(&self) -> Option<&Wear>;
    /// Limits in SI units.
    fn limits(&self) -> Limits;
    /// The drive as solids that move.
    fn scene(&self) -> Scene;
    /// Flanks in their rings, stage by stage.
    fn meshes(&self) -> Vec<RingMesh>;
    /// Line contact of output pins in holes and its equivalent radius in m, stage by stage.
    fn output_laws(&self) -> Vec<Option<(LineContact, f64)>>;
    /// As [`check_design`](crate::checks::check_design), with the strength of its parts.
    fn findings_with(&self, strength: &Strength) -> Vec<Finding>;

    /// The same without the order of failure.
    fn findings(&self) -> Vec<Finding> {
        self.findings_with(&Strength::at_largest_torque(self))
    }

    /// Bodies of its stages.
    fn bodies(&self) -> Vec<StageBody<'_>>;

    /// Its cooling.
    fn thermal(&self) -> StageThermal;

    /// Coefficients of friction stage by stage, and whether they are assumed.
    fn friction(&self) -> (Vec<StageFriction>, bool);

    /// Full period in turns of the input: one turn of all eccentrics, or with errors of single pins and lobes a turn
    /// of the output.
    fn turns(&self) -> usize {
        1
    }

    /// Equidistant angles (rad) of the input over these turns. For several turns their number is the next one from
    /// `positions` that has no common divisor with the turns and with the pins of the first ring: otherwise that ring
    /// would be computed in a few equal positions only.
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

    /// First-order efficiency: friction losses with the forces without friction under a torque.
    fn efficiency(&self, torque: f64, losses: &[StageLosses]) -> Efficiency {
        let lost: f64 = losses.iter().map(StageLosses::total).sum();
        Efficiency::of(self.ratio().abs() * lost / torque.abs())
    }

    /// Shapes of its discs, stage by stage.
    ///
    /// # Errors
    /// [`AnalysisError::Usage`] of families whose discs are rigid.
    fn disc_shapes(&self) -> Result<Vec<Vec<DiscShape>>, AnalysisError>;

    /// The new drive with elastic discs, stage by stage, or with rigid ones.
    ///
    /// # Errors
    /// [`AnalysisError`] for values without meaning.
    fn new_drive(&self, discs: &[ElasticDiscs]) -> Result<HeldDrive, AnalysisError>;

    /// The rings of the new drive.
    ///
    /// # Errors
    /// [`AnalysisError`] for values without meaning.
    fn rings(&self, discs: &[ElasticDiscs]) -> Result<Vec<LoadedRing<'_>>, AnalysisError>;

    /// The rings of the new drive with the data for their wear.
    ///
    /// # Errors
    /// As [`rings`](EccentricDrive::rings); [`AnalysisError::Usage`] where the design gives no wear.
    fn wearing_rings(&self, discs: &[ElasticDiscs]) -> Result<Vec<WearingRing>, AnalysisError> {
        let wearing = |LoadedRing { of, meshing, parts, factors, passes }: LoadedRing<'_>| {
            Ok(WearingRing { case: meshing::wear_case(self, of)?, meshing, parts, factors, passes })
        };
        self.rings(discs)?.into_iter().map(wearing).collect()
    }

    /// The drive after some hours of its duty.
    ///
    /// # Errors
    /// [`AnalysisError`] for values without meaning, and where the design gives no wear.
    fn held(
        &self,
        discs: &[ElasticDiscs],
        hours: f64,
        progress: &dyn Progress,
    ) -> Result<HeldDrive, AnalysisError> {
        let mut held = self.new_drive(discs)?;
        meshing::wear_down(self, discs, hours, progress, |stage, surfaces, parts| {
            held.set_stage_wear(stage, surfaces, parts)
        })?;
        Ok(held)
    }

    /// The new drive for simulations, with its fixed member at rest.
    ///
    /// # Errors
    /// As [`EccentricDrive::new_drive`].
    fn moving(&self, discs: &[ElasticDiscs]) -> Result<EccentricJoints, AnalysisError>;

    /// Damping of ring pins on flanks.
    fn contact_damping(&self) -> Damping;

    /// The drive with the errors and the discs of the options.
    ///
    /// # Errors
    /// As [`Made::of`].
    fn as_made(&self, options: &MadeOptions, host: &dyn Host) -> Result<Made<Self>, AnalysisError> {
        Made::of(self, options, host)
    }

    /// Manufacturing processes of the parts, stage by stage, if the file gives them.
    fn processes(&self) -> Vec<Option<StageProcess>>;

    /// Diameters in m of the holes of output pins, stage by stage; none where there are no output pins.
    fn hole_diameters(&self) -> Vec<Option<f64>>;

    /// Tolerances that drives are drawn from and the errors of one drive, stage by stage, where the file gives any.
    fn tolerances(&self) -> Option<Vec<StageTolerances>>;
    /// Errors of one drive, stage by stage, where the file gives any.
    fn given_errors(&self) -> Option<Vec<StageErrors>>;

    /// Errors that the drive has, and the same drive with others, stage by stage.
    fn errors(&self) -> Vec<StageErrors>;
    /// The same drive with other errors, stage by stage.
    #[must_use]
    fn with_errors(&self, errors: Vec<StageErrors>) -> Self;

    /// Whether all ring pins and all discs are the same.
    fn is_even(&self) -> bool {
        self.errors().iter().all(StageErrors::is_even)
    }

    /// Parts that have errors, stage by stage.
    fn part_counts(&self) -> Vec<PartCounts>;

    /// Its gaps, referred to the output.
    fn gap_chain(&self) -> GapChain;

    /// Whether the ring carries the output while the output pins are at rest.
    fn is_driven_housing(&self) -> bool {
        false
    }

    /// Turns of the input relative to the ring for one turn of the output.
    fn turns_against_ring(&self) -> f64 {
        if self.is_driven_housing() { self.ratio() - 1.0 } else { self.ratio() }
    }

    /// Order of the error per turn of the output of which all other orders are multiples: after this part of a turn
    /// eccentrics, pins and discs are in the same position again relative to the output.
    fn order(&self) -> f64;

    /// Name and hash of the design.
    fn stamp(&self) -> Stamp;

    /// Masses and moments of inertia. The design gives none for shaft, motor and output: shaft and motor have zero
    /// inertia, the output is a plain body of steel.
    fn inertia(&self) -> JointInertia;
}

/// Inertia of n discs on an eccentric (m), referred to the eccentric, with w turns of a disc per turn of it: n (m e²
/// + I w²).
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
    ratio_to_ring: f64,
) -> Result<HeldDrive, AnalysisError> {
    let joints = joints.map_err(AnalysisError::compute(BUILD))?;
    Ok(HeldDrive::new(joints, rated, ratio_to_ring))
}

/// The discs of a whole drive at rest, where a damping of modes would be a force that lags.
fn at_rest(discs: &[ElasticDiscs]) -> Option<ElasticDiscs> {
    ElasticDiscs::joined(discs).map(ElasticDiscs::undamped)
}

const BUILD: &str = "build the drive from its design";

/// Methods that read the same sections in the design files of all families.
macro_rules! of_file {
    ($Design:ident, $Variant:ident) => {
        fn any(&self) -> $crate::analyses::stage::AnyDesign {
            $crate::analyses::stage::AnyDesign::$Variant(Box::new(self.clone()))
        }

        fn of_any(any: &$crate::analyses::stage::AnyDesign) -> Option<&$Design> {
            match any {
                $crate::analyses::stage::AnyDesign::$Variant(design) => Some(design),
                _ => None,
            }
        }

        fn name(&self) -> &str {
            &self.name
        }

        fn text(&self) -> &str {
            $Design::text(self)
        }

        fn rated(&self) -> $crate::machine::DutyPoint {
            $Design::rated(self)
        }

        fn duty_points(&self) -> Vec<$crate::machine::DutyPoint> {
            $Design::duty_points(self)
        }

        fn wear(&self) -> Option<&$crate::machine::Wear> {
            $Design::wear(self)
        }

        fn limits(&self) -> $crate::machine::Limits {
            $Design::limits(self)
        }

        fn contact_damping(&self) -> $crate::contact::Damping {
            $Design::contact_damping(self)
        }

        fn thermal(&self) -> $crate::machine::StageThermal {
            $Design::thermal(self)
        }

        fn stamp(&self) -> $crate::exchange::Stamp {
            $crate::exchange::Stamp::named(&self.name, &self.hash())
        }
    };
}

// After the macro, which they use.
mod single_stage;
mod two_ring;
mod two_stage;
