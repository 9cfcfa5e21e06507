//! The recipes of the book draw the pictures of plain arrays.

use icoray_test_support::{Need, has_tool, skip_because};
use icoray_tests::native::{command, library, linked, log_of, root, succeeded};
use icoray_tests::pictures::{count_colors, pictures};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const WARNINGS: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-missing-field-initializers", "-O1"];

/// Links icoray's library.
fn with_icoray(command: &mut Command, to: &Path) -> PathBuf {
    succeeded(command.args(linked(library())).args(["-lm", "-o"]).arg(to));
    to.to_owned()
}

fn of_c(directory: &Path, source: &str, options: &[&str]) -> PathBuf {
    let include = format!("-I{}", root().join("include").display());
    let mut cc = command("cc", directory);
    cc.args(WARNINGS).args(options).arg(include).arg(root().join(source).with_extension("c"));
    with_icoray(&mut cc, &directory.join(Path::new(source).file_name().unwrap()))
}

fn of_fortran(directory: &Path, name: &str) -> PathBuf {
    let mut gfortran = command("gfortran", directory);
    // gfortran 12 warns of every array that an assignment allocates.
    let options = "-std=f2018 -Wall -Wextra -Werror -Wno-uninitialized -Wno-maybe-uninitialized -O1";
    gfortran.args(options.split(' '));
    let recipe = root().join("examples/recipes").join(name).with_extension("f90");
    with_icoray(gfortran.arg(root().join("include/icoray.f90")).arg(recipe), &directory.join(name))
}

/// The pictures of a run in a directory of its own, and what it printed.
fn drawn(
    directory: &Path,
    run: &str,
    program: &Path,
    head: &str,
    change: impl FnOnce(&mut Command),
) -> (Vec<image::RgbaImage>, String) {
    let run = directory.join(format!("run {run}"));
    std::fs::create_dir(&run).unwrap();
    let scene = std::fs::read_to_string(root().join("examples/recipes/scene.toml")).unwrap();
    std::fs::write(run.join("scene.toml"), format!("{head}{scene}")).unwrap();
    let mut command = command(program, &run);
    change(&mut command);
    let log = log_of(&mut command);
    assert!(!log.contains("icoray:"), "{log}");
    (pictures(&run.join("pictures")).into_values().collect(), log)
}

/// What plain arrays show, in so many steps.
fn plain(directory: &Path, steps: usize) -> Vec<image::RgbaImage> {
    let program = of_c(directory, "tests/c/recipes/plain", &[]);
    let (pictures, _) = drawn(directory, "plain", &program, "", |command| {
        command.arg(steps.to_string());
    });
    let colors = count_colors(&pictures[0]);
    assert!(colors > 500 && pictures[0] != pictures[1], "{colors} colours");
    pictures
}

#[test]
fn hosts_with_openmp_and_openacc() {
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    let expected = plain(directory, 4);
    let trial = directory.join("trial.c");
    std::fs::write(&trial, "#include <omp.h>\nint main(void) { return omp_get_max_threads() < 1; }\n").unwrap();
    for (option, name) in [("-fopenmp", "openmp"), ("-fopenacc", "openacc")] {
        let to = directory.join("trial");
        let is_there = command("cc", directory).args([option, "-fopenmp", "-o"]).arg(&to).arg(&trial).output();
        if !is_there.is_ok_and(|output| output.status.success()) {
            return skip_because(Need::Fortran, format!("no {option} in the C compiler, which GNU's have"));
        }
        let program = of_c(directory, &format!("examples/recipes/{name}"), &[option]);
        for bind in ["false", "true"] {
            let (pictures, log) = drawn(directory, &format!("{name} {bind}"), &program, "", |command| {
                command.env("OMP_PROC_BIND", bind).env("OMP_NUM_THREADS", "2").env("ACC_DEVICE_TYPE", "host");
            });
            let count = if name == "openmp" { 2 } else { 4 };
            assert!(pictures[..] == expected[..count], "{name}, bound: {bind}");
            assert!(name == "openmp" || log.contains("4 updates of the host"), "{log}");
        }
    }
    // A field is copied from the device where a picture reads it only.
    let program = directory.join("openacc");
    let (pictures, log) = drawn(directory, "every second", &program, "every = 2\n", |_| {});
    assert!(pictures.len() == 2 && log.contains("2 updates of the host"), "{log}");
}

#[test]
fn arrays_of_nicam() {
    if !has_tool(Need::Fortran, "gfortran") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    let expected = plain(directory, 2);
    let program = of_fortran(directory, "nicam");
    let (pictures, log) = drawn(directory, "nicam", &program, "", |_| {});
    assert!(pictures == expected);
    assert!(log.contains("bytes copied: 0"), "{log}");
}
