//! `report.csv`: a line per frame, beside the pictures.

use crate::folder::{existing_file, io_error};
use crate::frame::Frame;
use crate::frame::figures::{FIGURES, Scope};
use icoray_grid::{Error, ErrorKind, Result, printable};
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The first line: names of figures, and of two columns that identify the picture.
static HEADER: LazyLock<String> = LazyLock::new(|| {
    let figures = FIGURES.iter().filter(|figure| figure.scope >= Scope::Frame).map(|figure| figure.name);
    figures.chain(["field", "file"]).collect::<Vec<_>>().join(",")
});

/// The line of a frame whose picture was written to `picture`.
fn row(picture: &Path, frame: &Frame) -> String {
    let file = picture.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned());
    let figures = frame.figures(Scope::Frame).map(|(_, value)| value.to_string());
    let cells = figures.chain([frame.field.clone(), file]);
    cells.map(|cell| csv_cell(&cell)).collect::<Vec<_>>().join(",")
}

/// A CSV cell (RFC 4180), without control characters.
pub(super) fn csv_cell(cell: &str) -> String {
    let cell = printable(cell);
    if cell.contains([',', '"']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.into_owned() }
}

/// The report of the folder in which `picture` lies.
pub(super) fn beside(picture: &Path) -> PathBuf {
    picture.with_file_name("report.csv")
}

/// Checks that a report has our columns: lines of two kinds in one file could not be distinguished.
pub(super) fn check(path: &Path) -> Result<()> {
    let found = existing_file(path).map_err(|e| io_error(path, FAILED, e))?;
    found.map_or(Ok(()), |file| check_columns(path, &file))
}

/// Reads no more than the length of our header. A part of it is the rest of ours after a full disk.
fn check_columns(path: &Path, file: &File) -> Result<()> {
    let mut head = Vec::new();
    file.take(HEADER.len() as u64 + 1).read_to_end(&mut head).map_err(|e| io_error(path, FAILED, e))?;
    if HEADER.as_bytes().starts_with(&head) || head.strip_suffix(b"\n") == Some(HEADER.as_bytes()) {
        return Ok(());
    }
    let wish = "move it away or write to another directory";
    let context = format!("{}: its first line is not that of this version's reports; {wish}", path.display());
    Err(Error::new(ErrorKind::Exists, context))
}

const FAILED: &str = "cannot write the report";

