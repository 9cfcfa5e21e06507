//! Pictures and their report on disk.

mod exr;
mod name;
mod png;
mod report;

pub use name::{NameTemplate, Stamp};

use crate::error::{Error, ErrorKind, Result};
use crate::frame::Frame;
use std::path::{Path, PathBuf};

fn io_error(path: &Path, what: &str, error: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Io, format!("{}: {what}: {error}", path.display()))
}

/// Writes `frame` to `path`, as PNG (8-bit sRGB, with text) or EXR (linear, exact floats) by its ending.
///
/// # Errors
/// [`ErrorKind::Io`] names the path; [`ErrorKind::Argument`] an ending that is neither.
pub fn write_picture(path: &Path, frame: &Frame) -> Result<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("png") => png::write(path, frame),
        Some("exr") => exr::write(path, frame),
        _ => Err(Error::new(
            ErrorKind::Argument,
            format!("{}: expected a name that ends in .png or .exr", path.display()),
        )),
    }
}

/// Writes `frame` into `directory` under the name that `template` gives, and a row to `report.csv` beside the picture.
/// Missing directories are made; a picture of the same name is replaced.
///
/// # Errors
/// [`ErrorKind::Io`] names the path; [`ErrorKind::Argument`] when the template asks for a date that `stamp` lacks.
pub fn write_frame(
    directory: &Path,
    template: &NameTemplate,
    stamp: &Stamp,
    frame: &mut Frame,
) -> Result<PathBuf> {
    let start = std::time::Instant::now();
    let path = directory.join(template.name(stamp, &frame.field)?);
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| io_error(folder, "cannot make the directory", e))?;
    frame.stamp = stamp.clone();
    write_picture(&path, frame)?;
    frame.report.write_s = start.elapsed().as_secs_f64();
    report::append(&folder.join("report.csv"), &path, frame)?;
    Ok(path)
}
