//! What analyses ask a drive of eccentrics, discs and rings of pins, whatever its family, and under which keys its parts go.

use std::f64::consts::TAU;

use super::made::{Made, MadeOptions, MadePlay};
use super::{findings, meshing};
use crate::analyses::AnalysisError;
use crate::checks::Finding;
use crate::contact::{Damping, LineContact};
use crate::design::{Family, StageDesign, TwoRingDesign, TwoStageDesign};
use crate::dynamics::{HeldDrive, StageLosses};
use crate::machine::{DutyPoint, GapChain, Limits, PlayChain, RingMesh, SingleStage, StageFriction, gcd};
use crate::progress::Progress;
use crate::results::{Quantity, decimals, quantity};

/// Keys and names of one part of a stage.
#[derive(Debug)]
pub struct PartKeys {
    /// For readers: what bears, and what it is called in a sum of play.
    pub name: &'static str,
    pub short: &'static str,
    /// What its play comes from.
    pub gap: &'static str,
    pub force: Quantity,
    /// Of bearings none.
    pub pressure: Option<Quantity>,
    pub closed_form: Quantity,
    pub loss: Quantity,
    pub play: Quantity,
}

/// Parts of a stage by their numbers.
pub const RING: usize = 0;
pub const OUTPUT: usize = 1;
pub const ECCENTRIC: usize = 2;

/// A value for every part of a stage; 0 for those that it does not have.
pub type OfParts = [f64; 3];

