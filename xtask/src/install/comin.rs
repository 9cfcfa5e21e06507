//! Compiles the plugin for ICON against the `comin.h` of the user's ICON.

use std::path::{Path, PathBuf};

use xshell::cmd;

use super::library as check;
use crate::error::Error;
use crate::step::Step;
use crate::workspace::{Workspace, variable};

pub const PLUGIN: &str = "libicoray_comin.so";
const SOURCES: &str = "crates/icoray-comin";

/// The directories of an installed ComIn.
#[derive(Debug, PartialEq)]
pub struct Comin {
    include: PathBuf,
    libraries: PathBuf,
}

impl Comin {
    /// Finds header and library below a prefix.
    pub fn find(prefix: &Path) -> Result<Self, Error> {
        let include = prefix.join("include");
        let lack = |what: &str| {
            Error(format!(
                "--comin {}: {what}; expected the prefix where ComIn was installed (CMAKE_INSTALL_PREFIX). That of ICON's \
                 externals/comin is static and not installed: docs/src/comin.md has the commands that build a shared one",
                prefix.display()
            ))
        };
        if !include.join("comin.h").is_file() {
            return Err(lack("no include/comin.h there"));
        }
        let places = ["lib", "lib64"].map(|name| prefix.join(name));
        let libraries = places.into_iter().find(|place| place.join("libcomin.so").exists());
        let libraries = libraries.ok_or_else(|| lack("no lib/libcomin.so there"))?;
        Ok(Comin { include, libraries })
    }

    /// Compiles the plugin, which finds `library` beside itself when it is installed.
    pub fn build(&self, workspace: &Workspace, library: &Path, step: &mut Step) -> Result<PathBuf, Error> {
        let (sh, Comin { include, libraries }) = (&workspace.shell, self);
        let plugin = library.with_file_name(PLUGIN);
        let compiler = variable("CC").unwrap_or_else(|| "cc".into());
        let sources = ["clock.c", "grid.c", "host.c", "plugin.c"].map(|name| format!("{SOURCES}/src/{name}"));
        // comin.h of 0.2 defines tables of all functions of ComIn, which the plugin does not need.
        let sections = ["-fdata-sections", "-Wl,--gc-sections"];
        step.quiet(cmd!(
            sh,
            "{compiler} -std=c99 -O2 -Wall -fPIC -shared {sections...} -isystem {include} -Iinclude -o {plugin}
             {sources...} -Wl,--version-script={SOURCES}/exports.map {library} -L{libraries} -lcomin
             -Wl,-rpath,$ORIGIN:{libraries} -lm"
        ))?;
        step.quiet(check(workspace, "names", &plugin).arg("comin_main")).map(|()| plugin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use xshell::Shell;

    #[test]
    fn a_prefix_has_header_and_library() {
        let sh = Shell::new().unwrap();
        let prefix = sh.create_temp_dir().unwrap();
        let prefix = prefix.path();
        let message = |found: Result<Comin, Error>| found.unwrap_err().to_string();
        assert!(message(Comin::find(prefix)).contains("no include/comin.h there; expected the prefix"));
        sh.write_file(prefix.join("include/comin.h"), "").unwrap();
        assert!(message(Comin::find(prefix)).contains("no lib/libcomin.so there"));
        sh.write_file(prefix.join("lib64/libcomin.so"), "").unwrap();
        let found = Comin { include: prefix.join("include"), libraries: prefix.join("lib64") };
        assert_eq!(Comin::find(prefix), Ok(found));
    }
}
