//! The C ABI from outside: C programs against `include/icoray.h` and the shared library.

mod pictures;

use icoray_test_support::{Need, has_tool, runs, runs_long, skip_because};
use icoray_tests::layout::{LAYOUT, rust_layout};
use icoray_tests::native::{checked, command, compile, compile_c, library, root, succeeded, text};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const FUNCTIONS: [&str; 25] = [
    "icoray_close",
    "icoray_execute",
    "icoray_field_describe",
    "icoray_field_set",
    "icoray_field_set_ndarray",
    "icoray_grid_set",
    "icoray_heights_set",
    "icoray_heights_set_ndarray",
    "icoray_last_error",
    "icoray_layers_set",
    "icoray_log_stderr",
    "icoray_mesh_create",
    "icoray_mesh_free",
    "icoray_mesh_grid",
    "icoray_open",
    "icoray_open_serial",
    "icoray_part_set",
    "icoray_refuse",
    "icoray_report",
    "icoray_scene_load",
    "icoray_scene_text",
    "icoray_version",
    "icoray_wait",
    "icoray_wants",
    "icoray_wants_field",
];

/// The sources of each program in `tests/c`; the first has the program's name.
const LAYOUT_PROGRAM: [&str; 1] = ["layout"];
const REFUSALS: [&str; 21] = [
    "refusals",
    "refusals_calls",
    "refusals_entry",
    "refusals_execute",
    "refusals_fields",
    "refusals_files",
    "refusals_good",
    "refusals_grid",
    "refusals_heights",
    "refusals_late",
    "refusals_levels",
    "refusals_log",
    "refusals_long",
    "refusals_names",
    "refusals_ndarrays",
    "refusals_off",
    "refusals_parts",
    "refusals_scene",
    "refusals_tables",
    "refusals_wants",
    "check",
];
const PICTURES: [&str; 11] = [
    "pictures",
    "pictures_background",
    "pictures_common",
    "pictures_contexts",
    "pictures_fields",
    "pictures_layouts",
    "pictures_names",
    "pictures_ndarrays",
    "pictures_tables",
    "pictures_values",
    "check",
];

const VIEWS: [&str; 3] = ["views", "pictures_common", "check"];

/// Compiles a program of `tests/c` as C++.
fn compile_cpp(sources: &[&str]) -> PathBuf {
    compile("c++", &["-std=c++11", "-x", "c++"], sources)
}

/// Fails unless `program` prints the version and Rust's layout of the structs.
fn sees_the_structs_as_rust_does(program: &Path) {
    let directory = TempDir::new().unwrap();
    let output = succeeded(&mut command(program, directory.path()));
    let printed = text(&output.stdout);
    let (version, layout) = printed.split_once('\n').unwrap();
    assert_eq!(version, concat!("version ", env!("CARGO_PKG_VERSION")));
    assert_eq!(text(&output.stderr), "");
    is_layout_of_rust(layout);
}

fn is_layout_of_rust(layout: &str) {
    let rust = rust_layout();
    let first = rust.lines().zip(layout.lines()).find(|(a, b)| a != b);
    assert!(rust == layout, "they differ from Rust: {first:?}");
}

#[test]
#[cfg(target_pointer_width = "64")]
fn the_structs_are_those_of_earlier_versions() {
    is_layout_of_rust(LAYOUT);
}

#[test]
fn c_sees_the_structs_as_rust_does() {
    sees_the_structs_as_rust_does(&compile_c(&LAYOUT_PROGRAM));
}

#[test]
fn cpp_sees_the_structs_as_rust_does() {
    if has_tool(Need::Cxx, "c++") {
        sees_the_structs_as_rust_does(&compile_cpp(&LAYOUT_PROGRAM));
    }
}

#[test]
fn the_header_declares_the_functions() {
    let header = std::fs::read_to_string(root().join("include/icoray.h")).unwrap();
    // A prototype is the only place where a name is followed by a bracket and not preceded by a comment's star.
    let code =
        header.lines().filter(|l| !l.trim_start().starts_with('*') && !l.trim_start().starts_with("/*"));
    let mut declared: Vec<&str> = code
        .filter_map(|line| line.split_once('(').map(|(before, _)| before))
        .filter_map(|before| before.rsplit([' ', '*']).next())
        .filter(|name| name.starts_with("icoray_"))
        .collect();
    declared.sort_unstable();
    assert_eq!(declared, FUNCTIONS);
}

#[test]
fn the_library_exports_its_functions_and_nothing_else() {
    if !has_tool(Need::Binutils, "nm") {
        return;
    }
    let output = succeeded(Command::new("nm").args(["-D", "--defined-only"]).arg(library()));
    let symbols = text(&output.stdout);
    let mut exported: Vec<&str> = symbols.lines().filter_map(|l| l.split_whitespace().last()).collect();
    exported.sort_unstable();
    assert_eq!(exported, FUNCTIONS);
}

#[test]
fn what_is_wrong_is_refused() {
    let directory = TempDir::new().unwrap();
    let program = compile_c(&REFUSALS);
    checked(command(program, directory.path()).arg(directory.path()), "refusals", 3000);
}

/// What C++ makes of the enum and the macros.
#[test]
fn what_is_wrong_is_refused_in_cpp() {
    if !has_tool(Need::Cxx, "c++") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = compile_cpp(&REFUSALS);
    checked(command(program, directory.path()).arg(directory.path()), "refusals", 3000);
}

#[test]
fn no_memory_is_misused_or_lost() {
    if !runs_long() || !has_tool(Need::Valgrind, "valgrind") {
        return;
    }
    let directory = TempDir::new().unwrap();
    // The C library's loader reads eight bytes at a time where it compares the names of a driver's folders.
    let known = directory.path().join("loader.supp");
    std::fs::write(&known, "{\n  loader\n  Memcheck:Addr8\n  fun:strncmp\n  fun:is_dst\n}\n").unwrap();
    let valgrind = |directory: &Path| {
        let mut command = command("valgrind", directory);
        command.arg(format!("--suppressions={}", known.display()));
        command.args(["--quiet", "--error-exitcode=99", "--leak-check=full"]);
        command.args(["--show-leak-kinds=definite", "--errors-for-leak-kinds=definite"]);
        command
    };
    let probe = compile_c(&LAYOUT_PROGRAM);
    if !runs(valgrind(directory.path()).arg(probe)) {
        return skip_because(Need::Valgrind, "it cannot run the simplest program");
    }
    let refusals = compile_c(&REFUSALS);
    checked(valgrind(directory.path()).arg(refusals).arg(directory.path()), "refusals", 3000);
    let pictures = compile_c(&PICTURES);
    checked(valgrind(directory.path()).arg(pictures).arg("out").args(["1", "16"]), "pictures", 3000);
}
