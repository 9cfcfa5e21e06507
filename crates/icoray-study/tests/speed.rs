//! `icoray-study speed` in a process of its own: it runs itself to count instructions, other builds beside itself, and its
//! peak memory is that of the frame.

use icoray_test_support::{Need, skip};
use std::process::Command;

/// What the program prints with these words; or else its errors.
fn speed(words: &str, more: &[&str]) -> Result<String, String> {
    let directory = tempfile::tempdir().unwrap();
    let mut study = Command::new(env!("CARGO_BIN_EXE_icoray-study"));
    study.arg("speed").args(words.split_whitespace()).args(more).arg("--out").arg(directory.path());
    let output = study.output().unwrap();
    let [printed, errors] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    if output.status.success() { Ok(printed) } else { Err(errors) }
}

#[test]
fn instructions_are_counted_or_reported_as_uncounted() {
    let words = "--sizes 2x5 --counted 2x5 --pixels 16 --frames 1 --threads 1 --transfers dense,walk --lights unlit \
                 --tolerance 1e-3";
    let printed = speed(words, &[]).unwrap();
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
    let words =
        "--sizes 2x5,1x3 --pixels 16 --frames 3 --threads 1,2 --transfers dense --tolerance 1e-3 --uncounted --against";
    let printed = speed(words, &[env!("CARGO_BIN_EXE_icoray-study")]).unwrap();
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
    let errors = speed(words, &["/bin/true"]).unwrap_err();
    assert!(errors.contains("/bin/true: rendered no frame on request"), "{errors}");
}

/// The numbers in a cell `measured (percent %; planned)`.
fn measured_and_planned(cell: &str) -> [f64; 2] {
    let (measured, rest) = cell.trim().split_once(" (").unwrap_or_else(|| panic!("{cell}"));
    let (_, planned) = rest.trim_end_matches(')').split_once("; ").unwrap_or_else(|| panic!("{cell}"));
    [measured, planned].map(|number| number.trim().parse().unwrap_or_else(|_| panic!("{cell}")))
}

/// Each light has a process of its own, as frames may reuse what earlier ones have freed.
#[test]
fn a_frame_takes_the_memory_of_its_plan() {
    let [unlit, lit] = ["unlit", "lit"].map(|light| {
        let words = "--sizes 8x26 --pixels 64 --frames 1 --uncounted --threads 2 --transfers lobes --tolerance 1e-3";
        let printed = speed(&format!("{words} --lights {light}"), &[]).unwrap();
        let row = printed.lines().find(|line| line.starts_with("| 8 | 655,362 |"));
        let row = row.unwrap_or_else(|| panic!("{printed}"));
        let [measured, planned] = measured_and_planned(row.trim_matches('|').rsplit('|').next().unwrap());
        // The buffers and threads of a picture take 2 bytes per cell that are not planned.
        assert!((planned - measured).abs() < 3.0f64.max(0.1 * measured), "{row}");
        measured
    });
    assert!(lit > unlit + 40.0, "gradients take memory: {lit} and {unlit}");
}