/// Keys of one stage.
#[derive(Debug)]
pub struct StageKeys {
    /// For readers.
    pub name: &'static str,
    /// Table of its flank, and keys of that.
    pub profile: &'static str,
    pub flank: [&'static str; 4],
    /// Tables of its ring pins and of its output pins.
    pub contact: &'static str,
    pub output_pins: &'static str,
    /// Ring, output pins, eccentric bearings, as far as it has them.
    pub parts: [Option<PartKeys>; 3],
}

/// Of a flank, as those of [`profile::SUMMARY`](crate::analyses::profile::SUMMARY).
macro_rules! flank {
    ($key:literal) => {
        [
            concat!($key, "short_width_coefficient"),
            concat!($key, "inflection_deg"),
            concat!($key, "min_convex_flank_radius_mm"),
            concat!($key, "min_convex_flank_radius_at_deg"),
        ]
    };
}

/// Ring pins: prefix of the keys, name of a pin, of the ring, sentence of the play.
macro_rules! ring {
    ($key:literal, $pin:literal, $ring:literal, $play:literal, $closed:literal) => {
        Some(PartKeys {
            name: $pin,
            short: $ring,
            gap: concat!("gap of the flank, ", $ring),
            force: quantity(
                concat!($key, "max_force_n"),
                decimals(0),
                concat!("Largest force of a ", $pin, "."),
            ),
            pressure: Some(quantity(
                concat!($key, "max_pressure_mpa"),
                decimals(0),
                concat!("Largest Hertz pressure between a ", $pin, " and a flank."),
            )),
            closed_form: quantity(
                concat!("closed_form.", $key, "ring_pin_force_n"),
                decimals(1),
                concat!(
                    "Largest force of a ",
                    $pin,
                    " if all of one side carry as equal springs, ",
                    $closed,
                    "."
                ),
            ),
            loss: quantity(
                concat!("loss_shares.", $key, "ring"),
                decimals(3),
                concat!("Share of the losses between pins and flanks, ", $ring, "."),
            ),
            play: quantity(
                concat!("play_chain.", $key, "ring_arcmin"),
                decimals(3),
                concat!(
                    "Two-sided play at the output by the gap Δ of the flank, input held, ",
                    $ring,
                    ": ",
                    $play,
                    "."
                ),
            ),
        })
    };
}

macro_rules! output_pins {
    ($key:literal, $stage:literal, $play:literal) => {
        Some(PartKeys {
            name: concat!($stage, "output pin"),
            short: concat!($stage, "output pins"),
            gap: concat!("clearance of the ", $stage, "output pins in their holes"),
            force: quantity(
                concat!($key, "max_output_pin_force_n"),
                decimals(1),
                concat!("Largest force of an ", $stage, "output pin on a disc."),
            ),
            pressure: Some(quantity(
                concat!($key, "max_output_pin_pressure_mpa"),
                decimals(0),
                concat!("Largest Hertz pressure between an ", $stage, "output pin or its roller and a hole."),
            )),
            closed_form: quantity(
                concat!("closed_form.", $key, "output_pin_force_n"),
                decimals(1),
                concat!(
                    "Largest force of an ",
                    $stage,
                    "output pin if half of them carry as equal springs, 4T/(z_w R_w)."
                ),
            ),
            loss: quantity(
                concat!("loss_shares.", $key, "output_pins"),
                decimals(3),
                concat!(
                    "Share of the losses between ",
                    $stage,
                    "output pins and holes, or of rollers on their pins."
                ),
            ),
            play: quantity(
                concat!("play_chain.", $key, "output_arcmin"),
                decimals(3),
                concat!(
                    "Two-sided play by the clearance δ of the ",
                    $stage,
                    "output pins in their holes: ",
                    $play,
                    " where a pin stands across the eccentric."
                ),
            ),
        })
    };
}

macro_rules! eccentric {
    ($key:literal, $stage:literal, $play:literal, $closed:literal) => {
        Some(PartKeys {
            name: concat!($stage, "eccentric bearing"),
            short: concat!($stage, "eccentric bearing"),
            gap: concat!("clearance of the ", $stage, "eccentric bearing"),
            force: quantity(
                concat!($key, "eccentric_bearing_force_n"),
                decimals(1),
                concat!("Largest force of an ", $stage, "eccentric bearing."),
            ),
            pressure: None,
            closed_form: quantity(
                concat!("closed_form.", $key, "eccentric_bearing_force_n"),
                decimals(1),
                concat!("Force of an ", $stage, "eccentric bearing with equal springs: ", $closed, "."),
            ),
            loss: quantity(
                concat!("loss_shares.", $key, "eccentric_bearings"),
                decimals(3),
                concat!("Share of the losses of the ", $stage, "eccentric bearings."),
            ),
            play: quantity(
                concat!("play_chain.", $key, "eccentric_bearing_arcmin"),
                decimals(3),
                concat!(
                    "Two-sided play by the radial clearance c of the ",
                    $stage,
                    "eccentric bearing: ",
                    $play,
                    "."
                ),
            ),
        })
    };
}

/// Family by family, its stages from the input.
static SINGLE: [StageKeys; 1] = [StageKeys {
    name: "stage",
    profile: "profile",
    flank: flank!(""),
    contact: "contact",
    output_pins: "output_pins",
    parts: [
        ring!(
            "",
            "ring pin",
            "ring",
            "2Δ/(e z_c) for an even gap",
            "4T/(K1 z_c R) with the torque T of a disc"
        ),
        output_pins!("", "", "2δ/R_w"),
        eccentric!(
            "",
            "",
            "2c/(e z_c)",
            "T/(e z_c) across the eccentric, 4T/(π R_w) less the radial force of the ring along it"
        ),
    ],
}];

static TWO_RING: [StageKeys; 2] = [
    StageKeys {
        name: "first ring",
        profile: "profile",
        flank: flank!(""),
        contact: "contact",
        output_pins: "",
        parts: [
            ring!(
                "",
                "pin of the first ring",
                "first ring",
                "2Δ/(e z_c1) z_c2/z_p2 for an even gap",
                "4M/(K1 z_c1 R) with the moment M = T z_c2/z_p2 of a disc"
            ),
            None,
            eccentric!(
                "",
                "",
                "2c/(e |i|)",
                "T/(e i) across the eccentric, the radial forces of both rings along it"
            ),
        ],
    },
    StageKeys {
        name: "second ring",
        profile: "second_profile",
        flank: flank!("second_"),
        contact: "second_contact",
        output_pins: "",
        parts: [
            ring!(
                "second_",
                "pin of the second ring",
                "second ring",
                "2Δ/(e z_p2) for an even gap",
                "4T/(K1 z_p2 R) with the torque T of a disc"
            ),
            None,
            None,
        ],
    },
];

static TWO_STAGE: [StageKeys; 2] = [
    StageKeys {
        name: "first stage",
        profile: "first_stage_profile",
        flank: flank!("first_stage_"),
        contact: "first_stage_contact",
        output_pins: "first_stage_output_pins",
        parts: [
            ring!(
                "first_stage_",
                "first-stage ring pin",
                "first-stage ring",
                "2Δ/(e z_c) over the ratio of the second stage",
                "4T/(K1 z_c R) with the torque T of a disc"
            ),
            output_pins!("first_stage_", "first-stage ", "2δ/R_w over the ratio of the second stage"),
            eccentric!(
                "first_stage_",
                "first-stage ",
                "2c/(e z_c) over the ratio of the second stage",
                "as that of a single stage"
            ),
        ],
    },
    StageKeys {
        name: "second stage",
        profile: "profile",
        flank: flank!(""),
        contact: "contact",
        output_pins: "output_pins",
        parts: [
            ring!(
                "",
                "second-stage ring pin",
                "second-stage ring",
                "2Δ/(e z_c) for an even gap",
                "4T/(K1 z_c R) with the torque T of a disc"
            ),
            output_pins!("", "second-stage ", "2δ/R_w"),
            eccentric!("", "second-stage ", "2c/(e z_c)", "as that of a single stage"),
        ],
    },
];

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
pub trait Drive: Sized + 'static {
    const FAMILY: Family;
    /// Its stages from the input.
    const STAGES: &'static [StageKeys];

    fn name(&self) -> &str;
    fn ratio(&self) -> f64;
    fn rated(&self) -> DutyPoint;
    fn limits(&self) -> Limits;
    /// Flanks in their rings, stage by stage.
    fn meshes(&self) -> Vec<RingMesh>;
    /// Of output pins in holes, with the equivalent radius in m.
    fn output_laws(&self) -> Vec<Option<(LineContact, f64)>>;
    /// As [`check_design`](crate::checks::check_design).
    fn findings(&self) -> Vec<Finding>;

