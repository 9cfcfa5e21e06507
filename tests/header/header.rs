//! The checked-in header is what cbindgen makes of the sources.

use std::path::Path;

#[test]
fn header_is_current() {
    let here = &Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/icoray-capi");
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::Builder::new().with_crate(here).with_config(config).generate().unwrap();
    let mut text = Vec::new();
    bindings.write(&mut text);
    let generated = String::from_utf8(text).unwrap();
    let path = here.join("../../include/icoray.h");
    if std::env::var_os("ICORAY_WRITE_HEADER").is_some() {
        std::fs::write(&path, &generated).unwrap();
    }
    let checked_in = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        checked_in == generated,
        "include/icoray.h is stale; write it anew with ICORAY_WRITE_HEADER=1 cargo test -p icoray-header-test"
    );
}
