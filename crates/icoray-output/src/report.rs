//! `report.csv`: a line per frame, beside the pictures.

use super::csv_cell;
use crate::frame::{Colors, Frame};
use crate::path::io_error;
use icoray_grid::{Error, ErrorKind, Result};
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The columns of `report.csv`, in order. Seconds are wall clock; errors and tolerance are of premultiplied linear
/// channels, 0 to 1 ([`ErrorSummary`](crate::frame::ErrorSummary)); `error_kind` is `bound` or `estimate`;
/// `over_tolerance` counts the pixels whose error is above `tolerance`; `tiles` and
/// `compose_s` are those of rank 0; `sharing` is how several ranks shared out the picture, and why; `device` is what
/// traced rays beside the CPU, on rank 0, `left_to_cpu` why the CPU did instead, all or some; `color_min` and
/// `color_max` are the values over which the colour map `colors` goes, which also says how they came to be these; of
/// several maps they are the first one's, and `colors` has the ranges of all; `edge_pixels` are those with the edge of
/// a surface in them, which show the mean of 8 rays or more, and `rays` and what follows count these too; `samples` is the
/// scene's, `rays_per_pixel` the mean number that pixels took, and `sampling_error_max` and `sampling_error_mean` the
/// estimated errors of their means, empty where pixels are one ray each; cells per pixel are counted as in
/// [`CellsPerPixel`](crate::frame::CellsPerPixel).
const HEADER: &str = "step,time_s,date,field,file,prepare_s,render_s,write_s,rays,columns,frusta,void_frusta,value_min,value_max,missing_values,error_max,error_mean,error_p999,error_kind,tolerance,over_tolerance,pixel_step,lights,threads,bytes_copied,copy_s,waited_s,bytes_derived,ranks,tiles,balance,gather_s,bytes_received,fragments,fragment_bytes,compose_s,sharing,device,left_to_cpu,upload_s,device_s,bytes_uploaded,color_min,color_max,colors,edge_pixels,samples,rays_per_pixel,sampling_error_max,sampling_error_mean,cells_per_pixel_max,cells_per_pixel_mean,left_out";

/// The line of a frame whose picture was written to `picture`.
fn row(picture: &Path, frame: &Frame) -> String {
    let (r, s) = (&frame.report, &frame.stamp);
    let file = picture.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned());
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let colors = match r.colors.len() {
        0 => String::new(),
        1 => frame.of_each(|colors| colors.how.clone()),
        _ => frame.of_each(|Colors { how, range: [low, high], .. }| format!("{how}, {low} to {high}")),
    };
    let cells = [
        s.step.to_string(),
        s.time_s.to_string(),
        s.date.clone().unwrap_or_default(),
        frame.field.clone(),
        file,
        format!("{:.6}", r.timing.prepare_s),
        format!("{:.6}", r.timing.render_s),
        format!("{:.6}", r.timing.write_s),
        r.counts.rays.to_string(),
        r.counts.columns.to_string(),
        r.counts.frusta.to_string(),
        r.counts.void_frusta.to_string(),
        number(r.value_range.map(|v| v[0])),
        number(r.value_range.map(|v| v[1])),
        r.missing_values.to_string(),
        format!("{:e}", r.error.max),
        format!("{:e}", r.error.mean),
        format!("{:e}", r.error.p999),
        r.error.certainty.to_string(),
        r.quality.tolerance.to_string(),
        r.error.over.to_string(),
        r.quality.pixel_step.to_string(),
        r.quality.lights.to_string(),
        r.threads.to_string(),
        r.bytes_copied.to_string(),
        format!("{:.6}", r.timing.copy_s),
        format!("{:.6}", r.timing.waited_s),
        r.derived_bytes.to_string(),
        r.ranks.count.to_string(),
        r.ranks.tiles.to_string(),
        format!("{:.3}", r.ranks.balance),
        format!("{:.6}", r.ranks.gather_s),
        r.ranks.bytes_received.to_string(),
        r.counts.fragments.to_string(),
        r.counts.fragment_bytes.to_string(),
        format!("{:.6}", r.ranks.compose_s),
        r.ranks.sharing.map_or_else(String::new, |sharing| sharing.to_string()),
        r.device.name.clone().unwrap_or_default(),
        r.device.left_to_cpu.clone().unwrap_or_default(),
        format!("{:.6}", r.device.upload_s),
        number(r.device.trace_s),
        r.device.bytes_uploaded.to_string(),
        number(r.colors.first().map(|c| c.range[0])),
        number(r.colors.first().map(|c| c.range[1])),
        colors,
        r.edge_pixels.to_string(),
        r.sampling.samples.to_string(),
        format!("{:.3}", r.sampling.rays_per_pixel),
        number(r.sampling.error.map(|error| error.max)),
        number(r.sampling.error.map(|error| error.mean)),
        format!("{:.3}", r.sampling.cells_per_pixel.max),
        format!("{:.3}", r.sampling.cells_per_pixel.mean),
        r.left_out.join("; "),
    ];
    cells.map(|cell| csv_cell::quoted(&cell)).join(",")
}

/// The report of the folder in which `picture` lies.
pub(super) fn beside(picture: &Path) -> PathBuf {
    picture.with_file_name("report.csv")
}

