//! Which wear coefficient fits the measurement.

use super::{AnalysisError, Host, Outcome, Said, inputs};
use crate::design::{Design, InputFile, optional, options, required};
use crate::fidelity::{Fidelity, FidelityOptions, HasFidelity};
use crate::machine::Machine;
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Style, Tone, Verdict, significant,
};
use crate::results::{
    DeclaredTable, PLAIN, Summary, SummaryOf, Table, TableOf, Value, decimals, digits, quantities as q,
    quantity,
};
use crate::tables::{Column, Form};
use crate::units::{ARCMIN, HOUR, UM};
use crate::wear::CoupledOptions;
use crate::wear::calibrate::{Calibration, Observation, Observed, fit_and_predict};

pub const ABOUT: &str = "Fit the wear coefficient to measured depths or lost motion";
pub const GUIDE: &str = "Fits the wear coefficient k of the coupled prediction to observations, by least \
    squares of the relative residuals. With manufacturing errors the observations are those of one real \
    machine.\n\nThe file has a column hours, and depth_um (largest depth of a flank) or \
    lost_motion_increase_arcmin (or _arcsec; since new). An empty field is no observation. The running-in of \
    the design is kept.";
pub const EXAMPLES: &[&str] = &[
    "arcmin calibrate my-reducer.toml measured.csv",
    "arcmin calibrate my-reducer.toml measured.csv --fit-until-h 600",
    "arcmin calibrate my-reducer.toml measured.csv --running-in-h 150",
    "",
    "measured.csv:",
    "hours,lost_motion_increase_arcsec",
    "600,10.64",
    "1550,12.92",
];

options! {
    /// Options of `calibrate`.
    pub struct Options {
        [fidelity: FidelityOptions, joints = "bearings"]
        /// Observations: hours, and depth_um or lost_motion_increase_arcmin.
        data: InputFile => required(0.0, 0.0),
        /// Fit the observations up to this time only, and set the prediction beside the later ones.
        fit_until_h: Option<f64> => optional(0.0, 1e7),
        /// Fit a second coefficient, the factor of a running-in with this time constant, in place of the design's running-in.
        running_in_h: Option<f64> => optional(1e-3, 1e7),
    }
}

/// One observation beside its prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    pub observation: Observation,
    /// In the unit of the observation.
    pub predicted: f64,
    /// Whether it took part in the fit.
    pub fitted: bool,
}

/// A fitted coefficient.
#[derive(Debug, Clone)]
pub struct Calibrated {
    pub machine: Machine,
    pub fidelity: Fidelity,
    pub calibration: Calibration,
    pub rows: Vec<Row>,
    /// Time constant in s of a running-in that was fitted.
    pub running_in: Option<f64>,
}

/// A fit that leaves more than this of its observations, as a root mean square, has failed.
const FAILED: f64 = 0.5;

fn quantity_of(observed: Observed) -> (&'static str, f64, f64) {
    match observed {
        Observed::Depth(depth) => ("depth_um", depth, UM),
        Observed::LostMotionIncrease(increase) => ("lost_motion_increase_arcmin", increase, ARCMIN),
    }
}

const CALIBRATION: TableOf<Row> = TableOf {
    name: "calibration",
    what: "One observation a row, those of the fit first",
    columns: || {
        vec![
            q::HOURS.of(|r: &Row| (r.observation.time / HOUR).into()),
            q::QUANTITY.of(|r| quantity_of(r.observation.value).0.into()),
            quantity("observed", digits(5), "Observed value, in the unit of the quantity.").of(|r| {
                let (_, value, unit) = quantity_of(r.observation.value);
                (value / unit).into()
            }),
            quantity("predicted", digits(5), "Predicted value, in the unit of the quantity.")
                .of(|r| (r.predicted / quantity_of(r.observation.value).2).into()),
            quantity("residual_percent", decimals(2), "Prediction over observation, less one, in percent.")
                .of(|r| (100.0 * r.residual()).into()),
            quantity("use", PLAIN, "fitted, or predicted without a part in the fit.")
                .of(|r| if r.fitted { "fitted" } else { "predicted" }.into()),
        ]
    },
};

impl Row {
    /// Prediction over observation, less one.
    pub fn residual(&self) -> f64 {
        self.predicted / quantity_of(self.observation.value).1 - 1.0
    }
}

