//! Computations for a design, by the functions of the commands.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use arcmin::analyses::stage::AnyDesign;
use arcmin::analyses::{Analysis, AnalysisError, Host, OnlyResults, Origin, by_name};
use arcmin::design::InputFile;
use arcmin::life::WornState;
use arcmin::progress::Progress;
use arcmin::report::Provenance;
use arcmin::results::Table;
use arcmin::scene::Scene;
use serde_json::{Value as Json, json};

use super::answers;
use super::http::Waiting;
use super::session::{Session, State};
use crate::run::{LARGEST_TABLE, read_bounded};

/// Lanes run in parallel; the results of a lane are computed in sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    Sharing,
    Check,
    Life,
    /// Elastic discs may have to be reduced first, for which the life does not wait.
    Bench,
}

impl Lane {
    pub const ALL: [Lane; 4] = [Lane::Sharing, Lane::Check, Lane::Life, Lane::Bench];

    /// Names of the results, each of the analysis of this name except for [`analysis_of`].
    pub fn answers(self) -> &'static [&'static str] {
        match self {
            Lane::Sharing => &["profile", "contact", "film"],
            Lane::Check => &["check"],
            Lane::Life => &["life", "advice"],
            Lane::Bench => &["rig"],
        }
    }
}

impl Lane {
    /// While a value is dragged, long computations start only after a pause: they would slow down the short
    /// ones.
    pub fn patience(self) -> Duration {
        match self {
            Lane::Sharing => Duration::ZERO,
            Lane::Check => Duration::from_millis(50),
            Lane::Life | Lane::Bench => Duration::from_millis(80),
        }
    }
}

/// Results that are available at once or soon: a change waits for these.
pub const HEADLINE: [&str; 3] = ["profile", "contact", "check"];

/// The analysis of a result: `film` is the turn of `contact`; `advice` is a separate value of `life`, which
/// predicts the wear again, so that the life is not delayed by it.
fn analysis_of(name: &str) -> &str {
    match name {
        "film" => "contact",
        "advice" => "life",
        other => other,
    }
}

/// Options for the rolling elements of a film: those of an RV reducer are loaded with joints in bearings only.
const WITH_ROLLERS: &str = "joints = \"bearings\"\n";

/// Options of the analysis of a result that differ from their defaults.
pub fn options(name: &str, design: &AnyDesign) -> &'static str {
    match (analysis_of(name), design) {
        ("life", AnyDesign::Rv(_)) => "quasi_static = true\nbodies = \"rigid\"\n",
        ("life", _) => "discs = \"rigid\"\n",
        _ => "",
    }
}

/// The same as typed.
pub fn command(name: &str, design: &AnyDesign) -> String {
    let typed = options(name, design).lines().map(|line| match line.split_once(" = ") {
        Some((key, "true")) => format!(" --{}", key.replace('_', "-")),
        Some((key, value)) => format!(" --{} {}", key.replace('_', "-"), value.trim_matches('"')),
        None => String::new(),
    });
    format!("arcmin {} DESIGN{}", analysis_of(name), typed.collect::<String>())
}

/// Values of `life` and `rig` that take longer than all others together and that the explorer leaves out.
const LEFT_OUT: [&str; 5] = ["hours_band", "hangs_on", ADVICE, "verdict.undecided", "elastic_discs"];
/// Start of the keys of the advice, which is a separate result.
const ADVICE: &str = "advice";

/// Required results: every value of the summary, and for the life its tables.
fn wanted(name: &str, analysis: &Analysis, design: &AnyDesign, scene: &Scene) -> Vec<String> {
    let Ok(declared) = design.results(analysis) else { return Vec::new() };
    let is_quick = |key: &String| !LEFT_OUT.iter().any(|left| key.starts_with(left));
    let figures = declared.summary.iter().map(|quantity| quantity.key.to_owned());
    match name {
        "film" => scene
            .rings
            .iter()
            .flat_map(|ring| [answers::contact_table(ring), answers::rollers_table(ring, design)])
            .chain(["error".to_owned()])
            .collect(),
        ADVICE => figures.filter(|key| key.starts_with(ADVICE)).collect(),
        "life" => figures.filter(is_quick).chain(["life".to_owned()]).collect(),
        _ => figures.filter(is_quick).collect(),
    }
}

