//! The files of the installation for pkg-config and CMake, from templates in `crates/icoray-capi/install`.

use std::path::Path;

use crate::install::{SONAME, VERSION};

/// The paths of the files below the directory of the libraries, and their templates. The static library has an archive
/// of its own name for pkg-config.
pub const FILES: [(&str, &str); 4] = [
    ("pkgconfig/icoray.pc", include_str!("../../../crates/icoray-capi/install/icoray.pc.in")),
    ("pkgconfig/icoray-static.pc", include_str!("../../../crates/icoray-capi/install/icoray-static.pc.in")),
    ("cmake/icoray/icorayConfig.cmake", include_str!("../../../crates/icoray-capi/install/icorayConfig.cmake.in")),
    (
        "cmake/icoray/icorayConfigVersion.cmake",
        include_str!("../../../crates/icoray-capi/install/icorayConfigVersion.cmake.in"),
    ),
];

/// System libraries that the static library needs. Newer C libraries contain the last two, and have empty ones of these
/// names. Compilers add the unwinder, libgcc_s or libgcc_eh.
const SYSTEM_LIBS: [&str; 3] = ["m", "pthread", "dl"];

/// A template with its values, for libraries in `libdir`.
pub fn filled(template: &str, libdir: &Path) -> String {
    let depth = libdir.components().count();
    // The way from libdir/pkgconfig or libdir/cmake/icoray to the prefix.
    let up = |below: usize| vec![".."; depth + below].join("/");
    let values = [
        ("@UP@", up(1)),
        ("@CMAKE_UP@", up(2)),
        ("@LIBDIR@", libdir.display().to_string()),
        ("@VERSION@", VERSION.into()),
        ("@MAJOR@", env!("CARGO_PKG_VERSION_MAJOR").into()),
        ("@MINOR@", env!("CARGO_PKG_VERSION_MINOR").into()),
        ("@SONAME@", SONAME.into()),
        ("@SHARED@", super::shared_name()),
        ("@SYSTEM_LIBS@", SYSTEM_LIBS.map(|name| format!("-l{name}")).join(" ")),
        ("@CMAKE_SYSTEM_LIBS@", SYSTEM_LIBS.join(";")),
        ("@POINTER_BYTES@", size_of::<usize>().to_string()),
    ];
    values.iter().fold(template.to_owned(), |text, (name, value)| text.replace(name, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_is_filled_in_for_any_depth() {
        for (_, template) in FILES {
            let text = filled(template, Path::new("lib"));
            let left = text.lines().find(|line| line.split_once('@').is_some_and(|(_, rest)| rest.contains('@')));
            // A makefile's $@ stands alone on its line.
            assert_eq!(left, None);
        }
        for (libdir, up) in [("lib", "/../..\n"), ("lib/x86_64-linux-gnu", "/../../..\n")] {
            let text = filled(FILES[0].1, Path::new(libdir));
            assert!(text.contains(&format!("\nprefix=${{pcfiledir}}{up}")), "{text}");
        }
        let cmake = filled(FILES[2].1, Path::new("lib64"));
        assert!(cmake.contains("${CMAKE_CURRENT_LIST_DIR}/../../..\""), "{cmake}");
        assert!(cmake.contains(&format!("/lib64/libicoray.so.{VERSION}\"")), "{cmake}");
    }
}
