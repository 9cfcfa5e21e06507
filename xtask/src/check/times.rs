//! Seconds that checks and test programs take: kept in `target/check-times.csv`, so that a slow one is seen.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use crate::error::Error;
use crate::workspace::Workspace;

/// The file, below the directory of all builds.
const FILE: &str = "check-times.csv";
/// The column names of the file.
const HEADER: &str = "what,seconds";
/// Number of entries that the summary lists.
const LISTED: usize = 12;

/// The seconds of this run's steps and test programs, and those of the last one that had the same.
#[derive(Debug, Default, PartialEq)]
pub struct Times {
    file: PathBuf,
    last: BTreeMap<String, f64>,
    now: Vec<(String, f64)>,
}

impl Times {
    /// Reads those of the last run. A file that is missing or has other lines is as an empty one.
    pub fn read(workspace: &Workspace) -> Self {
        let file = workspace.products("").join(FILE);
        let last = parsed(&fs::read_to_string(&file).unwrap_or_default());
        Self { file, last, now: Vec::new() }
    }

    /// Adds a step or program of this run.
    pub fn add(&mut self, what: &str, seconds: f64) {
        self.now.push((what.to_owned(), seconds));
    }

    /// Adds those of checks that ran beside others.
    pub fn join(&mut self, others: Times) {
        self.now.extend(others.now);
    }

    /// Writes the file: what has run now with its new seconds, what has not with its last ones.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self) -> Result<(), Error> {
        let mut all = self.last.clone();
        all.extend(self.now.iter().cloned());
        let mut text = format!("{HEADER}\n");
        for (what, seconds) in &all {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{what},{seconds:.1}");
        }
        fs::write(&self.file, text).map_err(Error::while_doing(self.file.display()))
    }

    /// A line for each of the longest of this run, with the seconds of the last run.
    pub fn lines(&self) -> Vec<String> {
        let mut longest: Vec<_> = self.now.iter().collect();
        longest.sort_by(|a, b| b.1.total_cmp(&a.1));
        let line = |(what, seconds): &(String, f64)| {
            let last = self.last.get(what).map_or(String::new(), |last| format!(" (last time {last:.1} s)"));
            format!("{seconds:7.1} s  {what}{last}")
        };
        longest.into_iter().take(LISTED).map(line).collect()
    }
}

fn parsed(text: &str) -> BTreeMap<String, f64> {
    let entry = |line: &str| {
        let (what, seconds) = line.rsplit_once(',')?;
        Some((what.to_owned(), seconds.parse().ok()?))
    };
    text.lines().skip(1).filter_map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_did_not_run_keeps_its_seconds() {
        let directory = std::env::temp_dir().join(format!("icoray-times-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        let last = parsed("what,seconds\nlints,80.0\nicoray suite,40.5\nlinks, of pages,0.1\nno number,x\n");
        let mut times = Times { file: directory.join(FILE), last, now: Vec::new() };
        times.add("formatting", 1.0);
        times.add("icoray suite", 30.0);
        times.write().unwrap();
        let written = fs::read_to_string(&times.file).unwrap();
        fs::remove_dir_all(directory).unwrap();
        let expected = "what,seconds\nformatting,1.0\nicoray suite,30.0\nlinks, of pages,0.1\nlints,80.0\n";
        assert_eq!(written, expected);
        assert_eq!(times.lines(), ["   30.0 s  icoray suite (last time 40.5 s)", "    1.0 s  formatting"]);
    }
}
