//! Seconds that checks and test programs take: kept in `target/check-times.csv`, so that a slow one is seen.

use std::collections::BTreeMap;
use std::path::Path;

use csv::{Reader, Writer};

use crate::error::Error;

/// The file, below the directory of all builds.
pub const FILE: &str = "check-times.csv";
const LISTED: usize = 12;

/// Writes this run's seconds to the file, where what has not run keeps its last ones. Returns a line for each of the
/// longest of this run, with the seconds of the last one. A file that is missing or has other lines is as an empty one.
pub fn kept(file: &Path, mut now: Vec<(String, f64)>) -> Result<Vec<String>, Error> {
    let entries = Reader::from_path(file).into_iter().flat_map(Reader::into_deserialize);
    let last: BTreeMap<String, f64> = entries.flatten().collect();
    let mut all = last.clone();
    all.extend(now.iter().cloned());
    let write = || {
        let mut writer = Writer::from_path(file)?;
        writer.write_record(["what", "seconds"])?;
        all.iter().try_for_each(|(what, seconds)| writer.write_record([what, &format!("{seconds:.1}")]))?;
        Ok(writer.flush()?)
    };
    write().map_err(Error::while_doing::<csv::Error>(file.display()))?;
    now.sort_by(|a, b| b.1.total_cmp(&a.1));
    let line = |(what, seconds): (String, f64)| {
        let last = last.get(&what).map_or(String::new(), |last| format!(" (last time {last:.1} s)"));
        format!("{seconds:7.1} s  {what}{last}")
    };
    Ok(now.into_iter().take(LISTED).map(line).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_that_did_not_run_keep_their_seconds() {
        let sh = xshell::Shell::new().unwrap();
        let directory = sh.create_temp_dir().unwrap();
        let file = directory.path().join(FILE);
        sh.write_file(&file, "what,seconds\nlints,80.0\nicoray suite,40.5\n\"a, b\",0.1\nno number,x\n").unwrap();
        let lines = kept(&file, vec![("formatting".into(), 1.0), ("icoray suite".into(), 30.0)]).unwrap();
        assert_eq!(lines, ["   30.0 s  icoray suite (last time 40.5 s)", "    1.0 s  formatting"]);
        let expected = "what,seconds\n\"a, b\",0.1\nformatting,1.0\nicoray suite,30.0\nlints,80.0\n";
        assert_eq!(sh.read_file(file).unwrap(), expected);
    }
}
