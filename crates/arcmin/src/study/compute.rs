use serde_json::{Map, Value as Json};

use super::file::Study;
use super::limits::judged_limits;
use super::list_place::ListPlace;
use super::plan::{Kind, Row, Setting};
use super::run::RowError;
use super::stream::{Purpose, hash};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host, OnlyResults};
use crate::checks::Severity;
use crate::design::{DesignError, Value};
use crate::progress::Progress;

impl Study {
    /// The design of a row, without the errors of a drawn machine.
    ///
    /// # Errors
    /// Values that contradict each other.
    pub fn design_of(&self, row: &Row) -> Result<AnyDesign, Box<DesignError>> {
        self.design.with_all(self.changes_of(row)?)
    }

    /// The design file of a row: as [`Study::design_of`], with `[unknowns]` if the values of the row lie within their
    /// ranges.
    ///
    /// # Errors
    /// Values that contradict each other.
    pub fn file_of(&self, row: &Row) -> Result<AnyDesign, Box<DesignError>> {
        self.written.with_all(self.changes_of(row)?).or_else(|_| self.design_of(row))
    }

    fn changes_of(&self, row: &Row) -> Result<Vec<(String, Value)>, Box<DesignError>> {
        let mut changes: Vec<(String, Value)> = Vec::new();
        for (factor, setting) in self.plan.factors().iter().zip(&row.settings) {
            let value = match setting {
                Setting::Number(number) if factor.whole => Value::Count(*number as usize),
                Setting::Number(number) => Value::Number(*number),
                Setting::Word(word) => Value::Text(word.clone()),
                Setting::Flag(flag) => Value::Flag(*flag),
                Setting::Seed(_) => continue,
            };
            let Some(place) = ListPlace::find(&self.design, &factor.path) else {
                changes.push((factor.path.clone(), value));
                continue;
            };
            let Some(number) = value.as_number() else { continue };
            match changes.iter_mut().find(|(path, _)| *path == place.list) {
                Some((_, list)) => place.set(list, number),
                None => {
                    let mut list = self.design.get(&place.list)?;
                    place.set(&mut list, number);
                    changes.push((place.list, list));
                }
            }
        }
        Ok(changes)
    }

    /// The batch of a row, from 0; `None` if machines are drawn independently.
    pub fn batch_of(&self, number: u64) -> Option<u64> {
        self.batches.map(|batches| number / self.plan.sampling().rows_per_sample() / batches.machines)
    }

    /// Options of a row: those of the study, and the seed of a drawn machine.
    pub fn options_of(&self, row: &Row) -> String {
        let seed = row.settings.iter().find_map(|setting| match setting {
            Setting::Seed(seed) => Some(seed),
            _ => None,
        });
        let Some(seed) = seed else { return self.options().to_owned() };
        let mut options = format!("{}\nerrors = \"drawn\"\nseed = {seed}\n", self.options());
        if let (Some(batches), Some(batch)) = (self.batches, self.batch_of(row.number)) {
            let seed = hash(&[self.plan.sampling().seed(), Purpose::Batches as u64, batch]) >> 11;
            options.push_str(&format!("batch_seed = {seed}\nbatch_share = {:?}\n", batches.share));
        }
        options
    }

    /// Computes a row: its summary, with curves as lists under `table.column`.
    ///
    /// # Errors
    /// [`RowError::Failed`] for a machine that cannot exist or cannot be computed, [`RowError::Cancelled`] if the
    /// host cancelled the computation.
    pub fn compute(&self, row: &Row, host: &dyn Host) -> Result<Json, RowError> {
        let results: Vec<&str> = self.plan.kept().iter().map(|kept| kept.key.as_str()).collect();
        let host = &OnlyResults { host, results: &results };
        let design = self.design_of(row).map_err(|error| RowError::Failed(why_refused(&error)))?;
        let outcome = design.run(self.analysis, &self.options_of(row), self.origin(), host).map_err(
            |error| match error {
                AnalysisError::Stopped | AnalysisError::Interrupted { .. } => RowError::Cancelled,
                error => RowError::Failed(why_failed(&error, &design)),
            },
        )?;
        if host.is_cancelled() {
            return Err(RowError::Cancelled);
        }
        if let Some(why) = outcome.failure() {
            return Err(RowError::Failed(why));
        }
        let mut summary = outcome.summary().to_json();
        judged_limits(&mut summary);
        let curves = self.plan.kept().iter().filter(|kept| kept.kind == Kind::Curve);
        let curves: Vec<(&str, &str)> = curves.filter_map(|kept| kept.key.split_once('.')).collect();
        if !curves.is_empty() {
            let tables = outcome.tables();
            for (table, column) in curves {
                let found =
                    tables.iter().find(|t| t.name == table).and_then(|t| Some((t, t.column(column)?)));
                if let Some((table_of, cells)) = found {
                    let values = (0..table_of.rows()).map(|row| cells.cells.value(row).to_json()).collect();
                    let place = summary.entry(table).or_insert_with(|| Json::Object(Map::new()));
                    if let Json::Object(place) = place {
                        place.insert(column.to_owned(), Json::Array(values));
                    }
                }
            }
        }
        Ok(Json::Object(summary))
    }
}

/// Reason why a design is invalid, with the remedy.
fn why_refused(error: &DesignError) -> String {
    match error.hint() {
        Some(hint) => format!("{}; {hint}", error.kind),
        None => error.kind.to_string(),
    }
}

/// Reason why a machine could not be computed: first its error finding with the remedy, since this is probably
/// the cause; then the error of the computation.
fn why_failed(error: &AnalysisError, design: &AnyDesign) -> String {
    let findings = design.findings();
    let finding = findings.iter().find(|finding| finding.severity == Severity::Error);
    let mut why = finding.map_or(String::new(), |finding| {
        format!("{}: {}; to change: {}. Then: ", finding.code, finding.message, finding.change)
    });
    why.push_str(&error.to_string());
    if let Some(help) = error.help() {
        why.push_str(&format!("; {help}"));
    }
    why
}
