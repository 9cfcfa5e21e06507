//! The Fortran model over ranks has the bits of one process, for any number of ranks and any partition.

use icoray_test_support::{Need, has_tool};
use icoray_tests::native::{command, library, mpi_library, root, succeeded, text};
use icoray_tests::pictures::{assert_same, pictures};
use icoray_tests::ranks::FIRST;
use std::path::{Path, PathBuf};
use std::process::Command;
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
    let log = text(output);
    let diagnostics = log.lines().filter_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        match *words.first()? {
            "height" | "mass" | "energy" | "enstrophy" => Some(line.to_owned()),
            "summary" => Some(words.into_iter().filter(|word| !word.contains("_s=")).collect::<Vec<_>>().join(" ")),
            first => (words.len() == 9 && first.parse::<f64>().is_ok()).then(|| words[..7].join(" ")),
        }
    });
    diagnostics.collect()
}

const SIZE: [&str; 6] = ["--level", "3", "--layers", "3", "--lloyd", "10"];

#[test]
fn the_model_is_the_same_on_any_number_of_ranks() {
    let has_compilers = || has_tool(Need::Fortran, "mpifort") && has_tool(Need::Fortran, "gfortran");
    if !FIRST.is_there() || !has_compilers() || !has_tool(Need::Make, "make") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    let (alone, together) = (build(false, directory), build(true, directory));
    // Every cell to a rank by a rule that leaves islands, one cell wide.
    let scattered: String = (0..642).map(|cell| format!("{}\n", (cell * cell / 7 + cell / 100) % 3)).collect();
    std::fs::write(directory.join("scattered"), scattered).unwrap();

    it_has_the_same_bits(&alone, &together, directory);
    it_draws_the_same_pictures(&alone, &together, directory);
    it_checks_itself(&together, directory);
    it_refuses_partitions_that_do_not_fit(&together, directory);
}

fn it_has_the_same_bits(alone: &Path, together: &Path, directory: &Path) {
    for case in [&["--case", "galewsky", "--tilt", "10"][..], &["--case", "williamson2"], &["--lead", "0"]] {
        let options = [&SIZE, case, &["--days", "0.75", "--no-pictures"]].concat();
        let expected = said(&succeeded(command(alone, directory).args(&options)).stdout);
        assert!(expected.len() > 5 && expected.last().unwrap().contains("fingerprint="), "{expected:#?}");
        for ranks in 1..=4 {
            let run = succeeded(FIRST.on_ranks(ranks, together, directory).args(&options));
            assert_eq!(said(&run.stdout), expected, "{case:?} on {ranks} ranks");
        }
        let run = succeeded(FIRST.on_ranks(3, together, directory).args(&options).args(["--partition", "scattered"]));
        assert_eq!(said(&run.stdout), expected, "{case:?}, scattered");
    }
}

/// Fragments are put together in floating point: to the last bit of a PNG.
fn it_draws_the_same_pictures(alone: &Path, together: &Path, directory: &Path) {
    let scene = std::fs::read_to_string(root().join("examples/scenes/shallow_water.toml")).unwrap();
    // What labels say of errors is no matter of pixels.
    let scene = scene.replace("560", "120").replace("[labels]", "[labels]\nerror = false");
    let scene = format!("tolerance = 1e-5\n{scene}");
    std::fs::write(directory.join("scene.toml"), scene).unwrap();
    let options = [&SIZE[..], &["--days", "0.25", "--scene", "scene.toml", "--threads", "1", "--out"]].concat();
    let drawn = |run: &mut Command, to: &str| {
        succeeded(run.args(&options).arg(to));
        pictures(&directory.join(to))
    };
    let expected = drawn(&mut command(alone, directory), "alone");
    assert_eq!(expected.len(), 2, "one at the start and one at the end");
    for (ranks, partition) in [(1, None), (2, None), (3, None), (4, None), (3, Some("scattered"))] {
        let mut run = FIRST.on_ranks(ranks, together, directory);
        if let Some(file) = partition {
            run.args(["--partition", file]);
        }
        let several = drawn(&mut run, &format!("{ranks}{}", partition.unwrap_or_default()));
        assert_same(&several, &expected, format!("{ranks} ranks, {partition:?}"));
    }
}

fn it_checks_itself(together: &Path, directory: &Path) {
    for ranks in [1, 3] {
        let run = succeeded(FIRST.on_ranks(ranks, together, directory).args(["--self-test", "--level", "3"]));
        let log = text(&run.stdout);
        assert!(log.ends_with("self-test passed\n") && log.lines().count() > 30, "{log}");
    }
}

fn it_refuses_partitions_that_do_not_fit(together: &Path, directory: &Path) {
    for (partition, ranks) in [("scattered", 2), ("scattered", 4), ("nowhere", 2)] {
        let mut run = FIRST.on_ranks(ranks, together, directory);
        let output = run.args(SIZE).args(["--no-pictures", "--partition", partition]).output().unwrap();
        let log = text(&output.stderr);
        assert!(!output.status.success(), "{partition} on {ranks} ranks");
        assert_eq!(log.matches(&format!("shallow_water: {partition}: ")).count(), 1, "{log}");
    }
}
