//! Cache of costly results between runs: elastic discs, carriers, housings.
//!
//! Names contain a key of all inputs of an entry, and readers check the whole key and a checksum. So one
//! directory may be used for all designs and all versions of the program.

use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::output::write_file;
use super::read_bounded;
use crate::failure::{Failure, warn};

/// Size limit of a directory in bytes; the least recently used entries are removed first.
const LARGEST: u64 = 512 << 20;
/// Suffix of entries; other files of the directory are not touched.
const ENDING: &str = "reduced";

/// A directory of entries. Any number of processes may share it: entries are created atomically, by renaming,
/// and one that another process has removed is computed again.
#[derive(Debug)]
pub struct Cache {
    directory: PathBuf,
    largest: u64,
}

impl Cache {
    pub fn new(directory: &Path) -> Cache {
        Cache { directory: directory.to_owned(), largest: LARGEST }
    }

    /// The user's cache: `$XDG_CACHE_HOME/arcmin`, or where the system keeps caches below the home directory;
    /// for a user without a home that of the results.
    pub fn of_user(results: &Path) -> Cache {
        let absolute = |name: &str| {
            let path = PathBuf::from(std::env::var_os(name)?);
            path.is_absolute().then_some(path)
        };
        let below_home = || {
            if cfg!(windows) {
                return absolute("LOCALAPPDATA");
            }
            let below = if cfg!(target_os = "macos") { "Library/Caches" } else { ".cache" };
            Some(absolute("HOME")?.join(below))
        };
        match absolute("XDG_CACHE_HOME").or_else(below_home) {
            Some(directory) => Cache::new(&directory.join("arcmin")),
            None => Cache::new(results),
        }
    }

    /// The bytes stored under a name.
    pub fn get(&self, name: &str) -> Option<Vec<u8>> {
        let path = self.directory.join(name);
        let bytes = read_bounded(&path, self.largest).ok()?;
        // Marks the entry as recently used. In a read-only directory nothing is removed either.
        if let Ok(file) = OpenOptions::new().append(true).open(&path) {
            let _ = file.set_modified(SystemTime::now());
        }
        Some(bytes)
    }

    /// Stores bytes under a name. A failure only costs computing time in the next run; it is reported and the
    /// run continues.
    pub fn keep(&self, name: &str, bytes: &[u8]) {
        let written = std::fs::create_dir_all(&self.directory)
            .map_err(|cause| Failure::Write { path: self.directory.clone(), cause })
            .and_then(|()| write_file(&self.directory.join(name), bytes));
        match written {
            Ok(()) => self.shrink(name),
            Err(failure) => warn(&format!(
                "warning: {failure}; the next run must compute it again (--cache DIR sets another directory)"
            )),
        }
    }

    /// Removes the least recently used entries until the size limit is kept; never the entry `new`.
    fn shrink(&self, new: &str) {
        let Ok(entries) = std::fs::read_dir(&self.directory) else { return };
        let of_entry = |entry: std::fs::DirEntry| {
            let path = entry.path();
            let about = File::open(&path).and_then(|file| file.metadata()).ok()?;
            let is_entry = path.extension().is_some_and(|ending| ending == ENDING) && about.is_file();
            is_entry.then_some((about.modified().ok()?, about.len(), path))
        };
        let mut entries: Vec<_> = entries.flatten().filter_map(of_entry).collect();
        entries.sort();
        let mut size: u64 = entries.iter().map(|(_, size, _)| size).sum();
        for (_, bytes, path) in entries {
            if size <= self.largest {
                break;
            }
            if !path.ends_with(new) {
                // Another process may have removed it already.
                let _ = std::fs::remove_file(&path);
                size = size.saturating_sub(bytes);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Recently used entries are kept, the least recently used are removed, other files are not touched, and
    /// the newest entry is kept even if it alone is too large.
    #[test]
    fn a_cache_removes_the_least_recently_used_entries() {
        let directory = tempfile::tempdir().unwrap();
        let cache = Cache { largest: 100, ..Cache::new(directory.path()) };
        let past = SystemTime::now() - Duration::from_secs(3600);
        std::fs::write(directory.path().join("foreign.txt"), [0; 500]).unwrap();
        for (age, name) in ["a.reduced", "b.reduced", "c.reduced"].iter().enumerate() {
            cache.keep(name, &[age as u8; 30]);
            let file = OpenOptions::new().append(true).open(directory.path().join(name)).unwrap();
            file.set_modified(past + Duration::from_secs(age as u64)).unwrap();
        }
        assert_eq!(cache.get("a.reduced"), Some(vec![0; 30]));
        cache.keep("d.reduced", &[3; 30]);
        let there = |name: &str| directory.path().join(name).exists();
        assert!(there("a.reduced") && !there("b.reduced") && there("c.reduced") && there("d.reduced"));
        cache.keep("large.reduced", &[4; 300]);
        assert!(!there("a.reduced") && !there("d.reduced") && there("large.reduced") && there("foreign.txt"));
        assert_eq!(cache.get("b.reduced"), None);
    }

    /// Many concurrent writers and readers of the same names: an entry is complete or does not exist.
    #[test]
    fn a_cache_is_shared() {
        let directory = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for writer in 0..4_u8 {
                let cache = Cache { largest: 40_000, ..Cache::new(directory.path()) };
                scope.spawn(move || {
                    for round in 0..20_u8 {
                        let name = format!("{}.reduced", round % 5);
                        cache.keep(&name, &[writer; 10_000]);
                        if let Some(bytes) = cache.get(&name) {
                            assert!(bytes.len() == 10_000 && bytes.iter().all(|byte| *byte == bytes[0]));
                        }
                    }
                });
            }
        });
    }
}
