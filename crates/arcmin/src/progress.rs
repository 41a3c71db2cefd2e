//! How a long computation tells how far it is and learns that nobody wants it any more.

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

/// Shows nothing and never cancels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}
