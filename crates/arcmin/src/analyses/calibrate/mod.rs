//! Wear coefficient fitted to measurements, with its confidence band and the remaining hours of the machine.

mod declared;
mod drive;
mod limits;
mod lives;
mod observations;
mod page;
mod pasted;
mod plan;
mod shorthand;
#[cfg(test)]
mod tests;

use std::ops::Deref;

pub(crate) use declared::{SUMMARY, tables};
pub(in crate::analyses) use declared::{entries, fill};
pub(in crate::analyses) use drive::{CalibratedDrive, FIT};
pub use limits::{End, Remaining, conditional_life, survival};
pub use lives::{CurvePoint, MachineLife};
pub use observations::{NewIs, Observed};
pub(in crate::analyses) use page::{page, text_blocks};
pub use plan::ReadingError;

use self::lives::{curve, lives};
use self::observations::ASSUMED_NEW;
use self::plan::{beyond, predictable, reading_error, running_in};
use self::shorthand::SelectedLimit;
use super::life::{LifeVerdict, LimitKind};
use super::stage::AnyDesign;
use super::{AnalysisError, Attachment, Host, outcome};
use crate::design::{Design, InputFile, Value, optional, options, positional};
use crate::fidelity::{Fidelity, FidelityOptions};
use crate::machine::{Limits, Wear};
use crate::report::{compact, significant};
use crate::units::{ARCMIN, HOUR};
use crate::wear::{Fit, FitPlan, Measured, Model, RunningInFit, Truth};

pub(crate) const ABOUT: &str =
    "Fit the wear coefficient to readings of a machine and predict its remaining hours";
pub(crate) const GUIDE: &str = "Fits the wear coefficient k of the coupled prediction to readings by least squares, with its 95 % \
    band, and predicts for how many hours the machine keeps each of its limits. With manufacturing \
    errors the readings are those of one real machine.\n\nOne reading is enough (--reading \
    5200h=1.4arcmin). The lost motion of the new machine is then --new-arcmin or the design's. A file \
    has a column hours and one or more of the columns depth_um (largest wear depth of a flank), \
    lost_motion_increase_arcmin (since new) and lost_motion_arcmin (as measured; its value when new is \
    fitted too). A column machine separates several machines of one design. Empty fields are allowed. \
    Residuals of increases and depths are relative to their value, residuals of lost motion to the \
    largest growth of their machine.\n\nThe running-in is that of the design, or it is fitted: its \
    factor (--running-in-h), or factor and time constant (--fit-running-in). The run names parameters \
    that the readings cannot separate. Bands come from the profile likelihood. They use the scatter of \
    the readings, or the error of a reading if it is given, or an assumed error.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin calibrate my-reducer.toml --reading 5200h=1.4arcmin --limit lost_motion=2",
    "arcmin calibrate my-reducer.toml measured.csv",
    "arcmin calibrate my-reducer.toml measured.csv --fit-until-h 600",
    "arcmin calibrate my-reducer.toml measured.csv --reading-error-percent 5 --fit-running-in",
    "",
    "measured.csv:",
    "machine,hours,lost_motion_arcsec",
    "A17,0,38.2",
    "A17,600,48.8",
    "A17,1550,51.1",
];

options! {
    /// Options of `calibrate`.
    pub struct Options {
        [fidelity: FidelityOptions, joints = "bearings"]
        [readings: ReadingOptions]
    }

    /// Readings, and the requested results.
    pub struct ReadingOptions {
        /// File of readings. Columns: hours, and depth_um, lost_motion_increase_arcmin or lost_motion_arcmin; optional: machine.
        data: Option<InputFile> => positional(),
        /// One reading: 5200h=1.4arcmin (lost motion), 5200h=+0.4arcmin (its increase since new) or 5200h=12um (wear depth of
        /// the flank); may be given several times.
        reading: Vec<String> => optional(0.0, 0.0),
        /// Lost motion of the new machine. Left out: fitted to the readings; with one reading, the value that the design
        /// predicts.
        new_arcmin: Option<f64> => optional(-600.0, 600.0),
        /// Limit for the remaining hours, such as lost_motion or bearing_life; lost_motion=2 sets another value than the
        /// design's. Left out: the limit that is reached first.
        limit: Option<String> => optional(0.0, 0.0),
        /// Fit only readings up to this time and compare the prediction with later ones.
        fit_until_h: Option<f64> => optional(0.0, 1e7),
        /// Time constant of a running-in whose factor is fitted; it replaces the running-in of the design.
        running_in_h: Option<f64> => optional(1e-3, 1e7),
        /// Fit factor and time constant of a running-in; they replace the running-in of the design.
        fit_running_in: bool => optional(0.0, 0.0),
        /// Standard deviation of a reading, in percent of its value; for lost motion, of the largest growth of its machine.
        /// Left out: from the scatter of the readings if there are more readings than parameters, otherwise 0.05 arcmin (5 %
        /// for depths and increases).
        reading_error_percent: Option<f64> => optional(1e-6, 1e3),
    }
}

