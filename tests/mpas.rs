//! The hook for MPAS-Atmosphere, compiled against a double of the MPAS modules that it uses.

use icoray_test_support::{Need, has_tool};
use icoray_tests::native::{command, mpi_library, root, succeeded, text};
use icoray_tests::ranks::FIRST;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Compiles the double, the hook and the run; MPAS compiles its sources, `.F`, as free form through the preprocessor.
fn compile(options: &[&str], directory: &Path) -> PathBuf {
    let program = directory.join("mpas_run");
    let mut rpath = std::ffi::OsString::from("-Wl,-rpath,");
    rpath.push(mpi_library().parent().unwrap());
    let mut compile = command("mpifort", directory);
    let options_of_all = "-std=f2018 -Wall -Wextra -Werror -O1 -fcheck=all,no-array-temps -cpp -ffree-form";
    compile.args(options_of_all.split(' '));
    // gfortran 12 warns of arrays that an assignment allocates.
    compile.args(["-Wno-uninitialized", "-Wno-maybe-uninitialized", "-J"]).arg(directory).args(options);
    compile.args(["include/icoray.f90", "tests/fortran/mpas/mpas_double.f90"].map(|file| root().join(file)));
    compile
        .args(["examples/fortran/mpas/mpas_icoray.F", "tests/fortran/mpas/mpas_run.f90"].map(|file| root().join(file)));
    succeeded(compile.arg(mpi_library()).arg(rpath).arg("-o").arg(&program));
    program
}

/// A directory for a run, with the example's scene in small: labels tell errors, and all else depends on pixels only.
fn prepared(directory: &Path, name: &str) -> PathBuf {
    let scene = std::fs::read_to_string(root().join("examples/fortran/mpas/icoray.toml")).unwrap();
    let scene = scene.replace("640", "120").replace("480", "90").replace("place = \"below\"", "on = false");
    let to = directory.join(name);
    std::fs::create_dir(&to).unwrap();
    std::fs::write(to.join("icoray.toml"), format!("tolerance = 1e-5\nbackend = \"cpu\"\n{scene}")).unwrap();
    to
}

/// Names and pixels of the pictures of a run.
fn pictures(run: &Path) -> Vec<(String, image::RgbaImage)> {
    let entries = std::fs::read_dir(run.join("pictures")).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "png")).collect();
    paths.sort();
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    paths.iter().map(|path| (name(path), image::open(path).unwrap().into_rgba8())).collect()
}

#[test]
fn the_hook_draws_what_whole_arrays_show() {
    if !FIRST.is_there() || !has_tool(Need::Fortran, "mpifort") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    let program = compile(&[], directory);
    let direct = prepared(directory, "direct");
    succeeded(command(&program, &direct).arg("direct"));
    let expected = pictures(&direct);
    let names: Vec<&str> = expected.iter().map(|(name, _)| name.as_str()).collect();
    let all = |field: &str| ["01_00", "01_12", "02_00", "02_12"].map(|at| format!("{field}_2000-01-{at}.00.00.png"));
    assert_eq!(names, [&all("theta")[..], &["vorticity_2000-01-02_00.00.00.png".into()], &all("w")].concat());
    for ranks in [1, 2] {
        let run = prepared(directory, &ranks.to_string());
        let output = succeeded(FIRST.on_ranks(ranks, &program, &run).arg("hook"));
        assert_eq!(text(&output.stdout), "", "no line in MPAS's log");
        let drawn = pictures(&run);
        assert_eq!(drawn.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), names);
        for ((name, picture), (_, expected)) in drawn.iter().zip(&expected) {
            let channels = picture.iter().zip(expected.iter());
            let off = channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(off <= 1, "{name} of {ranks} ranks: {off} of 255");
        }
    }
    // Each step and each field shows something else.
    for (i, (name, picture)) in expected.iter().enumerate() {
        let colors = picture.pixels().collect::<std::collections::HashSet<_>>().len();
        assert!(colors > 100, "{name}: {colors} colours");
        assert!(expected[..i].iter().all(|(_, other)| other != picture), "{name}");
    }
}

/// Makes another scene of the example's, or none.
type Change = fn(String) -> Option<String>;

/// What is wrong is a line in MPAS's log, short enough for it, and the run ends well.
#[test]
fn a_scene_that_is_missing_or_wrong_is_a_line_in_the_log() {
    if !FIRST.is_there() || !has_tool(Need::Fortran, "mpifort") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    // As MPAS's makefile says for a library with the module mpi_f08.
    let program = compile(&["-DMPAS_USE_MPI_F08"], directory);
    let cases: [(&str, Change, &str); 3] = [
        ("missing", |_| None, "icoray.toml: cannot read the scene"),
        ("wrong", |scene| Some(scene.replace("fov = 45", "fov = 450")), "key camera.fov: 450, expected"),
        (
            "other",
            |scene| Some(scene.replace("field = \"theta\"", &format!("field = \"{}\"", "x".repeat(900)))),
            "was not given by icoray_field_set",
        ),
    ];
    for (name, change, said) in cases {
        let run = prepared(directory, name);
        let file = run.join("icoray.toml");
        let scene = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        if let Some(scene) = change(scene) {
            std::fs::write(&file, scene).unwrap();
        }
        let told = text(&succeeded(FIRST.on_ranks(2, &program, &run).arg("hook")).stdout);
        assert!(told.contains("log 2: icoray: ") && told.contains(said), "{name}: {told}");
        assert!(told.lines().all(|line| line.len() <= 400 + "log 2: icoray: ".len()), "{told}");
    }
}
