//! The tests of the studies, in one program.

#[cfg(feature = "gpu")]
mod gpu;
mod studies;

use clap::Parser;
use icoray_study::CommandLine;
use std::collections::HashMap;
use std::path::Path;

/// Runs a study; returns what it printed.
fn study<'w>(words: impl Iterator<Item = &'w str>) -> icoray::Result<String> {
    let mut out = Vec::new();
    CommandLine::try_parse_from(["study"].into_iter().chain(words)).unwrap().study.run(&mut out)?;
    Ok(String::from_utf8(out).unwrap())
}

/// The rows of a CSV file by their columns.
fn rows(path: &Path) -> Vec<HashMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}