/// One reading with its prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Reading with its machine.
    pub observed: Observed,
    /// In the unit of the reading; `None` beyond the computed growth.
    pub predicted: Option<f64>,
    /// By the bands of the parameters.
    pub band: Option<(f64, f64)>,
    /// Whether it is part of the fit.
    pub fitted: bool,
}

/// A fitted coefficient.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// Name of the design.
    pub name: String,
    /// Limits of the design.
    pub limits_of_design: Limits,
    /// Laws and coefficients of wear with the fitted one.
    pub wear: Wear,
    /// Sentence about the models used.
    pub physics: String,
    /// Parameters with their bands.
    pub fit: Fit,
    /// Readings with their predictions, in the given order.
    pub rows: Vec<Row>,
    /// Hours to the limit of lost motion, machine by machine.
    pub lives: Vec<MachineLife>,
    /// Every limit of every machine; of each machine the lost motion first.
    pub limits: Vec<Remaining>,
    /// Course of depth and lost motion with their bands.
    pub curve: Vec<CurvePoint>,
    /// Range of the computed growth, in hours at the fitted coefficient.
    pub followed_h: f64,
    /// The law of running-in that was fitted together with the coefficient.
    pub running_in: RunningInFit,
    /// Error of a reading that the bands use.
    pub reading_error: ReadingError,
    /// The limit named in the options, if any.
    selected: Option<SelectedLimit>,
    /// The design with the fitted coefficient.
    pub design: Option<AnyDesign>,
    /// Readings that were not used and limits that were not judged, with reasons.
    pub notes: Vec<String>,
}

/// That of an RV reducer.
#[derive(Debug, Clone)]
pub struct Calibrated {
    calibration: Calibration,
    /// Joints, bodies and errors of the modelled machine.
    pub fidelity: Fidelity,
}

impl Deref for Calibrated {
    type Target = Calibration;

    fn deref(&self) -> &Calibration {
        &self.calibration
    }
}

/// Relative root mean square of the residuals above which the fit is an error.
const FAILED: f64 = 0.5;
/// Relative residual above which the fit is reported as doubtful.
const POOR: f64 = 0.1;
/// Relative difference of the lost motion when new above which the machine is reported as different from the design.
const APART: f64 = 0.5;
/// Multiple of the service life up to which the limit is searched.
const SEARCH_FACTOR: f64 = 4.0;

/// Fits the coefficient of an RV reducer.
///
/// # Errors
/// [`AnalysisError`]: an invalid file, no reading to fit, a fit that fails.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Calibrated, AnalysisError> {
    let selected = options.readings.selected()?;
    let limited =
        selected.as_ref().map_or_else(|| Ok(design.clone()), |limit| design.with_all(limit.change()))?;
    let fidelity = Fidelity::resolve(&limited, &options.fidelity, host)?;
    let machine = limited.machine();
    let drive = drive::Reducer { design, machine, fidelity, options: &options.fidelity };
    let calibration = of_drive(&drive, &options.readings, host)?;
    Ok(Calibrated { calibration, fidelity: drive.fidelity })
}

