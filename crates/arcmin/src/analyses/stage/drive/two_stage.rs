//! Two single stages in series.

use super::{
    BUILD, EccentricDrive, Efficiency, at_rest, closed_forms_of, discs_inertia, held, hole_diameter,
    joint_inertia, output_law, parts_of,
};
use crate::analyses::AnalysisError;
use crate::analyses::stage::findings;
use crate::analyses::stage::keys::{OfParts, StageKeys, TWO_STAGE};
use crate::analyses::stage::made::SectionOfWidths;
use crate::analyses::stage::meshing::{self, LoadedRing, OfRing};
use crate::analyses::stage::strength::{StageBody, Strength};
use crate::checks::Finding;
use crate::contact::LineContact;
use crate::design::{Family, StageProcess, StageTolerancesSection, TwoStageDesign};
use crate::dynamics::{EccentricJoints, ElasticDiscs, HeldDrive, StageLosses, StageMeshing};
use crate::exchange::JointInertia;
use crate::fem::DiscShape;
use crate::life::OutputFactors;
use crate::machine::{
    GapChain, PartCounts, RingMesh, SingleStage, StageErrors, StageFriction, StageTolerances, TwoStage,
};
use crate::scene::{self, Scene};
use crate::units::MM;

impl EccentricDrive for TwoStageDesign {
    const FAMILY: Family = Family::TwoStage;
    const STAGES: &'static [StageKeys] = &TWO_STAGE;
    const TOLERANCES: &'static [SectionOfWidths] = &[
        SectionOfWidths {
            section: "first_stage.tolerances",
            stage: 0,
            widths: StageTolerancesSection::WIDTHS,
        },
        SectionOfWidths { section: "tolerances", stage: 1, widths: StageTolerancesSection::WIDTHS },
    ];

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

    fn findings_with(&self, strength: &Strength) -> Vec<Finding> {
        findings::of_two_stages(self, strength)
    }

    fn bodies(&self) -> Vec<StageBody<'_>> {
        let (drive, first) = (self.drive(), &self.first_stage);
        vec![
            StageBody::of(&drive.first, &first.disc, &first.ring),
            StageBody::of(&drive.second, &self.disc, &self.ring),
        ]
    }

    fn friction(&self) -> (Vec<StageFriction>, bool) {
        let (friction, assumed) = TwoStageDesign::friction(self);
        (friction.into(), assumed)
    }

    /// One turn of the eccentrics of the second stage; with errors of single parts one turn of its output.
    fn turns(&self) -> usize {
        let TwoStage { first, second } = self.drive();
        let (first, second) = (first.turns_to_repeat(), second.turns_to_repeat());
        if self.is_even() { first } else { first * second }
    }

    fn play(&self) -> Vec<OfParts> {
        self.drive().play().map(parts_of).into()
    }

    fn closed_forms(&self, torque: f64) -> Vec<OfParts> {
        let drive = self.drive();
        let [first, second] = drive.torques(torque);
        vec![closed_forms_of(&drive.first, first), closed_forms_of(&drive.second, second)]
    }

    /// The first stage also carries the losses of the second, so efficiencies multiply; with the output driving as
    /// well, if both can be driven.
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

    fn disc_shapes(&self) -> Result<Vec<Vec<DiscShape>>, AnalysisError> {
        let TwoStage { first, second } = self.drive();
        Ok([first, second].map(DiscShape::all_of_stage).into())
    }

    fn new_drive(&self, discs: &[ElasticDiscs]) -> Result<HeldDrive, AnalysisError> {
        held(self.drive().joints_with(at_rest(discs).as_ref()), self.rated().torque, 1.0)
    }

    fn moving(&self, discs: &[ElasticDiscs]) -> Result<EccentricJoints, AnalysisError> {
        self.drive().joints_with(ElasticDiscs::joined(discs).as_ref()).map_err(AnalysisError::compute(BUILD))
    }

    /// Each stage separately under its torque, at its speed. The intermediate shaft is supported by the bearings of
    /// both.
    fn rings(&self, discs: &[ElasticDiscs]) -> Result<Vec<LoadedRing<'_>>, AnalysisError> {
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
            let own = discs.get(k).cloned().map(ElasticDiscs::undamped);
            let meshing = StageMeshing::new(stage, own.as_ref(), torques[k] * self.rated().torque, 1.0);
            let parts = meshing::stage_parts(stage, *pins.roller_radius_mm > *pins.pin_radius_mm);
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
                factors: OutputFactors { error: errors[k], friction: 1.0 / errors[k].abs() },
                passes: parts.turns * speeds[k].abs(),
                parts,
            })
        };
        (0..2).map(ring).collect()
    }

    /// Period of the second stage. The error of the first stage, divided by the ratio of the second, has no common
    /// period with it within a turn of the output.
    fn order(&self) -> f64 {
        if !self.is_even() {
            return 1.0;
        }
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

    fn processes(&self) -> Vec<Option<StageProcess>> {
        TwoStageDesign::processes(self).into()
    }

    fn hole_diameters(&self) -> Vec<Option<f64>> {
        vec![hole_diameter(&self.drive().first), hole_diameter(&self.drive().second)]
    }

    fn tolerances(&self) -> Option<Vec<StageTolerances>> {
        TwoStageDesign::tolerances(self).map(Into::into)
    }

    fn given_errors(&self) -> Option<Vec<StageErrors>> {
        TwoStageDesign::given_errors(self).map(Into::into)
    }

    fn errors(&self) -> Vec<StageErrors> {
        vec![self.drive().first.errors.clone(), self.drive().second.errors.clone()]
    }

    fn with_errors(&self, errors: Vec<StageErrors>) -> TwoStageDesign {
        let mut errors = errors.into_iter();
        self.made([0; 2].map(|_| errors.next().unwrap_or_default()))
    }

    fn part_counts(&self) -> Vec<PartCounts> {
        vec![self.drive().first.part_counts(), self.drive().second.part_counts()]
    }

    fn gap_chain(&self) -> GapChain {
        GapChain::of_two_stages(self.drive())
    }
}
