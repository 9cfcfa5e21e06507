//! Files as a model writes them: record by record, and in pieces.

use crate::made::{Made, MadeVariable, RECORDS, Values};
use crate::run::Folder;
use icoray_test_support::PATIENCE;
use netcdf::{FileMut, Options};
use std::fs;
use std::ops::Range;
use std::path::Path;
use std::time::{Duration, Instant};

/// Some of the records of a file.
pub fn records(made: &Made, range: Range<usize>) -> Made {
    let mut made = made.clone();
    for variable in made.variables.iter_mut().filter(|variable| variable.dimensions[0] == "Time") {
        variable.values = part(&variable.values, &range);
    }
    made
}

fn part(values: &Values, range: &Range<usize>) -> Values {
    fn of<T: Clone>(values: &[T], range: &Range<usize>) -> Vec<T> {
        let each = values.len() / RECORDS;
        values[range.start * each..range.end * each].to_vec()
    }
    match values {
        Values::F32(values) => Values::F32(of(values, range)),
        Values::F64(values) => Values::F64(of(values, range)),
        Values::I32(values) => Values::I32(of(values, range)),
        Values::Text(values) => Values::Text(of(values, range)),
    }
}

/// A file of one later time, whose picture shows that all files before were looked at.
pub fn mark(folder: &Folder, day: u32) {
    let mut made = records(&Made::history(), 0..1);
    let Values::Text(text) = &mut made.variable("xtime").values else { panic!("xtime is text") };
    *text = format!("{:<64}", format!("2014-01-{day:02}_00:00:00")).into_bytes();
    let unseen = folder.at(".mark.nc");
    made.write_to(&unseen, Options::_64BIT_OFFSET);
    fs::rename(unseen, folder.at(format!("run/mark{day}.nc"))).unwrap();
}

impl Made {
    /// Begins a file as a model does.
    pub fn declare(&self, path: &Path, options: Options) -> FileMut {
        let mut declared = self.clone();
        declared.variables.iter_mut().for_each(|variable| variable.values = part(&variable.values, &(0..0)));
        declared.write_to(path, options);
        append(path)
    }

    /// Writes what does not change.
    pub fn put_fixed(&self, file: &mut FileMut) {
        for variable in self.variables.iter().filter(|variable| variable.dimensions[0] != "Time") {
            variable.put(file, 0);
        }
    }

    pub fn put_record(&self, file: &mut FileMut, record: usize) {
        for variable in self.variables.iter().filter(|variable| variable.dimensions[0] == "Time") {
            let values = part(&variable.values, &(record..record + 1));
            MadeVariable { values, ..variable.clone() }.put(file, record);
        }
    }
}

/// Opens a file to go on writing it. A command that another test starts may have inherited its lock for a moment.
pub fn append(path: &Path) -> FileMut {
    let start = Instant::now();
    loop {
        match netcdf::append(path) {
            Ok(file) => return file,
            Err(error) => assert!(start.elapsed() < PATIENCE, "{error}"),
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}
