//! `icoray manual`: manual pages and completions for shells, generated from the options.

use crate::failure::CommandResult;
use clap_complete::Shell;
use icoray::{Error, ErrorKind};
use std::io;
use std::path::{Path, PathBuf};

/// The files in which shells look for completions.
const COMPLETIONS: [(Shell, &str); 3] = [
    (Shell::Bash, "bash-completion/completions/icoray"),
    (Shell::Zsh, "zsh/site-functions/_icoray"),
    (Shell::Fish, "fish/vendor_completions.d/icoray.fish"),
];

/// Arguments of `icoray manual`.
#[derive(clap::Args)]
pub struct Args {
    /// Directory of shared files, such as ~/.local/share or /usr/local/share
    #[arg(value_name = "DIR")]
    directory: PathBuf,
}

/// Writes a manual page of each command, and completions for each shell.
pub fn run(args: &Args, command: clap::Command) -> CommandResult {
    let directory = &args.directory;
    let failed = |e| Error::new(ErrorKind::Io, format!("{}: cannot write the manual: {e}", directory.display()));
    Ok(write(directory, command).map_err(failed)?)
}

fn write(directory: &Path, mut command: clap::Command) -> io::Result<()> {
    let pages = directory.join("man/man1");
    std::fs::create_dir_all(&pages)?;
    // Before the completions, for which clap adds commands of help.
    clap_mangen::generate_to(command.clone(), pages)?;
    for (shell, path) in COMPLETIONS {
        let mut script = Vec::new();
        clap_complete::generate(shell, &mut command, "icoray", &mut script);
        let path = directory.join(path);
        std::fs::create_dir_all(path.parent().unwrap_or(directory))?;
        std::fs::write(path, script)?;
    }
    Ok(())
}
