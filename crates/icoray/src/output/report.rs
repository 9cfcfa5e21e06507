//! `report.csv`: a line per frame, beside the pictures.

use super::io_error;
use crate::error::Result;
use crate::frame::Frame;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

/// The columns of `report.csv`, in order. Seconds are wall clock.
const HEADER: &str = "step,time_s,date,field,file,prepare_s,render_s,write_s,rays,columns,frusta,void_frusta,value_min,value_max,missing_values,left_out";

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
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(quoted("plain"), "plain");
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
