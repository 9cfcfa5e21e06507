//! The implementation of Catalyst, loaded by a double of libcatalyst, and by the real one where ICORAY_CATALYST names
//! its prefix.

mod faults;
mod hosts;

use hosts::{DIRECT, HOST, Host, ended_well, has_view, prepared};
use icoray_test_support::{Need, runs_long, skip, skip_because};
use icoray_tests::native::{command, compile_to, log_of, new_directory, root, succeeded};
use icoray_tests::pictures::{Pictures, assert_distinct, assert_drew, assert_same, pictures};
use icoray_tests::ranks::FIRST;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const STEPS: usize = 3;

/// The pictures of a run.
fn drawn(run: &Path) -> Pictures {
    pictures(&run.join("pictures"))
}

/// What whole arrays in one process show, in a scene on native heights where there are hills. A scene of one field has
/// its name after these, as hexahedra have heights of points or of elements.
fn direct(directory: &Path, shape: &str, heights: &str) -> Pictures {
    direct_in(directory, shape, heights, heights)
}

/// As [`direct`], in the scene of other heights.
fn direct_in(directory: &Path, shape: &str, heights: &str, scene: &str) -> Pictures {
    let program = directory.join("direct");
    if !program.is_file() {
        compile_to(&program, "cc", &[], &DIRECT, &[]);
    }
    let run = prepared(directory, &format!("direct {shape} {heights} {scene}"), scene);
    succeeded(command(&program, &run).args(["scene.toml", shape, heights, &STEPS.to_string()]));
    let expected = drawn(&run);
    let [of_theta, of_q] = ["theta", "q"].map(|field| if has_view(scene, field) { STEPS } else { 0 });
    assert_eq!(expected.len(), of_theta + of_q.div_ceil(2));
    assert_distinct(&expected, 500);
    expected
}

const CASES: [(&str, &str); 9] = [
    ("wedges", "flat"),
    ("wedges", "hills"),
    ("prisms", "flat"),
    ("prisms", "hills"),
    ("hexes", "flat"),
    ("hexes", "hills theta"),
    ("hexes", "hills q"),
    ("points", "flat"),
    ("points", "hills"),
];
const ORDERS: [&str; 6] = ["column", "level", "top", "shuffled", "float", "strided"];

/// Draws with a host all shapes in all orders, on 1 to 3 ranks.
fn draws_the_same(directory: &Path, host: &Host, ranks: &[usize]) {
    for (shape, heights) in CASES {
        let expected = direct(directory, shape, heights);
        for order in ORDERS {
            // Other orders are read in the same way on all ranks.
            for &ranks in ranks.iter().filter(|ranks| **ranks == 1 || ["column", "shuffled"].contains(&order)) {
                let run = prepared(directory, &format!("{shape} {heights} {order} {ranks}"), heights);
                let log = host.run(ranks, &run, &["scene.toml", shape, heights, &STEPS.to_string(), order]);
                let is_copied = order == "shuffled";
                let said = log.matches("icoray: warning: ").count();
                let fields = ["theta", "q"].into_iter().filter(|field| has_view(heights, field)).count();
                assert_eq!(said, if is_copied { fields } else { 0 }, "{log}");
                assert_eq!(log.matches("are copied for each picture").count(), said, "{log}");
                assert!(ranks > 1 || is_copied || log.contains("\n0 bytes copied"), "{log}");
                assert!(!is_copied || !log.contains("\n0 bytes copied"), "{log}");
                assert_drew(&run, &expected);
            }
        }
        let runs = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
        let is_of_case = |path: &PathBuf| path.to_string_lossy().contains(&format!("/{shape} {heights}"));
        runs.filter(|path| path.is_dir() && is_of_case(path)).for_each(|run| std::fs::remove_dir_all(run).unwrap());
    }
}

#[test]
fn hosts_draw_the_pictures_of_whole_arrays() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    draws_the_same(directory, &Host::of_kind(directory, "", true), &[1, 2, 3]);
}

