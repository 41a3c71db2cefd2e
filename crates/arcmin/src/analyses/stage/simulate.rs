//! The motion of drives of eccentrics in time.

use super::drive::EccentricDrive;
use super::made::{HasStageFidelity, Made, MadeOptions, StageFidelity, fidelity_entries};
use super::meshing::wear_down;
use super::{Facts, StageBodies, StageJoints};
use crate::analyses::multibody::Driven;
use crate::analyses::simulate::motion::{self, HasMotion};
use crate::analyses::simulate::{self, Inputs, Motion, MotionOptions};
use crate::analyses::{AnalysisError, Host, NoHost, Outcome, TextBlock};
use crate::design::{default, default_word, options};
use crate::dynamics::{Drive, ElasticDiscs, Model, OutputLoad};
use crate::fidelity::{DiscBodies, FidelityOptions};
use crate::report::Page;
use crate::results::{DeclaredTable, Summary, SummaryOf, Table, quantities as q};

pub(crate) const ABOUT: &str = simulate::ABOUT;

options! {
    /// Options of `simulate` for a single stage. As on the bench positive torque opposes positive output motion; if
    /// the output turns in the opposite direction of the input, it drives at positive speeds.
    pub struct Options {
        [motion: MotionOptions]
        [made: MadeOptions]
        /// Joints.
        joints: StageJoints => default_word("bearings"),
        /// Bodies.
        bodies: StageBodies => default_word("rigid"),
        /// Age of the drive in hours of its duty: flanks, pins and bearings are worn accordingly.
        hours: f64 => default(0.0, 0.0, 1e7),
    }
}

/// A run with its settings.
#[derive(Debug, Clone)]
pub struct StageMotion {
    /// Run with plan and result.
    pub motion: Motion,
    /// Running hours of the wear of the drive.
    pub hours: f64,
    facts: Facts,
    made: StageFidelity,
}

impl HasStageFidelity for StageMotion {
    fn fidelity(&self) -> &StageFidelity {
        &self.made
    }
}

impl HasMotion for StageMotion {
    fn motion(&self) -> &Motion {
        &self.motion
    }
}

pub(crate) const SUMMARY: SummaryOf<StageMotion> = SummaryOf {
    entries: || {
        let mut entries = simulate::error_entries::<StageMotion>();
        entries.push(q::HOURS.of(|o: &StageMotion| o.hours.into()));
        entries.extend(simulate::solver_entries());
        entries.extend(fidelity_entries::<StageMotion>());
        entries
    },
};

/// Those of RV reducers.
pub fn tables() -> Vec<DeclaredTable> {
    simulate::tables()
}

/// Share of the rated speed over which the drag increases to its full value.
const DRAG_SPEED: f64 = 0.01;

/// Integrates the motion.
///
/// # Errors
/// As [`simulate::run`].
pub fn run<D: EccentricDrive>(
    design: &D,
    options: &Options,
    host: &dyn Host,
) -> Result<StageMotion, AnalysisError> {
    let Made { design, discs, fidelity: made } = &design.as_made(&options.made, host)?;
    let given = &options.motion;
    let Inputs { drive, load, notes } = Inputs::read(given, design.rated(), host)?;
    let model = model((design, discs), (options.hours, given.drag_nm), drive, load, host)?;
    let motion = motion::run(model, given, 0.0, notes, host)?;
    Ok(StageMotion { motion, hours: options.hours, facts: Facts::of(design), made: made.clone() })
}

/// The drive in motion after some hours, with a torque of drag (N·m) at the output.
fn model<D: EccentricDrive>(
    (design, discs): (&D, &[ElasticDiscs]),
    (hours, drag): (f64, f64),
    drive: Drive,
    load: OutputLoad,
    host: &dyn Host,
) -> Result<Model, AnalysisError> {
    let mut joints = design.moving(discs)?;
    wear_down(design, discs, hours, host, |stage, surfaces, parts| {
        joints.set_stage_wear(stage, surfaces, parts)
    })?;
    let drag_speed = (DRAG_SPEED * design.rated().input_speed / design.ratio()).abs().max(1e-6);
    Ok(joints.moving(design.contact_damping(), (drag, drag_speed), drive, load).into())
}

/// As [`multibody::require`](crate::analyses::multibody::require).
///
/// # Errors
/// As there.
pub fn require<D: EccentricDrive>(design: &D, options: &FidelityOptions) -> Result<(), AnalysisError> {
    let options = MadeOptions::of_fidelity(options)?;
    if options.discs.value == DiscBodies::Elastic {
        design.disc_shapes()?;
    }
    // Without reducing the discs.
    design.as_made(&options.with_discs(DiscBodies::Rigid), &NoHost).map(|_| ())
}

/// As [`multibody`](crate::analyses::multibody::multibody()).
///
/// # Errors
/// As there.
pub fn multibody<D: EccentricDrive>(
    design: &D,
    options: &FidelityOptions,
    driven: Driven,
    host: &dyn Host,
) -> Result<Model, AnalysisError> {
    let Made { design, discs, .. } = design.as_made(&MadeOptions::of_fidelity(options)?, host)?;
    let Driven { drive, load, hours, .. } = driven;
    model((&design, &discs), (hours, 0.0), drive, load, host)
}

impl StageMotion {
    /// Contents of the model.
    fn physics(&self) -> String {
        format!("{}, damped and without friction", self.made.model(self.facts.stages))
    }
}

impl Outcome for StageMotion {
    fn summary(&self) -> Summary {
        SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        simulate::fill(&self.motion)
    }

    fn failure(&self) -> Option<String> {
        self.motion.broke_off.clone()
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        let physics = self.physics();
        let state = if self.hours > 0.0 { format!("after {:.0} h", self.hours) } else { "new".to_owned() };
        let blocks =
            simulate::text_blocks_of(format!("{}: {state}; {physics}", self.facts.name), &self.motion);
        self.made.text_blocks().into_iter().chain(blocks).collect()
    }

    fn page(&self) -> Page {
        let state = if self.hours > 0.0 { "worn" } else { "new" };
        simulate::page_of(self.facts.name.clone(), state, (self.physics(), self.facts.ring), &self.motion)
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
