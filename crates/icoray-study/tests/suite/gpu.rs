//! `icoray-study gpu` on a small grid, on any adapter.

use crate::{rows, study};
use icoray::ErrorKind;
use icoray_test_support::{Need, skip_because};

fn run(words: &str) -> icoray::Result<String> {
    study(["gpu"].into_iter().chain(words.split(' ')))
}

#[test]
fn pictures_of_all_settings_are_drawn_on_both() {
    let directory = tempfile::tempdir().unwrap();
    let small = "--level 3 --layers 4 --size 24x20,17x9 --frames 1 --threads 1 --out";
    let printed = match run(&format!("{small} {}", directory.path().display())) {
        Err(e) if e.context().contains("no Vulkan adapter") => return skip_because(Need::Gpu, e),
        printed => printed.unwrap(),
    };
    let rows = rows(&directory.path().join("gpu.csv"));
    assert_eq!(rows.len(), 2 * 2 * 2 * 4);
    for row in &rows {
        let number = |key: &str| row[key].parse::<f64>().unwrap_or_else(|e| panic!("{key} of {row:?}: {e}"));
        assert!(number("device_ms") > 0.0 && number("device_ms") <= number("end_to_end_ms"), "{row:?}");
        // The CPU halves dense pieces where the GPU takes panels: they differ by a fraction of the tolerance.
        let tolerance = number("tolerance");
        assert!(number("rmse_to_cpu") <= 0.03 * tolerance && number("max_to_cpu") <= 0.4 * tolerance, "{row:?}");
        let rate = number("frusta") / number("device_ms") * 1e3;
        assert!((number("frusta_per_s") / rate - 1.0).abs() < 1e-3, "{row:?}");
        let per_frustum = if row["light"] == "lit" { 48.0 } else { 12.0 };
        assert!(number("bytes_read") > per_frustum * number("frusta"), "{row:?}");
        assert!(number("cpu_ms") > 0.0 && number("flops") > 0.0 && number("bytes_uploaded") > 642.0 * 16.0);
    }
    let tables = std::fs::read_to_string(directory.path().join("gpu.md")).unwrap();
    assert!(printed.contains(&tables), "{printed}");
    for cell in ["| 24 × 20 | unlit | 1e-3 |", "| 17 × 9 | lit | 1e-2 |", "| 494 | 783 | 755 | 689 |"] {
        assert!(tables.contains(cell), "{cell} is not in {tables}");
    }
}

#[test]
fn a_device_that_is_not_there_is_an_error() {
    let error = run("--quick --device nowhere --out /nowhere").unwrap_err();
    assert!(error.kind() == ErrorKind::Unsupported && error.context().contains("no "), "{error}");
}
