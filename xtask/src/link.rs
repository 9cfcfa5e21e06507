//! Installs the library as a package does, counts its instructions (`tests/link/instructions.sh`), and links programs
//! with it as models do (`tests/link/link.sh`).
//!
//! The installation is moved away from its prefix, so it works only if its files find each other by relative paths.

use std::fs;

use crate::check::{Record, has_program};
use crate::error::Error;
use crate::install::{self, Layout, SONAME};
use crate::step::Step;
use crate::workspace::Workspace;

pub fn check(workspace: &Workspace, step: &mut Step, record: &mut Record) -> Result<(), Error> {
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
    let script =
        |name: &str| sh.cmd("bash").arg(workspace.root.join("tests/link").join(name)).arg(&workspace.root).arg(&root);
    if has_program("valgrind", record)? {
        let _in = sh.push_dir(sh.create_dir(scratch.join("instructions"))?);
        step.quiet(script("instructions.sh"))?;
        record.tally.add_whole(true);
    }
    let _in = sh.push_dir(sh.create_dir(scratch.join("programs"))?);
    step.quiet(script("link.sh").arg(SONAME))?;
    record.tally.add_whole(true);
    Ok(())
}
