//! The Fortran module from outside: `include/icoray.f90` against the header, the library's layout and pictures.

use icoray_test_support::{Need, has_tool, runs_long};
use icoray_tests::interface::Interface;
use icoray_tests::layout::{LAYOUT, assert_layout_is_of_rust};
use icoray_tests::native::{ALLOCATES, checked, command, fortran, library, linked, root, succeeded, text, valgrind};
use icoray_tests::pictures::{count_colors, groups};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Warnings besides those of all programs.
const STRICT: [&str; 3] = ["-Wimplicit-interface", "-Wimplicit-procedure", "-Wcharacter-truncation"];

/// The sources of the program in `tests/fortran`, each after those it uses.
const PICTURES: [&str; 7] = ["check", "model", "layouts", "grids", "refusals", "scripts", "pictures"];

/// A directory for a test that needs the Fortran compiler. If there is none, skips the test.
fn directory() -> Option<TempDir> {
    has_tool(Need::Fortran, "gfortran").then(|| TempDir::new().unwrap())
}

/// Whether a program compiles with the module, and what the compiler says.
fn compiles(code: &str, directory: &Path) -> (bool, String) {
    let source = directory.join("checked.f90");
    std::fs::write(&source, code).unwrap();
    let output = gfortran(directory, &["-fsyntax-only", "-Wno-unused"]).arg(&source).output().unwrap();
    (output.status.success(), text(&output.stderr))
}

fn gfortran(directory: &Path, options: &[&str]) -> Command {
    fortran("gfortran", directory, &[&STRICT, options].concat())
}

/// Compiles the module and a program that uses it.
fn compile(sources: &[PathBuf], options: &[&str], directory: &Path) -> PathBuf {
    let program = directory.join("program");
    succeeded(gfortran(directory, options).args(sources).args(linked(library())).arg("-o").arg(&program));
    program
}

/// The program of the pictures.
fn compile_pictures(options: &[&str], directory: &Path) -> PathBuf {
    let sources = PICTURES.map(|name| root().join("tests/fortran").join(name).with_extension("f90"));
    compile(&sources, &[options, &ALLOCATES].concat(), directory)
}

#[test]
fn the_module_is_standard_fortran() {
    let Some(directory) = directory() else { return };
    for options in [["-O0", "-fcheck=all"], ["-O3", "-fopenmp"], ["-fdefault-integer-8", "-fdefault-real-8"]] {
        succeeded(gfortran(directory.path(), &options).args(["-c", "-o", "icoray.o"]));
    }
}

/// An array without TARGET could be a copy that is gone when icoray reads it; so the compiler must refuse it.
#[test]
fn arrays_that_cannot_be_read_in_place_do_not_compile() {
    let Some(directory) = directory() else { return };
    let program = |call: &str, attribute: &str, actual: &str| {
        let code = format!(
            "program actual\n use icoray\n real(kind(1d0)){attribute} :: q(4, 42)\n \
             type(icoray_context) :: ctx\n q = 0\n call {call}{actual})\nend program\n"
        );
        compiles(&code, directory.path())
    };
    for call in ["icoray_field_set(ctx, 'q', ", "icoray_heights_set(ctx, "] {
        for actual in ["q", "q(4:1:-1, :)", "q(:, ::2)", "q(1, :)"] {
            let (compiles, said) = program(call, ", target", actual);
            assert!(compiles, "{call}{actual}: {said}");
            assert!(!program(call, "", actual).0, "{call}{actual} without TARGET compiles");
        }
        let name = call.split('(').next().unwrap();
        for actual in ["q + 1", "(q)", "int(q)"] {
            let (compiles, said) = program(call, ", target", actual);
            assert!(!compiles && said.contains(name), "{call}{actual} compiles: {said}");
        }
    }
}

