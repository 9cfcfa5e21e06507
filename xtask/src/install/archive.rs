//! Reduces the static library so that it can be linked with any other.
//!
//! rustc writes a hundred objects whose symbols clash with those of any other Rust static library: those of the
//! standard library, of the personality routine, and of dependencies that export unmangled names; and their debug
//! information. Here the code that the library's functions need is linked into one object, in which only these
//! functions stay visible: a third of the size, without clashes.

use std::path::{Path, PathBuf};

use xshell::cmd;

use crate::elf;
use crate::error::Error;
use crate::step::Step;
use crate::workspace::Workspace;

/// Makes an archive of the code that `functions` need of `archive`, in `directory`.
pub fn reduce(
    workspace: &Workspace,
    archive: &Path,
    functions: &[String],
    directory: &Path,
    step: &mut Step,
) -> Result<PathBuf, Error> {
    let sh = &workspace.shell;
    sh.create_dir(directory)?;
    let [joined, object, reduced] = ["joined.o", "icoray.o", "libicoray.a"].map(|name| directory.join(name));
    // GNU's linker by its own name: other linkers cannot drop unused sections of a relocatable object.
    let undefined = functions.iter().map(|function| format!("--undefined={function}"));
    step.quiet(cmd!(sh, "ld.bfd -r --gc-sections --force-group-allocation -o {joined} {undefined...} {archive}"))?;
    // The bitcode of the standard library is unusable once joined, and plugins of the binutils fail on it.
    let keep = functions.iter().map(|function| format!("--keep-global-symbol={function}"));
    step.quiet(cmd!(
        sh,
        "objcopy --strip-debug --remove-section=.llvmbc --remove-section=.llvmcmd {keep...} {joined} {object}"
    ))?;
    // `ar` would add to an archive that exists; `D` leaves out dates and users, so that builds are reproducible.
    sh.remove_path(&reduced)?;
    step.quiet(cmd!(sh, "ar rcsD {reduced} {object}"))?;
    elf::check_names(&reduced, &[], functions)?;
    Ok(reduced)
}
