use super::AnalysisError;
use crate::design::InputFile;
use crate::life::WornState;
use crate::progress::{Progress, Silent};

/// Origin of the name of a file, which determines the directory it is relative to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// In the design file: relative to it.
    Design,
    /// In the options: relative to the working directory.
    Options,
}

/// Services of the caller of an analysis. The library itself accesses no files and no clock.
pub trait Host: Progress {
    /// The content of a file.
    ///
    /// # Errors
    /// [`AnalysisError::Input`] for a file that cannot be read.
    fn read(&self, file: &InputFile, _origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        Err(AnalysisError::Input {
            file: file.0.clone(),
            line: None,
            message: "there are no files here".to_owned(),
            help: "give the values themselves".to_owned(),
        })
    }

    /// Whether the caller needs this result (a key of the summary, or `table.column`), any result of this table or
    /// group, or the figures of the report (`report`). Results that are not needed need not be computed.
    fn needs(&self, _result: &str) -> bool {
        true
    }

    /// Shows a state of a prediction as soon as it is reached, before the prediction is judged.
    fn reached(&self, _state: &WornState) {}

    /// Seconds since an arbitrary time; 0 without a clock.
    fn seconds(&self) -> f64 {
        0.0
    }

    /// The entry that [`Host::cache`] kept under this name, perhaps in an earlier run.
    fn cached(&self, _name: &str) -> Option<Vec<u8>> {
        None
    }

    /// Stores bytes that are costly to compute again. A host without storage ignores them.
    fn cache(&self, _name: &str, _bytes: &[u8]) {}

    /// Whether it is time to keep a checkpoint.
    fn checkpoint_is_due(&self) -> bool {
        false
    }

    /// Keeps the state of a run in place of the one before.
    ///
    /// # Errors
    /// [`AnalysisError`] where it cannot be kept.
    fn keep_checkpoint(&self, _bytes: &[u8]) -> Result<(), AnalysisError> {
        Ok(())
    }

    /// The checkpoint kept last.
    ///
    /// # Errors
    /// [`AnalysisError`] where there is none.
    fn checkpoint(&self) -> Result<Vec<u8>, AnalysisError> {
        Err(AnalysisError::usage("there is no checkpoint to resume from", "start again without resume"))
    }
}

/// A host that limits the computation to some results, by their keys; of a table to those of its columns.
pub struct OnlyResults<'a> {
    /// Host for everything else.
    pub host: &'a dyn Host,
    /// Keys of the required results.
    pub results: &'a [&'a str],
}

impl Progress for OnlyResults<'_> {
    fn report(&self, stage: &str, share: f64) {
        self.host.report(stage, share);
    }

    fn is_cancelled(&self) -> bool {
        self.host.is_cancelled()
    }
}

impl Host for OnlyResults<'_> {
    fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        self.host.read(file, origin)
    }

    fn needs(&self, result: &str) -> bool {
        // A group contains its values, and a table its columns.
        let holds =
            |group: &str, key: &str| key.strip_prefix(group).is_some_and(|rest| rest.starts_with('.'));
        self.results.iter().any(|known| *known == result || holds(known, result) || holds(result, known))
    }

    fn reached(&self, state: &WornState) {
        self.host.reached(state);
    }

    fn seconds(&self) -> f64 {
        self.host.seconds()
    }

    fn cached(&self, name: &str) -> Option<Vec<u8>> {
        self.host.cached(name)
    }

    fn cache(&self, name: &str, bytes: &[u8]) {
        self.host.cache(name, bytes);
    }
}

/// A host of one computation among many: shows no progress of its own.
pub struct Quiet<'a>(pub &'a dyn Host);

impl Progress for Quiet<'_> {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

impl Host for Quiet<'_> {
    fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        self.0.read(file, origin)
    }

    fn seconds(&self) -> f64 {
        self.0.seconds()
    }

    fn cached(&self, name: &str) -> Option<Vec<u8>> {
        self.0.cached(name)
    }

    fn cache(&self, name: &str, bytes: &[u8]) {
        self.0.cache(name, bytes);
    }
}

/// A host without files, clock, progress and cancellation.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoHost;

impl Progress for NoHost {
    fn report(&self, stage: &str, share: f64) {
        Silent.report(stage, share);
    }

    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Host for NoHost {}
