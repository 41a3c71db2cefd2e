//! Accuracy over running hours, and the limit that ends the life of a machine.

mod advice;
mod ages;
mod band;
mod bearings;
mod declared;
mod demands;
mod effects;
mod fatigue;
mod figures;
mod judgement;
pub(in crate::analyses) mod limits;
mod page;
mod record;
#[cfg(test)]
mod tests;
mod undecided;
mod verdict;

pub use advice::Advice;
pub use ages::Age;
pub use band::Band;
pub(in crate::analyses) use band::{BandResults, Inputs, no_band};
pub(in crate::analyses) use bearings::TABLE as BEARINGS;
pub use bearings::{AssumedFriction, BearingLife, BearingLives, bearing_lives, catalogue_life_at_duty};
pub(in crate::analyses) use bearings::{WEIBULL_SLOPE, system_life};
pub(crate) use declared::limit_hours;
pub(in crate::analyses) use declared::{LIFE, Row, entries};
pub(crate) use declared::{SUMMARY, tables};
pub use demands::Demands;
pub(in crate::analyses) use effects::{LOADED, states_of};
pub(in crate::analyses) use judgement::banded;
pub use judgement::{Judgement, WithElasticBodies};
pub(in crate::analyses) use page::findings_section;
pub(in crate::analyses) use record::Record;
pub use undecided::Undecided;
pub(crate) use verdict::about;
pub use verdict::{LifeVerdict, Limit, LimitKind};

use super::{AnalysisError, Attachment, Host, elastic_disc, outcome};
use crate::checks::{self, Finding};
use crate::design::{Design, default, optional, options};
use crate::fidelity::{Fidelity, FidelityOptions};
use crate::geometry::Profile;
use crate::life::{LifeOptions, LifePoint, Prediction, most_loaded, predict};
use crate::load::{Cycle, ShareLoad};
use crate::machine::Machine;
use crate::report::Section;
use judgement::{alone, judge_elastic, needs_both};

pub(crate) const ABOUT: &str = "Predict accuracy over the hours of service and the limit that ends the life";
pub(crate) const GUIDE: &str = "The main job: accuracy of the reducer over its running hours, the limit that ends its life, and the \
    changes that help most.\n\nThe command predicts wear coupled to the load sharing. Over the service \
    life it computes play, lost motion by cause, transmission error, forces and pressures. At five ages \
    it runs the multibody model without load (STE) and under a sinusoidal load (DTE). It rates every \
    bearing by ISO 281 at the design's duty. All limits enter one verdict. A limit that is not kept \
    gives verdict.ok = false; the run itself has not failed.\n\nEvery limit has a band of hours that \
    contains nine of ten machines within the design's [unknowns], from first-order sensitivities (--band \
    computes whole lives instead). The machine is judged with rigid and with elastic bodies; a limit \
    that only one of them keeps is undecided. --bodies rigid or --bodies elastic judges with one of \
    them. Drives of eccentrics with output pins have elastic discs; --discs rigid is quicker and states \
    by how much its stiffness is off.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin life my-reducer.toml",
    "arcmin life my-reducer.toml --quasi-static",
    "arcmin life my-reducer.toml --bodies elastic",
    "arcmin life my-reducer.toml --errors drawn --seed 7",
];

/// Results that need the sensitivities of the hours to the inputs.
pub(in crate::analyses) const OF_BANDS: &[&str] = &["hours_band", "hangs_on", "report"];

options! {
    /// Options of `life`.
    pub struct Options {
        [fidelity: FidelityOptions, joints = "bearings"]
        /// Number of times between new and the end of the service life.
        points: usize => default(30.0, 4.0, 1000.0),
        /// Leave out the multibody runs (STE and DTE).
        quasi_static: bool => optional(0.0, 0.0),
    }
}

