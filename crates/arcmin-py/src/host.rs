//! Host of an analysis under Python: files, clock, cancellation, progress, cache.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use arcmin::analyses::stage::AnyDesign;
use arcmin::analyses::{Analysis, AnalysisError, Host, Origin};
use arcmin::design::InputFile;
use arcmin::progress::Progress;

/// The call: together with the files it identifies a run.
pub struct Question {
    pub analysis: &'static Analysis,
    pub design: Arc<AnyDesign>,
    /// As TOML.
    pub options: String,
}

pub const ORIGIN: &str = "the options";

/// Files, clock, cancellation, progress.
#[derive(Default)]
pub struct PyHost {
    started: Option<Instant>,
    cancelled: AtomicBool,
    progress: Mutex<Option<(String, f64)>>,
    beside_design: PathBuf,
    /// Contents of files given by the caller as data, by name.
    given: HashMap<String, Vec<u8>>,
    /// Contents of the files that were read; they are part of the identification of a run.
    read: Mutex<HashMap<(String, bool), Vec<u8>>>,
    question: Option<Arc<Question>>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl PyHost {
    pub fn new(beside_design: &Path, given: HashMap<String, Vec<u8>>) -> PyHost {
        PyHost {
            started: Some(Instant::now()),
            beside_design: beside_design.to_owned(),
            given,
            ..PyHost::default()
        }
    }

    pub fn about(self, question: Arc<Question>) -> PyHost {
        PyHost { question: Some(question), ..self }
    }

    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// The last report of progress.
    pub fn progress(&self) -> Option<(String, f64)> {
        locked(&self.progress).clone()
    }

    /// Identification of the run, from the files as they were read.
    pub fn identity(&self) -> Result<String, AnalysisError> {
        let Some(question) = &self.question else {
            return Err(AnalysisError::usage("there is no question", ""));
        };
        question.design.identity(question.analysis, &question.options, ORIGIN, self)
    }

    fn read_now(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        if let (Some(bytes), Origin::Options) = (self.given.get(&file.0), origin) {
            return Ok(bytes.clone());
        }
        let path = match origin {
            Origin::Design => self.beside_design.join(&file.0),
            Origin::Options => PathBuf::from(&file.0),
        };
        std::fs::read(&path).map_err(|cause| AnalysisError::Input {
            file: path.display().to_string(),
            line: None,
            message: format!("cannot be read: {cause}"),
            help: match origin {
                Origin::Design => "correct the path: it is relative to the file that names it",
                Origin::Options => "check its name and path",
            }
            .to_owned(),
        })
    }
}

impl Progress for PyHost {
    fn report(&self, stage: &str, share: f64) {
        // If the lock is taken, this report is skipped; progress is reported often enough.
        let Ok(mut at) = self.progress.try_lock() else { return };
        match &mut *at {
            Some((name, value)) if name == stage => *value = share,
            at => *at = Some((stage.to_owned(), share)),
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl Host for PyHost {
    fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        let key = (file.0.clone(), origin == Origin::Design);
        if let Some(bytes) = locked(&self.read).get(&key) {
            return Ok(bytes.clone());
        }
        let bytes = self.read_now(file, origin)?;
        locked(&self.read).insert(key, bytes.clone());
        Ok(bytes)
    }

    fn seconds(&self) -> f64 {
        self.started.map_or(0.0, |started| started.elapsed().as_secs_f64())
    }

    fn cached(&self, name: &str) -> Option<Vec<u8>> {
        locked(&MEMORY).get(name)
    }

    fn cache(&self, name: &str, bytes: &[u8]) {
        locked(&MEMORY).keep(name, bytes);
    }

    fn keep_checkpoint(&self, bytes: &[u8]) -> Result<(), AnalysisError> {
        let name = format!("checkpoint {}", self.identity()?);
        locked(&MEMORY).keep(&name, bytes);
        Ok(())
    }

    fn checkpoint(&self) -> Result<Vec<u8>, AnalysisError> {
        let name = format!("checkpoint {}", self.identity()?);
        locked(&MEMORY).get(&name).ok_or_else(|| {
            AnalysisError::usage(
                "no run of this design with these options was interrupted in this session",
                "leave resume out to start again",
            )
        })
    }
}

/// Results kept within a session: reduced discs, checkpoints of interrupted runs.
struct Memory {
    /// Entries in the order of age, the oldest first.
    entries: Vec<(String, Vec<u8>)>,
}

static MEMORY: Mutex<Memory> = Mutex::new(Memory { entries: Vec::new() });
/// Largest total size; the oldest entries are removed first.
const MEMORY_BYTES: usize = 256 << 20;

impl Memory {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        self.entries.iter().find(|(known, _)| known == name).map(|(_, bytes)| bytes.clone())
    }

    fn keep(&mut self, name: &str, bytes: &[u8]) {
        self.entries.retain(|(known, _)| known != name);
        self.entries.push((name.to_owned(), bytes.to_owned()));
        while self.entries.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() > MEMORY_BYTES {
            self.entries.remove(0);
        }
    }
}
