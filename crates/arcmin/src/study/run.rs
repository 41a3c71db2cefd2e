use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use serde_json::Value as Json;

use super::part::{Cell, Record, decode, encode};
use super::plan::{Kind, Plan, Row, Setting};

/// Storage of parts. The library accesses no files; its caller does.
pub trait Store: Sync {
    /// The bytes stored under a name, `None` if there are none.
    ///
    /// # Errors
    /// They cannot be read; with a sentence.
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, String>;

    /// Stores bytes under a name atomically, replacing earlier ones: a temporary name first, renamed at the end.
    ///
    /// # Errors
    /// They cannot be stored; with a sentence.
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), String>;

    /// Whether it is time to store the rows of an incomplete part, which a killed process would lose.
    fn part_is_due(&self) -> bool {
        false
    }
}

/// Storage in memory.
#[derive(Debug, Default)]
pub struct Memory(pub Mutex<BTreeMap<String, Vec<u8>>>);

impl Store for Memory {
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, String> {
        Ok(self.0.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned())
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), bytes.to_vec());
        Ok(())
    }
}

/// Number of a shard, from 1, and number of shards.
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

    /// Its parts: every n-th part, so that shards take about the same time if the cost changes along the study.
    pub fn parts(self, plan: &Plan) -> impl Iterator<Item = u64> {
        (self.index - 1..plan.parts()).step_by(usize::try_from(self.of).unwrap_or(usize::MAX))
    }
}

/// Reason for a row without results.
#[derive(Debug, Clone, PartialEq)]
pub enum RowError {
    /// The machine cannot be assembled, jams, or cannot be computed: stored as a result with this reason.
    Failed(String),
    /// The computation was stopped: the row is computed next time.
    Cancelled,
}

/// Outcome of a shard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Done {
    /// Rows computed by this call.
    pub computed: u64,
    /// Number of computed rows without results.
    pub failed: u64,
    /// Rows that existed already.
    pub found: u64,
    /// Parts that could not be used and were computed again.
    pub replaced: u64,
    /// Whether it was stopped before the end of the shard.
    pub cancelled: bool,
}

/// Computes the missing rows of a shard on all threads of the current pool. Every part is stored as soon as it is
/// complete; a cancelled run stores its incomplete parts.
///
/// Rows are taken in their order, each on a separate thread: all threads are then in use to the end, and
/// few parts unfinished at any time.
///
/// # Errors
/// A part cannot be read or stored, or threads cannot be started; with a sentence.
pub fn run(
    plan: &Plan,
    shard: Shard,
    store: &dyn Store,
    compute: Compute,
    watch: &Watch,
) -> Result<Done, String> {
    let mut done = Done::default();
    let mut missing: Vec<(u64, u64)> = Vec::new();
    let mut open = BTreeMap::new();
    for part in shard.parts(plan) {
        let (known, replaced) = kept(plan, part, store)?;
        done.replaced += u64::from(replaced);
        done.found += known.len() as u64;
        let lacking: Vec<(u64, u64)> = plan
            .rows_of(part)
            .filter(|number| known.binary_search_by_key(number, |record| record.number).is_err())
            .map(|number| (part, number))
            .collect();
        if !lacking.is_empty() {
            open.insert(part, Open { lacking: lacking.len(), new: Vec::new() });
            missing.extend(lacking);
        }
    }
    let work = Work {
        plan,
        store,
        missing,
        next: AtomicUsize::new(0),
        open: Mutex::new(open),
        computed: AtomicUsize::new(0),
        failed: AtomicUsize::new(0),
        cancelled: AtomicBool::new(false),
    };
    (watch.begun)(done.found);
    work.go(compute, watch.finished)?;
    let Work { open, computed, failed, cancelled, .. } = work;
    for (part, open) in open.into_inner().unwrap_or_else(PoisonError::into_inner) {
        keep(plan, part, open.new, store)?;
    }
    done.computed = computed.into_inner() as u64;
    done.failed = failed.into_inner() as u64;
    done.cancelled = cancelled.into_inner();
    Ok(done)
}

/// The stored rows of a part, and whether it exists but cannot be used.
fn kept(plan: &Plan, part: u64, store: &dyn Store) -> Result<(Vec<Record>, bool), String> {
    Ok(match store.read(&plan.part_name(part))?.map(|bytes| decode(plan, part, bytes)) {
        Some(Ok(records)) => (records, false),
        Some(Err(_)) => (Vec::new(), true),
        None => (Vec::new(), false),
    })
}

