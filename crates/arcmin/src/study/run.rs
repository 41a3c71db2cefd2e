use rayon::prelude::*;
use serde_json::Value as Json;

use super::part::{Cell, Record, decode, encode};
use super::plan::{Kind, Plan, Row, Setting};

/// Where parts are kept. The library touches no file; whoever runs it does.
pub trait Store: Sync {
    /// The bytes kept under a name, `None` if there are none.
    ///
    /// # Errors
    /// In a sentence, where they cannot be read.
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, String>;

    /// Keeps bytes under a name in place of what was there, all or nothing: a temporary name first, renamed
    /// at the end.
    ///
    /// # Errors
    /// In a sentence, where they cannot be kept.
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), String>;
}

/// Which of how many shards, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    of: u64,
}

impl Shard {
    /// The whole study.
    pub const WHOLE: Shard = Shard { index: 1, of: 1 };

    /// `None` unless 1 ≤ `index` ≤ `of`.
    pub fn new(index: u64, of: u64) -> Option<Shard> {
        (1..=of).contains(&index).then_some(Shard { index, of })
    }

    /// Reads `3/50`.
    pub fn parse(text: &str) -> Option<Shard> {
        let (index, of) = text.split_once('/')?;
        Shard::new(index.trim().parse().ok()?, of.trim().parse().ok()?)
    }

    /// Its parts: every so manieth, so that shards take about the same time where a study becomes costlier
    /// along the way.
    pub fn parts(self, plan: &Plan) -> impl Iterator<Item = u64> {
        (self.index - 1..plan.parts()).step_by(usize::try_from(self.of).unwrap_or(usize::MAX))
    }
}

/// Why a row has no results.
#[derive(Debug, Clone, PartialEq)]
pub enum RowError {
    /// The machine cannot be assembled, jams, or cannot be computed: kept as a result with this reason.
    Failed(String),
    /// The computation was stopped: the row is computed next time.
    Cancelled,
}

/// What a shard did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Done {
    pub computed: u64,
    /// Of those computed.
    pub failed: u64,
    /// Rows that were there already.
    pub found: u64,
    /// Parts that were there but could not be used, and were computed again.
    pub replaced: u64,
    pub cancelled: bool,
}

/// Computes the rows of a shard that are not there yet, on all threads of the pool it is called in, and keeps
/// every part as soon as it is complete; a cancelled one with the rows it has. `finished` is told every row
/// that ends.
///
/// # Errors
/// In a sentence, where a part cannot be read or kept.
pub fn run(
    plan: &Plan,
    shard: Shard,
    store: &dyn Store,
    compute: &(dyn Fn(&Row) -> Result<Json, RowError> + Sync),
    finished: &(dyn Fn(&Record) + Sync),
) -> Result<Done, String> {
    let mut done = Done::default();
    for part in shard.parts(plan) {
        let name = plan.part_name(part);
        let known = match store.read(&name)?.map(|bytes| decode(plan, part, bytes)) {
            Some(Ok(records)) => records,
            Some(Err(_)) => {
                done.replaced += 1;
                Vec::new()
            }
            None => Vec::new(),
        };
        done.found += known.len() as u64;
        let missing: Vec<u64> = plan
            .rows_of(part)
            .filter(|number| known.binary_search_by_key(number, |record| record.number).is_err())
            .collect();
        if missing.is_empty() {
            continue;
        }
        let asked = missing.len();
        let computed: Vec<Record> = missing
            .into_par_iter()
            .filter_map(|number| {
                let record = record(plan, &plan.row(number), compute)?;
                finished(&record);
                Some(record)
            })
            .collect();
        done.cancelled = computed.len() < asked;
        done.computed += computed.len() as u64;
        done.failed += computed.iter().filter(|record| record.failed.is_some()).count() as u64;
        if !computed.is_empty() {
            let mut records = known;
            records.extend(computed);
            records.sort_by_key(|record| record.number);
            let bytes = encode(plan, &records).map_err(|error| error.to_string())?;
            store.write(&name, &bytes)?;
        }
        if done.cancelled {
            break;
        }
    }
    Ok(done)
}

/// `None` if the computation was stopped.
fn record(
    plan: &Plan,
    row: &Row,
    compute: &(dyn Fn(&Row) -> Result<Json, RowError> + Sync),
) -> Option<Record> {
    let mut cells: Vec<Cell> = row.settings.iter().map(setting_cell).collect();
    let failed = match compute(row) {
        Ok(summary) => {
            cells.extend(plan.kept().iter().map(|kept| cell(&summary, &kept.key, kept.kind)));
            None
        }
        Err(RowError::Failed(reason)) => {
            cells.resize(cells.len() + plan.kept().len(), Cell::Absent);
            Some(reason)
        }
        Err(RowError::Cancelled) => return None,
    };
    Some(Record { number: row.number, cells, failed })
}

fn setting_cell(setting: &Setting) -> Cell {
    match setting {
        Setting::Number(number) => Cell::Number(*number),
        Setting::Seed(seed) => Cell::Number(*seed as f64),
        Setting::Word(word) => Cell::Word(word.clone()),
        Setting::Flag(flag) => Cell::Word(flag.to_string()),
    }
}

/// A value of a summary by its dotted key.
fn cell(summary: &Json, key: &str, kind: Kind) -> Cell {
    let Some(value) = key.split('.').try_fold(summary, |place, name| place.get(name)) else {
        return Cell::Absent;
    };
    match (kind, value) {
        (Kind::Number, Json::Bool(flag)) => Cell::Number(f64::from(u8::from(*flag))),
        (Kind::Number, value) => value.as_f64().map_or(Cell::Absent, Cell::Number),
        (Kind::Word, Json::String(word)) => Cell::Word(word.clone()),
        (Kind::Word, Json::Null) => Cell::Absent,
        (Kind::Word, value) => Cell::Word(value.to_string()),
        (Kind::Curve, Json::Array(values)) => {
            // A gap stays a gap.
            Cell::Curve(values.iter().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect())
        }
        (Kind::Curve, _) => Cell::Absent,
    }
}
