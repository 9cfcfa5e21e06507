//! The plugin for ICON, compiled against a double of ComIn 0.2 and 0.3, and run by the real `comin_replay` where
//! ICORAY_COMIN names its prefix.

use icoray_test_support::{Need, runs_long, skip, skip_because};
use icoray_tests::native::{command, compile_to, log_of, new_directory, root, succeeded};
use icoray_tests::pictures::{Pictures, assert_distinct, assert_drew, column, pictures};
use icoray_tests::ranks::FIRST;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

mod file;

/// Files in C of the plugin, from `tests/c`.
const PLUGIN: [&str; 4] = [
    "../../crates/icoray-comin/src/host",
    "../../crates/icoray-comin/src/grid",
    "../../crates/icoray-comin/src/clock",
    "../../crates/icoray-comin/src/plugin",
];

/// The plugin against the `comin.h` of a folder and the libcomin of another.
fn plugin(to: &Path, include: &Path, options: &[&str], library: &Path) {
    let exports = format!("-Wl,--version-script={}", root().join("crates/icoray-comin/exports.map").display());
    let (include, library) = (include.to_str().unwrap(), format!("-L{}", library.display()));
    let options =
        [&["-fPIC", "-shared", "-fdata-sections", "-Wl,--gc-sections", "-isystem", include, &exports], options]
            .concat();
    compile_to(to, "cc", &options, &PLUGIN, &[&library, "-lcomin"]);
}

/// A double with the host that runs it, of a release of ComIn.
struct Double {
    directory: PathBuf,
}

impl Double {
    fn new(directory: &Path, version: u32) -> Self {
        let directory = new_directory(directory, &format!("comin_0.{version}"));
        let include = root().join("tests/c/comin/double");
        let is_version = format!("-DCOMIN_DOUBLE={version}");
        let include_flag = format!("-I{}", include.display());
        let here = format!("-L{}", directory.display());
        let library = directory.join("libcomin.so.0");
        let options = [&is_version, &include_flag, "-fPIC", "-shared", "-Wl,-soname,libcomin.so.0"];
        compile_to(&library, "cc", &options, &["comin/icon", "comin/double/double"], &[]);
        std::os::unix::fs::symlink(&library, directory.join("libcomin.so")).unwrap();
        let host = [is_version.as_str(), include_flag.as_str()];
        compile_to(&directory.join("host"), "mpicc", &host, &["comin/host"], &[&here, "-lcomin"]);
        plugin(&directory.join("libicoray_comin.so"), &include, &[&is_version], &directory);
        Double { directory }
    }

    fn plugin(&self) -> PathBuf {
        self.directory.join("libicoray_comin.so")
    }

    /// The host with a plugin, on so many ranks.
    fn host(&self, ranks: usize, run: &Path, plugin: &Path, arguments: &[&str]) -> Command {
        let mut command = FIRST.on_ranks(ranks, &self.directory.join("host"), run);
        command.arg(plugin).args(arguments).env("LD_LIBRARY_PATH", &self.directory);
        command
    }

    /// What the host printed, which ended well on all ranks.
    fn run(&self, ranks: usize, run: &Path, arguments: &[&str]) -> String {
        ended_well(ranks, &mut self.host(ranks, run, &self.plugin(), arguments))
    }
}

fn ended_well(ranks: usize, host: &mut Command) -> String {
    let log = icoray_tests::native::ended_well(ranks, host);
    assert!(!log.contains("an error is left in ComIn"), "{log}");
    log
}

/// A directory for a run, with the test's scene or another one.
fn prepared(directory: &Path, name: &str, change: impl FnOnce(String) -> String) -> PathBuf {
    let scene = std::fs::read_to_string(root().join("tests/c/comin/scene.toml")).unwrap();
    let to = new_directory(directory, name);
    std::fs::write(to.join("scene.toml"), change(scene)).unwrap();
    to
}

/// What whole arrays in one process show, over the steps 0 to 3.
fn direct(directory: &Path) -> Pictures {
    let expected = direct_with(directory, |scene| scene);
    assert_eq!(expected.len(), 8);
    assert_distinct(&expected, 500);
    expected
}

/// As [`direct`], with another scene.
fn direct_with(directory: &Path, change: impl FnOnce(String) -> String) -> Pictures {
    let (program, run) = (directory.join("direct"), prepared(directory, "whole", change));
    compile_to(&program, "cc", &[], &["comin/direct", "comin/icon"], &[]);
    succeeded(command(&program, &run).args(["scene.toml", "0", "3"]));
    pictures(&run.join("pictures"))
}

/// The bytes that were copied for each picture.
fn bytes_copied(run: &Path) -> Vec<String> {
    column(&run.join("pictures/report.csv"), "bytes_copied")
}

