//! The tried designs of a session with their results.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use arcmin::analyses::stage::AnyDesign;
use arcmin::checks::Severity;
use arcmin::design::{DesignError, Value};

use super::work::{self, Lane};

/// Number of designs kept; older ones are removed.
const MOST_STATES: usize = 200;

/// A design that was tried.
#[derive(Debug)]
pub struct State {
    pub number: u64,
    pub design: AnyDesign,
    /// Key that was changed and its value; empty for the design as opened.
    pub change: String,
    /// The dragged key: its next value replaces this one.
    dragged: Option<String>,
}

/// Available results of a design, as JSON.
#[derive(Debug, Default)]
pub struct Known {
    pub answers: BTreeMap<&'static str, Arc<str>>,
    /// States of the life as they are reached.
    pub reached: Vec<Arc<str>>,
    /// Stage and share of the present computations.
    pub progress: BTreeMap<&'static str, (String, f64)>,
}

struct Inner {
    states: Vec<(Arc<State>, Known)>,
    present: usize,
    /// Number of changes of the present design.
    changes: u64,
    next_number: u64,
    /// Set when the computations for this design are cancelled.
    cancelled: Arc<AtomicBool>,
}

/// A session.
pub struct Session {
    inner: Mutex<Inner>,
    changed: Condvar,
    file: PathBuf,
    file_name: String,
    lanes: [Mutex<()>; Lane::ALL.len()],
    /// Locked while values of a key are tried.
    trying: Mutex<()>,
    /// Locked while a report is created.
    pub reporting: Mutex<()>,
    /// Names of the files that were named in the design when it was opened.
    pub named_files: Vec<String>,
    started: Instant,
}

/// State, answers and pending work for one reply.
pub struct Snapshot {
    pub state: Arc<State>,
    pub answers: BTreeMap<&'static str, Arc<str>>,
    pub pending: Vec<&'static str>,
    pub can_undo: bool,
    pub can_redo: bool,
    /// Number of changes of the present design: the page ignores replies with a smaller number than the last one shown.
    pub changes: u64,
}

