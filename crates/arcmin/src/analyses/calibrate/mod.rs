//! Which wear coefficient fits the measurement, how sure that is, and how long the machine still lasts.

mod declared;
mod observations;
mod page;

pub use declared::{SUMMARY, tables};
pub use observations::Observed;

use self::observations::Observations;
use super::{AnalysisError, Host, outcome};
use crate::design::{Design, InputFile, optional, options, required};
use crate::fidelity::{Fidelity, FidelityOptions};
use crate::life::{WornState, lost_motion_causes};
use crate::machine::Machine;
use crate::units::{ARCMIN, HOUR};
use crate::wear::{Beyond, Exposure, Fit, Growth, Measured, Reading, RunningInFit, follow_and_fit};

pub const ABOUT: &str = "Fit the wear coefficient to measured depths or lost motion";
pub const GUIDE: &str = "Fits the wear coefficient k of the coupled prediction to readings, by least squares of \
    their residuals over their scale, with its 95 % band, and says how long the machine still keeps its limit of \
    lost motion. With manufacturing errors the readings are those of one real machine.\n\nThe file has a column \
    hours and one or more of depth_um (largest depth of a flank), lost_motion_increase_arcmin (since new) and \
    lost_motion_arcmin (as read: counted from the machine's own first reading, whose error goes into all others). \
    A column machine tells several machines of one design apart. An empty field is no reading. Increases and \
    depths count relative to their value, readings of lost motion relative to the largest growth of their machine.\
    \n\nThe running-in of the design is kept, or fitted: its factor (--running-in-h), or factor and duration \
    (--fit-running-in). What the readings cannot tell apart is said. Bands come from the profile likelihood: from \
    the scatter of the readings, or from their error where it is given.";
pub const EXAMPLES: &[&str] = &[
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
        /// Readings: hours, and depth_um, lost_motion_increase_arcmin or lost_motion_arcmin; perhaps machine.
        data: InputFile => required(0.0, 0.0),
        /// Fit the readings up to this time only, and set the prediction beside the later ones.
        fit_until_h: Option<f64> => optional(0.0, 1e7),
        /// Fit a second coefficient, the factor of a running-in with this time constant, in place of the design's running-in.
        running_in_h: Option<f64> => optional(1e-3, 1e7),
        /// Fit factor and time constant of a running-in, in place of the design's.
        fit_running_in: bool => optional(0.0, 0.0),
        /// Standard deviation of one reading: in percent of its value, for readings of lost motion of the largest growth of their machine. Left out: from the scatter of the readings, if there are more than parameters.
        reading_error_percent: Option<f64> => optional(1e-6, 1e3),
    }
}

/// One reading beside its prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub observed: Observed,
    /// In the unit of the reading.
    pub predicted: f64,
    /// By the bands of the parameters.
    pub band: Option<(f64, f64)>,
    /// Whether it took part in the fit.
    pub fitted: bool,
}

/// How long a machine keeps its limit of lost motion.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineLife {
    /// As the file calls it; `None` for the design's own prediction.
    pub name: Option<String>,
    /// Hours of its last reading.
    pub last_h: f64,
    /// Lost motion when new in rad: its first reading less what had grown by then, or the design's.
    pub new: f64,
    /// Hours since new to the limit, with their band; `None` where the limit is not reached within what was
    /// followed.
    pub hours: Option<f64>,
    pub low: Option<f64>,
    pub high: Option<f64>,
}

/// Depth in m and increase of lost motion in rad at one time, each with its band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    pub hours: f64,
    pub depth: (f64, Option<(f64, f64)>),
    pub increase: (f64, Option<(f64, f64)>),
}

/// A fitted coefficient.
#[derive(Debug, Clone)]
pub struct Calibrated {
    pub machine: Machine,
    pub fidelity: Fidelity,
    pub fit: Fit,
    pub rows: Vec<Row>,
    pub lives: Vec<MachineLife>,
    pub curve: Vec<CurvePoint>,
    /// How far the growth was followed, in hours at the fitted coefficient.
    pub followed_h: f64,
    /// What was fitted beside the coefficient.
    pub running_in: RunningInFit,
    /// What of the file could not be used, and why.
    pub notes: Vec<String>,
}

/// A fit that leaves more than this of its readings, as a root mean square, has failed.
const FAILED: f64 = 0.5;
/// One that leaves more than this is doubtful.
const POOR: f64 = 0.1;
/// A machine whose lost motion when new differs by more than this share from that of the design is another one.
const APART: f64 = 0.5;
/// How far beyond the service life the limit is looked for.
const SEARCH_FACTOR: f64 = 4.0;
/// Points of the curve.
const CURVE_POINTS: usize = 120;

