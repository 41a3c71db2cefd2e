//! The host of an analysis on a terminal: files, clock, progress bar, Ctrl-C, cache and checkpoint.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use arcmin::analyses::{AnalysisError, Host, Origin};
use arcmin::design::InputFile;
use arcmin::progress::Progress;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::output::withdraw;
use super::pace::Pace;
use super::{Cache, LARGEST_TABLE, read_bounded, write_file};
use crate::failure::Failure;

/// Set by Ctrl-C or SIGTERM.
static CANCELLED: AtomicBool = AtomicBool::new(false);
/// Whether this run has written a checkpoint, or was resumed from one.
static CHECKPOINTED: AtomicBool = AtomicBool::new(false);
/// Whether this run stores its results as parts of a study.
pub(super) static KEEPS_PARTS: AtomicBool = AtomicBool::new(false);
/// Time that an interrupted run may take to end regularly and store its last state. Terminating it then loses
/// nothing else: results and checkpoints are written atomically.
const GRACE: Duration = Duration::from_millis(90);
/// Shorter computations show no bar.
const PATIENCE: Duration = Duration::from_secs(1);
/// Computing time that a killed run loses at most.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(10);
/// The first checkpoint is written sooner, since the run is then known to be long.
const FIRST_CHECKPOINT: Duration = Duration::from_millis(500);
const CHECKPOINT: &str = "checkpoint.json";

/// Whether Ctrl-C or SIGTERM was received.
pub fn is_stopped() -> bool {
    CANCELLED.load(Ordering::Relaxed)
}

/// Whether --resume can continue this run.
pub fn is_checkpointed() -> bool {
    CHECKPOINTED.load(Ordering::SeqCst)
}

/// Effect of a signal: the computation ends regularly; if this takes longer than [`GRACE`], the process is
/// terminated.
fn stop() {
    if CANCELLED.swap(true, Ordering::SeqCst) {
        std::process::exit(130);
    }
    std::thread::sleep(GRACE);
    let _nothing_is_written_any_more = withdraw();
    let failure = if is_checkpointed() {
        Failure::Ended
    } else if KEEPS_PARTS.load(Ordering::SeqCst) {
        Failure::Unfinished { reason: "stopped; repeat the command to continue from there".to_owned() }
    } else {
        Failure::Analysis { error: AnalysisError::Stopped, options: None, finding: None }
    };
    // The bar, if there is one, is on the line of the cursor.
    if std::io::stderr().is_terminal() {
        eprint!("\r\u{1b}[2K");
    }
    failure.print();
    std::process::exit(2);
}

/// The present stage: its pace and the share displayed last.
type Stage = Arc<Mutex<(Pace, f64)>>;

/// A bar with the text of the stage. It is also redrawn between reports: otherwise the last text before a long
/// computation would not be displayed, and the clock would stop.
fn progress_bar(stage: &Stage, started: Instant) -> ProgressBar {
    let bar = ProgressBar::new(1000);
    let stage = Arc::clone(stage);
    let words = move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
        let stage = stage.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = out.write_str(&stage.0.words(started.elapsed(), stage.1));
    };
    // On a narrow terminal the bar is shortened, the text is not.
    if let Ok(style) = ProgressStyle::with_template("{msg:20!} {wide_bar} {words}") {
        bar.set_style(style.with_key("words", words));
    }
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}

/// Progress on the terminal, and access to files for an analysis.
pub struct Terminal {
    started: Instant,
    /// `None` without display: quiet, or standard error is not a terminal.
    bar: Option<Mutex<Option<(ProgressBar, Stage)>>>,
    /// Directory of the design file.
    beside_design: PathBuf,
    out: PathBuf,
    cache: Cache,
    identity: OnceLock<String>,
    next_checkpoint: Mutex<Duration>,
}

impl Terminal {
    pub fn new(design: &Path, out: &Path, cache: Cache, quiet: bool) -> Terminal {
        // Only a second handler in the same process could fail here; Ctrl-C then has its default effect.
        let _ = ctrlc::set_handler(stop);
        let watched = !quiet && std::io::stderr().is_terminal();
        Terminal {
            started: Instant::now(),
            bar: watched.then(Mutex::default),
            beside_design: design.parent().unwrap_or(Path::new(".")).to_owned(),
            out: out.to_owned(),
            cache,
            identity: OnceLock::new(),
            next_checkpoint: Mutex::new(FIRST_CHECKPOINT),
        }
    }

