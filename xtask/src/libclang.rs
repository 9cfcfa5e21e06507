//! libclang, with which bindgen reads MPI's header: a library, and clang's own headers of the same version.
//!
//! bindgen finds Debian's by itself, but takes the library of the highest version even where its headers are missing
//! (libclang1-15 beside libclang-14-dev). `libclang-cpp.so` is another library.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use crate::files;
use crate::workspace::variable as environment;

/// Fails unless there is a libclang with its headers, or one that LIBCLANG_PATH names.
pub fn check() -> Result<(), String> {
    match environment("LIBCLANG_PATH").map(PathBuf::from) {
        Some(path) if path.is_file() || has_library(&path) => Ok(()),
        Some(path) => Err(format!("LIBCLANG_PATH is {}, where no libclang.so is", path.display())),
        None if complete(Path::new("/")).is_some() => Ok(()),
        None => Err("no libclang.so with clang's own headers was found below /usr; LIBCLANG_PATH may name one".into()),
    }
}

/// The environment variable by which bindgen takes the complete libclang, where it would choose another.
pub fn variable() -> Option<(&'static str, PathBuf)> {
    let is_set = environment("LIBCLANG_PATH").is_some();
    let (directory, _) = complete(Path::new("/")).filter(|(_, is_first)| !is_set && !is_first)?;
    Some(("LIBCLANG_PATH", directory))
}

/// The directory of the newest libclang that has its headers, and whether it is the newest of all.
fn complete(root: &Path) -> Option<(PathBuf, bool)> {
    let mut directories = files::fitting(root, "usr/lib/llvm-*/lib");
    directories.sort_by_key(|directory| Reverse(version(directory)));
    directories.extend(["usr/lib64", "usr/lib", "usr/local/lib"].map(|path| root.join(path)));
    directories.retain(|directory| has_library(directory));
    let found = directories.iter().position(|directory| {
        ["clang", "../lib/clang"].iter().any(|below| exists(&directory.join(below), "*/include/stddef.h"))
    })?;
    Some((directories.swap_remove(found), found == 0))
}

fn has_library(directory: &Path) -> bool {
    exists(directory, "libclang.so*") || exists(directory, "libclang-[0-9]*.so*")
}

fn exists(directory: &Path, pattern: &str) -> bool {
    !files::fitting(directory, pattern).is_empty()
}

/// N of `llvm-N/lib`.
fn version(directory: &Path) -> Option<u32> {
    directory.parent()?.file_name()?.to_str()?.strip_prefix("llvm-")?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_library_with_headers_is_taken() {
        let sh = xshell::Shell::new().unwrap();
        let root = sh.create_temp_dir().unwrap();
        let root = root.path();
        let add = |path: &str| sh.write_file(root.join("usr/lib").join(path), "").unwrap();
        let found = || complete(root).map(|(path, is_first)| (path.display().to_string(), is_first));
        add("llvm-14/lib/libclang-cpp.so.14");
        add("llvm-14/lib/clang/14.0.6/include/stddef.h");
        assert_eq!(found(), None, "libclang-cpp.so is another library");
        add("llvm-9/lib/libclang.so.1");
        assert_eq!(found(), None, "headers of another version");
        add("llvm-14/lib/libclang-14.so.1");
        let complete = root.join("usr/lib/llvm-14/lib").display().to_string();
        assert_eq!(found(), Some((complete.clone(), true)));
        add("llvm-15/lib/libclang.so.1");
        assert_eq!(found(), Some((complete, false)));
    }
}
