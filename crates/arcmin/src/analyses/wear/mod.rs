//! Wear depth of the flanks by place and time.

mod declared;
mod page;

pub(super) use declared::{HISTORY, entries};
pub(crate) use declared::{SUMMARY, tables};
pub(crate) use declared::{WEAR as WEAR_TABLE, places};
pub(crate) use page::stations;
pub(super) use page::{COLUMNS, depth_of, page_of, text_blocks_of};

use rayon::prelude::*;

use super::contact::refuse_beyond_closed_form;
use super::{AnalysisError, Attachment, Host, elastic_disc, outcome};
use crate::design::{Choice, Design, default, default_word, optional, options};
use crate::fidelity::{Fidelity, FidelityOptions, Joints};
use crate::geometry::{Profile, Relief};
use crate::life::{
    Accuracy, Courses, MachineCourse, OtherParts, RunAway, STATES_IN_A_ROW, Travel, WornState, accuracy,
    travel,
};
use crate::load::ShareLoad;
use crate::load::closed_form::{self, ClosedForm};
use crate::machine::Machine;
use crate::progress::Counter;
use crate::units::{HOUR, UM};
use crate::wear::paper::PaperWear;
use crate::wear::{CoupledOptions, Exposure, WearCase, WearError};

pub(crate) const ABOUT: &str = "Compute the wear of the flanks over the hours of service";
pub(crate) const GUIDE: &str = "Computes the wear of the flanks over the hours of service at the design's duty. Pins, bearings and \
    gears wear too if the design gives their coefficients.\n\nIn the mode coupled, the worn flank \
    changes the load sharing, which slows the wear down. The mode tao2024 is the method of that paper \
    with ideal joints: one uniform depth whose rate is the largest k (F/B) ξ of all pins.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin wear my-reducer.toml",
    "arcmin wear my-reducer.toml --mode tao2024",
    "arcmin wear my-reducer.toml --hours 2000 --points 40",
];

options! {
    /// Options of `wear`.
    pub struct Options {
        [fidelity: FidelityOptions, joints = "bearings"]
        /// Wear model.
        mode: Mode => default_word("coupled"),
        /// Hours to compute. Left out: the service life of the design.
        hours: Option<f64> => optional(0.0, 1e7),
        /// Number of times at which results are written, between new and the end.
        points: usize => default(30.0, 1.0, 10_000.0),
        /// Largest wear depth between two updates of the flank. For comparison: a contact approaches by about 1.5 µm under load.
        increment_um: f64 => default(0.8, 1e-3, 10.0),
    }
}

/// How wear and load are coupled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// The worn flank changes the load sharing.
    Coupled,
    /// One uniform depth by the paper's rule, with ideal joints.
    Tao2024,
}

impl Choice for Mode {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("coupled", "wear and load sharing change each other"),
        ("tao2024", "one uniform depth; its rate is the largest k (F/B) ξ of all pins"),
    ];
    const VALUES: &'static [Mode] = &[Mode::Coupled, Mode::Tao2024];
}

/// Crank positions at which accuracy is evaluated.
const POSITIONS: usize = 36;

/// Wear over the hours of the flanks and pins of one ring, of a drive of any family.
#[derive(Debug, Clone)]
pub struct WearOverHours {
    /// Name of the design.
    pub name: String,
    /// The flank as cut.
    pub profile: Profile,
    /// Way in which wear and load are coupled.
    pub mode: Mode,
    /// From new to the end.
    pub stations: Vec<Station>,
    /// Wear coefficient over time.
    pub exposure: Exposure,
    /// Updates of the flank; 0 for the uniform depth.
    pub updates: usize,
    /// Largest depth between two updates of the load sharing, m.
    pub increment: f64,
    /// Hours until a uniform depth of 50 µm; `None` for the coupled wear.
    pub hours_to_50_um: Option<f64>,
    /// Runaway of the wear, if any: the stations end before it.
    pub runs_away: Option<RunAway>,
}

/// Wear of an RV reducer.
#[derive(Debug, Clone)]
pub struct Wear {
    /// Wear of flanks and pins over the hours.
    pub hours: WearOverHours,
    /// Machine whose wear it is.
    pub machine: Machine,
    /// Joints, bodies and errors.
    pub fidelity: Fidelity,
}

impl std::ops::Deref for Wear {
    type Target = WearOverHours;