/// Computes a result as JSON. `None` if it was cancelled.
pub fn answer(
    name: &'static str,
    session: &Arc<Session>,
    state: &Arc<State>,
    cancelled: &Arc<AtomicBool>,
) -> Option<String> {
    let Some(analysis) = by_name(analysis_of(name)) else {
        unreachable!("answers are named after analyses");
    };
    let host = Explorer { session, state, cancelled, name };
    let scene = state.design.scene();
    let wanted = wanted(name, analysis, &state.design, &scene);
    let wanted: Vec<&str> = wanted.iter().map(String::as_str).collect();
    let started = session.seconds();
    let run = || {
        if wanted.is_empty() {
            return Ok(
                json!({ "status": "not_available", "error": format!("not for {}", state.design.family().drives()) }),
            );
        }
        let host = OnlyResults { host: &host, results: &wanted };
        let outcome = state.design.run(analysis, options(name, &state.design), "the options", &host)?;
        let mut answer = json!({ "status": "done", "summary": outcome.summary().to_json() });
        match name {
            "film" => {
                let tables = outcome.tables();
                let in_bearings = match &state.design {
                    AnyDesign::Rv(_) => rollers_in_bearings(state, analysis, &scene, &host)?,
                    _ => Vec::new(),
                };
                let rollers = if in_bearings.is_empty() { &tables } else { &in_bearings };
                let film = answers::film(&tables, rollers, &state.design, &scene);
                answer = json!({ "status": "done", "film": film });
            }
            "life" => {
                answer["table"] = answers::table(outcome.tables().iter().find(|table| table.name == "life"));
                answer["ages"] = answers::ages(outcome.as_ref(), &host)?;
            }
            _ => {}
        }
        Ok(answer)
    };
    // A panic in one computation must not end the server.
    let found = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
    if cancelled.load(Ordering::SeqCst) {
        return None;
    }
    let mut answer: Json = match found {
        Ok(Ok(answer)) => answer,
        Ok(Err(AnalysisError::Stopped | AnalysisError::Interrupted { .. })) => return None,
        Ok(Err(error)) => json!({
            "status": if state.design.results(analysis).is_err() { "not_available" } else { "failed" },
            "error": error.to_string(),
            "hint": error.help(),
        }),
        Err(_) => {
            json!({ "status": "failed", "error": "the computation broke off: a defect of the program" })
        }
    };
    answer["command"] = json!(command(name, &state.design));
    answer["seconds"] = json!(session.seconds() - started);
    Some(answer.to_string())
}

/// Tables of the rolling elements of an RV reducer over the same turn, with its joints in bearings.
fn rollers_in_bearings(
    state: &State,
    analysis: &Analysis,
    scene: &Scene,
    host: &dyn Host,
) -> Result<Vec<Table>, AnalysisError> {
    let names: Vec<String> =
        scene.rings.iter().map(|ring| answers::rollers_table(ring, &state.design)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let host = OnlyResults { host, results: &names };
    Ok(state.design.run(analysis, WITH_ROLLERS, "the options", &host)?.tables())
}

/// The report of an analysis as written by its command, one at a time, until the client disconnects.
///
/// # Errors
/// As [`AnyDesign::run`].
pub fn report(
    name: &str,
    session: &Session,
    state: &State,
    waiting: &Waiting<'_>,
) -> Result<String, AnalysisError> {
    let Some(analysis) = by_name(name) else { unreachable!("reports are those of analyses") };
    let design = &state.design;
    let _alone = session.reporting.lock().unwrap_or_else(PoisonError::into_inner);
    let host = Reporter { session, waiting };
    let outcome = design.run(analysis, options(name, design), "the options", &host)?;
    let mut page = outcome.page();
    page.provenance =
        Provenance { command: command(name, design), ..crate::provenance(&design.hash(), outcome.seeds()) };
    Ok(page.render())
}

/// The host of a report.
struct Reporter<'a> {
    session: &'a Session,
    waiting: &'a Waiting<'a>,
}

impl Progress for Reporter<'_> {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        self.waiting.is_over()
    }
}

impl Host for Reporter<'_> {
    fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        named_file(self.session, file, origin)
    }

    fn seconds(&self) -> f64 {
        self.session.seconds()
    }
}

/// A file that was named in the design when it was opened.
fn named_file(session: &Session, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
    let refused = |message: String| AnalysisError::Input {
        file: file.0.clone(),
        line: None,
        message,
        help: "close the explorer and open the design again".to_owned(),
    };
    if origin != Origin::Design || !session.named_files.contains(&file.0) {
        return Err(refused(
            "the explorer reads only files that the design named when it was opened".to_owned(),
        ));
    }
    read_bounded(&session.directory().join(&file.0), LARGEST_TABLE)
        .map_err(|cause| refused(format!("cannot be read: {cause}")))
}

/// The host of one computation: cancels it when another design is selected.
struct Explorer<'a> {
    session: &'a Session,
    state: &'a State,
    cancelled: &'a AtomicBool,
    name: &'static str,
}

impl Progress for Explorer<'_> {
    fn report(&self, stage: &str, share: f64) {
        // Steps below a thousandth are not visible, and other threads wait for the lock.
        let rounded = (share * 100.0).floor() / 100.0;
        self.session.report_progress(self.state, self.name, stage, rounded);
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl Host for Explorer<'_> {
    fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        named_file(self.session, file, origin)
    }

    fn reached(&self, state: &WornState) {
        let point = answers::reached(state, &self.state.design.scene()).to_string().into();
        self.session.add_results(self.state, |known| known.reached.push(point));
    }

    fn seconds(&self) -> f64 {
        self.session.seconds()
    }
}
