//! Pictures and their report on disk.

use crate::atomic::Existing;
use crate::error_map::write_error_map;
use crate::folder::made_folder;
use crate::frame::Frame;
use crate::{exr_file, label, lists, png_file, report};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::name::{Output, Stamp};
use std::path::{Path, PathBuf};

/// Writes `frame` to `path`: as PNG (8-bit sRGB, with text, and with the labels of its scene) or as EXR (linear, exact
/// floats, with the error of each pixel as a fifth channel, `error`), depending on the extension. An existing file is
/// replaced when the new one is complete.
///
/// # Errors
/// [`ErrorKind::Io`] names the path; [`ErrorKind::Argument`] an extension that is neither.
pub fn write_picture(path: &Path, frame: &Frame) -> Result<()> {
    write_picture_with(path, frame, Existing::Overwrite)
}

/// As [`write_picture`]; `existing` selects the treatment of an existing file.
///
/// # Errors
/// As [`write_picture`], and [`ErrorKind::Exists`] as specified by [`Existing`].
pub fn write_picture_with(path: &Path, frame: &Frame, existing: Existing) -> Result<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("png") => png_file::write(path, frame, existing),
        Some("exr") => exr_file::write(path, frame, existing),
        _ => {
            let context = format!("{}: expected a name that ends in .png or .exr", path.display());
            Err(Error::new(ErrorKind::Argument, context))
        }
    }
}

/// Writes a picture of all colour maps with their names to the PNG file at `path`; `existing` as in
/// [`write_picture_with`].
///
/// # Errors
/// As [`write_picture_with`].
pub fn write_color_maps(path: &Path, existing: Existing) -> Result<()> {
    png_file::write_canvas(path, &label::maps(), &[], existing)
}

/// Writes `frame` into `directory` under the name that `output` gives, the map of its errors beside it if that has a
/// name too, a row to `report.csv` beside the picture, and entries to the lists of the series. Missing directories are
/// made; `existing` selects the treatment of existing files.
///
/// # Errors
/// [`ErrorKind::Io`] and [`ErrorKind::Exists`] name the path, and state it if the picture itself is written but the map
/// or the row is not; otherwise as [`Output::names`].
pub fn write_frame(
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
    // Checked before the picture is written, so that only a failure to write leaves a picture without its map.
    if let Some(map) = &map {
        existing.check(map)?;
    }
    made_folder(&path)?;
    write_picture_with(&path, frame, existing)?;
    let beside = |e: Error| e.after(format!("the picture {} is written", path.display()));
    if let Some(map) = &map {
        made_folder(map).and_then(|_| write_error_map(map, frame, existing)).map_err(beside)?;
    }
    frame.report.timing.write_s = start.elapsed().as_secs_f64();
    report::append(&report::beside(&path), &path, frame).map_err(beside)?;
    lists::add(&output.series, directory, stamp, &path, map.as_deref()).map_err(beside)?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exr_file::exr_bytes;
    use crate::frame::tests::frame;
    use crate::png_file::png_bytes;
    use icoray_scene::name::NameTemplate;

    #[test]
    fn a_frame_leaves_a_picture_an_error_map_and_a_row() {
        let folder = tempfile::tempdir().unwrap();
        let name = |text| NameTemplate::new(text).unwrap();
        let error = Some(name("errors/{step}.png"));
        let output = Output { error, ..name("{field}_{step}.exr").into() };
        let stamp = Stamp { step: 12, ..Stamp::default() };
        let path = write_frame(folder.path(), &output, &stamp, &mut frame(), Existing::Overwrite).unwrap();
        assert_eq!(path, folder.path().join("q_12.exr"));
        assert!(path.is_file() && folder.path().join("errors/12.png").is_file());
        let report = std::fs::read_to_string(folder.path().join("report.csv")).unwrap();
        assert_eq!(report.lines().count(), 2);
        let output = Output { error: None, ..output };
        let stamp = Stamp { step: 13, ..Stamp::default() };
        write_frame(folder.path(), &output, &stamp, &mut frame(), Existing::Overwrite).unwrap();
        assert_eq!(std::fs::read_dir(folder.path().join("errors")).unwrap().count(), 1);
    }

    #[test]
    fn bytes_are_those_of_files() {
        let (folder, frame) = (tempfile::tempdir().unwrap(), frame());
        for (name, bytes) in [("a.png", png_bytes(&frame)), ("a.exr", exr_bytes(&frame))] {
            let path = folder.path().join(name);
            write_picture(&path, &frame).unwrap();
            assert_eq!(bytes.unwrap(), std::fs::read(&path).unwrap(), "{name}");
        }
    }

    #[test]
    fn an_error_map_is_a_png() {
        let error = write_error_map(Path::new("map.exr"), &frame(), Existing::Overwrite).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Argument);
        assert!(error.to_string().contains("map.exr"), "{error}");
    }
}