/// A single layer of elements, of triangles and quadrilaterals on a sphere, and of points: values are surfaces.
#[test]
fn single_layers_are_surfaces() {
    let Some(directory) = FIRST.directory() else { return };
    for (levels, shapes) in [("LEVELS=1", &["wedges", "hexes", "points"][..]), ("LEVELS=2", &["wedges", "prisms"])] {
        let directory = new_directory(directory.path(), levels);
        let option = format!("-D{levels}");
        compile_to(&directory.join("direct"), "cc", &[&option], &DIRECT, &[]);
        let host = Host::of_kind(&directory, levels, true);
        for shape in shapes {
            let expected = direct(&directory, shape, "opaque");
            for ranks in [1, 3] {
                let run = prepared(&directory, &format!("{shape} {ranks}"), "opaque");
                host.draws(ranks, &run, &["scene.toml", shape, "opaque", &STEPS.to_string(), "level"], &expected);
            }
        }
    }
}

/// A host without MPI, and one whose Conduit is a library of its own.
#[test]
fn hosts_on_one_process_draw_too() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let expected = direct(directory, "wedges", "flat");
    for kind in ["", "EXTERNAL_CONDUIT"] {
        let host = Host::of_kind(directory, kind, false);
        let run = prepared(directory, &format!("run {kind}"), "flat");
        host.draws(1, &run, &["scene.toml", "wedges", "flat", &STEPS.to_string(), "column"], &expected);
    }
    // A host that is a module, with a libcatalyst that is loaded for it alone.
    let alone = Host::of_kind(&new_directory(directory, "module"), "", false);
    let (module, loader) = (directory.join("module.so"), directory.join("loader"));
    let include = format!("-I{}", root().join("tests/c/catalyst/double").display());
    let (at, rpath) = (alone.library.parent().unwrap().to_str().unwrap(), alone.library.parent().unwrap().display());
    let of_module = ["-shared", "-fPIC", "-Dmain=host_main", &include, "-Wno-missing-prototypes"];
    let libraries = [&format!("-L{at}"), "-lcatalyst", &format!("-Wl,-rpath,{rpath}")];
    compile_to(&module, "cc", &of_module, &HOST, &libraries);
    compile_to(&loader, "cc", &["-Wl,--as-needed"], &["catalyst/loader"], &[]);
    let run = prepared(directory, "loaded", "flat");
    let mut command = command(&loader, &run);
    command.arg(&module).args(["scene.toml", "wedges", "flat", &STEPS.to_string(), "column"]);
    command.env("CATALYST_IMPLEMENTATION_NAME", "icoray").env("CATALYST_IMPLEMENTATION_PATHS", &alone.implementation);
    let log = ended_well(1, &mut command);
    assert!(!log.contains("icoray:"), "{log}");
    assert_drew(&run, &expected);
    // Without a planet's radius the innermost layer is its surface, as it is here; the environment may name the scene.
    let host = Host::of_kind(directory, "", true);
    for (fault, ranks) in [("no radius", 1), ("list", 2), ("count", 2)] {
        let run = prepared(directory, fault, "flat");
        host.draws(ranks, &run, &["scene.toml", "wedges", "flat", &STEPS.to_string(), "column", fault], &expected);
    }
    let run = prepared(directory, "environment", "flat");
    let arguments = ["-", "wedges", "flat", &STEPS.to_string(), "column", "no scene"];
    let mut command = host.command(2, &run, &arguments);
    ended_well(2, command.env("ICORAY_SCENE", "scene.toml"));
    assert_drew(&run, &expected);
}

/// Ranks without elements give arrays of none, an empty node, or no channel and so no step and time.
#[test]
fn ranks_without_elements_draw_with_the_others() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let host = Host::of_kind(directory, "", true);
    for shape in ["wedges", "hexes", "points"] {
        let expected = direct(directory, shape, "flat");
        for kind in ["empty", "no data", "mesh state"] {
            let run = prepared(directory, &format!("{shape} {kind}"), "flat");
            host.draws(3, &run, &["scene.toml", shape, "flat", &STEPS.to_string(), "column", kind], &expected);
        }
    }
}