/// Appends the line of a frame to the report at `path`, and the header first if the file is new or a full disk cut it
/// off. The file is locked meanwhile, so that contexts and processes may share a report; if it cannot be locked, each
/// line is still one write. A line that a full disk cut off stays on its own.
pub(super) fn append(path: &Path, picture: &Path, frame: &Frame) -> Result<()> {
    let failed = |e| io_error(path, FAILED, e);
    check(path)?;
    let mut file = OpenOptions::new().create(true).append(true).read(true).open(path).map_err(failed)?;
    // The lock is released when the file is closed.
    let is_locked = file.lock().is_ok();
    check_columns(path, &file)?;
    let length = file.metadata().map_err(failed)?.len();
    let head = if length == 0 {
        format!("{}\n", *HEADER)
    } else if length <= HEADER.len() as u64 && is_locked {
        file.set_len(0).map_err(failed)?;
        format!("{}\n", *HEADER)
    } else {
        let mut last = [0];
        file.seek(SeekFrom::End(-1)).and_then(|_| file.read_exact(&mut last)).map_err(failed)?;
        if last == *b"\n" { String::new() } else { "\n".to_owned() }
    };
    file.write_all(format!("{head}{}\n", row(picture, frame)).as_bytes()).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{CellsPerPixel, Colors, DeviceReport, RanksReport, SamplingError, SamplingReport, Timing};
    use icoray_scene::Lights;

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(csv_cell("plain"), "plain");
        assert_eq!(csv_cell("a, \"b\""), "\"a, \"\"b\"\"\"");
        assert_eq!(csv_cell("a\nb\u{1b}[31m"), r"a\nb\u{1b}[31m");
    }

    #[test]
    fn a_row_has_a_cell_for_each_column() {
        let mut frame = crate::frame::tests::frame();
        frame.report.threads = 3;
        frame.report.bytes_copied = 4096;
        frame.report.timing = Timing { copy_s: 0.25, waited_s: 0.5, ..Timing::default() };
        frame.report.ranks = RanksReport {
            count: 4,
            tiles: 17,
            bytes_received: 1 << 40,
            balance: 0.875,
            gather_s: 0.125,
            compose_s: 0.0625,
            sharing: None,
        };
        frame.report.counts.fragments = 11;
        frame.report.counts.fragment_bytes = 440;
        frame.report.device = DeviceReport {
            name: Some("GPU".into()),
            left_to_cpu: Some("it is lost".into()),
            upload_s: 0.375,
            device_s: Some(0.75),
            bytes_uploaded: 5,
        };
        frame.report.error.pixels_over_tolerance = 6;
        frame.report.sampling = SamplingReport {
            samples: 16,
            rays_per_pixel: 5.25,
            error: Some(SamplingError { max: 0.0625, mean: 0.03125 }),
            cells_per_pixel: CellsPerPixel { max: 42.5, mean: 7.125 },
        };
        frame.report.colors = vec![Colors { field: "q".into(), range: [-0.25, 1.5], how: "vik; fixed".into() }];
        frame.report.timing.write_s = 2e-5;
        frame.report.quality.lights = Lights::Coarse;
        let row = row(Path::new("folder/q.png"), &frame).replace("\"q: vik; fixed, -0.25 to 1.5\"", "colors");
        let cells: std::collections::HashMap<_, _> = HEADER.split(',').zip(row.split(',')).collect();
        assert_eq!(row.split(',').count(), cells.len());
        let expected = "step=7 file=q.png field=q error_max=0.0010000000474974513 error_mean=5.01250023717148e-4 \
                        error_is_bound=true tolerance=0.002 pixels_over_tolerance=6 lights=coarse samples=16 \
                        rays_per_pixel=5.25 sampling_error_max=0.0625 sampling_error_mean=0.03125 \
                        cells_per_pixel_max=42.5 cells_per_pixel_mean=7.125 threads=3 bytes_copied=4096 copy_s=0.25 \
                        waited_s=0.5 write_s=2e-5 ranks=4 tiles=17 balance=0.875 gather_s=0.125 fragments=11 \
                        fragment_bytes=440 compose_s=0.0625 bytes_received=1099511627776 scheme=alone sharing= \
                        drawn_on=gpu|and|cpu device=GPU left_to_cpu=it|is|lost upload_s=0.375 device_s=0.75 \
                        bytes_uploaded=5 value_min= color_min=-0.25 color_max=1.5 colors=colors left_out=";
        for (column, cell) in expected.split(' ').map(|pair| pair.split_once('=').unwrap()) {
            assert_eq!(cells[column].replace(' ', "|"), cell, "{column}");
        }
        // Of several maps the first one's range in numbers, and in words those of all.
        frame.report.colors.push(Colors { field: "w".into(), range: [2.0, 3.0], how: "viridis".into() });
        let several = super::row(Path::new("folder/q.png"), &frame);
        let colors = ",-0.25,1.5,\"q: vik; fixed, -0.25 to 1.5; w: viridis, 2 to 3\",";
        assert!(several.contains(colors), "{several}");
    }

    #[test]
    fn lines_are_added_below_one_header() {
        let folder = tempfile::tempdir().unwrap();
        let path = beside(&folder.path().join("q.png"));
        check(&path).unwrap();
        assert!(!path.exists(), "a look makes nothing");
        let frame = crate::frame::tests::frame();
        for _ in 0..2 {
            append(&path, Path::new("q.png"), &frame).unwrap();
            check(&path).unwrap();
        }
        let (header, line) = (HEADER.as_str(), row(Path::new("q.png"), &frame));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{header}\n{line}\n{line}\n"));
        // As full disks leave it.
        for cut in [1, 9, HEADER.len()] {
            std::fs::write(&path, &HEADER[..cut]).unwrap();
            append(&path, Path::new("q.png"), &frame).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{header}\n{line}\n"));
        }
        std::fs::write(&path, format!("{header}\n7,60")).unwrap();
        append(&path, Path::new("q.png"), &frame).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{header}\n7,60\n{line}\n"));
    }

    #[test]
    fn lines_of_two_versions_do_not_mix() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.csv");
        let header = HEADER.as_str();
        let older = header.replace(",threads", "");
        for other in [format!("{older}\n1,2\n"), format!("{header},more\n"), "\n".into()] {
            std::fs::write(&path, &other).unwrap();
            let frame = crate::frame::tests::frame();
            for error in [check(&path).unwrap_err(), append(&path, Path::new("q.png"), &frame).unwrap_err()] {
                assert_eq!(error.kind(), ErrorKind::Exists);
                assert!(error.to_string().contains("report.csv: its first line is not that"), "{error}");
            }
            assert_eq!(std::fs::read_to_string(&path).unwrap(), other);
        }
    }

    #[test]
    fn a_report_that_is_not_a_file_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.csv");
        // Opening it would wait for a process at its other end.
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let frame = crate::frame::tests::frame();
        for error in [check(&path).unwrap_err(), append(&path, Path::new("q.png"), &frame).unwrap_err()] {
            assert_eq!(error.kind(), ErrorKind::Io);
        }
    }
}