/// Fits the coefficient.
///
/// # Errors
/// [`AnalysisError`]: a file that cannot be used, no reading to fit, a fit that fails.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Calibrated, AnalysisError> {
    let machine = design.machine();
    let running_in = match (options.running_in_h, options.fit_running_in) {
        (Some(_), true) => {
            return Err(AnalysisError::usage(
                "the time constant of the running-in is given, and is to be fitted as well",
                "leave out one of running_in_h and fit_running_in",
            ));
        }
        (Some(hours), false) => RunningInFit::Factor(hours * HOUR),
        (None, true) => RunningInFit::Both,
        (None, false) => RunningInFit::Kept(machine.wear.running_in),
    };
    let Observations { readings, machines, notes } = observations::read(&options.data, host)?;
    let fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let until = options.fit_until_h.unwrap_or(f64::INFINITY) * HOUR;
    let (fitted, others): (Vec<Observed>, Vec<Observed>) =
        readings.into_iter().partition(|observed| observed.reading.time <= until * (1.0 + 1e-9));
    if fitted.is_empty() {
        return Err(AnalysisError::usage(
            format!("{}: no reading up to {} h", options.data.0, until / HOUR),
            "choose a later fit_until_h",
        ));
    }
    host.report("calibration", 0.0);
    let new = lost_motion_causes(&machine, fidelity.in_bearings(&machine)?, &WornState::new())
        .map_err(AnalysisError::wear("find the lost motion of the new machine"))?
        .lost_motion
        .whole;
    let beyond = Beyond {
        increase: machine.limits.lost_motion - new,
        time: SEARCH_FACTOR * machine.limits.service_life,
    };
    let readings: Vec<Reading> = fitted.iter().map(|observed| observed.reading).collect();
    let error = options.reading_error_percent.map(|percent| percent / 100.0);
    let meshing = fidelity.meshing(&machine)?;
    let (growth, fit) = follow_and_fit(&machine, &meshing, &readings, running_in, error, beyond, host)
        .map_err(AnalysisError::wear("fit the wear coefficient"))?;
    if !(fit.relative_rms < FAILED) {
        return Err(AnalysisError::usage(
            format!(
                "no wear coefficient fits: the best leaves {:.0} % of the readings",
                100.0 * fit.relative_rms
            ),
            "check units and hours of the file; a running-in (running_in_h) fits what slows down",
        ));
    }
    let row = |observed: Observed, fitted: bool| Row {
        predicted: growth.value(&observed.reading, &fit.law),
        band: fit.band(|law| growth.value(&observed.reading, law)),
        observed,
        fitted,
    };
    let rows: Vec<Row> = fitted
        .into_iter()
        .map(|observed| row(observed, true))
        .chain(others.into_iter().map(|observed| row(observed, false)))
        .collect();
    let lives = lives(&machine, new, &growth, &fit, &machines, &rows);
    let curve = curve(&growth, &fit, &rows, &lives);
    let followed_h = fit.law.time_at(growth.last()) / HOUR;
    Ok(Calibrated { machine, fidelity, fit, rows, lives, curve, followed_h, running_in, notes })
}

/// The design's own prediction, and that of every machine whose lost motion was read.
fn lives(
    machine: &Machine,
    new: f64,
    growth: &Growth,
    fit: &Fit,
    machines: &[observations::MachineReadings],
    rows: &[Row],
) -> Vec<MachineLife> {
    let limit = machine.limits.lost_motion;
    let life = |name: Option<String>, last: f64, new_of: &dyn Fn(&Exposure) -> f64| {
        let hours = |law: &Exposure| {
            growth.exposure_at(limit - new_of(law)).map_or(f64::INFINITY, |exposure| law.time_at(exposure))
                / HOUR
        };
        let known = |hours: f64| hours.is_finite().then_some(hours);
        let band = fit.band(hours);
        MachineLife {
            name,
            last_h: last / HOUR,
            new: new_of(&fit.law),
            hours: known(hours(&fit.law)),
            low: band.and_then(|(low, _)| known(low)),
            high: band.and_then(|(_, high)| known(high)),
        }
    };
    let last = rows.iter().map(|row| row.observed.reading.time).fold(0.0, f64::max);
    let mut lives = vec![life(None, last, &|_| new)];
    for one in machines {
        let Some((time, value)) = one.first else { continue };
        let of_machine = |law: &Exposure| value - growth.increase(law.at(time));
        lives.push(life(Some(one.shown_name()), one.last, &of_machine));
    }
    lives
}

