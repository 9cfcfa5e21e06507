//! Several ranks under mpirun: C and Fortran programs against the library that was built with MPI.

use icoray_tests::native::{
    checked, command, compile_with, is_there, library, mpi_library, root, succeeded, text,
};
use icoray_tests::ranks::{has_mpi, on_ranks};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A program of `tests/c` with what the others share, compiled against `library`.
fn compile(library: &Path, name: &str, directory: &Path) -> PathBuf {
    let sources = [name, "mpi_common", "host_common", "check"];
    compile_with(library, "mpicc", &["-std=c99", "-Wno-long-long"], &sources, directory)
}

/// The files of a directory but its report, whose lines have seconds.
fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let named = entries.map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), path));
    let kept = named.filter(|(name, _)| name != "report.csv");
    kept.map(|(name, path)| (name, std::fs::read(path).unwrap())).collect()
}

#[test]
fn pictures_of_several_ranks_are_those_of_one_to_the_byte() {
    if !has_mpi() {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = compile(mpi_library(), "mpi_pictures", directory.path());
    let at = |name: &str| directory.path().join(name);
    let alone =
        checked(command(&program, directory.path()).arg(at("one")).arg("serial"), "mpi_pictures", 150);
    let one = files(&at("one"));
    assert_eq!(one.len(), 6 * 3 + 2 * 3, "{:?}", one.keys());
    for ranks in [1, 2, 3, 4, 8] {
        let to = at(&ranks.to_string());
        let notes = checked(on_ranks(ranks, &program, directory.path()).arg(&to), "mpi_pictures", 150);
        // Where time is short all leave out as many pixels as may be, unless the machine was too fast for that.
        let is_coarsest = |note: &String| !note.contains("short: ") || note.contains("one of 32 ");
        let is_same = alone.iter().chain(&notes).all(is_coarsest);
        let is_left_out = |name: &str| name.starts_with("short") && !is_same;
        let several = files(&to);
        assert_eq!(several.keys().collect::<Vec<_>>(), one.keys().collect::<Vec<_>>());
        for (name, bytes) in &one {
            assert!(
                is_left_out(name) || several[name] == *bytes,
                "{name} of {ranks} ranks is another picture"
            );
        }
    }
}

#[test]
fn what_fails_on_one_rank_fails_on_all() {
    if !has_mpi() {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = compile(mpi_library(), "mpi_refusals", directory.path());
    for ranks in [2, 3, 4] {
        let to = directory.path().join(ranks.to_string());
        std::fs::create_dir(&to).unwrap();
        checked(on_ranks(ranks, &program, directory.path()).arg(&to), "mpi_refusals", 250);
        assert!(to.join("half_0/frame_1.png").is_file() && to.join("half_1/frame_2.png").is_file());
    }
}

#[test]
fn before_mpi_and_after_it_there_are_answers() {
    if !has_mpi() {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = compile(mpi_library(), "mpi_ends", directory.path());
    for ranks in [1, 2] {
        let to = directory.path().join(ranks.to_string());
        checked(on_ranks(ranks, &program, directory.path()).arg(&to), "mpi_ends", 15);
        assert!(to.join("frame_0.png").is_file());
    }
    let program = compile(library(), "mpi_ends", directory.path());
    checked(on_ranks(1, &program, directory.path()).arg(directory.path()).arg("without"), "mpi_ends", 3);
}

/// With `mpi_f08` and with the integers of `mpi`: the world's ranks, and a part of them.
#[test]
fn fortran_hands_its_communicators_over() {
    if !has_mpi() || !is_there("mpifort") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = directory.path().join("mpi_model");
    let mut rpath = std::ffi::OsString::from("-Wl,-rpath,");
    rpath.push(mpi_library().parent().unwrap());
    let mut compile = command("mpifort", directory.path());
    compile.args(["-std=f2018", "-Wall", "-Wextra", "-Werror", "-J"]).arg(directory.path());
    compile.arg(root().join("include/icoray.f90")).arg(root().join("tests/fortran/mpi_model.f90"));
    succeeded(compile.arg(mpi_library()).arg(rpath).arg("-o").arg(&program));
    for ranks in [1, 3] {
        let to = directory.path().join(ranks.to_string());
        let output = succeeded(on_ranks(ranks, &program, directory.path()).arg(&to));
        assert_eq!(
            text(&output.stdout),
            format!("mpi_model: all well on {ranks}\n"),
            "{}",
            text(&output.stderr)
        );
        for name in ["world/f_1.png", "integer/f_1.png", "part/f_1.png"] {
            assert!(to.join(name).is_file(), "{name}");
        }
        let picture = |name: &str| std::fs::read(to.join(name)).unwrap();
        assert!(picture("world/f_1.png") == picture("part/f_1.png"));
        assert!(picture("world/f_1.png") == picture("integer/f_1.png"));
    }
}