    /// Coefficients of friction stage by stage, and whether they are assumed.
    fn friction(&self) -> (Vec<StageFriction>, bool);

    /// Turns of the input in which all eccentrics go round; with errors of single pins and lobes, those of a turn of the output.
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

    /// The drive after some hours of its duty.
    ///
    /// # Errors
    /// [`AnalysisError`] for values without meaning, and where the wear is not computed.
    fn held(&self, hours: f64, progress: &dyn Progress) -> Result<HeldDrive, AnalysisError>;

    /// Damping of ring pins on flanks.
    fn contact_damping(&self) -> Damping;

    /// Whether drives of the family have manufacturing errors.
    const IS_DRAWN: bool = false;

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

    /// Whether the ring carries the output while the output pins are at rest.
    fn is_driven_housing(&self) -> bool {
        false
    }
}

fn parts_of(play: PlayChain) -> OfParts {
    [play.ring, play.output, play.eccentric_bearing]
}

fn closed_forms_of(stage: &SingleStage, torque: f64) -> OfParts {
    [stage.ring_force(torque), stage.output_pin_force(torque), stage.eccentric_force(torque)]
}

/// New, since their wear is not computed.
fn new_drive(
    joints: Result<crate::dynamics::EccentricJoints, crate::dynamics::DynamicsError>,
    rated: f64,
    hours: f64,
    family: Family,
) -> Result<HeldDrive, AnalysisError> {
    if hours > 0.0 {
        return Err(AnalysisError::usage(
            format!("the wear of a {} is not computed", family.drive()),
            "leave out --hours: the answer is that of the new drive",
        ));
    }
    let joints = joints.map_err(AnalysisError::compute("build the drive from its design"))?;
    Ok(HeldDrive::new(joints, rated, 1.0))
}

impl Drive for StageDesign {
    const FAMILY: Family = Family::Eccentric;
    const STAGES: &'static [StageKeys] = &SINGLE;

    fn name(&self) -> &str {
        &self.name
    }

    fn ratio(&self) -> f64 {
        StageDesign::ratio(self)
    }

    fn rated(&self) -> DutyPoint {
        StageDesign::rated(self)
    }

    fn limits(&self) -> Limits {
        StageDesign::limits(self)
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

    fn held(&self, hours: f64, progress: &dyn Progress) -> Result<HeldDrive, AnalysisError> {
        Ok(meshing::worn(self, hours, progress)?.into_held())
    }

    fn contact_damping(&self) -> Damping {
        StageDesign::contact_damping(self)
    }

    fn is_driven_housing(&self) -> bool {
        StageDesign::is_driven_housing(self)
    }

    const IS_DRAWN: bool = true;

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

    fn gap_play(&self) -> Option<f64> {
        let stage = self.stage();
        GapChain::new(stage).least(&stage.errors).map(|play| play * self.seen_from_ring())
    }
}

impl Drive for TwoRingDesign {
    const FAMILY: Family = Family::TwoRing;
    const STAGES: &'static [StageKeys] = &TWO_RING;

    fn name(&self) -> &str {
        &self.name
    }

    fn ratio(&self) -> f64 {
        self.drive().ratio()
    }

    fn rated(&self) -> DutyPoint {
        TwoRingDesign::rated(self)
    }

    fn limits(&self) -> Limits {
        TwoRingDesign::limits(self)
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

    fn held(&self, hours: f64, _: &dyn Progress) -> Result<HeldDrive, AnalysisError> {
        new_drive(self.drive().joints(), self.rated().torque, hours, Family::TwoRing)
    }

    fn contact_damping(&self) -> Damping {
        TwoRingDesign::contact_damping(self)
    }

    fn as_made(&self, options: &MadeOptions, _: f64) -> Result<Made<TwoRingDesign>, AnalysisError> {
        Made::nominal(self, options)
    }
}

impl Drive for TwoStageDesign {
    const FAMILY: Family = Family::TwoStage;
    const STAGES: &'static [StageKeys] = &TWO_STAGE;

    fn name(&self) -> &str {
        &self.name
    }

    fn ratio(&self) -> f64 {
        self.drive().ratio()
    }

    fn rated(&self) -> DutyPoint {
        TwoStageDesign::rated(self)
    }

    fn limits(&self) -> Limits {
        TwoStageDesign::limits(self)
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

    fn held(&self, hours: f64, _: &dyn Progress) -> Result<HeldDrive, AnalysisError> {
        new_drive(self.drive().joints(), self.rated().torque, hours, Family::TwoStage)
    }

    fn contact_damping(&self) -> Damping {
        TwoStageDesign::contact_damping(self)
    }

    fn as_made(&self, options: &MadeOptions, _: f64) -> Result<Made<TwoStageDesign>, AnalysisError> {
        Made::nominal(self, options)
    }
}
