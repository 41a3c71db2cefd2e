//! Atomic writing: files get their final names only when complete.

use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use serde_json::{Map, Value, json};
use tempfile::NamedTempFile;

use crate::failure::Failure;

const SUMMARY: &str = "summary.json";
/// Name of the earlier summary while its results are being replaced: if the run is killed meanwhile, it
/// contains the list of files that the next run must remove.
const REPLACED: &str = ".replaced-summary.json";

/// Directories in which this process has temporary files. The lock is held while files are written, renamed or
/// removed, so that a run is not terminated between two of its renames.
static WRITING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn writing() -> MutexGuard<'static, Vec<PathBuf>> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of this process, and prevents new ones while the guard exists.
pub fn withdraw() -> MutexGuard<'static, Vec<PathBuf>> {
    let directories = writing();
    for directory in directories.iter() {
        for file in temporary_files(directory, &PREFIX) {
            let _ = std::fs::remove_file(file);
        }
    }
    directories
}

/// The results of one run.
///
/// Files are staged beside their final names and renamed together by [`Results::publish`], `summary.json` last:
/// a summary always belongs to the tables beside it, and a run that is killed during its computation leaves the
/// earlier results unchanged.
pub struct Results {
    out: PathBuf,
    staged: Vec<Staged>,
    /// Files of the earlier run, from its summary.
    earlier: Vec<String>,
}

impl Results {
    /// Creates the directory and tests writing to it, so that an unusable one is reported before the
    /// computation. Results of another design are overwritten only with `force`. `name` is that of the design
    /// or robot.
    pub fn prepare_for(out: &Path, name: &str, force: bool) -> Result<Results, Failure> {
        let try_it = || {
            std::fs::create_dir_all(out)?;
            remove_forgotten(out);
            temporary(out)?.as_file_mut().write_all(&[0; 4096])
        };
        try_it().map_err(|cause| Failure::Write { path: out.to_owned(), cause })?;
        let read = |name: &str| -> Value {
            let bytes = std::fs::read(out.join(name)).ok();
            bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or(Value::Null)
        };
        let (before, replaced) = (read(SUMMARY), read(REPLACED));
        if let Some(other) = before["design"]["name"].as_str()
            && other != name
            && !force
        {
            return Err(Failure::Usage {
                message: format!("{} holds results of another design, \"{other}\"", out.display()),
                help: "choose another directory with --out, or overwrite them with --force".to_owned(),
            });
        }
        let files = [before, replaced].into_iter().filter_map(|summary| summary["files"].as_array().cloned());
        let earlier = files.flatten().filter_map(|name| name.as_str().map(str::to_owned)).collect();
        Ok(Results { out: out.to_owned(), staged: Vec::new(), earlier })
    }

    /// Stages a file.
    pub fn file(&mut self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        self.staged.push(Staged::write(&self.out, name, bytes)?);
        Ok(())
    }

    /// Writes the summary, gives all files their final names, and removes files of the earlier run that this
    /// one did not write. Returns the names.
    pub fn publish(mut self, mut summary: Map<String, Value>) -> Result<Vec<String>, Failure> {
        let mut names: Vec<String> = self.staged.iter().map(|staged| staged.name.clone()).collect();
        names.push(SUMMARY.to_owned());
        summary.insert("files".to_owned(), json!(names));
        let mut text = serde_json::to_string_pretty(&Value::Object(summary))
            .map_err(|cause| Failure::Json { cause: cause.to_string() })?;
        text.push('\n');
        self.file(SUMMARY, text.as_bytes())?;
        let _whole = writing();
        // From here to the new summary there is none: the old one must not be beside new tables.
        let replaced = self.out.join(REPLACED);
        match std::fs::rename(self.out.join(SUMMARY), &replaced) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                return Err(Failure::Write { path: replaced, cause });
            }
            _ => {}
        }
        for name in self.earlier.iter().filter(|name| !names.contains(name) && is_plain(name)) {
            remove(&self.out.join(name))?;
        }
        for staged in self.staged {
            staged.publish()?;
        }
        remove(&replaced)?;
        Ok(names)
    }
}

/// A plain file name: a manipulated summary must not remove files elsewhere.
fn is_plain(name: &str) -> bool {
    Path::new(name).file_name().is_some_and(|file| file.to_str() == Some(name))
}

/// Start of all temporary names; those of this process start with [`PREFIX`].
const HIDDEN: &str = ".arcmin-";
/// Process numbers are not sufficient: processes of several machines may write to one directory.
static PREFIX: LazyLock<String> =
    LazyLock::new(|| format!("{HIDDEN}{:016x}-", RandomState::new().hash_one(())));

fn temporary_files(directory: &Path, prefix: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(directory) else { return Vec::new() };
    let is_temporary = |name: &std::ffi::OsStr| name.to_str().is_some_and(|name| name.starts_with(prefix));
    entries.flatten().filter(|entry| is_temporary(&entry.file_name())).map(|entry| entry.path()).collect()
}

/// A temporary file, locked while its process runs, so that other processes do not remove it.
fn temporary(directory: &Path) -> std::io::Result<NamedTempFile> {
    loop {
        let mut named = tempfile::Builder::new();
        named.prefix(PREFIX.as_str());
        // Readable by others, as usual; the process's umask still applies.
        #[cfg(unix)]
        named.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = named.tempfile_in(directory)?;
        // Before the lock is set, another process may remove the file.
        if !matches!(file.as_file().try_lock(), Err(TryLockError::WouldBlock)) && file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes temporary files of killed processes. On file systems without locks they remain.
pub fn remove_forgotten(directory: &Path) {
    for path in temporary_files(directory, HIDDEN) {
        if let Ok(file) = File::open(&path)
            && file.try_lock().is_ok()
        {
            // Another process may have removed it already.
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// A complete file that still has a temporary name in the directory of its final one.
struct Staged {
    file: NamedTempFile,
    path: PathBuf,
    name: String,
}

impl Staged {
    fn write(directory: &Path, name: &str, bytes: &[u8]) -> Result<Staged, Failure> {
        let path = directory.join(name);
        let write = || {
            let mut directories = writing();
            if !directories.iter().any(|known| known == directory) {
                remove_forgotten(directory);
                directories.push(directory.to_owned());
            }
            let mut file = temporary(directory)?;
            // Through the file itself: errors of the wrapper contain the name of the temporary file only.
            file.as_file_mut().write_all(bytes)?;
            // Without this the rename may be on disk before the data.
            file.as_file().sync_all()?;
            Ok(file)
        };
        match write() {
            Ok(file) => Ok(Staged { file, path, name: name.to_owned() }),
            Err(cause) => Err(Failure::Write { path, cause }),
        }
    }

    fn publish(self) -> Result<(), Failure> {
        let path = self.path;
        self.file.persist(&path).map_err(|error| Failure::Write { path, cause: error.error })?;
        Ok(())
    }
}

/// Writes one file atomically.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let staged = Staged::write(directory, &name, bytes)?;
    let _whole = writing();
    staged.publish()
}

/// Removes a file, if there is one.
fn remove(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
            Err(Failure::Write { path: path.to_owned(), cause })
        }
        _ => Ok(()),
    }
}