/// Fits the coefficient of a drive.
///
/// # Errors
/// As [`run`].
pub(in crate::analyses) fn of_drive(
    drive: &impl CalibratedDrive,
    options: &ReadingOptions,
    host: &dyn Host,
) -> Result<Calibration, AnalysisError> {
    let selected = options.selected()?;
    let (limits, wear) = (drive.limits(), drive.wear()?);
    let running_in = running_in(options, &wear)?;
    let given = options.new_arcmin.map(|new| new * ARCMIN);
    let mut all = observations::read(options.data.as_ref(), &options.reading, given, host)?;
    host.report("calibration", 0.0);
    let predicted = drive.new_lost_motion()?;
    let mut known = all.settle(given, predicted)?;
    let until = options.fit_until_h.unwrap_or(f64::INFINITY) * HOUR;
    let (fitted, others): (Vec<Observed>, Vec<Observed>) = std::mem::take(&mut all.readings)
        .into_iter()
        .partition(|observed| observed.reading.time <= until * (1.0 + 1e-9));
    let others = predictable(&fitted, others, &known, &mut all);
    let reading_error = reading_error(options, &fitted, &known, &all, running_in);
    let error = match reading_error {
        ReadingError::Given(error) | ReadingError::Assumed(error) => Some(error),
        ReadingError::Scatter => None,
    };
    for (new, one) in known.iter_mut().zip(&all.machines) {
        if let (Some(new), NewIs::Assumed, Some(error)) = (new, one.new, error) {
            new.error = ASSUMED_NEW * predicted.abs() / (error * one.scale);
        }
    }
    let readings = Observed::together(&fitted, &known);
    if readings.targets().is_empty() {
        return Err(match options.fit_until_h {
            Some(hours) => AnalysisError::usage(
                format!("there is no growth to fit up to {hours} h"),
                "choose a later fit_until_h",
            ),
            None => AnalysisError::usage(
                "all readings are at 0 hours: there is no growth to fit",
                "give a later reading",
            ),
        });
    }
    let plan = FitPlan {
        running_in,
        reading_error: error,
        beyond: beyond(&limits, predicted, &fitted, &others, &known),
    };
    let (growth, fit) = drive.fit(&readings, &plan, host)?;
    if !(fit.relative_rms < FAILED) {
        return Err(AnalysisError::usage(
            format!(
                "no wear coefficient fits: the residuals of the best one are {:.0} % of the readings",
                100.0 * fit.relative_rms
            ),
            "check units and hours of the file; for a growth that slows down fit a running-in (running_in_h)",
        ));
    }
    let model = Model::new(&growth, &readings);
    let row = |observed: Observed, fitted: bool| {
        let reading = observed.reading;
        let of = |truth: &Truth| match growth.covers(truth.law.at(reading.time)) {
            true => model.value(&reading, truth),
            false => f64::INFINITY,
        };
        let predicted = Some(of(&Truth::best(fit.law))).filter(|value| value.is_finite());
        let band = fit.band(of).filter(|(_, high)| high.is_finite());
        Row { predicted, band, observed, fitted }
    };
    let rows: Vec<Row> = fitted
        .into_iter()
        .map(|observed| row(observed, true))
        .chain(others.into_iter().map(|observed| row(observed, false)))
        .collect();
    let lives = lives(&limits, given.unwrap_or(predicted), &model, &fit, &all, &rows);
    let curve = curve(&growth, &fit, &rows, &lives);
    let followed_h = fit.law.time_at(growth.last()) / HOUR;
    let fits_running_in = !matches!(running_in, RunningInFit::Kept(_));
    let mut calibrated = Calibration {
        design: pasted::into_design(&drive.design(), &fit.law, fits_running_in),
        limits: lives.iter().map(|life| life.remaining(followed_h)).collect(),
        selected,
        name: drive.name(),
        limits_of_design: limits,
        wear,
        physics: drive.physics(),
        fit,
        rows,
        lives,
        curve,
        followed_h,
        running_in,
        reading_error,
        notes: all.notes,
    };
    if ["limits", "limit", "remaining_hours", "remaining_hours_band", "remaining_limits"]
        .iter()
        .any(|result| host.needs(result))
    {
        calibrated.judge(drive, host)?;
    }
    Ok(calibrated)
}

