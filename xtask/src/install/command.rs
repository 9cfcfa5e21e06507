//! Builds the command `icoray`, with its completions and manual pages.

use std::fs;
use std::path::{Path, PathBuf};

use xshell::cmd;

use crate::error::Error;
use crate::libclang;
use crate::step::Step;
use crate::workspace::Workspace;

/// Completions by shell, below the prefix.
const COMPLETIONS: [(&str, &str); 3] = [
    ("bash", "share/bash-completion/completions/icoray"),
    ("zsh", "share/zsh/site-functions/_icoray"),
    ("fish", "share/fish/vendor_completions.d/icoray.fish"),
];

/// A built file, its path below the prefix, and its permissions.
pub type Placed = (PathBuf, PathBuf, u32);

/// Builds the command as the library for C is built, with MPI or without, and with GPUs or without.
pub fn build(
    workspace: &Workspace,
    profile: &str,
    mpi: bool,
    gpu: bool,
    step: &mut Step,
) -> Result<Vec<Placed>, Error> {
    let mut cargo = workspace.cargo(["build", "--package", "icoray-cli", "--profile", profile]);
    cargo = cargo.args((!gpu).then_some("--no-default-features")).args(mpi.then_some("--features=mpi"));
    if mpi {
        cargo = cargo.envs(libclang::variable());
    }
    step.quiet(cargo)?;
    let products = workspace.products(profile);
    files(workspace, products.join("icoray"), &products.join("manual"))
}

/// The files of a built command; manual pages are written to `manual` first, completions to its folder.
fn files(workspace: &Workspace, program: PathBuf, manual: &Path) -> Result<Vec<Placed>, Error> {
    let sh = &workspace.shell;
    cmd!(sh, "{program} manual {manual}").quiet().run()?;
    let mut files = Vec::new();
    for page in sh.read_dir(manual)? {
        let name = page.file_name().unwrap_or_default().to_owned();
        files.push((page, Path::new("share/man/man1").join(name), 0o644));
    }
    for (shell, path) in COMPLETIONS {
        let file = manual.with_file_name(format!("icoray.{shell}"));
        fs::write(&file, cmd!(sh, "{program} completions {shell}").quiet().read()?)
            .map_err(Error::while_doing(file.display()))?;
        files.push((file, path.into(), 0o644));
    }
    files.push((program, "bin/icoray".into(), 0o755));
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_and_completions_go_where_man_and_shells_look() {
        let workspace = Workspace::find().unwrap();
        let sh = &workspace.shell;
        let scratch = sh.create_temp_dir().unwrap();
        let program = scratch.path().join("icoray");
        // Written by another process: one that another test starts would hold a file open that this one writes.
        let script =
            "#!/bin/sh\ncase $1 in manual) mkdir \"$2\"; echo page >\"$2/icoray.1\" ;; *) echo \"$*\" ;; esac\n";
        let write = "printf %s \"$2\" >\"$1\" && chmod +x \"$1\"";
        cmd!(sh, "sh -c {write} sh {program} {script}").quiet().run().unwrap();
        let files = files(&workspace, program, &scratch.path().join("manual")).unwrap();
        let placed: Vec<_> =
            files.iter().map(|(file, path, _)| (path.to_str().unwrap(), sh.read_file(file).unwrap())).collect();
        let expected = [
            ("share/man/man1/icoray.1", "page\n".to_owned()),
            (COMPLETIONS[0].1, "completions bash".to_owned()),
            (COMPLETIONS[1].1, "completions zsh".to_owned()),
            (COMPLETIONS[2].1, "completions fish".to_owned()),
            ("bin/icoray", script.to_owned()),
        ];
        assert_eq!(placed, expected);
    }
}
