//! Progress and cancellation of long computations.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Receives progress and decides on cancellation. The library itself displays nothing.
pub trait Progress: Sync {
    /// The part `share` of the stage called `stage` is done, 0…1. May be called from any thread, often, and out
    /// of order.
    fn report(&self, stage: &str, share: f64);

    /// Whether the computation shall end as soon as possible. It then returns its module's error for a
    /// cancelled computation.
    fn is_cancelled(&self) -> bool;
}

/// Counts the completed parts of a stage, from any number of threads.
pub struct Counter<'a> {
    stage: &'static str,
    all: usize,
    done: AtomicUsize,
    progress: &'a dyn Progress,
}

impl<'a> Counter<'a> {
    /// Reports that none of `all` parts is done.
    pub fn new(stage: &'static str, all: usize, progress: &'a dyn Progress) -> Counter<'a> {
        progress.report(stage, 0.0);
        Counter { stage, all, done: AtomicUsize::new(0), progress }
    }

    /// Counts one part as done and reports the share done so far.
    pub fn one_more(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.report(self.stage, done as f64 / self.all.max(1) as f64);
    }

    /// The result of `part`, counted when it is complete.
    pub fn after<T>(&self, part: impl FnOnce() -> T) -> T {
        let given = part();
        self.one_more();
        given
    }

    /// Whether the computation shall be cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }
}

/// A stage within another one: without display, cancelled together with the other one.
pub struct Unseen<'a>(pub &'a dyn Progress);

impl Progress for Unseen<'_> {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

/// No display and no cancellation.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}
