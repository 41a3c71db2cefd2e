//! Parts of a study as files of a directory, with progress by samples.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use arcmin::study::Store;
use indicatif::{ProgressBar, ProgressStyle};

use super::output::{remove_forgotten, write_file};
use super::terminal::KEEPS_PARTS;

/// Computing time that a killed process loses at most.
const KEEP_EVERY: Duration = Duration::from_secs(10);
/// A directory of parts. Several processes, also on several machines, may write to it at the same time.
pub struct Parts {
    directory: PathBuf,
    started: Instant,
    /// Milliseconds since the start.
    next_keep: AtomicU64,
}

impl Parts {
    pub fn new(directory: &Path) -> Parts {
        remove_forgotten(directory);
        KEEPS_PARTS.store(true, Ordering::SeqCst);
        let next_keep = AtomicU64::new(KEEP_EVERY.as_millis() as u64);
        Parts { directory: directory.to_owned(), started: Instant::now(), next_keep }
    }
}

impl Store for Parts {
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, String> {
        let path = self.directory.join(name);
        match std::fs::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(cause) => Err(format!("cannot read {}: {cause}", path.display())),
        }
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        let path = self.directory.join(name);
        std::fs::create_dir_all(&self.directory)
            .map_err(|cause| format!("cannot write {}: {cause}", self.directory.display()))?;
        write_file(&path, bytes).map_err(|failure| failure.to_string())
    }

    fn part_is_due(&self) -> bool {
        let now = self.started.elapsed().as_millis() as u64;
        let next = self.next_keep.load(Ordering::Relaxed);
        let later = now + KEEP_EVERY.as_millis() as u64;
        now >= next
            && self.next_keep.compare_exchange(next, later, Ordering::Relaxed, Ordering::Relaxed).is_ok()
    }
}

/// A progress bar of samples with their rate and the remaining time; none without a terminal.
pub struct SampleBar(Option<ProgressBar>);

impl SampleBar {
    pub fn new(what: &str, all: u64, quiet: bool) -> SampleBar {
        if quiet || !std::io::stderr().is_terminal() {
            return SampleBar(None);
        }
        let bar = ProgressBar::new(all).with_message(what.to_owned());
        let template = "{msg} {wide_bar} {human_pos}/{human_len} {rate} {elapsed} left {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            let rate = |state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{:.2}/s", state.per_sec());
            };
            bar.set_style(style.with_key("rate", rate));
        }
        // During a single slow sample the time must continue to count.
        bar.enable_steady_tick(std::time::Duration::from_millis(500));
        SampleBar(Some(bar))
    }

    /// Number of samples from earlier runs, which do not count for the rate.
    pub fn found(&self, count: u64) {
        if let Some(bar) = &self.0 {
            bar.set_position(count);
            bar.reset_eta();
        }
    }

    pub fn one_more(&self) {
        if let Some(bar) = &self.0 {
            bar.inc(1);
        }
    }
}

impl Drop for SampleBar {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
