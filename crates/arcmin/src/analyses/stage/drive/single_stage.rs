//! A single stage: one eccentric for each disc, output pins in holes of the discs.

use std::f64::consts::TAU;

use super::{
    BUILD, EccentricDrive, Efficiency, at_rest, closed_forms_of, discs_inertia, held, hole_diameter,
    joint_inertia, output_law, parts_of,
};
use crate::analyses::AnalysisError;
use crate::analyses::stage::findings;
use crate::analyses::stage::keys::{OfParts, SINGLE, StageKeys};
use crate::analyses::stage::made::SectionOfWidths;
use crate::analyses::stage::meshing::{self, LoadedRing, OfRing};
use crate::analyses::stage::strength::{StageBody, Strength};
use crate::checks::Finding;
use crate::contact::LineContact;
use crate::design::{Family, StageDesign, StageProcess, StageTolerancesSection};
use crate::dynamics::{EccentricJoints, ElasticDiscs, HeldDrive, StageLosses, StageMeshing};
use crate::exchange::JointInertia;
use crate::fem::DiscShape;
use crate::life::{OutputFactors, StageParts};
use crate::machine::{GapChain, PartCounts, RingMesh, StageErrors, StageFriction, StageTolerances};
use crate::scene::{self, Scene};
use crate::units::MM;

impl EccentricDrive for StageDesign {
    const FAMILY: Family = Family::Eccentric;
    const STAGES: &'static [StageKeys] = &SINGLE;
    const TOLERANCES: &'static [SectionOfWidths] =
        &[SectionOfWidths { section: "tolerances", stage: 0, widths: StageTolerancesSection::WIDTHS }];

    of_file! { StageDesign, Eccentric }

    fn scene(&self) -> Scene {
        scene::of_stage(self)
    }

    fn ratio(&self) -> f64 {
        StageDesign::ratio(self)
    }

    fn meshes(&self) -> Vec<RingMesh> {
        vec![self.drive().mesh.clone()]
    }

    fn output_laws(&self) -> Vec<Option<(LineContact, f64)>> {
        vec![output_law(self.drive())]
    }

    fn findings_with(&self, strength: &Strength) -> Vec<Finding> {
        findings::of_single_stage(self, strength)
    }

    fn bodies(&self) -> Vec<StageBody<'_>> {
        vec![StageBody::of(self.drive(), &self.disc, &self.ring)]
    }

    fn friction(&self) -> (Vec<StageFriction>, bool) {
        let (friction, assumed) = StageDesign::friction(self);
        (vec![friction], assumed)
    }

    fn play(&self) -> Vec<OfParts> {
        vec![parts_of(self.play_chain())]
    }

    fn closed_forms(&self, torque: f64) -> Vec<OfParts> {
        vec![closed_forms_of(self.drive(), torque * self.ratio_to_ring())]
    }

    /// Losses are referred to the ring: η = T/(T + M z_c/m), the same with the ring turning.
    fn efficiency(&self, torque: f64, losses: &[StageLosses]) -> Efficiency {
        Efficiency::of(self.drive().ratio().abs() * losses[0].total() / torque.abs())
    }

    fn disc_shapes(&self) -> Result<Vec<Vec<DiscShape>>, AnalysisError> {
        Ok(vec![DiscShape::all_of_stage(self.drive())])
    }

    fn new_drive(&self, discs: &[ElasticDiscs]) -> Result<HeldDrive, AnalysisError> {
        held(self.drive().joints_with(at_rest(discs).as_ref()), self.rated().torque, self.ratio_to_ring())
    }

    fn moving(&self, discs: &[ElasticDiscs]) -> Result<EccentricJoints, AnalysisError> {
        let (stage, discs) = (self.drive(), discs.first());
        let joints =
            if self.is_driven_housing() { stage.driven_housing(discs) } else { stage.joints_with(discs) };
        joints.map_err(AnalysisError::compute(BUILD))
    }

    fn rings(&self, discs: &[ElasticDiscs]) -> Result<Vec<LoadedRing<'_>>, AnalysisError> {
        let (stage, ratio_to_ring) = (self.drive(), self.ratio_to_ring());
        let meshing = StageMeshing::new(stage, at_rest(discs).as_ref(), self.rated().torque, ratio_to_ring);
        let parts = meshing::stage_parts(stage, self.has_rollers());
        Ok(vec![LoadedRing {
            of: OfRing {
                mesh: &stage.mesh,
                discs: stage.phases.len(),
                width: *self.disc.width_mm * MM,
                pin_mounting: *self.ring.pin_mounting,
                friction: StageDesign::friction(self).0.ring,
                torque: 1.0,
                speed: 1.0,
                largest_force: Box::new(move |torque| stage.ring_force(torque * ratio_to_ring)),
                error: 1.0,
            },
            meshing: meshing.map_err(AnalysisError::compute(BUILD))?,
            // The input is held relative to the member at rest.
            parts: StageParts { turns: self.eccentric_turns(), ..parts },
            factors: OutputFactors::ONE_RING,
            passes: self.eccentric_turns(),
        }])
    }

    fn is_driven_housing(&self) -> bool {
        StageDesign::is_driven_housing(self)
    }

    fn tolerances(&self) -> Option<Vec<StageTolerances>> {
        StageDesign::tolerances(self).map(|tolerances| vec![tolerances])
    }

    fn given_errors(&self) -> Option<Vec<StageErrors>> {
        StageDesign::given_errors(self).map(|errors| vec![errors])
    }

    fn errors(&self) -> Vec<StageErrors> {
        vec![self.drive().errors.clone()]
    }

    fn with_errors(&self, mut errors: Vec<StageErrors>) -> StageDesign {
        self.made(errors.swap_remove(0))
    }

    fn part_counts(&self) -> Vec<PartCounts> {
        vec![self.drive().part_counts()]
    }

    fn gap_chain(&self) -> GapChain {
        GapChain::new(self.drive()).scaled(self.ratio_to_ring())
    }

    fn processes(&self) -> Vec<Option<StageProcess>> {
        vec![self.process()]
    }

    fn hole_diameters(&self) -> Vec<Option<f64>> {
        vec![hole_diameter(self.drive())]
    }

    fn turns(&self) -> usize {
        if self.drive().errors.is_even() { 1 } else { self.drive().turns_to_repeat() }
    }

    /// This number for every turn of the input, since each turn meets other pins.
    fn angles(&self, positions: usize) -> Vec<f64> {
        (0..self.turns() * positions).map(|step| TAU * step as f64 / positions as f64).collect()
    }

    /// After one pin pitch the next ring pin is in the position of the previous one; with errors of single parts the
    /// period contains all of them.
    fn order(&self) -> f64 {
        if self.drive().errors.is_even() { self.drive().profile.pin_count as f64 } else { 1.0 }
    }

    fn inertia(&self) -> JointInertia {
        let stage = self.drive();
        let (count, e) = (stage.phases.len(), stage.profile.eccentricity);
        // With the output at rest the discs do not turn.
        let (turns, output) = match self.is_driven_housing() {
            true => (0.0, stage.ring_body),
            false => (1.0 / stage.ratio(), stage.output),
        };
        joint_inertia(discs_inertia(count, stage.disc, e, turns), count as f64 * stage.disc.0, output)
    }
}
