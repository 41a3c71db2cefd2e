use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use arcmin::progress::Progress;
use indicatif::{ProgressBar, ProgressStyle};

/// Set by Ctrl-C; a second Ctrl-C ends the process at once.
static CANCELLED: AtomicBool = AtomicBool::new(false);
/// Work shorter than this needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Progress on the terminal, and Ctrl-C as a wish that computations respect.
pub struct Bar {
    started: Instant,
    /// `None` where nobody watches: quiet, or standard error is not a terminal.
    bar: Option<Mutex<Shown>>,
}

#[derive(Default)]
struct Shown {
    bar: Option<ProgressBar>,
    stage: String,
}

impl Bar {
    pub fn new(quiet: bool) -> Bar {
        // Only a second handler in the same process could fail here; Ctrl-C then keeps its usual effect.
        let _ = ctrlc::set_handler(|| {
            if CANCELLED.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
            eprintln!("stopping; Ctrl-C again ends at once");
        });
        let watched = !quiet && std::io::stderr().is_terminal();
        Bar { started: Instant::now(), bar: watched.then(Mutex::default) }
    }

    /// Takes the bar off the screen.
    pub fn clear(&self) {
        if let Some(shown) = &self.bar
            && let Some(bar) = shown.lock().unwrap_or_else(PoisonError::into_inner).bar.take()
        {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Bar {
    fn report(&self, stage: &str, share: f64) {
        let Some(shown) = &self.bar else { return };
        if self.started.elapsed() < PATIENCE {
            return;
        }
        // Whoever finds the lock taken has nothing to add: progress is shown often enough.
        let Ok(mut shown) = shown.try_lock() else { return };
        if shown.bar.is_none() {
            let bar = ProgressBar::new(1000);
            if let Ok(style) = ProgressStyle::with_template("{msg:24} {bar:40} {percent:>3} %  {elapsed}") {
                bar.set_style(style);
            }
            shown.bar = Some(bar);
        }
        if shown.stage != stage {
            shown.stage = stage.to_owned();
        }
        if let Some(bar) = &shown.bar {
            bar.set_message(stage.to_owned());
            bar.set_position((share.clamp(0.0, 1.0) * 1000.0) as u64);
        }
    }

    fn is_cancelled(&self) -> bool {
        CANCELLED.load(Ordering::Relaxed)
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.clear();
    }
}
