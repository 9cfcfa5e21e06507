//! The C model over ranks: each computes the whole model, and together they draw the pictures of one process.

use icoray_tests::native::{command, library, mpi_library, root, succeeded, text};
use icoray_tests::pictures::files;
use icoray_tests::programs::Program;
use icoray_tests::ranks::FIRST;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The model, compiled as the head of `tracer.c` says.
fn compiled(compiler: &str, library: &Path, options: &[&str]) -> PathBuf {
    let sources = ["tracer", "mesh", "options", "ranks", "transport", "winds"];
    let sources = sources.map(|source| format!("../../examples/c/{source}"));
    let options = &[&["-std=c99", "-O2", "-Wmissing-field-initializers"], options].concat();
    Program { library, compiler, options, sources: &sources.each_ref().map(String::as_str) }.path()
}

const SIZE: [&str; 8] = ["--level", "3", "--layers", "6", "--days", "1", "--threads", "1"];

/// The pictures that a run leaves in `to`.
fn drawn(run: &mut Command, scene: &Path, to: &Path) -> BTreeMap<String, Vec<u8>> {
    std::fs::create_dir(to).unwrap();
    let output = succeeded(run.args(SIZE).arg("--scene").arg(scene).arg("--out").arg(to));
    let log = text(&output.stdout);
    assert_eq!(log.matches("summary ").count(), 1, "only rank 0 speaks:\n{log}");
    files(to)
}

#[test]
fn the_model_draws_the_same_bytes_on_any_number_of_ranks() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let one = compiled("cc", &library(), &[]);
    let ranks = compiled("mpicc", &mpi_library(), &["-DTRACER_MPI"]);
    let scene = std::fs::read_to_string(root().join("examples/scenes/tracer.toml")).unwrap();
    let path = directory.join("scene.toml");
    std::fs::write(&path, scene.replace("640", "160")).unwrap();

    let expected = drawn(&mut command(one, directory), &path, &directory.join("alone"));
    assert_eq!(expected.len(), 3, "each half day");
    for n in [1, 2, 3] {
        let mut run = FIRST.on_ranks(n, &ranks, directory);
        let several = drawn(&mut run, &path, &directory.join(n.to_string()));
        assert!(several == expected, "{n} ranks draw other pictures");
    }

    // What is wrong is said once, and the simulation goes on without pictures.
    let output = FIRST.on_ranks(2, &ranks, directory).args(SIZE).args(["--scene", "nowhere"]).output().unwrap();
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    assert!(!output.status.success());
    assert_eq!(stderr.matches("tracer: icoray_scene_load: ").count(), 1, "{stderr}");
    assert!(stdout.contains(" frames=0 ") && stdout.contains(" pictures_failed=3"), "{stdout}");
}
