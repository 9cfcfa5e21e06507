//! `icoray completions` and `icoray manual`: what shells and `man` know of the command, made of its options.

use crate::failure::CommandResult;
use icoray::{Error, ErrorKind};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `icoray completions`.
#[derive(clap::Args)]
pub struct CompletionArgs {
    /// The shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// Arguments of `icoray manual`.
#[derive(clap::Args)]
pub struct ManualArgs {
    /// Directory of the pages, such as ~/.local/share/man/man1
    #[arg(value_name = "DIR")]
    directory: PathBuf,
}

/// Prints the completions of a shell.
pub fn complete(args: &CompletionArgs, mut command: clap::Command, out: &mut impl Write) -> CommandResult {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "icoray", &mut script);
    Ok(out.write_all(&script)?)
}

/// Writes a manual page of each command.
pub fn write_manual(args: &ManualArgs, command: clap::Command) -> CommandResult {
    let directory = &args.directory;
    let written = std::fs::create_dir_all(directory).and_then(|()| clap_mangen::generate_to(command, directory));
    let failed = |e| Error::new(ErrorKind::Io, format!("{}: cannot write the manual: {e}", directory.display()));
    Ok(written.map_err(failed)?)
}