    fn deref(&self) -> &WearOverHours {
        &self.hours
    }
}

/// The drive at one time.
#[derive(Debug, Clone)]
pub struct Station {
    /// Wear of surfaces and parts.
    pub state: WornState,
    /// Errors under load, forces and pressures.
    pub accuracy: Accuracy,
    /// Free travel and play.
    pub travel: Travel,
    /// For a uniform depth: load sharing in closed form, and |φ| in rad of the pin that determines the rate.
    pub handbook: Option<(ClosedForm, f64)>,
}

impl Station {
    /// Running hours since new.
    pub fn hours(&self) -> f64 {
        self.accuracy.hours
    }

    /// φ| in rad at the largest depth of wear of the flank, for a uniform depth that of the pin which determines the rate; `None` without wear.
    pub fn worst_angle(&self) -> Option<f64> {
        let at = self.accuracy.max_depth_at?;
        Some(self.handbook.as_ref().map_or(at.abs(), |(_, angle)| *angle))
    }

    pub(super) fn max_force(&self) -> f64 {
        self.handbook.as_ref().map_or(self.accuracy.max_force, |(solution, _)| solution.max_force)
    }

    pub(super) fn loaded_pairs(&self) -> f64 {
        match &self.handbook {
            Some((solution, _)) => solution.loaded_pairs() as f64,
            None => self.accuracy.loaded_pairs,
        }
    }
}

/// Computes the wear of the machine over the hours.
///
/// # Errors
/// [`AnalysisError`] where no load sharing is found or options contradict each other.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Wear, AnalysisError> {
    let machine = design.machine();
    let end = options.hours.unwrap_or(machine.limits.service_life / HOUR);
    let mut words = options.fidelity.clone();
    if options.mode == Mode::Tao2024 && !words.joints.is_written {
        words.joints.value = Joints::Ideal;
    }
    let fidelity = Fidelity::resolve(design, &words, host)?;
    match options.mode {
        Mode::Coupled => coupled(machine, fidelity, end, options, host),
        Mode::Tao2024 => {
            refuse_beyond_closed_form("the study of Tao2024", &fidelity)?;
            uniform(machine, fidelity, end, options, host)
        }
    }
}

fn times(end: f64, points: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..=points).map(move |index| {
        let share = index as f64 / points as f64;
        (end * share, share)
    })
}

fn coupled(
    machine: Machine,
    fidelity: Fidelity,
    end: f64,
    options: &Options,
    host: &dyn Host,
) -> Result<Wear, AnalysisError> {
    let increment = options.increment_um * UM;
    let settings = CoupledOptions { depth_increment: increment, ..CoupledOptions::default() };
    let course = MachineCourse::new(&machine, &fidelity, settings)?;
    let name = machine.name.clone();
    let mut rings = over_hours(course.into(), name, (end, options.points), increment, host)?;
    Ok(Wear { hours: rings.swap_remove(0), machine, fidelity })
}