/// The prediction over time, as far as readings and limit reach and wear was followed. Where the fastest wear
/// of the band leaves what was followed, the band ends.
fn curve(growth: &Growth, fit: &Fit, rows: &[Row], lives: &[MachineLife]) -> Vec<CurvePoint> {
    let last = rows.iter().map(|row| row.observed.reading.time / HOUR).fold(0.0, f64::max);
    let limits = lives.iter().filter_map(|life| life.hours).map(|hours| 1.05 * hours);
    let end = limits.filter(|hours| *hours <= 8.0 * last).fold(1.2 * last, f64::max);
    let end = end.min(fit.law.time_at(growth.last()) / HOUR).max(last);
    let followed = growth.last() * (1.0 + 1e-9);
    let point = |index: usize| {
        let hours = end * index as f64 / CURVE_POINTS as f64;
        let of = |value: &dyn Fn(f64) -> f64| {
            let at = |law: &Exposure| {
                let exposure = law.at(hours * HOUR);
                if exposure <= followed { value(exposure) } else { f64::INFINITY }
            };
            (value(fit.law.at(hours * HOUR)), fit.band(at).filter(|(_, high)| high.is_finite()))
        };
        CurvePoint { hours, depth: of(&|x| growth.depth(x)), increase: of(&|x| growth.increase(x)) }
    };
    (0..=CURVE_POINTS).map(point).collect()
}

impl Row {
    /// Prediction less reading, over the scale of the reading.
    pub fn residual(&self) -> f64 {
        (self.predicted - self.observed.reading.value) / self.observed.reading.scale
    }

    /// The growth since new that the reading tells of; what grew before a first reading is the fit's.
    fn since_new(&self, curve: &[CurvePoint]) -> f64 {
        let reading = &self.observed.reading;
        let Measured::Since(first) = reading.measured else { return reading.value };
        let hours = first / HOUR;
        let right = curve.partition_point(|point| point.hours < hours).clamp(1, curve.len() - 1);
        let (a, b) = (curve[right - 1], curve[right]);
        let t = (hours - a.hours) / (b.hours - a.hours);
        reading.value + a.increase.0 + t * (b.increase.0 - a.increase.0)
    }
}

impl Calibrated {
    /// What to write into the design file.
    fn keys(&self) -> String {
        let k = self.fit.law.coefficient;
        let mut text = format!(
            "k = {k:.4e} 1/Pa; in the design file, under [wear.coupled]:\n  coefficient_per_pa = {k:.4e}"
        );
        if let (true, Some(running_in)) = (self.fits_running_in(), self.fit.law.running_in) {
            let (factor, hours) = (running_in.factor, running_in.duration / HOUR);
            let hours = crate::report::compact(hours, 4);
            text.push_str(&format!(
                "\nand under [wear.running_in]:\n  factor = {factor:.4}\n  duration_h = {hours}"
            ));
        }
        text
    }

    fn fits_running_in(&self) -> bool {
        !matches!(self.running_in, RunningInFit::Kept(_))
    }

    /// What a reader must not overlook: readings not used, parameters not told, a fit that leaves much.
    pub fn cautions(&self) -> Vec<String> {
        let mut cautions = self.notes.clone();
        if self.fit.relative_rms > POOR {
            let hint = if self.fits_running_in() {
                "the growth follows another law, or the readings scatter"
            } else {
                "a growth that slows down may be a running-in (--fit-running-in, --running-in-h)"
            };
            cautions.push(format!(
                "the fit leaves {:.0} % of the readings: {hint}",
                100.0 * self.fit.relative_rms
            ));
        }
        cautions.extend(self.fit.untold());
        // A prediction is the first of the lives.
        let predicted = self.lives.first().map_or(0.0, |life| life.new);
        for life in
            self.lives.iter().skip(1).filter(|life| (life.new - predicted).abs() > APART * predicted.abs())
        {
            cautions.push(format!(
                "{} had {} arcmin of lost motion when new, the design predicts {}: its clearances are not those of the design",
                life.name.as_deref().unwrap_or_default(),
                crate::report::significant(life.new / ARCMIN, 3),
                crate::report::significant(predicted / ARCMIN, 3)
            ));
        }
        if self.machine.wear.parts.any() {
            cautions.push(
                "wear of bearings and gears is not followed here: `life` adds it to the lost motion"
                    .to_owned(),
            );
        }
        cautions
    }

    /// How many readings the coefficients leave to test them.
    fn test(&self) -> Option<String> {
        let coefficients = self.fit.estimates.len();
        let fitted = self.rows.iter().filter(|row| row.fitted).count();
        let others = self.rows.len() - fitted;
        if fitted > coefficients {
            return None;
        }
        let many = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
        Some(format!(
            "{} for {}: the fit tests nothing{}",
            many(fitted, "reading"),
            many(coefficients, "coefficient"),
            if others == 0 { "; another one would." } else { "; those predicted do." }
        ))
    }
}

outcome!(Calibrated {});
