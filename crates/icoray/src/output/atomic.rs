//! Whole files or none: a file is written under another name in its own folder and renamed when it is complete.
//!
//! A model may be stopped at any moment, a disk may fill up, and somebody may be looking at the folder meanwhile. A rename
//! within one folder is atomic on every file system that models run on, so a picture is either not there or whole. The
//! other name begins with a dot and ends in `.tmp`; the file of that name goes when anything fails, a panic included. Only
//! a process that is killed leaves it behind.

use super::io_error;
use crate::error::{Error, ErrorKind, Result};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// What is done where a file of a picture's name is there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Existing {
    /// It stays as it is, and writing fails with [`ErrorKind::Exists`]: what a run has drawn is not lost by starting it
    /// again.
    #[default]
    NeverModify,
    /// It is replaced, at once and whole. A link of that name is replaced too, not followed.
    Overwrite,
}

/// Writes the file at `path` with `encode`, which gets a buffered writer that can seek. `what` is being written, in
/// words for an error ("the picture").
///
/// The data are on the disk before the file has its name: a crash leaves no empty picture, and a network file system
/// that tells of a full disk or quota late tells it in time.
pub(super) fn write(
    path: &Path,
    existing: Existing,
    what: &str,
    encode: impl FnOnce(&mut BufWriter<&File>) -> Result<()>,
) -> Result<()> {
    check(path, existing)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let failed = |e: io::Error| io_error(path, &format!("cannot write {what}"), cause(&e));
    let file = temporary(folder).map_err(|e| io_error(path, &format!("cannot create {what}"), cause(&e)))?;
    let mut out = BufWriter::new(file.as_file());
    encode(&mut out)?;
    out.flush().map_err(failed)?;
    drop(out);
    file.as_file().sync_data().map_err(failed)?;
    let moved = match existing {
        Existing::Overwrite => file.persist(path).map_err(|e| e.error),
        Existing::NeverModify => persist_new(file, path),
    };
    match moved {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists && existing == Existing::NeverModify => {
            Err(exists(path))
        }
        moved => moved.map(drop).map_err(failed),
    }
}

/// Refuses a name that cannot be written: a folder's, or with [`Existing::NeverModify`] one that is taken.
pub(super) fn check(path: &Path, existing: Existing) -> Result<()> {
    // The name itself counts, not what a link leads to: a link to nothing is in the way as well.
    match path.symlink_metadata() {
        Ok(there) if there.is_dir() => {
            Err(io_error(path, "cannot write the file", "a directory has its name"))
        }
        Ok(_) if existing == Existing::NeverModify => Err(exists(path)),
        _ => Ok(()),
    }
}

/// The error that says that `path` is taken.
pub(super) fn exists(path: &Path) -> Error {
    let wish =
        "move it away, write to another directory or under another name, or ask for files to be overwritten";
    Error::new(ErrorKind::Exists, format!("{}: is there already and is not modified; {wish}", path.display()))
}

/// A new file in `folder` that anybody may read whom the umask allows: tempfile's own default is the owner alone.
fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".icoray-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Gives `file` its name where that is free: in one step where the file system can do that, which is by a rename that
/// replaces nothing or by a hard link. Where it can do neither (FAT, some FUSE and network ones), a look and a rename, so
/// that a file that comes to be between the two would be replaced.
fn persist_new(file: tempfile::NamedTempFile, path: &Path) -> io::Result<File> {
    let refused = match file.persist_noclobber(path) {
        Ok(file) => return Ok(file),
        Err(refused) => refused,
    };
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    if !matches!(refused.error.kind(), InvalidInput | PermissionDenied | Unsupported) {
        return Err(refused.error);
    }
    rename_new(refused.file, path)
}

/// [`persist_new`] without the file system's help.
fn rename_new(file: tempfile::NamedTempFile, path: &Path) -> io::Result<File> {
    match path.symlink_metadata() {
        Ok(_) => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => file.persist(path).map_err(|e| e.error),
    }
}

/// What the system said, without the temporary file's name, which would only confuse.
fn cause(error: &io::Error) -> String {
    let inner = error.get_ref().and_then(|e| e.source());
    inner.map_or_else(|| error.to_string(), ToString::to_string)
}
