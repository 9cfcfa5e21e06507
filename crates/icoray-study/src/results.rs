//! The output of studies: lines, directories, files, CSV tables, and tables inside a README.

use icoray::{Error, ErrorKind, Fields, Frame, Grid, Layers, Renderer, Result, Scene};
use icoray_progress::Bar;
use icoray_reference::comparison::median;
use std::fmt::{Arguments, Display};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A bar is cleared where it is dropped.
pub(crate) use icoray_progress::steps as progress;

/// Prints a formatted line and flushes it, so that the progress of a long study is visible.
macro_rules! say {
    ($out:expr, $($text:tt)*) => { $crate::results::print_line($out, format_args!($($text)*)) };
}
pub(crate) use say;

pub(crate) fn print_line(out: &mut dyn Write, line: Arguments) -> Result<()> {
    let written = writeln!(out, "{line}").and_then(|()| out.flush());
    written.map_err(|e| Error::new(ErrorKind::Io, format!("standard output: {e}")))
}

pub(crate) fn io_error(path: &Path, e: impl Display) -> Error {
    Error::new(ErrorKind::Io, format!("{}: {e}", path.display()))
}

/// Creates a directory for results, with its parents.
pub(crate) fn make_directory(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| io_error(path, e))
}

pub(crate) fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|e| io_error(path, e))
}

/// Writes a file, replacing an older one.
pub(crate) fn write_file(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    std::fs::write(path, content).map_err(|e| io_error(path, e))
}

/// Renders a frame; returns its seconds from end to end, too.
pub(crate) fn timed<'f>(
    renderer: &Renderer,
    scene: &Scene,
    grid: &Grid,
    layers: &Layers,
    fields: impl Into<Fields<'f>>,
) -> Result<(f64, Frame)> {
    let start = Instant::now();
    let frame = renderer.render(scene, grid, layers, fields)?;
    Ok((start.elapsed().as_secs_f64(), frame))
}

/// Draws frames of two kinds in turn, so that noise of the machine affects both; `draw` returns the seconds of one.
/// Returns the least seconds of both, and the median of the ratios of a frame of the first to the next of the second.
pub(crate) fn in_turn(pairs: usize, mut draw: impl FnMut(usize) -> Result<f64>) -> Result<[f64; 3]> {
    let (mut least, mut ratios) = ([f64::INFINITY; 2], Vec::new());
    for _ in 0..pairs.max(1) {
        let pair = [draw(0)?, draw(1)?];
        ratios.push(pair[0] / pair[1]);
        least = [least[0].min(pair[0]), least[1].min(pair[1])];
    }
    Ok([least[0], least[1], median(ratios)])
}

/// A number of threads in words.
pub(crate) fn threads(count: usize) -> String {
    if count == 1 { "one thread".to_owned() } else { format!("{count} threads") }
}

pub(crate) fn number(value: f64) -> String {
    format!("{value:.6e}")
}

/// A number with three significant digits, and at least all before the point.
pub(crate) fn three_digits(value: f64) -> String {
    let digits = usize::from(value < 9.995) + usize::from(value < 99.95);
    format!("{value:.digits$}")
}

/// A table as a CSV file, flushed after every row, some columns of which are printed.
pub(crate) struct Table {
    path: PathBuf,
    writer: csv::Writer<File>,
    columns: Vec<&'static str>,
}

impl Table {
    /// Creates the file, in a directory that is made if it does not exist, with its header; `columns` are names with
    /// commas between, and `-` before those that are not printed.
    pub fn create(path: PathBuf, columns: &'static str) -> Result<Self> {
        path.parent().map_or(Ok(()), make_directory)?;
        let writer = csv::Writer::from_path(&path).map_err(|e| io_error(&path, e))?;
        let mut table = Table { path, writer, columns: columns.split(',').collect() };
        let names: Vec<String> = table.columns.iter().map(|name| name.replace('-', "")).collect();
        table.row(&names).map(|_| table)
    }

    pub fn heading(&self) -> String {
        self.line(&self.columns)
    }

    /// Appends a row; returns its printed line.
    pub fn row(&mut self, cells: &[String]) -> Result<String> {
        self.writer.write_record(cells).map_err(|e| io_error(&self.path, e))?;
        self.writer.flush().map_err(|e| io_error(&self.path, e))?;
        Ok(self.line(cells))
    }

    /// Appends a row, prints it, and advances the progress.
    pub fn print(&mut self, cells: &[String], bar: &Bar, out: &mut dyn Write) -> Result<()> {
        let line = self.row(cells)?;
        bar.suspend(|| say!(out, "{line}"))?;
        bar.inc(1);
        Ok(())
    }

    fn line(&self, cells: &[impl AsRef<str>]) -> String {
        let cells = self.columns.iter().zip(cells).filter(|(name, _)| !name.starts_with('-'));
        cells.map(|(name, cell)| format!("{:>1$}", cell.as_ref(), name.len().max(12))).collect::<Vec<_>>().join(" ")
    }
}

const END: &str = "<!-- end -->\n";

/// Replaces the text of a file, if there is one, between the lines `<!-- icoray-study NAME -->` and `<!-- end -->`.
///
/// # Errors
/// [`ErrorKind::Io`] where the file cannot be read or written; [`ErrorKind::Argument`] where it lacks the lines.
pub(crate) fn replace_section(path: Option<&Path>, study: &str, text: &str) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let (old, begin) = (read_text(path)?, format!("<!-- icoray-study {study} -->\n"));
    let section = || {
        let (before, rest) = old.split_once(&begin)?;
        Some((before, rest.split_once(END)?.1))
    };
    let (before, after) = section().ok_or_else(|| {
        let context = format!("{}: expected a line {begin}and behind it {END}", path.display());
        Error::new(ErrorKind::Argument, context.replace('\n', " "))
    })?;
    write_file(path, format!("{before}{begin}{text}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_for_a_file_without_the_section_names_the_expected_lines() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("README.md");
        for text in ["nothing", "<!-- end -->\n<!-- icoray-study speed -->\n"] {
            std::fs::write(&path, text).unwrap();
            let error = replace_section(Some(&path), "speed", "").unwrap_err().to_string();
            assert!(
                error.contains("expected a line <!-- icoray-study speed --> and behind it <!-- end -->"),
                "{error}"
            );
        }
    }
}
