//! The C ABI from outside: C programs against `include/icoray.h` and the shared library.

mod pictures;

use icoray_test_support::{Need, has_tool, runs, runs_long, skip_because};
use icoray_tests::interface::Interface;
use icoray_tests::layout::{LAYOUT, assert_is_rust, assert_layout_is_of_rust};
use icoray_tests::native::{checked, command, compile, compile_c, library, root, succeeded, text, valgrind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use tempfile::TempDir;

/// The functions without `icoray_`, in the order of the alphabet.
const FUNCTIONS: &str = "close execute field_describe field_set field_set_ndarray grid_set heights_set \
    heights_set_ndarray last_error layers_set log_stderr mesh_create mesh_free mesh_grid open \
    open_serial part_set points_set refuse report scene_field scene_load scene_text version wait wants wants_field";
const VIEWS: [&str; 3] = ["views", "pictures_common", "check"];

/// Path without `.c` of a program that prints, for each line of `layout.txt`, what the C compiler makes of that name.
static LAYOUT_PROGRAM: LazyLock<String> = LazyLock::new(|| {
    let print = |line: &str| {
        let name = line.split_once(' ').unwrap().0;
        let number = match name.split_once('.') {
            Some((of, member)) => format!("offsetof({of}, {member})"),
            None if name.starts_with("ICORAY_") => name.into(),
            None => format!("sizeof({name})"),
        };
        format!("printf(\"{name} %d\\n\", (int)({number}));\n")
    };
    let code = format!(
        "#include <icoray.h>\n#include <stddef.h>\n#include <stdio.h>\nint main(void)\n{{\n\
         printf(\"version %s\\n\", icoray_version());\n{}return 0;\n}}\n",
        LAYOUT.lines().map(print).collect::<String>()
    );
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("layout");
    std::fs::write(path.with_extension("c"), code).unwrap();
    path.to_str().unwrap().into()
});

fn functions() -> Vec<String> {
    FUNCTIONS.split(' ').map(|name| format!("icoray_{name}")).collect()
}

/// Compiles the program of the files of `tests/c` whose names begin with `name`, and of `check`.
fn compile_all(name: &str, compile: fn(&[&str]) -> PathBuf) -> PathBuf {
    let files = std::fs::read_dir(root().join("tests/c")).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let stems = names.filter_map(|name| name.strip_suffix(".c").map(str::to_owned));
    let mut stems: Vec<String> = stems.filter(|stem| stem.starts_with(name)).collect();
    stems.sort();
    let sources: Vec<&str> = stems.iter().map(String::as_str).chain(["check"]).collect();
    compile(&sources)
}

fn compile_cpp(sources: &[&str]) -> PathBuf {
    compile("c++", &["-std=c++11", "-x", "c++"], sources)
}

/// Fails unless `program` prints the version and Rust's layout of the structs.
fn sees_the_structs_as_rust_does(program: &Path) {
    let directory = TempDir::new().unwrap();
    let output = succeeded(&mut command(program, directory.path()));
    assert_eq!(text(&output.stderr), "");
    assert_layout_is_of_rust(&text(&output.stdout));
}

#[test]
#[cfg(target_pointer_width = "64")]
fn the_structs_are_those_of_earlier_versions() {
    assert_is_rust(LAYOUT);
}

#[test]
fn c_sees_the_structs_as_rust_does() {
    sees_the_structs_as_rust_does(&compile_c(&[&LAYOUT_PROGRAM]));
}

#[test]
fn cpp_sees_the_structs_as_rust_does() {
    if has_tool(Need::Cxx, "c++") {
        sees_the_structs_as_rust_does(&compile_cpp(&[&LAYOUT_PROGRAM]));
    }
}

#[test]
fn the_header_declares_the_functions() {
    let header = std::fs::read_to_string(root().join("include/icoray.h")).unwrap();
    assert_eq!(Interface::of_c(&header).functions.into_keys().collect::<Vec<_>>(), functions());
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
    assert_eq!(exported, functions());
}

fn refuses_wrong_calls(program: &Path) {
    let directory = TempDir::new().unwrap();
    checked(command(program, directory.path()).arg(directory.path()), "refusals", 3000);
}

#[test]
fn wrong_calls_are_refused() {
    refuses_wrong_calls(&compile_all("refusals", compile_c));
}

/// What C++ makes of the enum and the macros.
#[test]
fn wrong_calls_are_refused_in_cpp() {
    if has_tool(Need::Cxx, "c++") {
        refuses_wrong_calls(&compile_all("refusals", compile_cpp));
    }
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
        let mut command = valgrind(directory);
        command.arg(format!("--suppressions={}", known.display()));
        command
    };
    let probe = compile_c(&[&LAYOUT_PROGRAM]);
    if !runs(valgrind(directory.path()).arg(probe)) {
        return skip_because(Need::Valgrind, "it cannot run the simplest program");
    }
    let refusals = compile_all("refusals", compile_c);
    checked(valgrind(directory.path()).arg(refusals).arg(directory.path()), "refusals", 3000);
    let pictures = compile_all("pictures", compile_c);
    checked(valgrind(directory.path()).arg(pictures).arg("out").args(["1", "16"]), "pictures", 3000);
}
