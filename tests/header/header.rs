//! Checked-in files equal those that their sources generate: the interfaces of C and Fortran from `crates/icoray-capi`,
//! and the figures of a frame in Python's types and the book from the list of `icoray-output`.

use icoray_output::figures::{ABOUT, FIGURES, Figure, Scope};
use minijinja::context;
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Checks that the file at `path` is `generated`, or writes it.
fn check(path: &str, generated: &str) {
    let file = root().join(path);
    if std::env::var_os("ICORAY_WRITE_HEADER").is_some() {
        std::fs::write(&file, generated).unwrap();
    }
    let checked_in = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        checked_in == generated,
        "{path} is stale; write it anew with ICORAY_WRITE_HEADER=1 cargo test -p icoray-header-test"
    );
}

/// Checks that the lines between two lines of the file at `path` are `generated`, or writes them.
fn check_between(path: &str, [first, last]: [&str; 2], generated: &str) {
    let page = std::fs::read_to_string(root().join(path)).unwrap();
    let (head, others) = page.split_once(first).unwrap();
    let (_, tail) = others.split_once(last).unwrap();
    check(path, &format!("{head}{first}\n{generated}{last}{tail}"));
}

/// The figures that C has.
fn c_figures() -> impl Iterator<Item = (&'static Figure, &'static str)> {
    FIGURES.iter().filter_map(|figure| Some((figure, figure.c_type?)))
}

/// The declaration of the report, which a macro hides from cbindgen.
fn report_source() -> String {
    let comment = |text: &str| text.lines().map(|line| format!("///{line}\n")).collect::<String>();
    let mut source = comment(ABOUT) + "#[repr(C)]\npub struct icoray_frame_report {\n";
    source += "/// sizeof(icoray_frame_report)\npub struct_size: usize,\n";
    for (figure, c_type) in c_figures() {
        writeln!(source, "{}pub {}: {c_type},", comment(figure.meaning), figure.name).unwrap();
    }
    source + "}\n"
}

#[test]
fn header_is_current() {
    let capi = root().join("crates/icoray-capi");
    let mut report = tempfile::NamedTempFile::with_suffix(".rs").unwrap();
    std::io::Write::write_all(&mut report, report_source().as_bytes()).unwrap();
    let config = cbindgen::Config::from_file(capi.join("cbindgen.toml")).unwrap();
    let builder = cbindgen::Builder::new().with_src(report.path()).with_crate(capi).with_config(config);
    let mut text = Vec::new();
    builder.generate().unwrap().write(&mut text);
    check("include/icoray.h", &String::from_utf8(text).unwrap());
}

#[test]
fn fortran_module_is_current() {
    let mut environment = minijinja::Environment::new();
    let mut syntax = minijinja::syntax::SyntaxConfig::builder();
    syntax.trim_blocks(true).lstrip_blocks(true).keep_trailing_newline(true);
    environment.set_syntax(syntax.build().unwrap());
    environment.set_undefined_behavior(minijinja::UndefinedBehavior::Strict);
    let template = std::fs::read_to_string(root().join("crates/icoray-capi/icoray.f90.jinja")).unwrap();
    let lines = |text: &'static str| text.lines().map(str::trim_start).collect::<Vec<_>>();
    let figures = c_figures().map(|(figure, c_type)| {
        let kind = match c_type {
            "f64" => "real(c_double)",
            "i32" => "integer(c_int32_t)",
            _ => "integer(c_int64_t)",
        };
        context! { name => figure.name, type => kind, meaning => lines(figure.meaning) }
    });
    let values = context! { about => lines(ABOUT), figures => figures.collect::<Vec<_>>() };
    let module = environment.render_named_str("icoray.f90.jinja", &template, values);
    check("include/icoray.f90", &module.unwrap_or_else(|error| panic!("{error:#}")));
}

#[test]
fn the_types_of_python_have_all_figures() {
    let class = |name: &str, is_in: fn(&Figure) -> bool| {
        let mut lines = format!("@type_check_only\nclass {name}(TypedDict):\n");
        for figure in FIGURES.iter().filter(|figure| is_in(figure)) {
            writeln!(lines, "    {}: {}", figure.name, figure.kind.python).unwrap();
        }
        lines
    };
    let image = class("_Report", |figure| figure.scope >= Scope::Frame);
    let context = class("_ContextReport", |figure| figure.c_type.is_some());
    let path = "crates/icoray-python/python/icoray/_icoray.pyi";
    check_between(path, ["# Figures of a frame.", "# End of figures."], &format!("{image}\n{context}"));
}

#[test]
fn the_book_lists_all_figures() {
    let mut table = String::from("| figure | where | what it is |\n|---|---|---|\n");
    for figure in FIGURES {
        let meaning = figure.meaning.replace("\n", "");
        let place = match (figure.scope, figure.c_type) {
            (Scope::Host, _) => "model",
            (_, Some(_)) => "everywhere",
            (_, None) => "frame",
        };
        writeln!(table, "| `{}` | {place} |{meaning} |", figure.name).unwrap();
    }
    check_between("docs/src/reports.md", ["<!-- figures -->", "<!-- end -->"], &table);
}
