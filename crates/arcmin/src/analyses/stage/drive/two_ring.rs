//! Stepped discs between two rings.

use std::f64::consts::TAU;

use super::{BUILD, EccentricDrive, discs_inertia, held, joint_inertia};
use crate::analyses::AnalysisError;
use crate::analyses::stage::findings;
use crate::analyses::stage::keys::{OfParts, StageKeys, TWO_RING};
use crate::analyses::stage::made::SectionOfWidths;
use crate::analyses::stage::meshing::{LoadedRing, OfRing};
use crate::analyses::stage::strength::{StageBody, Strength};
use crate::checks::Finding;
use crate::contact::LineContact;
use crate::design::{Family, SecondTolerancesSection, StageProcess, TwoRingDesign, TwoRingTolerancesSection};
use crate::dynamics::{EccentricJoints, ElasticDiscs, HeldDrive, StageMeshing};
use crate::exchange::JointInertia;
use crate::fem::DiscShape;
use crate::life::{OutputFactors, StageParts};
use crate::machine::{GapChain, PartCounts, RingMesh, StageErrors, StageFriction, StageTolerances, gcd};
use crate::scene::{self, Scene};

impl EccentricDrive for TwoRingDesign {
    const FAMILY: Family = Family::TwoRing;
    const STAGES: &'static [StageKeys] = &TWO_RING;
    const TOLERANCES: &'static [SectionOfWidths] = &[
        SectionOfWidths { section: "tolerances", stage: 0, widths: TwoRingTolerancesSection::WIDTHS },
        SectionOfWidths { section: "second_tolerances", stage: 1, widths: SecondTolerancesSection::WIDTHS },
    ];

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

    fn findings_with(&self, strength: &Strength) -> Vec<Finding> {
        findings::of_two_rings(self, strength)
    }

    fn bodies(&self) -> Vec<StageBody<'_>> {
        let drive = self.drive();
        let ring = |k: usize| StageBody {
            mesh: &drive.meshes[k],
            width: drive.widths[k],
            discs: drive.phases.len(),
            disc: &self.disc.material,
            ring: [&self.ring.material, &self.second_ring.material][k],
            openings: &drive.openings,
            pins: None,
        };
        vec![ring(0), ring(1)]
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

    fn disc_shapes(&self) -> Result<Vec<Vec<DiscShape>>, AnalysisError> {
        Err(AnalysisError::usage(
            "stepped discs are rigid: the finite-element model of a disc has a single profile",
            "leave out --discs",
        ))
    }

    fn new_drive(&self, _: &[ElasticDiscs]) -> Result<HeldDrive, AnalysisError> {
        held(self.drive().joints(), self.rated().torque, 1.0)
    }

    fn moving(&self, _: &[ElasticDiscs]) -> Result<EccentricJoints, AnalysisError> {
        self.drive().joints().map_err(AnalysisError::compute(BUILD))
    }

    /// Both rings share the same equilibria.
    fn rings(&self, _: &[ElasticDiscs]) -> Result<Vec<LoadedRing<'_>>, AnalysisError> {
        let drive = self.drive();
        let (friction, turns) = (TwoRingDesign::friction(self).0, drive.turns()[2]);
        let parts = StageParts {
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
                parts: parts.clone(),
                factors: OutputFactors { error: [1.0, 0.0][k], friction: 1.0 / drive.per_disc() },
                passes: turns,
            })
        };
        (0..2).map(ring).collect()
    }

    fn turns(&self) -> usize {
        if self.is_even() { 1 } else { self.drive().turns_to_repeat() }
    }

    /// The eccentrics pass z_p1 i pins of the first ring in a turn of the output and z_p2 (i − 1) of the second: z_p1 z_p2/(z_c1 m_2 −
    /// z_c2 m_1) times z_c1 and z_c2. With errors of single parts all of them have passed after a turn, or several where i is no whole number.
    fn order(&self) -> f64 {
        if !self.is_even() {
            return (self.ratio() / self.drive().turns_to_repeat() as f64).abs();
        }
        let [first, second] = self.drive().meshes.each_ref().map(|mesh| mesh.profile.lobe_count());
        let [pins, others] = self.drive().meshes.each_ref().map(|mesh| mesh.profile.pin_count);
        (pins * others * gcd(first, second)) as f64 / self.drive().teeth_apart() as f64
    }

    fn inertia(&self) -> JointInertia {
        let drive = self.drive();
        let (count, e) = (drive.phases.len(), drive.meshes[0].profile.eccentricity);
        let turns = 1.0 / drive.meshes[0].profile.lobes_per_turn();
        let output = drive.output_body();
        joint_inertia(discs_inertia(count, drive.disc, e, turns), count as f64 * drive.disc.0, output)
    }

    fn processes(&self) -> Vec<Option<StageProcess>> {
        TwoRingDesign::processes(self).map_or(vec![None; 2], |both| both.map(Some).into())
    }

    fn hole_diameters(&self) -> Vec<Option<f64>> {
        vec![None; 2]
    }

    fn tolerances(&self) -> Option<Vec<StageTolerances>> {
        TwoRingDesign::tolerances(self).map(Into::into)
    }

    fn given_errors(&self) -> Option<Vec<StageErrors>> {
        TwoRingDesign::given_errors(self).map(Into::into)
    }

    fn errors(&self) -> Vec<StageErrors> {
        self.drive().errors.to_vec()
    }

    fn with_errors(&self, errors: Vec<StageErrors>) -> TwoRingDesign {
        let mut errors = errors.into_iter();
        self.made([0; 2].map(|_| errors.next().unwrap_or_default()))
    }

    fn part_counts(&self) -> Vec<PartCounts> {
        self.drive().part_counts().into()
    }

    fn gap_chain(&self) -> GapChain {
        GapChain::of_two_rings(self.drive())
    }
}