pub const SUMMARY: SummaryOf<Calibrated> = SummaryOf {
    entries: || {
        let mut entries = vec![
            q::WEAR_COEFFICIENT.of(|o: &Calibrated| o.calibration.exposure.coefficient.into()),
            quantity("wear_coefficient_mm2_per_n", digits(4), "Wear coefficient in mm²/N.")
                .of(|o| (o.calibration.exposure.coefficient * 1e6).into()),
            quantity("running_in_factor", digits(4), "Factor of a running-in that was fitted.").of(|o| {
                let fitted = o.calibration.exposure.running_in.filter(|_| o.running_in.is_some());
                Value::from(fitted.map(|running_in| running_in.factor))
            }),
            quantity("running_in_duration_h", digits(4), "Time constant of a running-in that was fitted.")
                .of(|o| Value::from(o.running_in.map(|time| time / HOUR))),
            quantity("fitted", PLAIN, "Observations that took part in the fit.")
                .of(|o| o.rows.iter().filter(|row| row.fitted).count().into()),
            quantity("relative_rms", digits(3), "Root mean square of the relative residuals of the fit.")
                .of(|o| o.calibration.relative_rms.into()),
            quantity("observations", PLAIN, "All observations, with the columns of calibration.csv.").of(
                |o| {
                    let columns = (CALIBRATION.columns)();
                    let record = |row: &Row| {
                        Value::Record(columns.iter().map(|c| (c.quantity.key, c.value(row))).collect())
                    };
                    Value::List(o.rows.iter().map(record).collect())
                },
            ),
        ];
        entries.extend(Fidelity::entries());
        entries
    },
};

pub fn tables() -> Vec<DeclaredTable> {
    vec![CALIBRATION.into()]
}

/// Fits the coefficient.
///
/// # Errors
/// [`AnalysisError`]: a file that cannot be used, no observation to fit, a fit that fails.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Calibrated, AnalysisError> {
    let machine = design.machine();
    let fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let until = options.fit_until_h.unwrap_or(f64::INFINITY) * HOUR;
    let (fitted, others): (Vec<Observation>, Vec<Observation>) =
        observations(&options.data, host)?.into_iter().partition(|o| o.time <= until * (1.0 + 1e-9));
    if fitted.is_empty() {
        return Err(AnalysisError::usage(
            format!("{}: no observation up to {} h", options.data.0, until / HOUR),
            "choose a later fit_until_h",
        ));
    }
    let running_in = options.running_in_h.map(|hours| hours * HOUR);
    host.report("calibration", 0.0);
    let meshing = fidelity.meshing(&machine)?;
    let calibration =
        fit_and_predict(&machine, meshing, CoupledOptions::default(), &fitted, &others, running_in)
            .map_err(AnalysisError::wear("fit the wear coefficient"))?;
    if !(calibration.relative_rms < FAILED) {
        return Err(AnalysisError::usage(
            format!(
                "no wear coefficient fits: the best leaves {:.0} % of the observations",
                100.0 * calibration.relative_rms
            ),
            "check units and hours of the file; a running-in (running_in_h) fits what slows down",
        ));
    }
    let count = fitted.len();
    let row = |(index, (observation, predicted)): (usize, (&Observation, &f64))| Row {
        observation: *observation,
        predicted: *predicted,
        fitted: index < count,
    };
    let rows = fitted.iter().chain(&others).zip(&calibration.predicted).enumerate().map(row).collect();
    Ok(Calibrated { machine, fidelity, calibration, rows, running_in })
}

/// The observations of a file; one row may hold several.
fn observations(file: &InputFile, host: &dyn Host) -> Result<Vec<Observation>, AnalysisError> {
    const DEPTH: Column = Column::number("depth_um").optional().with_gaps().within(1e-6, 1e4);
    const INCREASE: Column = Column::number("lost_motion_increase_arcmin")
        .also(&["lost_motion"])
        .optional()
        .with_gaps()
        .within(1e-9, 600.0);
    let hours = Column::number("hours").within(1e-6, 1e7);
    let table = inputs::table(file, &Form::new(&[hours, DEPTH, INCREASE]), host)?;
    let hours = table.numbers("hours")?.to_vec();
    let mut all = Vec::new();
    for (column, observed) in [
        (DEPTH.name(), (|depth| Observed::Depth(depth * UM)) as fn(f64) -> Observed),
        (INCREASE.name(), |increase| Observed::LostMotionIncrease(increase * ARCMIN)),
    ] {
        if table.has(column) {
            let values = table.gaps(column)?;
            let some = hours.iter().zip(values).filter_map(|(hours, value)| Some((*hours, value?)));
            all.extend(some.map(|(hours, value)| Observation { time: hours * HOUR, value: observed(value) }));
        }
    }
    if all.is_empty() {
        return Err(AnalysisError::usage(
            format!("{}: there is no observation", file.0),
            "give a column depth_um, or lost_motion_increase_arcmin (or _arcsec)",
        ));
    }
    all.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(all)
}

