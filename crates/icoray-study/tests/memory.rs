//! The memory of a plan against the peak of a process that draws the frame.

use std::process::Command;

/// The numbers in a cell `measured (percent %; planned)`.
fn measured_and_planned(cell: &str) -> [f64; 2] {
    let (measured, rest) = cell.trim().split_once(" (").unwrap_or_else(|| panic!("{cell}"));
    let (_, planned) = rest.trim_end_matches(')').split_once("; ").unwrap_or_else(|| panic!("{cell}"));
    [measured, planned].map(|number| number.trim().parse().unwrap_or_else(|_| panic!("{cell}")))
}

#[test]
fn a_frame_takes_the_memory_of_its_plan() {
    let directory = tempfile::tempdir().unwrap();
    let mut study = Command::new(env!("CARGO_BIN_EXE_icoray-study"));
    study.args(["speed", "--sizes", "8x26", "--pixels", "64", "--frames", "1", "--uncounted", "--threads", "2"]);
    study.args(["--transfers", "lobes", "--tolerance", "1e-3"]);
    let output = study.arg("--out").arg(directory.path()).output().unwrap();
    let [printed, errors] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(output.status.success(), "{errors}");
    let row = printed.lines().find(|line| line.starts_with("| 8 | 655,362 |")).unwrap_or_else(|| panic!("{printed}"));
    let cells: Vec<&str> = row.trim_matches('|').split('|').collect();
    let [unlit, lit] = [cells[cells.len() - 2], cells[cells.len() - 1]].map(measured_and_planned);
    for [measured, planned] in [unlit, lit] {
        assert!((planned / measured - 1.0).abs() < 0.1, "{row}");
    }
    assert!(lit[0] > unlit[0] + 40.0, "gradients take memory: {row}");
}
