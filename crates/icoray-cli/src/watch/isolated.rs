//! Reading NetCDF-4 files that a model may be writing.
//!
//! HDF5 locks a file that it reads, and a model that opens a locked file to write it fails. So the command runs with
//! these locks switched off. Without them a file may be read while its structure is being changed; that, like damage, may
//! end or hang the process inside HDF5. So such a file is read by another process first.

use icoray::{Error, ErrorKind, Result};
use icoray_netcdf::Outline;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// The variable that HDF5 asks whether to lock files.
const LOCKING: &str = "HDF5_USE_FILE_LOCKING";
/// How long the other process may read header and times, and how long a record.
const FOR_HEADER: Duration = Duration::from_secs(60);
const FOR_RECORD: Duration = Duration::from_secs(300);

/// Arguments of the other process.
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

fn program() -> Result<PathBuf> {
    // The file of a running program may be replaced or removed; this name stays.
    let own = Path::new("/proc/self/exe");
    if own.exists() {
        return Ok(own.to_owned());
    }
    std::env::current_exe().map_err(|e| Error::new(ErrorKind::Io, format!("cannot find the own program: {e}")))
}

/// Starts the program anew, in this process, with HDF5's locks switched off, unless they are.
#[cfg(unix)]
pub fn switch_locks_off() -> Result<()> {
    use std::os::unix::process::CommandExt;
    if std::env::var_os(LOCKING).is_some_and(|value| value == "FALSE") {
        return Ok(());
    }
    let mut words = std::env::args_os();
    let name = words.next().unwrap_or_else(|| "icoray".into());
    let failed = Command::new(program()?).arg0(name).args(words).env(LOCKING, "FALSE").exec();
    Err(Error::new(ErrorKind::Io, format!("cannot switch HDF5's locks off: {failed}")))
}

/// Other systems lock files by themselves.
#[cfg(not(unix))]
pub fn switch_locks_off() -> Result<()> {
    Ok(())
}

/// Reads header and times in another process first, of a file that is not classic.
pub fn try_outline(path: &Path, is_classic: bool) -> Result<()> {
    if is_classic { Ok(()) } else { try_in_another(path, &[], FOR_HEADER) }
}

/// Reads a record in another process first, of a file that is not classic.
pub fn try_record(path: &Path, record: usize, variables: &[String]) -> Result<()> {
    if Outline::is_classic(path)? {
        return Ok(());
    }
    let option = ["--record".to_owned(), record.to_string(), "--".to_owned()];
    try_in_another(path, &[&option, variables].concat(), FOR_RECORD)
}

fn try_in_another(path: &Path, words: &[String], patience: Duration) -> Result<()> {
    let error = |what: String| Error::new(ErrorKind::Io, format!("{}: {what}", path.display()));
    let mut command = Command::new(program()?);
    command.arg("try-reading").arg(path).args(words);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| error(format!("cannot start a process that reads it: {e}")))?;
    let start = Instant::now();
    let mut pause = Duration::from_millis(2);
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if start.elapsed() < patience => std::thread::sleep(pause),
            _ => {
                // What has ended by itself meanwhile needs no end.
                let _ = child.kill();
                let _ = child.wait();
                return Err(error(format!(
                    "reading it took more than {} s: not whole, or damaged",
                    patience.as_secs()
                )));
            }
        }
        pause = (pause * 2).min(Duration::from_millis(50));
    };
    if status.success() {
        return Ok(());
    }
    let mut said = String::new();
    if let Some(mut stderr) = child.stderr.take() {
        let _ = stderr.read_to_string(&mut said);
    }
    Err(reason(&said).map_or_else(|| error(ending(status)), |context| Error::new(ErrorKind::Io, context)))
}

/// The sentence of an error that the other process printed, without the kind that it has here too.
fn reason(said: &str) -> Option<String> {
    let line = said.lines().find_map(|line| line.strip_prefix("icoray: error: "))?;
    let kind = format!("{}: ", ErrorKind::Io);
    Some(line.strip_prefix(&kind).unwrap_or(line).to_owned())
}

fn ending(status: ExitStatus) -> String {
    format!("the HDF5 library ended the process that read it ({status}): not whole, or damaged")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_process_gives_its_reason() {
        let error = Error::new(ErrorKind::Io, "a.nc: cut off".to_owned());
        assert_eq!(reason(&format!("noise\nicoray: error: {error}\n")).as_deref(), Some("a.nc: cut off"));
        assert_eq!(reason("killed"), None);
    }
}