/// A mesh may change at each step: its heights alone, or all of it. Names distinguish channels with the same field.
#[test]
fn meshes_of_each_step_are_drawn() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let host = Host::of_kind(directory, "", true);
    for shape in ["wedges", "prisms", "points"] {
        let [flat, hills] = ["flat", "hills"].map(|heights| direct_in(directory, shape, heights, "hills"));
        let mut moving = flat;
        moving.extend(hills.into_iter().filter(|(name, _)| name.ends_with("1.png")));
        let flat = direct(directory, shape, "flat");
        for ranks in [1, 3] {
            for (change, heights, expected) in [("moving", "hills", &moving), ("renumbered", "flat", &flat)] {
                let run = prepared(directory, &format!("{shape} {change} {ranks}"), heights);
                let arguments = ["scene.toml", shape, heights, &STEPS.to_string(), "column", change];
                host.draws(ranks, &run, &arguments, expected);
            }
        }
        let run = prepared(directory, &format!("{shape} two"), "flat");
        let two = ["scene.toml", shape, "flat", &STEPS.to_string(), "column", "two"];
        let log = host.run(2, &run, &two);
        assert!(log.contains("several channels have theta, name one of grid.theta, other.theta"), "{log}");
        // The other view is drawn, until too many pictures of this one have failed.
        let others = drawn(&run);
        assert!(others.keys().all(|name| name.starts_with("q_")) && !others.is_empty(), "{log}");
        let scene = std::fs::read_to_string(run.join("scene.toml")).unwrap();
        std::fs::write(run.join("scene.toml"), scene.replace("field = \"theta\"", "field = \"grid.theta\"")).unwrap();
        // That name is also good where there is one channel.
        for arguments in [&two[..], &two[..5]] {
            std::fs::remove_dir_all(run.join("pictures")).unwrap();
            let log = host.run(2, &run, arguments);
            assert!(!log.contains("icoray:"), "{log}");
            let named = drawn(&run).into_iter().map(|(name, picture)| (name.replace("grid.", ""), picture));
            assert_same(&named.collect(), &flat, run.display());
        }
    }
}

/// Kitware's library: the host, and the same calls again from the files that it writes of them.
#[test]
fn the_real_libcatalyst_draws_the_same() {
    if !runs_long() || !FIRST.is_there() {
        return;
    }
    let Some(prefix) = std::env::var_os("ICORAY_CATALYST").map(PathBuf::from) else {
        return skip(Need::Catalyst);
    };
    let (include, library) = (prefix.join("include/catalyst-2.0"), prefix.join("lib/libcatalyst.so"));
    if !include.join("catalyst.h").is_file() || !library.is_file() {
        return skip_because(Need::Catalyst, "no include/catalyst-2.0/catalyst.h or lib/libcatalyst.so");
    }
    let directory = TempDir::new().unwrap();
    let directory = directory.path();
    let host = Host::new(directory, &include, &library, &["-Wno-error", "-w"], true);
    draws_the_same(directory, &host, &[1, 2, 3]);
    let replay = prefix.join("bin/catalyst_replay");
    if !replay.is_file() {
        return skip_because(Need::Catalyst, "no bin/catalyst_replay");
    }
    let expected = drawn(&directory.join("direct wedges hills hills"));
    for ranks in [1, 2, 3] {
        let [first, again] =
            ["dumped", "replayed"].map(|name| prepared(directory, &format!("{name} {ranks}"), "hills"));
        let dump = new_directory(&first, "dump");
        let mut host = host.command(ranks, &first, &["scene.toml", "wedges", "hills", &STEPS.to_string(), "column"]);
        host.env("CATALYST_DATA_DUMP_DIRECTORY", format!("{}/", dump.display()));
        ended_well(ranks, &mut host);
        let mut player = FIRST.on_ranks(ranks, &replay, &again);
        player.arg(&dump).env("CATALYST_IMPLEMENTATION_NAME", "icoray");
        player.env("CATALYST_IMPLEMENTATION_PATHS", directory.join("implementation"));
        let log = log_of(player.env("LD_LIBRARY_PATH", library.parent().unwrap()));
        // Files are packed, so that numbers may lie at odd addresses.
        let copies = log.matches("are not at multiples of their size in memory, and are copied").count();
        assert_eq!(log.matches("icoray:").count(), copies, "{log}");
        assert_drew(&first, &expected);
        assert_drew(&again, &expected);
    }
}
