//! Reading NetCDF-4 files in a child process.
//!
//! Damage of such a file may end or hang the process inside HDF5, so that commands that read one run in a child, and
//! report how it ended. Files are read once, by the child.
//!
//! Watching a directory must go on when a file cannot be read, and reads files that a model may be writing. HDF5 locks
//! a file that it reads, and a model that opens a locked file to write it fails. So the command runs with these locks
//! switched off. Without them a file may be read while its structure is being changed; that has the same effect as
//! damage. So such a file is read by a child first.

use crate::input::Input;
use icoray::{Error, ErrorKind, Result};
use icoray_netcdf::{Outline, end_process, watch_calls};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus, Output, Stdio};
use std::time::Duration;
use std::{io, thread};

/// The variable that HDF5 asks whether to lock files.
const LOCKING: &str = "HDF5_USE_FILE_LOCKING";
/// Processor time that a call may take of the smallest file.
const CALL_TIME: Duration = Duration::from_secs(60);

/// Arguments of a child that reads a file and keeps nothing.
#[derive(clap::Args)]
pub struct Args {
    file: PathBuf,
    /// Record to read; without it the header and the times are
    #[arg(long)]
    record: Option<usize>,
    /// Variables to read
    variables: Vec<String>,
}

/// Reads a file and keeps nothing.
pub fn run(args: &Args) -> Result<()> {
    match args.record {
        Some(record) => Outline::try_reading(&args.file, &args.variables, record),
        None => Outline::read(&args.file).map(drop),
    }
}

/// Begins the work of a child: it ends when a call of HDF5 hangs, and when its parent does.
pub fn begin() {
    watch_calls(CALL_TIME, |error| {
        crate::complain(&error.into());
        end_process(1)
    });
    thread::spawn(|| {
        // The parent never writes to it, and has it open until it ends or is killed.
        let _ = io::copy(&mut io::stdin(), &mut io::sink());
        end_process(1);
    });
}

/// Runs this command in a child, if one of its files is not classic; returns the child's exit code.
pub fn run_apart(input: &Input) -> Result<Option<ExitCode>> {
    // Files that cannot be opened are reported when they are needed.
    let files = input.paths().filter(|path| !Outline::is_classic(path).unwrap_or(true));
    let files: Vec<_> = files.map(|path| path.display().to_string()).collect();
    if files.is_empty() {
        return Ok(None);
    }
    let error = |what| Error::new(ErrorKind::Io, format!("{}: {what}", files.join(", ")));
    let mut command = own_program()?;
    command.arg("--isolated").args(std::env::args_os().skip(1));
    let status = finished(command).map_err(error)?.status;
    match status.code() {
        Some(code) => Ok(Some(ExitCode::from(u8::try_from(code).unwrap_or(1)))),
        None => Err(error(ending(status))),
    }
}

/// This program, under the name by which it was called.
fn own_program() -> Result<Command> {
    // The file of a running program may be replaced or removed; this name stays.
    let own = Path::new("/proc/self/exe");
    let failed = |e| Error::new(ErrorKind::Io, format!("cannot find the path of this program: {e}"));
    let path = if own.exists() { own.to_owned() } else { std::env::current_exe().map_err(failed)? };
    let mut command = Command::new(path);
    command.arg0(std::env::args_os().next().unwrap_or_else(|| "icoray".into()));
    Ok(command)
}

/// Runs a child to its end.
fn finished(mut command: Command) -> std::result::Result<Output, String> {
    let failed = |e| format!("cannot start a process that reads it: {e}");
    let mut child = command.stdin(Stdio::piped()).spawn().map_err(failed)?;
    // Open until the child has ended: see `begin`.
    let _stdin = child.stdin.take();
    child.wait_with_output().map_err(failed)
}

/// Starts the program anew, in this process, with HDF5's locks switched off, unless they are.
pub fn switch_locks_off() -> Result<()> {
    if std::env::var_os(LOCKING).is_some_and(|value| value == "FALSE") {
        return Ok(());
    }
    let failed = own_program()?.args(std::env::args_os().skip(1)).env(LOCKING, "FALSE").exec();
    Err(Error::new(ErrorKind::Io, format!("cannot switch HDF5's locks off: {failed}")))
}

/// Reads a record in a child first, of a file that is not classic.
pub fn try_record(path: &Path, record: usize, variables: &[String]) -> Result<()> {
    if Outline::is_classic(path)? {
        return Ok(());
    }
    let option = ["--record".to_owned(), record.to_string(), "--".to_owned()];
    try_in_child(path, &[&option, variables].concat())
}

/// Reads a file in a child: header and times, or what the words say.
pub fn try_in_child(path: &Path, words: &[String]) -> Result<()> {
    let error = |what| Error::new(ErrorKind::Io, format!("{}: {what}", path.display()));
    let mut command = own_program()?;
    command.args(["--isolated", "try-reading"]).arg(path).args(words);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let Output { status, stderr, .. } = finished(command).map_err(error)?;
    if status.success() {
        return Ok(());
    }
    let reason = reason(&String::from_utf8_lossy(&stderr));
    Err(reason.map_or_else(|| error(ending(status)), |context| Error::new(ErrorKind::Io, context)))
}

/// The context of an error that a child printed, without its kind, which is added again here.
fn reason(printed: &str) -> Option<String> {
    let line = printed.lines().find_map(|line| line.strip_prefix("icoray: error: "))?;
    let kind = format!("{}: ", ErrorKind::Io);
    Some(line.strip_prefix(&kind).unwrap_or(line).to_owned())
}

/// A description of a child's end, whose probable reason is HDF5.
fn ending(status: ExitStatus) -> String {
    format!("the process that read it ended ({status}), usually in the HDF5 library: incomplete or damaged")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_child_gives_its_reason() {
        let error = Error::new(ErrorKind::Io, "a.nc: cut off".to_owned());
        assert_eq!(reason(&format!("noise\nicoray: error: {error}\n")).as_deref(), Some("a.nc: cut off"));
        assert_eq!(reason("killed"), None);
    }
}