/// Own cells are declared in one way: calls without a declaration or with two do not compile, so no rank fails alone.
#[test]
fn own_cells_are_declared_in_one_way() {
    let Some(directory) = directory() else { return };
    for (arguments, is_good) in [
        ("n, ierr, owned=4", true),
        ("n, owned=4, grid='g'", true),
        ("w(::2), is_owned=m", true),
        ("n, ierr, is_owned=n(::-1), grid='g'", true),
        ("part, ierr", true),
        ("n, owned=4, corner_global=n, owned_corners=3", true),
        ("w(::2), ierr, is_owned=m, corner_global=w, is_corner_owned=m", true),
        ("n, is_owned=n, grid='g', corner_global=n, is_corner_owned=n", true),
        ("n, ierr, owned=4, corner_global=w, owned_corners=3", false),
        ("n, ierr, is_owned=m, corner_global=n, is_corner_owned=n", false),
        ("n, ierr", false),
        ("n, ierr, grid='g'", false),
        ("n, ierr, owned=4, is_owned=m", false),
        ("n, ierr, is_owned=w", false),
        ("r, ierr, owned=4", false),
    ] {
        let code = format!(
            "program parts\n use icoray\n use, intrinsic :: iso_c_binding\n integer(c_int32_t) :: n(9) = 0\n \
             integer(c_int64_t) :: w(17) = 0\n logical :: m(9) = .true.\n real :: r(9) = 0\n integer :: ierr\n \
             type(icoray_context) :: ctx\n type(icoray_part) :: part\n \
             call icoray_part_set(ctx, {arguments})\nend program\n"
        );
        let (compiles, said) = compiles(&code, directory.path());
        assert_eq!(compiles, is_good, "{arguments}: {said}");
        assert!(is_good || said.contains("icoray_part_set"), "{arguments}: {said}");
    }
}

#[test]
fn the_module_declares_the_items_of_the_header() {
    let header = std::fs::read_to_string(root().join("include/icoray.h")).unwrap();
    let module = std::fs::read_to_string(root().join("include/icoray.f90")).unwrap();
    let c = Interface::of_c(&header);
    let fortran = Interface::of_fortran(&module);
    assert!(c.functions.len() > 15 && c.structs.len() > 5 && c.constants.len() > 30, "{c:?}");
    assert_eq!(c.differences(&fortran), Vec::<String>::new());

    // Each of these changes is seen, and nothing else is.
    for (from, to, item) in [
        ("icoray_wants_c(ctx, step, time_s, wants)", "icoray_wants_c(ctx, step, wants)", "icoray_wants"),
        ("name='icoray_wait')", "name='icoray_waits')", "icoray_wait"),
        ("function icoray_close_c(ctx) bind", "function icoray_close_c(ctx) bind_not", "icoray_close"),
        (
            "integer(c_int32_t), value :: level\n      type(c_ptr), intent",
            "integer(c_int64_t), value :: level\n      type(c_ptr), intent",
            "icoray_mesh_create",
        ),
        ("type(c_ptr), intent(out) :: mesh", "type(c_ptr), value :: mesh", "icoray_mesh_create"),
        (
            "type(icoray_layers), intent(in) :: layers\n      integer(c_int32_t)",
            "type(icoray_grid), intent(in) :: layers\n      integer(c_int32_t)",
            "icoray_layers_set",
        ),
        ("type(icoray_frame_report), intent(inout)", "type(icoray_frame_report), intent(in)", "icoray_report"),
        ("integer(c_size_t), value :: len", "integer(c_size_t) :: len", "icoray_last_error"),
        ("integer(c_int64_t) :: count = 0", "integer(c_int32_t) :: count = 0", "icoray_layers"),
        ("when_full = 0, log_level = 0", "log_level = 0, when_full = 0", "icoray_config"),
        ("extent(ICORAY_MAX_RANK) = 0", "extent(4) = 0", "icoray_ndarray"),
        ("ICORAY_ERR_ORDER = 9", "ICORAY_ERR_ORDER = 19", "ICORAY_ERR_ORDER"),
        ("ICORAY_BLOCK = 0, ", "", "ICORAY_BLOCK"),
    ] {
        let changed = module.replacen(from, to, 1);
        assert_ne!(changed, module, "{from}");
        let differences = c.differences(&Interface::of_fortran(&changed));
        assert!(!differences.is_empty(), "{to} is not seen");
        assert!(differences.iter().all(|d| d.starts_with(item)), "{to}: {differences:?}");
    }
}

