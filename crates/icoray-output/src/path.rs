//! Errors and folders of paths.

use icoray_grid::{Error, ErrorKind, Result};
use std::path::Path;

/// An error of kind [`ErrorKind::Io`] that names the path.
pub(crate) fn io_error(path: &Path, what: &str, error: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Io, format!("{}: {what}: {error}", path.display()))
}

/// The folder of a file, made if missing.
pub(crate) fn made_folder(path: &Path) -> Result<&Path> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| io_error(folder, "cannot make the directory", e))?;
    Ok(folder)
}