/// Outcome for a design with another value of a key.
#[derive(Debug, PartialEq, Eq)]
pub enum Tryout {
    Refused(String),
    Errors(Vec<&'static str>),
}

/// One tried design in the list of all.
pub struct Tried {
    pub number: u64,
    pub change: String,
    pub is_present: bool,
    pub answers: BTreeMap<&'static str, Arc<str>>,
}

impl Session {
    /// A session on a design; `file_name` is its name in messages.
    ///
    /// # Errors
    /// Errors of the design.
    pub fn open(file: &Path, text: String, file_name: String) -> Result<Session, Box<DesignError>> {
        let design = AnyDesign::parse(&text, &file_name)?;
        let named_files = match &design {
            AnyDesign::Rv(design) => design.measured_flanks().into_iter().map(|flank| flank.file).collect(),
            _ => Vec::new(),
        };
        let state = State { number: 0, design, change: String::new(), dragged: None };
        Ok(Session {
            inner: Mutex::new(Inner {
                states: vec![(Arc::new(state), Known::default())],
                present: 0,
                changes: 0,
                next_number: 1,
                cancelled: Arc::default(),
            }),
            changed: Condvar::new(),
            file: file.to_owned(),
            file_name,
            lanes: Default::default(),
            trying: Mutex::default(),
            reporting: Mutex::default(),
            named_files,
            started: Instant::now(),
        })
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    pub fn file_name(&self) -> &str {
        &self.file_name
    }

    pub fn directory(&self) -> PathBuf {
        self.file.parent().unwrap_or(Path::new(".")).to_owned()
    }

    /// Computes the missing results of the present design.
    pub fn start(self: &Arc<Session>) {
        let mut inner = self.lock();
        self.compute(&mut inner);
    }

    /// Stops computations for other designs and starts the missing ones of the present design, each lane on a
    /// thread of its own.
    fn compute(self: &Arc<Session>, inner: &mut Inner) {
        inner.cancelled.store(true, Ordering::SeqCst);
        inner.cancelled = Arc::default();
        let (state, known) = &mut inner.states[inner.present];
        known.progress.clear();
        if !known.answers.contains_key("life") {
            known.reached.clear();
        }
        for lane in Lane::ALL {
            let lacking: Vec<&'static str> =
                lane.answers().iter().copied().filter(|name| !known.answers.contains_key(name)).collect();
            if lacking.is_empty() {
                continue;
            }
            let (session, state, cancelled) =
                (Arc::clone(self), Arc::clone(state), Arc::clone(&inner.cancelled));
            let run = move || {
                if state.dragged.is_some() {
                    std::thread::sleep(lane.patience());
                }
                let _alone = session.lanes[lane as usize].lock().unwrap_or_else(PoisonError::into_inner);
                for name in lacking {
                    if cancelled.load(Ordering::SeqCst) {
                        return;
                    }
                    if let Some(answer) = work::answer(name, &session, &state, &cancelled) {
                        session.add_results(&state, |known| {
                            known.progress.remove(name);
                            known.answers.insert(name, answer.into());
                        });
                    }
                }
            };
            let _ = std::thread::Builder::new().name(format!("explore-{lane:?}")).spawn(run);
        }
        self.changed.notify_all();
    }

    /// Adds results of a design.
    pub fn add_results(&self, state: &State, add: impl FnOnce(&mut Known)) {
        let mut inner = self.lock();
        if let Some((_, known)) = inner.states.iter_mut().find(|(other, _)| other.number == state.number) {
            add(known);
        }
        drop(inner);
        self.changed.notify_all();
    }

    /// Reports the progress of a computation if it has changed.
    pub fn report_progress(&self, state: &State, name: &'static str, stage: &str, share: f64) {
        let mut inner = self.lock();
        let Some((_, known)) = inner.states.iter_mut().find(|(other, _)| other.number == state.number) else {
            return;
        };
        if !known.progress.get(name).is_some_and(|(known_stage, at)| known_stage == stage && *at == share) {
            known.progress.insert(name, (stage.to_owned(), share));
            drop(inner);
            self.changed.notify_all();
        }
    }

    fn snapshot_of(inner: &Inner) -> Snapshot {
        let (state, known) = &inner.states[inner.present];
        let all = Lane::ALL.iter().flat_map(|lane| lane.answers());
        Snapshot {
            state: Arc::clone(state),
            answers: known.answers.clone(),
            pending: all.copied().filter(|name| !known.answers.contains_key(name)).collect(),
            can_undo: inner.present > 0,
            can_redo: inner.present + 1 < inner.states.len(),
            changes: inner.changes,
        }
    }

    /// The present design, as soon as these results are available, or after a time limit.
    pub fn snapshot(&self, names: &[&str], patience: Duration) -> Snapshot {
        let until = Instant::now() + patience;
        let mut inner = self.lock();
        loop {
            let known = &inner.states[inner.present].1;
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || names.iter().all(|name| known.answers.contains_key(name)) {
                return Session::snapshot_of(&inner);
            }
            inner = self.changed.wait_timeout(inner, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Sets a key of the present design. While it is dragged, its values are one step of the history.
    ///
    /// # Errors
    /// With the message of the commands; the design is not changed.
    pub fn set(self: &Arc<Session>, key: &str, value: Value, drags: bool) -> Result<(), Box<DesignError>> {
        let mut inner = self.lock();
        let present = Arc::clone(&inner.states[inner.present].0);
        let change = format!("{key} = {value}");
        let design = present.design.with(key, value)?;
        let is_same = design == present.design;
        let goes_on = present.dragged.as_deref() == Some(key) && inner.present > 0;
        if is_same && !goes_on {
            return Ok(());
        }
        let dragged = drags.then(|| key.to_owned());
        let place = if goes_on { inner.present } else { inner.present + 1 };
        // A drag ends with the design of its last value, whose results are kept.
        let answers = if is_same { inner.states[inner.present].1.answers.clone() } else { BTreeMap::new() };
        let state = State { number: inner.next_number, design, change, dragged };
        inner.next_number += 1;
        inner.states.truncate(place);
        inner.states.push((Arc::new(state), Known { answers, ..Known::default() }));
        if inner.states.len() > MOST_STATES {
            inner.states.remove(0);
        }
        inner.present = inner.states.len() - 1;
        inner.changes += 1;
        self.compute(&mut inner);
        Ok(())
    }

    /// A design that was tried.
    pub fn state(&self, number: u64) -> Option<Arc<State>> {
        let inner = self.lock();
        inner.states.iter().find(|(state, _)| state.number == number).map(|(state, _)| Arc::clone(state))
    }

    /// Outcome for the present design with each of these values of a key: refused, with error findings (their
    /// codes), or without. Ends early when another design is selected.
    pub fn tried_with(&self, key: &str, values: &[f64]) -> Vec<Tryout> {
        let _alone = self.trying.lock().unwrap_or_else(PoisonError::into_inner);
        let (present, cancelled) = {
            let inner = self.lock();
            (Arc::clone(&inner.states[inner.present].0), Arc::clone(&inner.cancelled))
        };
        let one = |value: &f64| {
            let design = match present.design.with(key, Value::Number(*value)) {
                Ok(design) => design,
                Err(error) => return Tryout::Refused(error.kind.to_string()),
            };
            let found = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| design.findings()));
            let errors =
                found.unwrap_or_default().into_iter().filter(|found| found.severity == Severity::Error);
            Tryout::Errors(errors.map(|found| found.code).collect())
        };
        values.iter().take_while(|_| !cancelled.load(Ordering::SeqCst)).map(one).collect()
    }

    /// Selects another tried design; false if there is none.
    fn go(self: &Arc<Session>, place: impl FnOnce(&Inner) -> Option<usize>) -> bool {
        let mut inner = self.lock();
        let Some(place) = place(&inner).filter(|place| *place < inner.states.len()) else { return false };
        if place != inner.present {
            inner.present = place;
            inner.changes += 1;
            self.compute(&mut inner);
        }
        true
    }

    pub fn undo(self: &Arc<Session>) -> bool {
        self.go(|inner| inner.present.checked_sub(1))
    }

    pub fn redo(self: &Arc<Session>) -> bool {
        self.go(|inner| Some(inner.present + 1))
    }

    pub fn go_to(self: &Arc<Session>, number: u64) -> bool {
        self.go(|inner| inner.states.iter().position(|(state, _)| state.number == number))
    }

    /// All designs that were tried, in their order.
    pub fn tried(&self) -> Vec<Tried> {
        let inner = self.lock();
        let one = |(index, (state, known)): (usize, &(Arc<State>, Known))| Tried {
            number: state.number,
            change: state.change.clone(),
            is_present: index == inner.present,
            answers: known.answers.clone(),
        };
        inner.states.iter().enumerate().map(one).collect()
    }

    /// Events since the last call for one listener; empty after a second without events.
    pub fn news(&self, delivered: &mut Delivered) -> Vec<String> {
        let until = Instant::now() + Duration::from_secs(1);
        let mut inner = self.lock();
        loop {
            let news = delivered.take(&inner.states[inner.present].0, &inner.states[inner.present].1);
            let left = until.saturating_duration_since(Instant::now());
            if !news.is_empty() || left.is_zero() {
                return news;
            }
            inner = self.changed.wait_timeout(inner, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// Events that one listener has already received.
#[derive(Default)]
pub struct Delivered {
    number: Option<u64>,
    answers: Vec<&'static str>,
    reached: usize,
    progress: BTreeMap<&'static str, (String, f64)>,
}

impl Delivered {
    fn take(&mut self, state: &State, known: &Known) -> Vec<String> {
        let number = state.number;
        let mut news = Vec::new();
        if self.number != Some(number) || known.reached.len() < self.reached {
            *self = Delivered { number: Some(number), ..Delivered::default() };
            news.push(format!("{{\"state\":{number},\"news\":\"state\"}}"));
        }
        for point in &known.reached[self.reached..] {
            news.push(format!("{{\"state\":{number},\"news\":\"reached\",\"data\":{point}}}"));
        }
        self.reached = known.reached.len();
        for (name, answer) in &known.answers {
            if !self.answers.contains(name) {
                self.answers.push(name);
                news.push(format!(
                    "{{\"state\":{number},\"news\":\"answer\",\"name\":\"{name}\",\"data\":{answer}}}"
                ));
            }
        }
        if self.progress != known.progress {
            self.progress = known.progress.clone();
            let shown: BTreeMap<_, _> = known
                .progress
                .iter()
                .map(|(name, (stage, share))| (*name, serde_json::json!({ "stage": stage, "share": share })))
                .collect();
            let data = serde_json::json!({ "state": number, "news": "progress", "data": shown });
            news.push(data.to_string());
        }
        news
    }
}
