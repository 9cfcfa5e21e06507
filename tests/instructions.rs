//! Instructions per frustum of the release profile: counts, unlike seconds, do not depend on the machine.

use icoray_test_support::{Need, has_tool, runs_long};
use icoray_tests::native::root;
use std::path::PathBuf;
use std::process::Command;

/// Instructions per frustum read that were reached on the instruction set that valgrind has (AVX2), in whole frames of
/// 192 x 192 pixels of 2,562 cells with 31 layers at tolerance 1e-3, by transfer function, light and heights. Of native
/// heights a lit frame has its gradients and normals in it.
const REACHED: [(&str, &str, &str, f64); 7] = [
    ("walk", "unlit", "mean", 180.0),
    ("dense", "unlit", "mean", 318.0),
    ("thin", "unlit", "mean", 1250.0),
    ("dense", "lit", "mean", 776.0),
    ("thin", "lit", "mean", 1759.0),
    ("dense", "unlit", "native", 453.0),
    ("dense", "lit", "native", 1180.0),
];

/// Largest difference from what was reached, in parts of it. Frames that need fewer are to be written down above.
const TOLERANCE: f64 = 0.1;

/// `icoray-study` of the release profile without GPU.
fn study() -> PathBuf {
    let arguments = ["build", "--quiet", "--release", "--package", "icoray-study", "--no-default-features"];
    let status = Command::new(env!("CARGO")).args(arguments).current_dir(root()).status().unwrap();
    assert!(status.success(), "{status}");
    root().join("target/release/icoray-study")
}

/// Instructions of the whole program and frusta of this many frames.
fn count(program: &PathBuf, [transfer, light, heights]: [&str; 3], frames: &str) -> (f64, f64) {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(program);
    command.args(["speed", "--bare", "--pixels", "192", "--threads", "1", "--sizes", "4x31", "--transfers", transfer]);
    command.args(["--lights", light, "--tolerance", "1e-3", "--method", "exact", "--precision", "f32"]);
    let output = command.args(["--heights", heights, "--frames", frames]).output().unwrap();
    let [out, log] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{log}");
    let collected = log.lines().find_map(|line| line.split_once("Collected : ")?.1.trim().parse().ok());
    let frusta = out.lines().find_map(|line| line.strip_prefix("frusta ")?.parse().ok());
    (collected.unwrap_or_else(|| panic!("{log}")), frusta.unwrap_or(0.0))
}

#[test]
fn instructions_per_frustum_are_those_that_were_reached() {
    if !runs_long() || !has_tool(Need::Valgrind, "valgrind") {
        return;
    }
    let program = study();
    let without = ["mean", "native"].map(|heights| count(&program, ["walk", "unlit", heights], "0").0);
    let mut off = Vec::new();
    for (transfer, light, heights, reached) in REACHED {
        let (whole, frusta) = count(&program, [transfer, light, heights], "1");
        let per_frustum = (whole - without[usize::from(heights == "native")]) / frusta;
        println!("{transfer}, {light}, {heights} heights: {per_frustum:.0} instructions per frustum");
        if (per_frustum / reached - 1.0).abs() > TOLERANCE {
            off.push(format!("{transfer}, {light}, {heights} heights: {per_frustum:.0} instead of {reached}"));
        }
    }
    assert!(off.is_empty(), "{}", off.join("; "));
}