/// Follows the coupled wear of a drive of any family, ring by ring, to its `end` (h), with as many stations after the new one.
///
/// # Errors
/// [`AnalysisError`] where no load sharing is found, or the host stops it.
pub(super) fn over_hours<S: ShareLoad + Clone, P: OtherParts>(
    mut courses: Courses<S, P>,
    name: String,
    (end, points): (f64, usize),
    increment: f64,
    host: &dyn Host,
) -> Result<Vec<WearOverHours>, AnalysisError> {
    let failed = || AnalysisError::wear("compute the wear");
    let mut states = Vec::with_capacity(points + 1);
    let mut runs_away = None;
    for (hours, share) in times(end, points) {
        match courses.advance_to(hours, host) {
            Err(WearError::RunsAwayAt { hours, depth_um }) => {
                runs_away = Some(RunAway { hours, depth: depth_um * UM, ring: courses.ran_away() });
                break;
            }
            result => result.map_err(failed())?,
        }
        states.push(courses.states());
        host.report("wear", share);
    }
    let wear = courses.rings().iter().map(|ring| (*ring.exposure(), ring.updates())).collect::<Vec<_>>();
    let rings = courses.for_evaluation();
    let last = states.last().map_or(0.0, |states| states[0].hours);
    let lost: Vec<Vec<WornState>> = match runs_away {
        Some(_) => courses.intermediate_states_after(last),
        None => Vec::new(),
    };
    drop(courses);
    let done = Counter::new("accuracy", states.len() + lost.len(), host);
    let follow = |rows: &[Vec<WornState>]| -> Result<Vec<Vec<Station>>, WearError> {
        let mut rings = rings.clone();
        let mut stations = Vec::with_capacity(rows.len());
        for states in rows {
            if host.is_cancelled() {
                return Err(WearError::Stopped);
            }
            let found = rings.evaluate(states, POSITIONS, true)?.into_iter().zip(states);
            let station = |((accuracy, travel), state): ((Accuracy, Option<Travel>), &WornState)| {
                // The travel was requested.
                Some(Station { state: state.clone(), accuracy, travel: travel?, handbook: None })
            };
            stations.push(found.filter_map(station).collect());
            done.one_more();
        }
        Ok(stations)
    };
    // Figures are those of the last state; tables and pictures show all. A row of states is computed in sequence, each
    // state from the equilibria of the previous one. Rows are not shortened, so that results are the same to the last bit.
    let shows_all = ["wear", "wear_history", "report"].iter().any(|result| host.needs(result));
    let last_row = states.len().saturating_sub(1) / STATES_IN_A_ROW * STATES_IN_A_ROW;
    let states = if shows_all { &states[..] } else { &states[last_row..] };
    let stations: Result<Vec<_>, WearError> = states.par_chunks(STATES_IN_A_ROW).map(follow).collect();
    let mut stations = stations.map_err(failed())?.concat();
    // If the wear runs away, up to the last state with a load sharing.
    stations.extend(lost.iter().map_while(|states| follow(std::slice::from_ref(states)).ok()).flatten());
    if host.is_cancelled() {
        return Err(AnalysisError::Stopped);
    }
    let of_ring = |(ring, (exposure, updates)): (usize, (Exposure, usize))| WearOverHours {
        name: name.clone(),
        profile: rings.cases[ring].profile.clone(),
        mode: Mode::Coupled,
        stations: stations.iter().map(|rings| rings[ring].clone()).collect(),
        exposure,
        updates,
        increment,
        hours_to_50_um: None,
        runs_away,
    };
    Ok(wear.into_iter().enumerate().map(of_ring).collect())
}

fn uniform(
    machine: Machine,
    fidelity: Fidelity,
    end: f64,
    options: &Options,
    host: &dyn Host,
) -> Result<Wear, AnalysisError> {
    let failed = || AnalysisError::wear("compute the wear in closed form");
    let case = WearCase::from(&machine);
    let wear = PaperWear::deep_enough(&machine, end).map_err(failed())?;
    let runs_away = wear.runs_away.map(|(hours, depth)| RunAway { hours, depth, ring: 0 });
    let ends = runs_away.map_or(f64::INFINITY, |end| end.hours);
    let mut stations = Vec::with_capacity(options.points + 1);
    for (hours, share) in times(end, options.points).take_while(|(hours, _)| *hours <= ends) {
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let depth = wear.depth_at(hours).max(0.0);
        let flank = Relief::uniform(depth);
        let mut meshing = machine.meshing(&flank);
        let accuracy = accuracy(&case, &mut meshing, &flank, hours, POSITIONS).map_err(failed())?;
        let travel = travel(&case, &mut meshing, POSITIONS).map_err(failed())?;
        let solution = closed_form::solve(&machine, machine.rated.torque.abs(), depth)
            .map_err(AnalysisError::compute("share the load in closed form"))?;
        let state = WornState { hours, ..WornState::uniform(depth) };
        let handbook = Some((solution, wear.worst_angle_at(depth)));
        stations.push(Station { state, accuracy, travel, handbook });
        host.report("wear", share);
    }
    let hours = WearOverHours {
        hours_to_50_um: Some(wear.hours_at(50.0 * UM)),
        exposure: wear.exposure,
        name: machine.name.clone(),
        profile: case.profile,
        mode: Mode::Tao2024,
        stations,
        updates: 0,
        increment: options.increment_um * UM,
        runs_away,
    };
    Ok(Wear { hours, machine, fidelity })
}

impl WearOverHours {
    /// The machine at the end.
    pub fn last(&self) -> &Station {
        // A run has the new machine at least.
        &self.stations[self.stations.len() - 1]
    }
}

outcome!(Wear {
    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        elastic_disc::attachments(&self.machine, &self.fidelity)
    }
});
