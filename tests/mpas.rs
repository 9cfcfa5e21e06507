//! The hooks for MPAS-Atmosphere and MPAS-Ocean, compiled against a double of the MPAS modules that they use.

use icoray_test_support::{Need, has_tool};
use icoray_tests::native::{ALLOCATES, command, fortran, linked, mpi_library, new_directory, root, succeeded, text};
use icoray_tests::pictures::{assert_distinct, assert_same, column, pictures};
use icoray_tests::ranks::FIRST;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A hook below `examples/fortran`, its directory and its name, and the program of `tests/fortran/mpas` that runs it.
struct Hook {
    directory: &'static str,
    source: &'static str,
    run: &'static str,
    /// Says the precision, as MPAS's makefile does.
    options: &'static [&'static str],
}

const ATMOSPHERE: Hook =
    Hook { directory: "mpas", source: "mpas_icoray", run: "mpas_run", options: &["-DSINGLE_PRECISION"] };
const OCEAN: Hook = Hook { directory: "mpas_ocean", source: "mpas_icoray_ocean", run: "mpas_ocean_run", options: &[] };

impl Hook {
    fn file(&self, name: &str) -> PathBuf {
        root().join("examples/fortran").join(self.directory).join(name)
    }

    /// Compiles the double, the hook and the run; MPAS has its sources, `.F`, preprocessed and read as free form.
    fn compile(&self, options: &[&str], directory: &Path) -> PathBuf {
        let program = directory.join(self.run);
        let options_of_all = ["-O1", "-fcheck=all,no-array-temps", "-cpp", "-ffree-form"];
        let options = [&options_of_all, self.options, options, &ALLOCATES].concat();
        let mut compile = fortran("mpifort", directory, &options);
        let of_test = |name: &str| root().join("tests/fortran/mpas").join(name).with_extension("f90");
        compile.args(["mpas_double", "mpas_parts"].map(of_test));
        compile.arg(self.file(self.source).with_extension("F")).arg(of_test(self.run));
        succeeded(compile.args(linked(mpi_library())).arg("-o").arg(&program));
        program
    }

    /// A directory for a run, with the example's scene in small and without labels, whose text has errors.
    fn prepared(&self, directory: &Path, name: &str) -> PathBuf {
        let scene = std::fs::read_to_string(self.file("icoray.toml")).unwrap();
        let scene = scene.replace("width = 640", "width = 120").replace("height = 480", "height = 90");
        let scene = scene.replace("place = \"below\"", "on = false");
        let to = new_directory(directory, name);
        std::fs::write(to.join("icoray.toml"), format!("tolerance = 1e-3\nbackend = \"cpu\"\n{scene}")).unwrap();
        to
    }

    /// Compares the pictures of a run with the hook, on 1 and 2 ranks, with those of the whole arrays, and their names
    /// with `names`.
    fn draws_the_pictures_of_whole_arrays(&self, program: &Path, case: &[&str], names: &[String]) {
        let directory = TempDir::new().unwrap();
        let directory = directory.path();
        let direct = self.prepared(directory, "direct");
        succeeded(command(program, &direct).arg("direct").args(case));
        let expected = pictures(&direct.join("pictures"));
        assert_eq!(expected.keys().collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
        for ranks in [1, 2] {
            let run = self.prepared(directory, &ranks.to_string());
            let output = succeeded(FIRST.on_ranks(ranks, program, &run).arg("hook").args(case));
            let log = text(&output.stdout);
            assert!(log.lines().all(|line| line.contains("only the core is drawn there")), "MPAS's log: {log}");
            assert_same(&pictures(&run.join("pictures")), &expected, format!("{ranks} ranks {case:?}"));
            let copied = column(&run.join("pictures/report.csv"), "bytes_copied");
            assert_eq!(copied.len(), names.len());
            assert!(ranks > 1 || copied.iter().all(|bytes| bytes == "0"), "{copied:?}");
        }
        // Each step and each field shows something else.
        assert_distinct(&expected, 100);
    }
}

/// Names of the pictures of a view at times of January 2000.
fn at(view: &str, times: &[&str]) -> Vec<String> {
    times.iter().map(|time| format!("{view}_2000-01-{time}.00.00.png")).collect()
}

#[test]
fn the_hook_draws_the_pictures_of_whole_arrays() {
    let Some(directory) = FIRST.directory().filter(|_| has_tool(Need::Fortran, "mpifort")) else { return };
    let program = ATMOSPHERE.compile(&[], directory.path());
    let all = ["01_00", "01_12", "02_00", "02_12"];
    let names = [at("theta", &all), at("vorticity", &["02_00"]), at("w", &all)].concat();
    ATMOSPHERE.draws_the_pictures_of_whole_arrays(&program, &[], &names);
}

/// With levels that are missing above, under ice, the mesh has `minLevelCell`; without, it has not.
#[test]
fn the_hook_of_the_ocean_draws_the_pictures_of_whole_arrays() {
    let Some(directory) = FIRST.directory().filter(|_| has_tool(Need::Fortran, "mpifort")) else { return };
    let program = OCEAN.compile(&[], directory.path());
    let temperature = at("temperature", &["01_00", "01_12", "02_00", "02_12"]);
    let names = [at("salinity", &["01_00", "02_00"]), temperature, at("vorticity", &["02_00"])].concat();
    for case in [&[][..], &["ice"]] {
        OCEAN.draws_the_pictures_of_whole_arrays(&program, case, &names);
    }
}

/// Makes another scene of the example's, or none.
type Change = fn(String) -> Option<String>;

/// What is wrong is a line in MPAS's log, short enough for it, and the run ends well.
#[test]
fn a_scene_that_is_missing_or_wrong_is_a_line_in_the_log() {
    let Some(directory) = FIRST.directory().filter(|_| has_tool(Need::Fortran, "mpifort")) else { return };
    let directory = directory.path();
    // As MPAS's makefile says for a library with the module mpi_f08.
    let program = ATMOSPHERE.compile(&["-DMPAS_USE_MPI_F08"], directory);
    let cases: [(&str, Change, &str); 3] = [
        ("missing", |_| None, "icoray.toml: cannot read the scene"),
        (
            "wrong",
            |scene| Some(scene.replace("[labels]", "[camera]\nfov = 450\n[labels]")),
            "key camera.fov: 450, expected",
        ),
        (
            "other",
            |scene| Some(scene.replace("field = \"theta\"", &format!("field = \"{}\"", "x".repeat(900)))),
            "was not given by icoray_field_set",
        ),
    ];
    for (name, change, said) in cases {
        let run = ATMOSPHERE.prepared(directory, name);
        let file = run.join("icoray.toml");
        let scene = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        if let Some(scene) = change(scene) {
            std::fs::write(&file, scene).unwrap();
        }
        let log = text(&succeeded(FIRST.on_ranks(2, &program, &run).arg("hook")).stdout);
        assert!(log.contains("log 2: icoray: ") && log.contains(said), "{name}: {log}");
        assert!(log.lines().all(|line| line.len() <= 400 + "log 2: icoray: ".len()), "{log}");
    }
}
