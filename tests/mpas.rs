//! The hooks for MPAS-Atmosphere and MPAS-Ocean, compiled against a double of the MPAS modules that they use.

use icoray_test_support::{Need, has_tool};
use icoray_tests::native::{command, mpi_library, root, succeeded, text};
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

    /// Compiles the double, the hook and the run; MPAS compiles its sources, `.F`, as free form through the
    /// preprocessor.
    fn compile(&self, options: &[&str], directory: &Path) -> PathBuf {
        let program = directory.join(self.run);
        let mut rpath = std::ffi::OsString::from("-Wl,-rpath,");
        rpath.push(mpi_library().parent().unwrap());
        let mut compile = command("mpifort", directory);
        let options_of_all = "-std=f2018 -Wall -Wextra -Werror -O1 -fcheck=all,no-array-temps -cpp -ffree-form";
        compile.args(options_of_all.split(' ')).args(self.options).args(options);
        // gfortran 12 warns of arrays that an assignment allocates.
        compile.args(["-Wno-uninitialized", "-Wno-maybe-uninitialized", "-J"]).arg(directory);
        compile.arg(root().join("include/icoray.f90"));
        let of_test = |name: &str| root().join("tests/fortran/mpas").join(name).with_extension("f90");
        compile.args(["mpas_double", "mpas_parts"].map(of_test));
        compile.arg(self.file(self.source).with_extension("F")).arg(of_test(self.run));
        succeeded(compile.arg(mpi_library()).arg(rpath).arg("-o").arg(&program));
        program
    }

    /// A directory for a run, with the example's scene in small: labels tell errors, and all else depends on pixels
    /// only.
    fn prepared(&self, directory: &Path, name: &str) -> PathBuf {
        let scene = std::fs::read_to_string(self.file("icoray.toml")).unwrap();
        let scene = scene.replace("width = 640", "width = 120").replace("height = 480", "height = 90");
        let scene = scene.replace("place = \"below\"", "on = false");
        let to = directory.join(name);
        std::fs::create_dir(&to).unwrap();
        std::fs::write(to.join("icoray.toml"), format!("tolerance = 1e-3\nbackend = \"cpu\"\n{scene}")).unwrap();
        to
    }

    /// Compares the pictures of a run with the hook, on 1 and 2 ranks, with those of the whole arrays, and their names
    /// with `names`.
    fn draws_what_whole_arrays_show(&self, program: &Path, case: &[&str], names: &[String]) {
        let directory = TempDir::new().unwrap();
        let directory = directory.path();
        let direct = self.prepared(directory, "direct");
        succeeded(command(program, &direct).arg("direct").args(case));
        let expected = pictures(&direct);
        assert_eq!(expected.iter().map(|(name, _)| name).collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
        for ranks in [1, 2] {
            let run = self.prepared(directory, &ranks.to_string());
            let output = succeeded(FIRST.on_ranks(ranks, program, &run).arg("hook").args(case));
            let told = text(&output.stdout);
            assert!(told.lines().all(|line| line.contains("holes are drawn as nothing")), "MPAS's log: {told}");
            let drawn = pictures(&run);
            assert_eq!(drawn.iter().map(|(name, _)| name).collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
            for ((name, picture), (_, expected)) in drawn.iter().zip(&expected) {
                let channels = picture.iter().zip(expected.iter());
                let off = channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap();
                assert!(off <= 1, "{name} of {ranks} ranks {case:?}: {off} of 255");
            }
            let copied = bytes_copied(&run);
            assert_eq!(copied.len(), names.len());
            assert!(ranks > 1 || copied.iter().all(|bytes| bytes == "0"), "{copied:?}");
        }
        // Each step and each field shows something else.
        for (i, (name, picture)) in expected.iter().enumerate() {
            let colors = picture.pixels().collect::<std::collections::HashSet<_>>().len();
            assert!(colors > 100, "{name}: {colors} colours");
            assert!(expected[..i].iter().all(|(_, other)| other != picture), "{name}");
        }
    }
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

/// What `report.csv` says of each picture. No column before it has a comma.
fn bytes_copied(run: &Path) -> Vec<String> {
    let report = std::fs::read_to_string(run.join("pictures/report.csv")).unwrap();
    let mut lines = report.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "bytes_copied").unwrap();
    lines.map(|line| line.split(',').nth(column).unwrap().to_owned()).collect()
}

/// Names of the pictures of a view at times of January 2000.
fn at(view: &str, times: &[&str]) -> Vec<String> {
    times.iter().map(|time| format!("{view}_2000-01-{time}.00.00.png")).collect()
}

#[test]
fn the_hook_draws_what_whole_arrays_show() {
    if !FIRST.is_there() || !has_tool(Need::Fortran, "mpifort") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = ATMOSPHERE.compile(&[], directory.path());
    let all = ["01_00", "01_12", "02_00", "02_12"];
    let names = [at("theta", &all), at("vorticity", &["02_00"]), at("w", &all)].concat();
    ATMOSPHERE.draws_what_whole_arrays_show(&program, &[], &names);
}

/// With levels that are missing above, under ice, the mesh has `minLevelCell`; without, it has not.
#[test]
fn the_hook_of_the_ocean_draws_what_whole_arrays_show() {
    if !FIRST.is_there() || !has_tool(Need::Fortran, "mpifort") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = OCEAN.compile(&[], directory.path());
    let temperature = at("temperature", &["01_00", "01_12", "02_00", "02_12"]);
    let names = [at("salinity", &["01_00", "02_00"]), temperature, at("vorticity", &["02_00"])].concat();
    for case in [&[][..], &["ice"]] {
        OCEAN.draws_what_whole_arrays_show(&program, case, &names);
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
        let told = text(&succeeded(FIRST.on_ranks(2, &program, &run).arg("hook")).stdout);
        assert!(told.contains("log 2: icoray: ") && told.contains(said), "{name}: {told}");
        assert!(told.lines().all(|line| line.len() <= 400 + "log 2: icoray: ".len()), "{told}");
    }
}