#[test]
fn icon_draws_the_pictures_of_whole_arrays() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let expected = direct(directory);
    for version in [2, 3] {
        let double = Double::new(directory, version);
        for ranks in [1, 2, 3] {
            let run = prepared(directory, &format!("{version}_{ranks}"), |scene| scene);
            let log = double.run(ranks, &run, &["scene.toml", "1", "0", "3"]);
            assert!(!log.contains("icoray:"), "{log}");
            assert_drew(&run, &expected);
            assert_eq!(bytes_copied(&run), ["0"; 8], "{ranks} ranks");
        }
        // Ranks that are alone on their nodes exchange fragments.
        let run = prepared(directory, &format!("{version}_nodes"), |scene| scene);
        let mut host = double.host(3, &run, &double.plugin(), &["scene.toml", "1", "0", "3"]);
        ended_well(3, host.env("ICORAY_NODE_RANKS", "1"));
        assert_drew(&run, &expected);
        // Rendered while the host goes on.
        for ranks in [1, 3] {
            let name = format!("{version}_{ranks}_async");
            let run = prepared(directory, &name, |scene| format!("async_render = true\n{scene}"));
            double.run(ranks, &run, &["scene.toml", "1", "0", "3"]);
            assert_drew(&run, &expected);
            // The first picture of a step has the copies of all; over ranks averages are assembled, which are none.
            assert!(ranks > 1 || bytes_copied(&run).iter().any(|bytes| bytes != "0"));
        }
        // A restart goes on with steps and names, and only what the scene reads is requested.
        let run = prepared(directory, &format!("{version}_again"), |scene| {
            scene[..scene.match_indices("[[views]]").nth(2).unwrap().0].to_owned()
        });
        let log = double.run(2, &run, &["scene.toml", "1", "2", "3"]);
        assert_eq!(log.matches("requested temp").count() + log.matches("requested w ").count(), 4, "{log}");
        assert_eq!(log.matches("requested").count(), 4, "{log}");
        let is_of_it = |name: &str| {
            ["temp_temp", "w_w"].iter().any(|view| name.starts_with(view))
                && (name.contains("_000002") || name.contains("_000003"))
        };
        let late: Pictures = expected.clone().into_iter().filter(|(name, _)| is_of_it(name)).collect();
        assert_eq!(late.len(), 3);
        assert_drew(&run, &late);
    }
}

#[test]
fn a_nest_is_a_grid_of_its_own() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let double = Double::new(directory, 3);
    let of_nest = |scene: String| {
        let first = scene[..scene.match_indices("[[views]]").nth(1).unwrap().0].replace("lat = 35", "lat = 80");
        let nest = first[first.find("[[views]]").unwrap()..].replace("\"temp\"", "\"temp_DOM02\"");
        format!("{first}{nest}").replace("heights = \"native\"\n", "")
    };
    let [one, three] = [1, 3].map(|ranks| {
        let run = prepared(directory, &ranks.to_string(), of_nest);
        let log = double.run(ranks, &run, &["scene.toml", "2", "0", "1"]);
        assert_eq!(log.matches("requested temp of domain 2").count(), ranks, "{log}");
        let mut logged = log.lines().filter(|line| line.contains("icoray:"));
        assert!(logged.all(|line| line.contains("only the core is drawn there")), "{log}");
        run
    });
    let expected = pictures(&one.join("pictures"));
    assert_eq!(expected.len(), 4);
    assert!(expected.values().next() != expected.values().nth(2), "the nest is no sphere");
    assert_drew(&three, &expected);
}

/// Vertices are icoray's cells; over several processes they are refused, as what one draws may be another's.
#[test]
fn one_process_draws_values_at_vertices() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let of_vertices = |scene: String| scene.replace("field = \"w\"", "field = \"omega_z\"");
    let expected = direct_with(directory, of_vertices);
    assert_eq!(expected.keys().filter(|name| name.starts_with("w_omega_z")).count(), 2, "{expected:?}");
    for version in [2, 3] {
        let run = prepared(directory, &version.to_string(), of_vertices);
        let log = Double::new(directory, version).run(1, &run, &["scene.toml", "1", "0", "3"]);
        assert!(!log.contains("icoray:"), "{log}");
        assert_drew(&run, &expected);
    }
}

