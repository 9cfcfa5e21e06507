//! The static library made fit to be linked with anything.
//!
//! What rustc writes is a hundred objects whose symbols all clash with those of any other Rust static library: the
//! standard library's, the personality routine's, those of dependencies that export unmangled names. It also has their
//! debug information. Here what the library's functions need of it is linked into one object, in which only these
//! functions stay visible: a third of the size, and its Rust is nobody else's.

use std::fs;
use std::path::{Path, PathBuf};

use crate::elf;
use crate::error::Error;
use crate::step::Step;
use crate::workspace::Workspace;

/// Bitcode of the standard library. Nobody can use it once it is joined, and plugins of the binutils that meet it fail.
const BITCODE: [&str; 2] = ["--remove-section=.llvmbc", "--remove-section=.llvmcmd"];

/// Makes an archive of what `functions` need of `archive`, in `directory`.
pub fn reduce(
    workspace: &Workspace,
    archive: &Path,
    functions: &[String],
    directory: &Path,
    step: &mut Step,
) -> Result<PathBuf, Error> {
    let failed = |what: &Path| Error::while_doing(what.display().to_string());
    fs::create_dir_all(directory).map_err(failed(directory))?;
    let (joined, object) = (directory.join("joined.o"), directory.join("icoray.o"));

    // GNU's linker by its own name: others cannot leave out what is not needed from a relocatable object.
    let mut link = workspace.command("ld.bfd");
    link.args(["-r", "--gc-sections", "--force-group-allocation", "-o"]).arg(&joined);
    for function in functions {
        link.arg(format!("--undefined={function}"));
    }
    step.quiet(link.arg(archive))?;

    let mut hide = workspace.command("objcopy");
    hide.arg("--strip-debug").args(BITCODE);
    hide.args(functions.iter().map(|function| format!("--keep-global-symbol={function}")));
    step.quiet(hide.arg(&joined).arg(&object))?;

    let reduced = directory.join("libicoray.a");
    // An archive that is there would be added to.
    if reduced.exists() {
        fs::remove_file(&reduced).map_err(failed(&reduced))?;
    }
    // Without dates and users, so that the same library is the same file.
    step.quiet(workspace.command("ar").arg("rcsD").arg(&reduced).arg(&object))?;
    elf::same_names("the static library shows", &elf::defined(&reduced, &[])?, functions)?;
    Ok(reduced)
}
