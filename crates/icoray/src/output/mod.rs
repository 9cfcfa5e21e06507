//! Pictures and their report on disk.

mod animation;
mod atomic;
mod csv;
mod digits;
mod error_map;
mod exr;
mod folder;
mod name;
mod outcomes;
mod png;
mod report;
mod series;
mod template;
mod writer;

pub use animation::{Animated, write_animation};
pub use atomic::Existing;
pub use error_map::{write_error_map, write_error_map_with};
pub use name::{FrameNames, NameTemplate, Output, Stamp};
pub use outcomes::{Outcome, Outcomes};
pub(crate) use png::srgb_byte;
pub use series::{Cinema, Concat, Series};
pub(crate) use template::{Template, date};
pub use writer::{Submitted, WhenFull, Writer, WriterOptions, Written};

use crate::error::{Error, ErrorKind, Result};
use crate::frame::Frame;
use std::path::{Path, PathBuf};

fn io_error(path: &Path, what: &str, error: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Io, format!("{}: {what}: {error}", path.display()))
}

/// Writes `frame` to `path`: as PNG (8-bit sRGB, with text, and with the labels of its scene) or as EXR (linear, exact
/// floats, with the error of each pixel as a fifth channel, `error`), depending on the ending. An existing file is
/// replaced when the new one is complete.
///
/// ```
/// # use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
/// # let mesh = IcosahedralMesh::new(2)?;
/// # let grid = Grid::new(mesh.tables())?;
/// # let layers = Layers::from_heights(&[0.0, 1e6], 6.371e6)?;
/// # let values = vec![1.0f32; 2 * grid.cells()];
/// # let shape = Shape::cell_fastest(grid.cells(), 2);
/// # let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;
/// # let scene = Scene::parse(
/// #     "field = 'one'
/// #      image = { width = 8, height = 8 }
/// #      camera = { lon = 0, lat = 0, distance = 3 }
/// #      transfer = { map = 'viridis', range = [0, 2], opacity = [[0, 0.5], [2, 0.5]] }",
/// # )?;
/// let frame = Renderer::new(1)?.render(&scene, &grid, &layers, &field)?;
/// let folder = std::env::temp_dir().join(format!("icoray-doc-{}", std::process::id()));
/// std::fs::create_dir_all(&folder).unwrap();
/// icoray::output::write_picture(&folder.join("picture.png"), &frame)?;
/// icoray::output::write_picture(&folder.join("picture.exr"), &frame)?;
/// assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), icoray::Error>(())
/// ```
///
/// # Errors
/// [`ErrorKind::Io`] names the path; [`ErrorKind::Argument`] an ending that is neither.
pub fn write_picture(path: &Path, frame: &Frame) -> Result<()> {
    write_picture_with(path, frame, Existing::Overwrite)
}

/// As [`write_picture`], with a say on a file that is there already.
///
/// # Errors
/// As [`write_picture`], and [`ErrorKind::Exists`] as [`Existing`] says.
pub fn write_picture_with(path: &Path, frame: &Frame, existing: Existing) -> Result<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("png") => png::write(path, frame, existing),
        Some("exr") => exr::write(path, frame, existing),
        _ => Err(Error::new(
            ErrorKind::Argument,
            format!("{}: expected a name that ends in .png or .exr", path.display()),
        )),
    }
}

/// Writes `frame` into `directory` under the name that `output` gives, the map of its errors beside it where that has a
/// name too, a row to `report.csv` beside the picture, and what is kept of the series. Missing directories are made; files
/// of the same name are replaced.
///
/// # Errors
/// As [`write_frame_with`].
pub fn write_frame(directory: &Path, output: &Output, stamp: &Stamp, frame: &mut Frame) -> Result<PathBuf> {
    write_frame_with(directory, output, stamp, frame, Existing::Overwrite)
}

/// As [`write_frame`], with a say on files that are there already.
///
/// # Errors
/// [`ErrorKind::Io`] and [`ErrorKind::Exists`] name the path, and say so where the picture itself is written but the map
/// or the row is not; otherwise as [`Output::names`].
pub fn write_frame_with(
    directory: &Path,
    output: &Output,
    stamp: &Stamp,
    frame: &mut Frame,
    existing: Existing,
) -> Result<PathBuf> {
    let start = std::time::Instant::now();
    let names = output.names(stamp, &frame.field)?;
    frame.stamp = stamp.clone();
    let path = directory.join(names.file);
    let map = names.error.map(|name| directory.join(name));
    // Before the picture is there, so that no frame is half there but for a true failure.
    if let Some(map) = &map {
        existing.check(map)?;
    }
    made_folder(&path)?;
    write_picture_with(&path, frame, existing)?;
    let beside = |e: Error| e.after(format!("the picture {} is written", path.display()));
    if let Some(map) = &map {
        made_folder(map).and_then(|_| write_error_map_with(map, frame, existing)).map_err(beside)?;
    }
    frame.report.write_s = start.elapsed().as_secs_f64();
    report::append(&report::beside(&path), &path, frame).map_err(beside)?;
    output.series.add(directory, stamp, &path, map.as_deref()).map_err(beside)?;
    Ok(path)
}

/// The folder of a file, made where it is missing.
fn made_folder(path: &Path) -> Result<&Path> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| io_error(folder, "cannot make the directory", e))?;
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::frame;

    #[test]
    fn a_frame_leaves_a_picture_an_error_map_and_a_row() {
        let folder = tempfile::tempdir().unwrap();
        let name = |text| NameTemplate::new(text).unwrap();
        let error = Some(name("errors/{step}.png"));
        let output = Output { error, ..name("{field}_{step}.exr").into() };
        let stamp = Stamp { step: 12, ..Stamp::default() };
        let path = write_frame(folder.path(), &output, &stamp, &mut frame()).unwrap();
        assert_eq!(path, folder.path().join("q_12.exr"));
        assert!(path.is_file() && folder.path().join("errors/12.png").is_file());
        let report = std::fs::read_to_string(folder.path().join("report.csv")).unwrap();
        assert_eq!(report.lines().count(), 2);
        let output = Output { error: None, ..output };
        let stamp = Stamp { step: 13, ..Stamp::default() };
        write_frame(folder.path(), &output, &stamp, &mut frame()).unwrap();
        assert_eq!(std::fs::read_dir(folder.path().join("errors")).unwrap().count(), 1);
    }

    #[test]
    fn an_error_map_is_a_png() {
        let error = write_error_map(Path::new("map.exr"), &frame()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Argument);
        assert!(error.to_string().contains("map.exr"), "{error}");
    }
}
