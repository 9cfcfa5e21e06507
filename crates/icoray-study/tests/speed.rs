//! `icoray-study speed` runs itself to count instructions.

use icoray_test_support::{Need, skip};
use std::process::Command;

#[test]
fn instructions_are_counted_or_reported_as_uncounted() {
    let directory = tempfile::tempdir().unwrap();
    let mut study = Command::new(env!("CARGO_BIN_EXE_icoray-study"));
    study.args(["speed", "--sizes", "2x5", "--counted", "2x5", "--pixels", "16", "--frames", "1"]);
    study.args(["--threads", "1", "--transfers", "dense,walk", "--lights", "unlit", "--tolerance", "1e-3"]);
    let output = study.arg("--out").arg(directory.path()).output().unwrap();
    let [printed, errors] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(output.status.success(), "{errors}");
    if printed.contains("instructions are not counted: neither") {
        return skip(Need::Counters);
    }
    let row = printed.lines().find_map(|line| line.strip_prefix("| unlit: instructions per frustum that is read | "));
    let row = row.unwrap_or_else(|| panic!("{printed}"));
    let counts: Vec<f64> = row.trim_end_matches(" |").split(" | ").map(|cell| cell.parse().unwrap()).collect();
    let [dense, walk] = counts[..] else { panic!("{row}") };
    // A few for each number that a frustum has.
    assert!(walk > 20.0 && dense > 1.2 * walk && dense < 1e5, "{row}");
}
