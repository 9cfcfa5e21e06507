//! The Fortran model over ranks: it has the bits of one process, on however many ranks and however its cells are dealt.

use icoray_tests::native::{command, is_there, library, mpi_library, root, succeeded, text};
use icoray_tests::ranks::FIRST;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Builds the model in `directory`, as its Makefile does it against a source tree.
fn build(with_mpi: bool, directory: &Path) -> PathBuf {
    let (library, options) = if with_mpi { (mpi_library(), "MPI=1") } else { (library(), "MPI=") };
    let folder = library.parent().unwrap();
    let to = directory.join(options);
    let mut make = command("make", &root().join("examples/fortran/shallow_water"));
    make.args([options, "OPT=-O2"]).arg(format!("BUILD={}", to.display()));
    make.arg(format!("ICORAY_SOURCE={}", root().join("include/icoray.f90").display()));
    make.arg(format!("ICORAY_LIB={} -Wl,-rpath,{}", library.display(), folder.display()));
    succeeded(make.env_remove("MAKEFLAGS"));
    to.join("shallow_water")
}

/// What a run says but for seconds and ranks: a line per day, its last with the fingerprint of all bits of the state.
fn said(output: &[u8]) -> Vec<String> {
    let told = text(output);
    let diagnostics = told.lines().filter_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        match *words.first()? {
            "height" | "mass" | "energy" | "enstrophy" => Some(line.to_owned()),
            "summary" => {
                Some(words.into_iter().filter(|word| !word.contains("_s=")).collect::<Vec<_>>().join(" "))
            }
            first => (words.len() == 9 && first.parse::<f64>().is_ok()).then(|| words[..7].join(" ")),
        }
    });
    diagnostics.collect()
}

#[test]
fn the_model_has_the_same_bits_on_any_number_of_ranks() {
    if !FIRST.is_there() || !is_there("mpifort") || !is_there("gfortran") || !is_there("make") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    let (alone, together) = (build(false, directory), build(true, directory));

    // Every cell to a rank by a rule that leaves islands, one cell wide.
    let scattered: String =
        (0..642).map(|cell| format!("{}\n", (cell * cell / 7 + cell / 100) % 3)).collect();
    std::fs::write(directory.join("scattered"), scattered).unwrap();

    let size = ["--level", "3", "--layers", "3", "--lloyd", "10", "--days", "0.75", "--no-pictures"];
    for case in [&["--case", "galewsky", "--tilt", "10"][..], &["--case", "williamson2"], &["--lead", "0"]] {
        let expected = said(&succeeded(command(&alone, directory).args(size).args(case)).stdout);
        assert!(expected.len() > 5 && expected.last().unwrap().contains("fingerprint="), "{expected:#?}");
        for ranks in 1..=4 {
            let run = succeeded(FIRST.on_ranks(ranks, &together, directory).args(size).args(case));
            assert_eq!(said(&run.stdout), expected, "{case:?} on {ranks} ranks");
        }
        let dealt = ["--partition", "scattered"];
        let run = succeeded(FIRST.on_ranks(3, &together, directory).args(size).args(case).args(dealt));
        assert_eq!(said(&run.stdout), expected, "{case:?}, scattered");
    }

    for ranks in [1, 3] {
        let run =
            succeeded(FIRST.on_ranks(ranks, &together, directory).args(["--self-test", "--level", "3"]));
        let told = text(&run.stdout);
        assert!(told.ends_with("self-test passed\n") && told.lines().count() > 30, "{told}");
    }
    for (partition, ranks) in [("scattered", 2), ("scattered", 4), ("nowhere", 2)] {
        let mut run = FIRST.on_ranks(ranks, &together, directory);
        let output = run.args(size).args(["--partition", partition]).output().unwrap();
        let told = text(&output.stderr);
        assert!(!output.status.success(), "{partition} on {ranks} ranks");
        assert_eq!(told.matches(&format!("shallow_water: {partition}: ")).count(), 1, "{told}");
    }
}