/// What goes wrong is a line in ICON's log, and ICON ends well.
#[test]
fn no_failure_ends_icon() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let [old, new] = [2, 3].map(|version| Double::new(directory, version));
    let cases: [(&str, &[&str], &str); 9] = [
        ("no scene", &["", "1", "0", "1"], "options in comin_nml have no scene"),
        ("missing", &["nowhere.toml", "1", "0", "1"], "nowhere.toml: cannot read the scene"),
        ("field", &["scene.toml", "1", "0", "4"], "the scene reads vorticity, and ICON has no such variable"),
        ("rank", &["scene.toml", "1", "0", "1", "table"], "warning: rank 1: "),
        ("nest", &["scene.toml", "1", "0", "1"], "the scene reads temp_DOM02, and ICON has no such variable"),
        ("vn", &["scene.toml", "1", "0", "1"], "the scene reads vn, and ICON has it at edges"),
        ("omega_z", &["scene.toml", "1", "0", "1"], "the scene reads omega_z, and ICON has it at vertices"),
        ("few", &["scene.toml", "1", "0", "1"], "field \"few\": "),
        ("many", &["scene.toml", "1", "0", "1"], "field \"many\": "),
    ];
    for (name, arguments, said) in cases {
        for (version, double) in [(2, &old), (3, &new)] {
            let run = prepared(directory, &format!("{name} {version}"), |scene| match name {
                "field" => scene.replace("field = \"w\"", "field = \"vorticity\""),
                "nest" => scene.replace("field = \"w\"", "field = \"temp_DOM02\""),
                "vn" | "omega_z" | "few" | "many" => scene.replace("field = \"w\"", &format!("field = \"{name}\"")),
                _ => scene,
            });
            let log = double.run(3, &run, arguments);
            assert!(log.contains("icoray: warning: ") && log.contains(said), "{name}: {log}");
            assert!(log.lines().all(|line| line.len() < 480), "{log}");
            // Once, not once per rank.
            assert!(["rank", "few", "many"].contains(&name) || log.matches(said).count() == 1, "{name}: {log}");
            // Other views are drawn.
            let has_others = ["field", "nest", "vn", "omega_z", "few", "many"].contains(&name);
            let others = pictures(&run.join("pictures")).into_keys().filter(|name| name.starts_with("temp_")).count();
            assert_eq!(others > 0, has_others, "{name}: {log}");
        }
    }
    // A plugin of another release than the library that is loaded.
    for (host, plugin) in [(&old, &new), (&new, &old)] {
        let run = directory.join("scene.toml");
        std::fs::write(&run, "").unwrap();
        let log = ended_well(2, &mut host.host(2, directory, &plugin.plugin(), &["scene.toml", "1", "0", "1"]));
        assert!(log.contains("was built for another ComIn than ICON's"), "{log}");
    }
    // Where pictures cannot be written.
    let run = prepared(directory, "in the way", |scene| scene);
    std::fs::write(run.join("pictures"), "").unwrap();
    let log = new.run(2, &run, &["scene.toml", "1", "0", "1"]);
    assert!(log.contains("icoray: warning: ") && log.contains("pictures"), "{log}");
}

/// The real library, with values that ComIn's own replay plugin sets.
#[test]
fn the_real_comin_draws_the_same() {
    if !runs_long() || !FIRST.is_there() {
        return;
    }
    let Some(prefix) = std::env::var_os("ICORAY_COMIN").map(PathBuf::from) else {
        return skip(Need::Comin);
    };
    let (replay, values) = (prefix.join("bin/comin_replay"), prefix.join("lib/libcomin_var_replay_plugin.so"));
    let Some(netcdf) = file::netcdf().filter(|_| replay.is_file() && values.is_file()) else {
        return skip_because(Need::Comin, "no comin_replay, its plugin for variables, or libnetcdf");
    };
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    let expected = direct(directory);
    let (writer, library) = (directory.join("replay"), directory.join("libicoray_comin.so"));
    let netcdf: Vec<&str> = netcdf.iter().map(String::as_str).collect();
    compile_to(&writer, "cc", &[], &["comin/replay", "comin/icon"], &netcdf);
    plugin(&library, &prefix.join("include"), &[], &prefix.join("lib"));
    let version = std::fs::read_to_string(prefix.join("include/comin_version.inc")).unwrap();
    let number = |name: &str| {
        let line = version.lines().find(|line| line.contains(name)).unwrap();
        line.split_whitespace().last().unwrap().to_owned()
    };
    for ranks in [1, 2, 3] {
        let run = prepared(directory, &format!("real_{ranks}"), |scene| scene);
        let mut data = command(&writer, &run);
        data.args([&ranks.to_string(), "3"]).args([&values, &library]).arg("scene.toml");
        succeeded(data.args([number("VERSION_MAJOR"), number("VERSION_MINOR")]));
        let mut host = FIRST.on_ranks(ranks, &replay, &run);
        let log = log_of(host.env("LD_LIBRARY_PATH", prefix.join("lib")));
        assert!(!log.contains("icoray: "), "{log}");
        assert_drew(&run, &expected);
        assert_eq!(bytes_copied(&run), ["0"; 8], "{ranks} ranks");
    }
}
