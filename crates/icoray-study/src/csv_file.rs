//! A table of results as a CSV file.

use crate::io_error;
use icoray::Result;
use std::fs::File;
use std::path::PathBuf;

/// A CSV file that has each row as soon as it is written.
pub(crate) struct CsvFile {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl CsvFile {
    /// Makes the file with its head.
    pub fn create(path: PathBuf, columns: &[&str]) -> Result<Self> {
        let writer = csv::Writer::from_path(&path).map_err(|e| io_error(&path, e))?;
        let mut file = CsvFile { path, writer };
        file.row(columns)?;
        Ok(file)
    }

    /// Adds a row; it must have as many cells as the head.
    pub fn row(&mut self, cells: &[impl AsRef<[u8]>]) -> Result<()> {
        self.writer.write_record(cells).map_err(|e| io_error(&self.path, e))?;
        self.writer.flush().map_err(|e| io_error(&self.path, e))
    }
}