impl Calibrated {
    fn keys(&self) -> String {
        let k = self.calibration.exposure.coefficient;
        let mut text = format!(
            "k = {k:.4e} 1/Pa; in the design file, under [wear.coupled]:\n  coefficient_per_pa = {k:.4e}"
        );
        if let (Some(time), Some(running_in)) = (self.running_in, self.calibration.exposure.running_in) {
            let (factor, hours) = (running_in.factor, time / HOUR);
            text.push_str(&format!(
                "\nand under [wear.running_in]:\n  factor = {factor:.4}\n  duration_h = {hours}"
            ));
        }
        text
    }

    /// How many observations the coefficients leave to test them.
    fn test(&self) -> Option<String> {
        let coefficients = 1 + usize::from(self.running_in.is_some());
        let fitted = self.rows.iter().filter(|row| row.fitted).count();
        let others = self.rows.len() - fitted;
        if fitted > coefficients {
            return None;
        }
        let many = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
        Some(format!(
            "{} for {}: the fit tests nothing{}",
            many(fitted, "observation"),
            many(coefficients, "coefficient"),
            if others == 0 { "; another one would." } else { "; those predicted do." }
        ))
    }
}

impl HasFidelity for Calibrated {
    fn fidelity(&self) -> &Fidelity {
        &self.fidelity
    }
}

impl Outcome for Calibrated {
    fn summary(&self) -> Summary {
        SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        vec![CALIBRATION.fill(&self.rows)]
    }

    fn said(&self) -> Vec<Said> {
        let table = CALIBRATION.fill(&self.rows);
        let columns = ["hours", "quantity", "observed", "predicted", "residual_percent", "use"];
        let mut said = vec![
            Said::line(format!("{}: {}", self.machine.name, self.fidelity.sentence())),
            Said::columns(&table, &columns, 0..table.rows()),
            Said::line(self.keys()),
        ];
        said.extend(self.test().map(Said::Line));
        said
    }

    fn page(&self) -> Page {
        let k = self.calibration.exposure.coefficient;
        let mut verdict = Verdict::new(
            if self.test().is_some() { Tone::Caution } else { Tone::Neutral },
            format!("k = {k:.3e} 1/Pa fits within {:.1} %.", 100.0 * self.calibration.relative_rms),
        );
        verdict.figures = vec![KeyFigure {
            label: "Wear coefficient".to_owned(),
            value: significant(k * 1e6, 4),
            unit: "mm²/N".to_owned(),
            note: format!("{k:.4e} 1/Pa, of Archard's law"),
            tone: Tone::Neutral,
        }];
        verdict.answers.extend(self.test().map(|text| ("What to be careful with".to_owned(), text)));
        verdict.answers.push(("Which physics".to_owned(), self.fidelity.sentence()));
        let mut blocks = Vec::new();
        for (key, axis) in [
            ("depth_um", Axis::new("Depth", "µm").from_zero()),
            ("lost_motion_increase_arcmin", Axis::new("Increase of the lost motion", "arcmin").from_zero()),
        ] {
            let of = |fitted: bool, value: fn(&Row) -> f64| {
                let rows = self
                    .rows
                    .iter()
                    .filter(|r| r.fitted == fitted && quantity_of(r.observation.value).0 == key);
                rows.map(|r| (r.observation.time / HOUR, value(r) / quantity_of(r.observation.value).2))
                    .collect::<Vec<_>>()
            };
            let observed = |r: &Row| quantity_of(r.observation.value).1;
            let (fitted, others) = (of(true, observed), of(false, observed));
            if fitted.is_empty() && others.is_empty() {
                continue;
            }
            let mut predicted: Vec<(f64, f64)> = of(true, |r| r.predicted);
            predicted.extend(of(false, |r| r.predicted));
            let mut plot = Plot::new("Observed and predicted", Axis::new("Running time", "h"), axis)
                .with(Series::new("predicted", Style::LineMarkers, predicted))
                .with(Series::new("observed, fitted", Style::Markers, fitted))
                .noted("The coupled prediction with the coefficient fitted, beside the observations.");
            if !others.is_empty() {
                plot = plot.with(Series::new("observed, not fitted", Style::Markers, others));
            }
            blocks.push(Block::Plot(plot));
        }
        blocks.push(Block::Code { title: "For the design file".to_owned(), text: self.keys() });
        Page {
            title: self.machine.name.clone(),
            subtitle: "Calibration of the wear".to_owned(),
            provenance: Provenance::default(),
            verdict,
            sections: vec![Section::new("fit", "Fit", blocks)],
        }
    }

    fn seeds(&self) -> Vec<u64> {
        self.fidelity.seeds()
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
