//! The recipes of the book draw the pictures of plain arrays.

use icoray_test_support::{Need, has_tool, skip_because};
use icoray_tests::native::{
    ALLOCATES, command, compile, compile_c, fortran, library, linked, log_of, new_directory, root, succeeded,
};
use icoray_tests::pictures::{count_colors, pictures};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

fn of_recipe(name: &str, option: &str) -> PathBuf {
    compile("cc", &["-std=c99", option], &[&format!("../../examples/recipes/{name}")])
}

fn of_fortran(directory: &Path, name: &str) -> PathBuf {
    let to = directory.join(name);
    let mut gfortran = fortran("gfortran", directory, &[&["-O1"], &ALLOCATES[..]].concat());
    gfortran.arg(root().join("examples/recipes").join(name).with_extension("f90"));
    succeeded(gfortran.args(linked(library())).arg("-o").arg(&to));
    to
}

/// The pictures of a run in a directory of its own, and what it printed.
fn drawn(
    directory: &Path,
    run: &str,
    program: &Path,
    head: &str,
    change: impl FnOnce(&mut Command),
) -> (Vec<image::RgbaImage>, String) {
    let run = new_directory(directory, &format!("run {run}"));
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
    let program = compile_c(&["recipes/plain"]);
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
        let program = of_recipe(name, option);
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
    let program = of_recipe("openacc", "-fopenacc");
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