/// Accuracy over the hours of a drive of any family, and the verdict.
#[derive(Debug, Clone)]
pub struct DriveLife {
    /// Turns of the input for one of the output.
    pub ratio: f64,
    /// The flank as cut.
    pub profile: Profile,
    /// Duty, limits and speeds.
    pub demands: Demands,
    /// Wear and accuracy over the hours.
    pub prediction: Prediction,
    /// Rating lives of the bearings.
    pub bearings: BearingLives,
    /// Findings of the design.
    pub findings: Vec<Finding>,
    /// Limits with their hours, and the first of them.
    pub verdict: LifeVerdict,
    /// Wall seconds of the stages.
    pub stages: Vec<(&'static str, f64)>,
}

/// The life of an RV reducer.
#[derive(Debug, Clone)]
pub struct Life {
    /// Machine of the design.
    pub machine: Machine,
    /// Joints, bodies and errors.
    pub fidelity: Fidelity,
    /// Prediction and verdict.
    pub drive: DriveLife,
    /// Multibody runs at some points of the prediction; empty if left out.
    pub ages: Vec<Age>,
    /// The same machine with elastic bodies, unless the options name the bodies.
    pub with_elastic_bodies: WithElasticBodies,
    /// Load sharing over one pin pitch of crank angle at the points that the report shows, by their number.
    pitches: Vec<(usize, Cycle)>,
    /// Whether rigid bodies were chosen in the options.
    bodies_are_chosen: bool,
    /// Changes of the design with the life that each would give.
    pub advice: Vec<Advice>,
    /// The design as written.
    design_text: String,
    elastic: Option<Section>,
}

/// Predicts the life.
///
/// # Errors
/// [`AnalysisError`] where no load sharing or no wear coefficient is found, or the host stops it.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Life, AnalysisError> {
    let machine = design.machine();
    let mut clock = Clock::new(host);
    let mut findings = checks::check_design(design);
    clock.stage("check");
    let fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    clock.stage("fidelity");
    // The verdict needs the free travel if it has a limit.
    let travel = machine.limits.backlash.is_some() || declared::needs_travel(host);
    let quasi_static = options.quasi_static || !declared::needs_runs(host);
    let causes = host.needs("lost_motion_causes");
    let mut settings = LifeOptions { intervals: options.points, travel, causes, ..LifeOptions::default() };
    if !declared::needs_search(host) {
        settings.search_factor = 1.0;
    }
    let (prediction, ages) = predict_with_runs(&machine, &fidelity, settings, quasi_static, host)?;
    let pitches = if host.needs("report") { pitches(&machine, &fidelity, &prediction)? } else { Vec::new() };
    clock.stage(if quasi_static { "prediction" } else { "prediction_and_simulation" });
    host.report("bearings", 0.0);
    let bearings = bearing_lives(&machine, &fidelity.joint_settings()?, bearings::POSITIONS)?;
    let emergency = emergency_pressure(&machine, &fidelity, &prediction)?;
    clock.stage("bearings");
    let inputs = if OF_BANDS.iter().any(|result| host.needs(result)) {
        host.report("bands of the limits", 0.0);
        match effects::inputs_of(design, &fidelity, &prediction, host) {
            Ok(inputs) => Some(inputs),
            Err(AnalysisError::Stopped) => return Err(AnalysisError::Stopped),
            Err(error) => {
                findings.push(no_band(&error));
                None
            }
        }
    } else {
        None
    };
    let demands = Demands::of(&machine);
    let record = Record::of(demands.clone(), &prediction, &bearings, &findings, emergency);
    let (service_h, searched_h) = (record.service_h, record.searched_h);
    let (limits, band) = banded(&[record], &alone, inputs.as_ref());
    clock.stage("bands");
    let with_elastic_bodies = if needs_both(&options.fidelity, host) {
        judge_elastic(design, &machine, options, &findings, inputs.as_ref(), host)?
    } else {
        WithElasticBodies::NotAsked
    };
    with_elastic_bodies.note(&mut findings);
    clock.stage("elastic_bodies");
    let undecided = with_elastic_bodies.undecided(&limits, service_h);
    let verdict = LifeVerdict { limits, service_h, searched_h, band, undecided };
    let advice = if host.needs("advice") || host.needs("advice_keys") {
        host.report("advice", 0.0);
        advice::advise(design, &fidelity, &prediction, &verdict, host)?
    } else {
        Vec::new()
    };
    clock.stage("advice");
    let elastic = elastic_disc::section(&machine, &fidelity)?;
    let drive = DriveLife {
        ratio: machine.kinematics().ratio(),
        profile: machine.profile(),
        demands,
        prediction,
        bearings,
        findings,
        verdict,
        stages: clock.stages,
    };
    Ok(Life {
        design_text: design.text().to_owned(),
        machine,
        fidelity,
        drive,
        ages,
        with_elastic_bodies,
        pitches,
        bodies_are_chosen: options.fidelity.bodies.is_written,
        advice,
        elastic,
    })
}