/// A program that prints, for each line of `layout.txt`, what the Fortran compiler makes of that name.
fn layout_program() -> String {
    let mut program = String::from(
        "program layout\n  use icoray\n  use, intrinsic :: iso_c_binding\n  implicit none\n  \
         print '(2a)', 'version ', icoray_version()\n",
    );
    let (mut variables, mut lines) = (String::new(), String::new());
    for line in LAYOUT.lines() {
        let (name, _) = line.split_once(' ').unwrap();
        let number = match name.split_once('.') {
            Some((of, member)) => format!("apart(c_loc(s_{of}), c_loc(s_{of}%{member}))"),
            None if name == "icoray_status" => "int(c_sizeof(icoray_close_c(none)))".into(),
            None if name.starts_with("ICORAY_") => name.into(),
            None => {
                writeln!(variables, "  type({name}), target :: s_{name}").unwrap();
                format!("int(c_sizeof(s_{name}))")
            }
        };
        writeln!(lines, "  print '(a, i0)', '{name} ', &\n    {number}").unwrap();
    }
    program = program.replace("  print", &format!("{variables}  type(c_ptr) :: none = c_null_ptr\n  print"));
    program
        + &lines
        + "contains\n  integer function apart(from, to)\n    type(c_ptr), intent(in) :: from, to\n    \
           apart = int(transfer(to, 0_c_intptr_t) - transfer(from, 0_c_intptr_t))\n  end function apart\n\
           end program layout\n"
}

#[test]
fn fortran_sees_the_structs_as_rust_does() {
    let Some(directory) = directory() else { return };
    let source = directory.path().join("layout.f90");
    std::fs::write(&source, layout_program()).unwrap();
    let program = compile(&[source], &["-O0"], directory.path());
    let output = succeeded(&mut command(program, directory.path()));
    assert_layout_is_of_rust(&text(&output.stdout));
}

/// Layouts, kinds and numberings make no difference to a picture; values do. Refusals are checked by the program.
#[test]
fn pictures_depend_on_values_and_nothing_else() {
    let Some(directory) = directory() else { return };
    let program = compile_pictures(&["-O1", "-fcheck=all"], directory.path());
    checked(command(program, directory.path()).arg("out").args(["3", "64"]), "pictures", 400);
    let within = |path: &Path| std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    let groups = groups(within(&directory.path().join("out")).flat_map(|path| within(&path)));
    let sizes: Vec<_> = groups.iter().map(|(name, group)| (name.as_str(), group.count)).collect();
    let expected = [
        ("backwards", 1),
        ("coarse", 1),
        ("corner", 3),
        ("missing", 2),
        ("negative", 2),
        ("once", 1),
        ("plain", 36),
        ("still", 3),
        ("year_0001", 2),
    ];
    assert_eq!(sizes, expected);
    for (name, group) in &groups {
        let colors = count_colors(&group.picture);
        assert!(colors > 50 || name == "coarse", "{name}: {colors} colours");
        for (other, others) in groups.iter().filter(|(other, _)| *other != name) {
            assert!(group.picture != others.picture, "{name} and {other} are the same");
        }
    }
}

/// The example compiles and draws, from the code that the README shows.
#[test]
fn the_example_draws_its_pictures() {
    let Some(directory) = directory() else { return };
    let example = root().join("examples/fortran/minimal.f90");
    let program = compile(&[example], &["-O2"], directory.path());
    let output = succeeded(&mut command(program, directory.path()));
    assert_eq!((text(&output.stdout).lines().count(), text(&output.stderr).as_str()), (4, ""));
    for step in [0, 10, 20, 30] {
        let picture = directory.path().join(format!("pictures/wave_{step}.png"));
        let picture = image::open(picture).unwrap().into_rgb8();
        assert_eq!(picture.dimensions(), (640, 480));
        // Red and blue on grey ground, and labels in white.
        let count = |shows: fn([u8; 3]) -> bool| picture.pixels().filter(|pixel| shows(pixel.0)).count();
        let [red, blue] = [count(|[r, _, b]| r > b.saturating_add(40)), count(|[r, _, b]| b > r.saturating_add(40))];
        assert!(red.min(blue) > 10_000, "step {step}: {red} red and {blue} blue pixels");
        assert!(count(|rgb| rgb.iter().all(|channel| *channel > 240)) > 100, "step {step}: no labels");
    }
}

#[test]
fn no_memory_is_misused_or_lost() {
    if !runs_long() || !has_tool(Need::Fortran, "gfortran") || !has_tool(Need::Valgrind, "valgrind") {
        return;
    }
    let directory = TempDir::new().unwrap();
    // As models are built whose integers have 64 bits.
    let program = compile_pictures(&["-O1", "-g", "-fdefault-integer-8"], directory.path());
    let mut valgrind = valgrind(directory.path());
    checked(valgrind.arg(program).arg("out").args(["1", "16"]), "pictures", 400);
}
