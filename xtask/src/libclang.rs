//! libclang, with which MPI's header is read for Rust: a library alone, without a program that could be asked for it.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;

/// Whether the library is where bindgen looks for it.
pub fn is_there() -> bool {
    if let Some(path) = env::var_os("LIBCLANG_PATH") {
        return PathBuf::from(path).exists();
    }
    let libraries = |directory: &str| fs::read_dir(directory).ok().map(|found| found.flatten());
    let is_libclang = |name: &OsStr| {
        let name = name.to_string_lossy();
        name.starts_with("libclang.so") || name.starts_with("libclang-") && name.contains(".so")
    };
    // Debian keeps a version's in a directory of its own, and the unversioned name only there.
    let versions = libraries("/usr/lib").into_iter().flatten().filter_map(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        name.starts_with("llvm-").then(|| format!("/usr/lib/{name}/lib"))
    });
    let triple = format!("/usr/lib/{}-linux-gnu", env::consts::ARCH);
    let places = ["/usr/lib".into(), "/usr/lib64".into(), "/usr/local/lib".into(), triple];
    let mut entries =
        places.into_iter().chain(versions).filter_map(|place: String| libraries(&place)).flatten();
    entries.any(|entry| is_libclang(&entry.file_name()))
}
