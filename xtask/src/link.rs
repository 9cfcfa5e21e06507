//! Installs the library as a package does, and links programs with it as models do: `tests/link/link.sh`.
//!
//! The installation is moved away from its prefix, so it works only if its files find each other by relative paths.

use std::fs;

use crate::error::Error;
use crate::install::{self, Layout, SONAME};
use crate::step::Step;
use crate::workspace::Workspace;

/// The check.
pub fn check(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let scratch = workspace.products("tmp").join("link");
    workspace.shell.remove_path(&scratch)?;
    let layout = Layout { prefix: "/opt/icoray".into(), libdir: "lib".into(), destdir: Some(scratch.join("a place")) };
    let built = install::build(workspace, false, true, step)?;
    install::install(workspace, &built, &layout)?;
    step.quiet(install::check_shared(workspace, &layout.root().join("lib").join(SONAME), false))?;

    // Not below "a place": the shell splits the flags that pkg-config prints at blanks.
    let root = scratch.join("prefix");
    fs::rename(layout.root(), &root).map_err(Error::while_doing(root.display()))?;
    let sh = &workspace.shell;
    let _in = sh.push_dir(sh.create_dir(scratch.join("programs"))?);
    let script = workspace.root.join("tests/link/link.sh");
    step.quiet(sh.cmd("bash").arg(script).arg(&workspace.root).arg(root).arg(SONAME))
}
