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

/// Frames of two builds, which are the same here, and of a program that is none.
#[test]
fn two_builds_render_frames_in_turn() {
    let run = |other: &str| {
        let mut study = Command::new(env!("CARGO_BIN_EXE_icoray-study"));
        study.args(["speed", "--sizes", "2x5,1x3", "--pixels", "16", "--frames", "3", "--threads", "1,2"]);
        study.args(["--transfers", "dense", "--tolerance", "1e-3", "--uncounted", "--against", other]);
        let output = study.output().unwrap();
        let [printed, errors] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.success(), printed, errors)
    };
    let (is_done, printed, errors) = run(env!("CARGO_BIN_EXE_icoray-study"));
    assert!(is_done, "{errors}");
    let rows: Vec<&str> = printed.lines().filter(|line| line.contains(" core")).skip(1).collect();
    assert_eq!(rows.len(), 2 * 2 * 2, "{printed}");
    assert!(rows[0].starts_with("| 2x5, 1 core | dense unlit 1e-3 | "), "{printed}");
    for row in rows {
        let cells: Vec<f64> =
            row.split(" | ").skip(2).map(|cell| cell.trim_end_matches(" |").parse().unwrap()).collect();
        let [other, this, ratio, pairs] = cells[..] else { panic!("{row}") };
        // Seconds are printed with four decimals, and may be small.
        let apart = 6e-5 * (1.0 + ratio) / this.max(1e-4) + 1e-3;
        assert!(other > 0.0 && (other / this - ratio).abs() < apart && pairs > 0.0, "{row}");
    }
    let (is_done, _, errors) = run("/bin/true");
    assert!(!is_done && errors.contains("/bin/true: rendered no frame on request"), "{errors}");
}