/// Wall seconds of the stages.
pub(in crate::analyses) struct Clock<'a> {
    host: &'a dyn Host,
    since: f64,
    pub stages: Vec<(&'static str, f64)>,
}

impl<'a> Clock<'a> {
    pub fn new(host: &'a dyn Host) -> Clock<'a> {
        Clock { host, since: host.seconds(), stages: Vec::new() }
    }

    pub fn stage(&mut self, name: &'static str) {
        let now = self.host.seconds();
        self.stages.push((name, now - self.since));
        self.since = now;
    }
}

/// Pin pitches of the points in the report, up to the last point with a solution of the load sharing.
fn pitches(
    machine: &Machine,
    fidelity: &Fidelity,
    prediction: &Prediction,
) -> Result<Vec<(usize, Cycle)>, AnalysisError> {
    let mut joints = fidelity.meshing(machine)?;
    let positions = LifeOptions::default().crank_positions;
    let of = |index: usize| {
        prediction.points[index].state.apply_to(&machine.designed_relief(), &mut joints);
        let cycle = joints.pitch_cycle(machine.rated.torque, positions).ok()?;
        Some((index, cycle))
    };
    Ok(figures::shown(prediction.points.len()).filter_map(of).collect())
}

/// The prediction; multibody runs start on the other cores as soon as their state is reached.
fn predict_with_runs(
    machine: &Machine,
    fidelity: &Fidelity,
    settings: LifeOptions,
    quasi_static: bool,
    host: &dyn Host,
) -> Result<(Prediction, Vec<Age>), AnalysisError> {
    if quasi_static {
        return Ok((predict(machine, fidelity, settings, host, |state| host.reached(state))?, Vec::new()));
    }
    let wanted = ages::points(settings.intervals);
    let runs = ages::Runs::default();
    let prediction = rayon::scope(|scope| {
        let (mut reached, mut begun) = (0, 0);
        let prediction = predict(machine, fidelity, settings, host, |state| {
            host.reached(state);
            if wanted.contains(&reached) {
                for job in ages::jobs(reached, state) {
                    let runs = &runs;
                    scope.spawn(move |_| runs.run(job, machine, fidelity, host));
                    begun += 1;
                }
            }
            reached += 1;
        });
        runs.wait_for(begun, host);
        prediction
    })?;
    Ok((prediction, runs.ages()?))
}

/// Largest pressure at the emergency torque that the design names, new and at the end.
fn emergency_pressure(
    machine: &Machine,
    fidelity: &Fidelity,
    prediction: &Prediction,
) -> Result<Option<f64>, AnalysisError> {
    let Some(torque) = machine.limits.emergency_torque else { return Ok(None) };
    let torque = torque.copysign(machine.rated.torque);
    let mut largest = 0.0_f64;
    for point in prediction.points.first().into_iter().chain(prediction.points.last()) {
        let mut meshing = fidelity.meshing(machine)?;
        point.state.apply_to(&machine.designed_relief(), &mut meshing);
        let found = most_loaded(&mut meshing, torque, LifeOptions::default().crank_positions)
            .map_err(AnalysisError::compute("share the load of an emergency stop"))?;
        largest = largest.max(found.largest_pressure.pressure);
    }
    Ok(Some(largest))
}

impl std::ops::Deref for Life {
    type Target = DriveLife;

    fn deref(&self) -> &DriveLife {
        &self.drive
    }
}

impl DriveLife {
    /// The new machine.
    pub fn first(&self) -> &LifePoint {
        &self.prediction.points[0]
    }

    /// The machine at the end of its service life.
    pub fn last(&self) -> &LifePoint {
        // A prediction has the new machine at least.
        &self.prediction.points[self.prediction.points.len() - 1]
    }
}

outcome!(Life {
    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        elastic_disc::attachments(&self.machine, &self.fidelity)
    }
});