impl Row {
    /// Prediction less reading, over the scale of the reading.
    pub fn residual(&self) -> Option<f64> {
        self.predicted
            .map(|predicted| (predicted - self.observed.reading.value) / self.observed.reading.scale)
    }

    /// Growth since new by the reading, with the lost motion of its machine when new.
    fn since_new(&self, lives: &[MachineLife]) -> f64 {
        let reading = &self.observed.reading;
        let Measured::LostMotion(_) = reading.measured else { return reading.value };
        let name = &self.observed.machine;
        let of_machine = |life: &&MachineLife| match &life.name {
            Some(shown) => shown == name || name.is_empty(),
            None => false,
        };
        reading.value - lives.iter().find(of_machine).map_or(0.0, |life| life.new)
    }
}

impl ReadingOptions {
    /// Key of the design for the selected limit, if its value differs from that of the design.
    pub(in crate::analyses) fn change(&self) -> Result<Option<(&'static str, Value)>, AnalysisError> {
        Ok(self.selected()?.and_then(|limit| limit.change()))
    }

    fn selected(&self) -> Result<Option<SelectedLimit>, AnalysisError> {
        self.limit.as_deref().map(shorthand::limit).transpose()
    }
}

impl Calibration {
    /// The machine of the headline: the measured machine whose lost motion reaches its limit first, or the design's
    /// prediction if none was measured.
    pub fn headline_machine(&self) -> &MachineLife {
        let left = |life: &&MachineLife| life.hours.map_or(f64::INFINITY, |hours| hours - life.last_h);
        let measured = self.lives.iter().skip(1).min_by(|a, b| left(a).total_cmp(&left(b)));
        measured.unwrap_or(&self.lives[0])
    }

    /// Limits of the machine of the headline.
    pub fn its_limits(&self) -> impl Iterator<Item = &Remaining> {
        let name = &self.headline_machine().name;
        self.limits.iter().filter(move |limit| limit.machine == *name)
    }

    /// The selected limit, or the first to be reached.
    pub fn headline_limit(&self) -> &Remaining {
        let left = |limit: &&Remaining| limit.left().unwrap_or(f64::INFINITY);
        let named =
            self.selected.and_then(|chosen| self.its_limits().find(|limit| limit.kind == chosen.kind));
        let first = self.its_limits().min_by(|a, b| left(a).total_cmp(&left(b)));
        named.or(first).unwrap_or(&self.limits[0])
    }

    /// Judges the limits other than lost motion by the prediction with the fitted coefficient.
    fn judge(&mut self, drive: &impl CalibratedDrive, host: &dyn Host) -> Result<(), AnalysisError> {
        let Some(design) = &self.design else {
            self.notes.push(
                "the coefficient cannot be entered into the design, so its other limits are not judged"
                    .into(),
            );
            return Ok(());
        };
        let last = self.lives.iter().map(|life| life.last_h).fold(0.0, f64::max);
        let design =
            self.selected.map_or_else(|| Ok(design.clone()), |limit| design.with_all(limit.change()))?;
        let verdict: LifeVerdict = match limits::judged(&design, drive, last, host) {
            Ok(verdict) => verdict,
            Err(AnalysisError::Stopped) => return Err(AnalysisError::Stopped),
            Err(error) => {
                self.notes.push(format!("limits other than lost motion could not be judged: {error}"));
                return Ok(());
            }
        };
        let service_h = self.limits_of_design.service_life / HOUR;
        let law = self.fit.law;
        let again = |hours: f64| {
            let exposure = law.at(hours * HOUR);
            let of = |truth: &Truth| truth.law.time_at(exposure) / HOUR;
            self.fit.band(of).map(|(low, high)| (Some(low), Some(high)))
        };
        let others = |life: &MachineLife| -> Vec<Remaining> {
            verdict
                .limits
                .iter()
                .filter(|limit| !matches!(limit.kind, LimitKind::LostMotion | LimitKind::Findings))
                .map(|limit| {
                    let hours = (life.last_h, service_h, verdict.service_h);
                    limits::remaining(limit, life.name.clone(), hours, again)
                })
                .collect()
        };
        let all: Vec<Remaining> = (self.lives.iter())
            .flat_map(|life| std::iter::once(life.remaining(self.followed_h)).chain(others(life)))
            .collect();
        let selected = self.selected.map(|limit| limit.kind);
        if let Some(kind) = selected.filter(|kind| all.iter().all(|limit| limit.kind != *kind)) {
            return Err(AnalysisError::usage(
                format!("the design has no limit {}", kind.key()),
                format!("give one: limit = \"{}=VALUE\", or set it in [limits]", kind.key()),
            ));
        }
        self.limits = all;
        Ok(())
    }

