//! `report.csv`: a line per frame, beside the pictures.

use super::io_error;
use crate::error::Result;
use crate::frame::Frame;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

/// The columns of `report.csv`, in order. Seconds are wall clock.
const HEADER: &str = "step,time_s,date,field,file,prepare_s,render_s,write_s,rays,columns,frusta,void_frusta,value_min,value_max,missing_values,left_out";

/// One frame's line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameRow(String);

impl FrameRow {
    /// The line of a frame that was written to `path`.
    pub fn new(path: &Path, frame: &Frame) -> Self {
        let (r, s) = (&frame.report, &frame.stamp);
        let file = path.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned());
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
        FrameRow(cells.map(|cell| quoted(&cell)).join(","))
    }
}

/// A CSV cell (RFC 4180).
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_string()
    }
}

/// A `report.csv` on disk.
#[derive(Debug)]
pub struct ReportFile;

impl ReportFile {
    /// Appends a row, and the header first where the file is new or empty.
    ///
    /// # Errors
    /// [`ErrorKind::Io`](crate::ErrorKind::Io) names the path.
    pub fn append(path: &Path, row: &FrameRow) -> Result<()> {
        let failed = |e| io_error(path, "cannot write the report", e);
        let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(failed)?;
        let is_new = file.metadata().map_err(failed)?.len() == 0;
        let text = if is_new { format!("{HEADER}\n{}\n", row.0) } else { format!("{}\n", row.0) };
        file.write_all(text.as_bytes()).map_err(failed)
    }
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