/// Refuses a report that has other columns than ours: lines of two kinds in one file could not be distinguished.
pub(super) fn check(path: &Path) -> Result<()> {
    let found = match std::fs::metadata(path) {
        // Opening a pipe would wait for a writer.
        Ok(found) if !found.is_file() => Err(io::Error::other("it is not a file")),
        Ok(_) => File::open(path),
        Err(e) => Err(e),
    };
    match found {
        Ok(file) => check_columns(path, &file),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(e) => Err(io_error(path, FAILED, e)),
    }
}

/// Reads no more than the header of ours would have. A part of it is what a disk that was full left of ours.
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

/// Appends the line of a frame to the report at `path`, and the header first where that is new or was cut off by a full
/// disk. The file is locked meanwhile, so that contexts and processes may share a report; where it cannot be, each line
/// is still one write. A line that a full disk cut off before stays alone.
pub(super) fn append(path: &Path, picture: &Path, frame: &Frame) -> Result<()> {
    let failed = |e| io_error(path, FAILED, e);
    check(path)?;
    let mut file = OpenOptions::new().create(true).append(true).read(true).open(path).map_err(failed)?;
    // Given back when the file is closed.
    let is_locked = file.lock().is_ok();
    check_columns(path, &file)?;
    let length = file.metadata().map_err(failed)?.len();
    let head = if length == 0 {
        format!("{HEADER}\n")
    } else if length <= HEADER.len() as u64 && is_locked {
        file.set_len(0).map_err(failed)?;
        format!("{HEADER}\n")
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
    use crate::frame::{CellsPerPixel, DeviceReport, RanksReport, SamplingError, SamplingReport, Timing};

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
        (frame.report.counts.fragments, frame.report.counts.fragment_bytes) = (11, 440);
        frame.report.device = DeviceReport {
            name: Some("GPU".into()),
            left_to_cpu: Some("it is lost".into()),
            upload_s: 0.375,
            trace_s: Some(0.75),
            bytes_uploaded: 5,
        };
        frame.report.error.over = 6;
        frame.report.sampling = SamplingReport {
            samples: 16,
            rays_per_pixel: 5.25,
            error: Some(SamplingError { max: 0.0625, mean: 0.03125 }),
            cells_per_pixel: CellsPerPixel { max: 42.5, mean: 7.125 },
        };
        frame.report.colors = vec![Colors { field: "q".into(), range: [-0.25, 1.5], how: "vik; fixed".into() }];
        let row = row(Path::new("folder/q.png"), &frame);
        let cells: std::collections::HashMap<_, _> = HEADER.split(',').zip(row.split(',')).collect();
        assert_eq!(row.split(',').count(), cells.len());
        assert_eq!((cells["step"], cells["file"]), ("7", "q.png"));
        for (column, value) in [
            ("error_max", f64::from(1e-3f32)),
            ("error_mean", (f64::from(1e-3f32) + f64::from(2.5e-6f32)) / 2.0),
            ("error_p999", f64::from(1e-3f32)),
            ("tolerance", 2e-3),
            ("over_tolerance", 6.0),
            ("samples", 16.0),
            ("rays_per_pixel", 5.25),
            ("sampling_error_max", 0.0625),
            ("sampling_error_mean", 0.03125),
            ("cells_per_pixel_max", 42.5),
            ("cells_per_pixel_mean", 7.125),
            ("threads", 3.0),
            ("bytes_copied", 4096.0),
            ("copy_s", 0.25),
            ("waited_s", 0.5),
            ("ranks", 4.0),
            ("tiles", 17.0),
            ("balance", 0.875),
            ("gather_s", 0.125),
            ("fragments", 11.0),
            ("fragment_bytes", 440.0),
            ("compose_s", 0.0625),
            ("upload_s", 0.375),
            ("device_s", 0.75),
            ("bytes_uploaded", 5.0),
            ("color_min", -0.25),
            ("color_max", 1.5),
            ("bytes_received", f64::from(2u32.pow(20)).powi(2)),
        ] {
            assert_eq!(cells[column].parse(), Ok(value), "{column}");
        }
        assert_eq!([cells["device"], cells["left_to_cpu"]], ["GPU", "it is lost"]);
        assert_eq!(cells["colors"], "vik; fixed");
        // Of several maps the first one's range, and in words those of all.
        frame.report.colors.push(Colors { field: "w".into(), range: [2.0, 3.0], how: "viridis".into() });
        let several = super::row(Path::new("folder/q.png"), &frame);
        assert!(several.contains(",-0.25,1.5,\"q: vik; fixed, -0.25 to 1.5; w: viridis, 2 to 3\","), "{several}");
        assert_eq!([cells["error_kind"], cells["sharing"], cells["left_out"]], ["bound", "", ""]);
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
        let line = row(Path::new("q.png"), &frame);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{HEADER}\n{line}\n{line}\n"));
        // As full disks leave it.
        for cut in [1, 9, HEADER.len()] {
            std::fs::write(&path, &HEADER[..cut]).unwrap();
            append(&path, Path::new("q.png"), &frame).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{HEADER}\n{line}\n"));
        }
        std::fs::write(&path, format!("{HEADER}\n7,60")).unwrap();
        append(&path, Path::new("q.png"), &frame).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{HEADER}\n7,60\n{line}\n"));
    }

    #[test]
    fn lines_of_two_versions_do_not_mix() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.csv");
        let older = HEADER.replace(",threads", "");
        for other in [format!("{older}\n1,2\n"), format!("{HEADER},more\n"), "\n".into()] {
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
    fn what_is_not_a_file_is_left_alone() {
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
