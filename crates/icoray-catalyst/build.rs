//! Link options of the shared library that cargo builds for tests; `cargo xtask install` links the installed one.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libcatalyst-icoray.so");
    println!("cargo::rustc-cdylib-link-arg=-Wl,--exclude-libs,ALL");
    // The functions of the C interface that it has inside are its own, also where the host links another libicoray.
    println!("cargo::rustc-cdylib-link-arg=-Wl,-Bsymbolic");
}
