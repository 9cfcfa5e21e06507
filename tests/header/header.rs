//! The checked-in interfaces of C and Fortran are what their sources in `crates/icoray-capi` generate.

use std::path::{Path, PathBuf};

fn capi() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/icoray-capi")
}

/// Checks that `include/NAME` is `generated`, or writes it.
fn check(name: &str, generated: &str) {
    let path = capi().join("../../include").join(name);
    if std::env::var_os("ICORAY_WRITE_HEADER").is_some() {
        std::fs::write(&path, generated).unwrap();
    }
    let checked_in = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        checked_in == generated,
        "include/{name} is stale; write it anew with ICORAY_WRITE_HEADER=1 cargo test -p icoray-header-test"
    );
}

#[test]
fn header_is_current() {
    let config = cbindgen::Config::from_file(capi().join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::Builder::new().with_crate(capi()).with_config(config).generate().unwrap();
    let mut text = Vec::new();
    bindings.write(&mut text);
    check("icoray.h", &String::from_utf8(text).unwrap());
}

#[test]
fn fortran_module_is_current() {
    let mut environment = minijinja::Environment::new();
    let mut syntax = minijinja::syntax::SyntaxConfig::builder();
    syntax.trim_blocks(true).lstrip_blocks(true).keep_trailing_newline(true);
    environment.set_syntax(syntax.build().unwrap());
    environment.set_undefined_behavior(minijinja::UndefinedBehavior::Strict);
    let template = std::fs::read_to_string(capi().join("icoray.f90.jinja")).unwrap();
    let module = environment.render_named_str("icoray.f90.jinja", &template, ());
    check("icoray.f90", &module.unwrap_or_else(|error| panic!("{error:#}")));
}