    /// Sets the identity of the run to which checkpoints belong.
    pub fn set_identity(&self, identity: &str) {
        let _ = self.identity.set(identity.to_owned());
    }

    /// Removes the bar from the screen.
    pub fn clear(&self) {
        if let Some(shown) = &self.bar
            && let Some((bar, _)) = shown.lock().unwrap_or_else(PoisonError::into_inner).take()
        {
            bar.finish_and_clear();
        }
    }

    /// A finished run needs no checkpoint; a failure to remove it has no effect.
    pub fn discard_checkpoint(&self) {
        let _ = std::fs::remove_file(self.out.join(CHECKPOINT));
    }
}

impl Progress for Terminal {
    fn report(&self, stage: &str, share: f64) {
        let Some(shown) = &self.bar else { return };
        if self.started.elapsed() < PATIENCE {
            return;
        }
        // If the lock is taken, this report is skipped, since progress is displayed often enough.
        let Ok(mut shown) = shown.try_lock() else { return };
        let now = self.started.elapsed();
        let (bar, pace) = shown.get_or_insert_with(|| {
            let pace = Arc::new(Mutex::new((Pace::new(stage, now, share), share)));
            (progress_bar(&pace, self.started), pace)
        });
        let mut pace = pace.lock().unwrap_or_else(PoisonError::into_inner);
        if pace.0.stage != stage {
            pace.0 = Pace::new(stage, now, share);
        }
        pace.1 = share;
        // The bar requests its text while it is drawn.
        drop(pace);
        bar.set_message(stage.to_owned());
        // An incomplete stage is never displayed as complete.
        bar.set_position((share.clamp(0.0, 1.0) * 1000.0).min(999.0) as u64);
    }

    fn is_cancelled(&self) -> bool {
        is_stopped()
    }
}

impl Host for Terminal {
    fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        let path = match origin {
            Origin::Design => self.beside_design.join(&file.0),
            Origin::Options => PathBuf::from(&file.0),
        };
        read_bounded(&path, LARGEST_TABLE).map_err(|cause| AnalysisError::Input {
            file: path.display().to_string(),
            line: None,
            message: format!("cannot be read: {cause}"),
            help: match origin {
                Origin::Design => "correct the path: it is relative to the file that names it".to_owned(),
                Origin::Options => "check its name and path".to_owned(),
            },
        })
    }

    fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    fn cached(&self, name: &str) -> Option<Vec<u8>> {
        self.cache.get(name)
    }

    fn cache(&self, name: &str, bytes: &[u8]) {
        self.cache.keep(name, bytes);
    }

    fn checkpoint_is_due(&self) -> bool {
        let next = self.next_checkpoint.lock().unwrap_or_else(PoisonError::into_inner);
        self.started.elapsed() >= *next
    }

    fn keep_checkpoint(&self, bytes: &[u8]) -> Result<(), AnalysisError> {
        let mut kept = self.identity.get().cloned().unwrap_or_default().into_bytes();
        kept.push(b'\n');
        kept.extend_from_slice(bytes);
        write_file(&self.out.join(CHECKPOINT), &kept).map_err(|failure| {
            AnalysisError::usage(failure.to_string(), "choose another directory with --out")
        })?;
        CHECKPOINTED.store(true, Ordering::SeqCst);
        let mut next = self.next_checkpoint.lock().unwrap_or_else(PoisonError::into_inner);
        *next = self.started.elapsed() + CHECKPOINT_INTERVAL;
        Ok(())
    }

    fn checkpoint(&self) -> Result<Vec<u8>, AnalysisError> {
        let path = self.out.join(CHECKPOINT);
        let bytes = std::fs::read(&path).map_err(|cause| {
            AnalysisError::usage(
                format!("cannot read {}: {cause}", path.display()),
                "start again without --resume",
            )
        })?;
        let identity = self.identity.get().map(String::as_bytes).unwrap_or_default();
        match bytes.iter().position(|byte| *byte == b'\n') {
            Some(end) if &bytes[..end] == identity => {
                CHECKPOINTED.store(true, Ordering::SeqCst);
                Ok(bytes[end + 1..].to_vec())
            }
            _ => Err(AnalysisError::usage(
                format!(
                    "{} belongs to a run with another design, other options or input files, or another version of \
                     the program",
                    path.display()
                ),
                "repeat that run with the same inputs, or start again without --resume",
            )),
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.clear();
    }
}