    /// Lines to write into the design file.
    fn keys(&self) -> String {
        pasted::sections(&self.fit.law, self.fits_running_in())
    }

    /// The design file with the coefficient, where there is one.
    pub(in crate::analyses) fn calibrated_design(&self) -> Vec<Attachment> {
        let file = |design: &AnyDesign| Attachment {
            name: "calibrated.toml".to_owned(),
            bytes: design.to_toml().into_bytes(),
        };
        self.design.iter().map(file).collect()
    }

    fn fits_running_in(&self) -> bool {
        !matches!(self.running_in, RunningInFit::Kept(_))
    }

    /// Warnings to the reader: readings not used, parameters not determined, a fit with large residuals.
    pub fn cautions(&self) -> Vec<String> {
        let mut cautions = self.notes.clone();
        if self.fit.relative_rms > POOR {
            let hint = if self.fits_running_in() {
                "the growth follows another law, or the readings have a large scatter"
            } else {
                "for a growth that slows down fit a running-in (--fit-running-in, --running-in-h)"
            };
            cautions.push(format!(
                "the residuals of the fit are {:.0} % of the readings: {hint}",
                100.0 * self.fit.relative_rms
            ));
        }
        if let ReadingError::Assumed(share) = self.reading_error {
            cautions.push(format!(
                "the error of a reading is assumed, {} % of the growth: the readings do not tell it \
                 (--reading-error-percent gives it)",
                significant(100.0 * share, 2)
            ));
        }
        cautions.extend(self.fit.untold());
        // A prediction is the first of the lives.
        let predicted = self.lives.first().map_or(0.0, |life| life.new);
        for life in self.lives.iter().skip(1) {
            let name = life.name.as_deref().unwrap_or_default();
            let new = significant(life.new / ARCMIN, 3);
            if life.new_is == NewIs::Assumed {
                cautions.push(format!(
                    "{name} was read at one time only: its lost motion when new is assumed, {} arcmin ± {:.0} % \
                     by the design (--new-arcmin gives what was measured)",
                    significant(predicted / ARCMIN, 3),
                    100.0 * ASSUMED_NEW
                ));
            } else if (life.new - predicted).abs() > APART * predicted.abs() {
                cautions.push(format!(
                    "{name} had {new} arcmin of lost motion when new, the design predicts {}: its clearances are \
                     not those of the design",
                    significant(predicted / ARCMIN, 3)
                ));
            }
        }
        if self.rows.iter().any(|row| row.predicted.is_none()) {
            cautions.push(format!(
                "wear was computed to {} h only: later readings have no prediction",
                compact(self.followed_h, 4)
            ));
        }
        if self.wear.parts.any() {
            cautions.push(
                "wear of bearings and gears is not part of the fit: `life` adds it to the lost motion"
                    .to_owned(),
            );
        }
        cautions
    }

    /// Number of readings beyond the number of parameters, as a sentence.
    fn test(&self) -> Option<String> {
        let fitted: Vec<&Row> = self.rows.iter().filter(|row| row.fitted).collect();
        let machines = self.lives.iter().skip(1).filter(|life| life.new_is == NewIs::Fitted).count();
        let unknown = self.fit.estimates.len() + machines;
        let others = self.rows.len() - fitted.len();
        if fitted.len() > unknown {
            return None;
        }
        let many = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
        Some(format!(
            "{} for {}: the fit tests nothing{}",
            many(fitted.len(), "reading"),
            many(unknown, "unknown"),
            if others == 0 { "; another one would." } else { "; those predicted do." }
        ))
    }
}

outcome!(Calibrated {
    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        Ok(self.calibrated_design())
    }
});
