//! Plan of a fit: quantities, their error, and how far the growth is followed.

use super::observations::{
    ASSUMED_NEW, ASSUMED_READING_ARCMIN, ASSUMED_SHARE, NewIs, Observations, Observed,
};
use super::{ReadingOptions, SEARCH_FACTOR};
use crate::analyses::AnalysisError;
use crate::machine::{Limits, Wear};
use crate::units::{ARCMIN, HOUR};
use crate::wear::{Beyond, Measured, New, RunningInFit};

/// Source of the error of a reading, as a share of the scale of the readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReadingError {
    /// Standard deviation that the user gave.
    Given(f64),
    /// From the residuals of the fit.
    Scatter,
    /// There are no data for it.
    Assumed(f64),
}

pub(super) fn running_in(options: &ReadingOptions, wear: &Wear) -> Result<RunningInFit, AnalysisError> {
    match (options.running_in_h, options.fit_running_in) {
        (Some(_), true) => Err(AnalysisError::usage(
            "the time constant of the running-in is both given and fitted",
            "leave out one of running_in_h and fit_running_in",
        )),
        (Some(hours), false) => Ok(RunningInFit::Factor(hours * HOUR)),
        (None, true) => Ok(RunningInFit::Both),
        (None, false) => Ok(RunningInFit::Kept(wear.running_in)),
    }
}

/// The later readings that can be predicted; a machine without earlier readings has no reference for its lost
/// motion.
pub(super) fn predictable(
    fitted: &[Observed],
    others: Vec<Observed>,
    known: &[Option<New>],
    all: &mut Observations,
) -> Vec<Observed> {
    let is_predictable = |observed: &Observed| match observed.reading.measured {
        Measured::LostMotion(machine) => {
            let of = Measured::LostMotion(machine);
            known[machine].is_some() || fitted.iter().any(|observed| observed.reading.measured == of)
        }
        _ => true,
    };
    let (predictable, others): (Vec<Observed>, Vec<Observed>) = others.into_iter().partition(is_predictable);
    let mut names: Vec<String> = others.into_iter().map(|observed| observed.machine).collect();
    names.dedup();
    for name in names {
        all.notes.push(format!("{name} was first read after the fitted readings, so that it is not judged"));
    }
    predictable
}

pub(super) fn reading_error(
    options: &ReadingOptions,
    fitted: &[Observed],
    known: &[Option<New>],
    all: &Observations,
    running_in: RunningInFit,
) -> ReadingError {
    if let Some(percent) = options.reading_error_percent {
        return ReadingError::Given(percent / 100.0);
    }
    let parameters = match running_in {
        RunningInFit::Kept(_) => 1,
        RunningInFit::Factor(_) => 2,
        RunningInFit::Both => 3,
    };
    let read = |machine: usize| {
        fitted.iter().any(|observed| observed.reading.measured == Measured::LostMotion(machine))
    };
    let machines: Vec<usize> = (0..all.machines.len()).filter(|machine| read(*machine)).collect();
    let new = machines.iter().filter(|machine| known[**machine].is_some()).count();
    let is_assumed = machines.iter().any(|machine| all.machines[*machine].new == NewIs::Assumed);
    if fitted.len() + new > machines.len() + parameters && !is_assumed {
        return ReadingError::Scatter;
    }
    let of_machine = |machine: &usize| ASSUMED_READING_ARCMIN * ARCMIN / all.machines[*machine].scale;
    let others = fitted.iter().any(|observed| !matches!(observed.reading.measured, Measured::LostMotion(_)));
    let shares = machines.iter().map(of_machine).chain(others.then_some(ASSUMED_SHARE));
    ReadingError::Assumed(shares.fold(0.0, f64::max))
}

/// To the last reading of all, and to the limit of every machine from each of its readings.
pub(super) fn beyond(
    limits: &Limits,
    predicted: f64,
    fitted: &[Observed],
    others: &[Observed],
    known: &[Option<New>],
) -> Beyond {
    let limit = limits.lost_motion;
    let latest = fitted.iter().chain(others).map(|observed| observed.reading.time).fold(0.0, f64::max);
    // The value when new may be less than the one predicted or given, and with it the limit farther.
    let new = std::iter::once(predicted).chain(known.iter().flatten().map(|new| new.value));
    let mut ends: Vec<(f64, f64)> = new.map(|new| (0.0, limit - (1.0 - 2.0 * ASSUMED_NEW) * new)).collect();
    ends.extend(fitted.iter().filter_map(|observed| {
        let reading = observed.reading;
        matches!(reading.measured, Measured::LostMotion(_)).then_some((reading.time, limit - reading.value))
    }));
    Beyond { latest, ends, time: SEARCH_FACTOR * limits.service_life.max(latest) }
}
