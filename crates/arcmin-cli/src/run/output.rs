//! Files appear under their final names complete or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// A complete file that still has a temporary name in the directory of its final one.
pub struct Staged {
    file: NamedTempFile,
    path: PathBuf,
    name: String,
}

impl Staged {
    pub fn write(directory: &Path, name: &str, bytes: &[u8]) -> Result<Staged, Failure> {
        let path = directory.join(name);
        let write = || {
            let mut file = tempfile::Builder::new()
                .prefix(".arcmin-")
                .permissions(permissions())
                .tempfile_in(directory)?;
            // Through the file itself: the wrapper's errors name the temporary file, which tells the user
            // nothing.
            file.as_file_mut().write_all(bytes)?;
            // Without this the rename can reach the disk before the bytes do.
            file.as_file().sync_all()?;
            Ok(file)
        };
        match write() {
            Ok(file) => Ok(Staged { file, path, name: name.to_owned() }),
            Err(cause) => Err(Failure::Write { path, cause }),
        }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn publish(self) -> Result<(), Failure> {
        let path = self.path;
        self.file.persist(&path).map_err(|error| Failure::Write { path, cause: error.error })?;
        Ok(())
    }
}

/// Readable by others, as files written in the usual way are; the process's umask still applies.
#[cfg(unix)]
fn permissions() -> std::fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(0o666)
}

/// Makes the output directory and tries to write there, so that an unusable one is noticed before the
/// computation.
pub fn prepare(directory: &Path) -> Result<(), Failure> {
    let try_it = || {
        std::fs::create_dir_all(directory)?;
        tempfile::Builder::new()
            .prefix(".arcmin-")
            .tempfile_in(directory)?
            .as_file_mut()
            .write_all(&[0; 4096])
    };
    try_it().map_err(|cause| Failure::Write { path: directory.to_owned(), cause })
}

/// Writes one file atomically, for commands without an output directory.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    Staged::write(directory, &name, bytes)?.publish()
}

/// Removes a file, if there is one.
pub fn remove(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
            Err(Failure::Write { path: path.to_owned(), cause })
        }
        _ => Ok(()),
    }
}

/// Prints a line; a reader who has gone (`arcmin … | head`) is no reason to fail.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
