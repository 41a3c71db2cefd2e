//! How a long computation tells how far it is and learns that nobody wants it any more.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Receives progress and is asked for cancellation. Implementations decide what to show; the library shows
/// nothing.
pub trait Progress: Sync {
    /// `share` of the stage called `stage` is done, 0…1. May be called from any thread, often, and out of
    /// order.
    fn report(&self, stage: &str, share: f64);

    /// Whether the computation should end as soon as it can. It then returns its module's error for a
    /// cancelled computation.
    fn is_cancelled(&self) -> bool;
}

/// Counts the parts of a stage that are done, from any number of threads.
pub struct Counter<'a> {
    stage: &'static str,
    all: usize,
    done: AtomicUsize,
    progress: &'a dyn Progress,
}

impl<'a> Counter<'a> {
    /// None of `all` parts is done, which is said.
    pub fn new(stage: &'static str, all: usize, progress: &'a dyn Progress) -> Counter<'a> {
        progress.report(stage, 0.0);
        Counter { stage, all, done: AtomicUsize::new(0), progress }
    }

    /// Counts one part as done and reports the share done so far.
    pub fn one_more(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.report(self.stage, done as f64 / self.all.max(1) as f64);
    }

    /// The result of `part`, counted as soon as it is there.
    pub fn after<T>(&self, part: impl FnOnce() -> T) -> T {
        let given = part();
        self.one_more();
        given
    }

    /// Whether the computation is to be given up.
    pub fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }
}

/// A stage within another one: shows nothing, ends when the other does.
pub struct Unseen<'a>(pub &'a dyn Progress);

impl Progress for Unseen<'_> {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

/// Shows nothing and never cancels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}