/// Adds rows to the stored ones. Rows that another process has stored meanwhile remain: they are identical.
fn keep(plan: &Plan, part: u64, new: Vec<Record>, store: &dyn Store) -> Result<(), String> {
    if new.is_empty() {
        return Ok(());
    }
    let mut records = kept(plan, part, store)?.0;
    records.extend(new);
    records.sort_by_key(|record| record.number);
    records.dedup_by_key(|record| record.number);
    let bytes = encode(plan, &records).map_err(|error| error.to_string())?;
    store.write(&plan.part_name(part), &bytes)
}

/// An incomplete part.
struct Open {
    lacking: usize,
    /// Rows computed but not stored yet.
    new: Vec<Record>,
}

/// Receiver of the progress of a run.
pub struct Watch<'a> {
    /// Number of rows that existed already.
    pub begun: &'a dyn Fn(u64),
    /// Called for every finished row.
    pub finished: &'a (dyn Fn(&Record) + Sync),
}

impl Watch<'_> {
    /// Ignores the progress.
    pub const NONE: Watch<'static> = Watch { begun: &|_| (), finished: &|_| () };
}

/// Computes one row: its summary, or the reason if there is none.
pub type Compute<'a> = &'a (dyn Fn(&Row) -> Result<Json, RowError> + Sync);

struct Work<'a> {
    plan: &'a Plan,
    store: &'a dyn Store,
    /// (part, row)
    missing: Vec<(u64, u64)>,
    next: AtomicUsize,
    open: Mutex<BTreeMap<u64, Open>>,
    computed: AtomicUsize,
    failed: AtomicUsize,
    cancelled: AtomicBool,
}

impl Work<'_> {
    fn go(&self, compute: Compute, finished: &(dyn Fn(&Record) + Sync)) -> Result<(), String> {
        let threads = rayon::current_num_threads().max(1);
        let workers = threads.min(self.missing.len()).max(1);
        let pool = || rayon::ThreadPoolBuilder::new().num_threads((threads / workers).max(1)).build();
        let pools: Vec<_> =
            (0..workers).map(|_| pool().map_err(|error| error.to_string())).collect::<Result<_, _>>()?;
        std::thread::scope(|scope| {
            let started: Vec<_> =
                pools.iter().map(|pool| scope.spawn(move || self.rows(compute, finished, pool))).collect();
            started.into_iter().try_for_each(|worker| {
                worker
                    .join()
                    .unwrap_or_else(|_| Err("the computation of a row failed unexpectedly".to_owned()))
            })
        })
    }

    /// Computes rows until none is left, each on a pool of its own: an analysis that waits for its own threads cannot
    /// start another row in the meantime.
    fn rows(
        &self,
        compute: Compute,
        finished: &(dyn Fn(&Record) + Sync),
        pool: &rayon::ThreadPool,
    ) -> Result<(), String> {
        while !self.cancelled.load(Ordering::Relaxed) {
            let Some((part, number)) = self.missing.get(self.next.fetch_add(1, Ordering::Relaxed)) else {
                break;
            };
            let Some(record) = pool.install(|| record(self.plan, &self.plan.row(*number), compute)) else {
                self.cancelled.store(true, Ordering::Relaxed);
                break;
            };
            finished(&record);
            self.computed.fetch_add(1, Ordering::Relaxed);
            self.failed.fetch_add(usize::from(record.failed.is_some()), Ordering::Relaxed);
            self.take(*part, record).inspect_err(|_| self.cancelled.store(true, Ordering::Relaxed))?;
        }
        Ok(())
    }

    fn take(&self, part: u64, record: Record) -> Result<(), String> {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(place) = open.get_mut(&part) else { return Ok(()) };
        place.lacking -= 1;
        place.new.push(record);
        if place.lacking == 0 {
            let new = open.remove(&part).map_or(Vec::new(), |place| place.new);
            drop(open);
            return keep(self.plan, part, new, self.store);
        }
        if self.store.part_is_due() {
            for (part, place) in open.iter_mut() {
                keep(self.plan, *part, std::mem::take(&mut place.new), self.store)?;
            }
        }
        Ok(())
    }
}

/// `None` if the computation was stopped.
fn record(plan: &Plan, row: &Row, compute: Compute) -> Option<Record> {
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

pub(super) fn setting_cell(setting: &Setting) -> Cell {
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
