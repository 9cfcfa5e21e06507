//! `report.csv`: a line per frame, beside the pictures.

use super::io_error;
use crate::error::Result;
use crate::frame::Frame;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

/// The columns of `report.csv`, in order. Seconds are wall clock; errors and tolerance are of premultiplied linear
/// channels, 0 to 1 ([`ErrorSummary`](crate::ErrorSummary)); `error_kind` is `bound` or `estimate`.
const HEADER: &str = "step,time_s,date,field,file,prepare_s,render_s,write_s,rays,columns,frusta,void_frusta,value_min,value_max,missing_values,error_max,error_mean,error_p999,error_kind,tolerance,pixel_step,lights,left_out";

/// The line of a frame whose picture was written to `picture`.
fn row(picture: &Path, frame: &Frame) -> String {
    let (r, s) = (&frame.report, &frame.stamp);
    let file = picture.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned());
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let cells = [
        s.step.to_string(),
        s.time_s.to_string(),
        s.date.clone().unwrap_or_default(),
        frame.field.clone(),
        file,
        format!("{:.6}", r.prepare_s),
        format!("{:.6}", r.render_s),
        format!("{:.6}", r.write_s),
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
        r.quality.pixel_step.to_string(),
        r.quality.lights.to_string(),
        r.left_out.join("; "),
    ];
    cells.map(|cell| quoted(&cell)).join(",")
}

/// A CSV cell (RFC 4180).
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_string()
    }
}

/// Appends the line of a frame to the report at `path`, and the header first where that is new or empty.
pub(super) fn append(path: &Path, picture: &Path, frame: &Frame) -> Result<()> {
    let failed = |e| io_error(path, "cannot write the report", e);
    let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(failed)?;
    let is_new = file.metadata().map_err(failed)?.len() == 0;
    let head = if is_new { format!("{HEADER}\n") } else { String::new() };
    file.write_all(format!("{head}{}\n", row(picture, frame)).as_bytes()).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_cell_for_each_column() {
        let frame = crate::frame::tests::frame();
        let row = row(Path::new("folder/q.png"), &frame);
        let cells: std::collections::HashMap<_, _> = HEADER.split(',').zip(row.split(',')).collect();
        assert_eq!(row.split(',').count(), cells.len());
        assert_eq!((cells["step"], cells["file"]), ("7", "q.png"));
        for (column, value) in [
            ("error_max", f64::from(1e-3f32)),
            ("error_mean", (f64::from(1e-3f32) + f64::from(2.5e-6f32)) / 2.0),
            ("error_p999", f64::from(1e-3f32)),
            ("tolerance", 2e-3),
        ] {
            assert_eq!(cells[column].parse(), Ok(value), "{column}");
        }
        assert_eq!((cells["error_kind"], cells["left_out"]), ("bound", ""));
    }

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(quoted("plain"), "plain");
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
