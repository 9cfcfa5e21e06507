//! The machine that the checks of [`crate::requirements`] examine: programs on a search path, environment variables,
//! and files below a root. Tests make such machines in temporary directories.

use std::collections::BTreeMap;
use std::env;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use xshell::{Shell, TempDir};

use crate::error::{Error, last_lines};

/// A program that runs longer has failed. Compilers and `mpirun` take a second or two.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// Interval at which a running program is polled.
const PAUSE: Duration = Duration::from_millis(5);
/// Free bytes that must be there for temporary files: more than the compiled programs take.
const SPACE: usize = 1 << 20;

/// A machine to be examined.
pub struct Host {
    /// Directory that stands for `/` where files are looked for.
    root: PathBuf,
    path: OsString,
    variables: BTreeMap<String, OsString>,
    /// Holds the compiled programs.
    scratch: TempDir,
    /// Number of files in `scratch` so far.
    count: AtomicUsize,
}

/// A source file for a compiler.
#[derive(Debug)]
pub struct Probe {
    /// The name of the file; its ending is that of the language.
    pub name: &'static str,
    pub text: &'static str,
}

impl Host {
    /// This machine.
    pub fn here() -> Result<Self, Error> {
        let path = env::var_os("PATH").unwrap_or_default();
        let variables = env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value)));
        Self::new("/".into(), path, variables.collect())
    }

    /// A machine with the files below `root`, the programs of `path` and these environment variables.
    ///
    /// # Errors
    /// If temporary files cannot be written.
    pub fn new(root: PathBuf, path: OsString, variables: BTreeMap<String, OsString>) -> Result<Self, Error> {
        let shell = Shell::new()?;
        let scratch = shell.create_temp_dir().and_then(|scratch| {
            let file = scratch.path().join("space");
            shell.write_file(&file, [0; SPACE]).and_then(|()| shell.remove_path(&file)).map(|()| scratch)
        });
        let scratch = scratch.map_err(|cause| {
            let directory = env::temp_dir();
            Error::Failed(format!(
                "cannot write temporary files to {}: {cause}; \
                 let TMPDIR name a directory with free space that can be written",
                directory.display()
            ))
        })?;
        Ok(Self { root, path, variables, scratch, count: AtomicUsize::new(0) })
    }

    /// The value of an environment variable that is set and not empty.
    pub fn variable(&self, name: &str) -> Option<&OsStr> {
        self.variables.get(name).map(OsString::as_os_str).filter(|value| !value.is_empty())
    }

    /// The path below the root of the file with this absolute path.
    pub fn file(&self, path: impl AsRef<Path>) -> PathBuf {
        let path = path.as_ref();
        // Paths that programs print may already be below the root.
        if path.starts_with(&self.root) {
            return path.to_path_buf();
        }
        self.root.join(path.strip_prefix("/").unwrap_or(path))
    }

    /// The directories in which programs are looked for.
    pub fn program_directories(&self) -> Vec<PathBuf> {
        env::split_paths(&self.path).collect()
    }

    /// The file of a program; names without a slash are searched on the search path.
    pub fn program(&self, name: impl AsRef<Path>) -> Option<PathBuf> {
        let name = name.as_ref();
        if name.components().count() > 1 {
            return is_program(name).then(|| name.to_path_buf());
        }
        let mut files = self.program_directories().into_iter().map(|directory| directory.join(name));
        files.find(|file| is_program(file))
    }

    /// Runs a program; returns its standard output, or else the cause of its failure in one line.
    pub fn run<A: AsRef<OsStr>>(
        &self,
        program: impl AsRef<Path>,
        arguments: impl IntoIterator<Item = A>,
    ) -> Result<String, String> {
        let name = program.as_ref().display().to_string();
        let file = self.program(&program).ok_or_else(|| format!("no program {name}"))?;
        let (stdout, stderr) = (self.scratch_file("stdout"), self.scratch_file("stderr"));
        let create = |path: &Path| File::create(path).map_err(|cause| format!("{}: {cause}", path.display()));
        let mut command = Command::new(file);
        command.args(arguments).current_dir(self.scratch.path()).env("PATH", &self.path).env("LC_ALL", "C");
        command.stdin(Stdio::null()).stdout(create(&stdout)?).stderr(create(&stderr)?);
        let status = wait(command, &name)?;
        let text = |path| String::from_utf8_lossy(&fs::read(path).unwrap_or_default()).into_owned();
        let (printed, errors) = (text(&stdout), text(&stderr));
        if status.success() {
            return Ok(printed);
        }
        let cause = cause(&errors).or_else(|| cause(&printed));
        Err(cause.map_or_else(|| format!("{name} ended with {status}"), |line| format!("{name}: {line}")))
    }

    /// Compiles and links a program; returns its file, or else the cause of the failure in one line.
    pub fn build<A: AsRef<OsStr>>(
        &self,
        compiler: impl AsRef<Path>,
        source: &Probe,
        arguments: impl IntoIterator<Item = A>,
    ) -> Result<PathBuf, String> {
        let file = self.write(source)?;
        let program = self.scratch_file("program");
        let mut words: Vec<OsString> = vec!["-o".into(), program.clone().into(), file.into()];
        words.extend(arguments.into_iter().map(|word| word.as_ref().to_owned()));
        self.run(compiler, words)?;
        Ok(program)
    }

    /// Writes a text to a file in the scratch directory.
    pub fn write(&self, source: &Probe) -> Result<PathBuf, String> {
        let file = self.scratch_file(source.name);
        fs::write(&file, source.text).map_err(|cause| format!("{}: {cause}", file.display()))?;
        Ok(file)
    }

    fn scratch_file(&self, name: &str) -> PathBuf {
        self.scratch.path().join(format!("{}-{name}", self.count.fetch_add(1, Ordering::Relaxed)))
    }
}

/// Runs a command until it ends or the time limit is over.
fn wait(mut command: Command, name: &str) -> Result<ExitStatus, String> {
    let failed = |cause| format!("{name}: {cause}");
    let started = Instant::now();
    let mut child = loop {
        match command.spawn() {
            // A program that was just written is busy while a process that another thread starts has its file open.
            Err(cause) if cause.kind() == io::ErrorKind::ExecutableFileBusy && started.elapsed() < TIME_LIMIT => {
                thread::sleep(PAUSE);
            }
            result => break result.map_err(failed)?,
        }
    };
    while started.elapsed() <= TIME_LIMIT {
        if let Some(status) = child.try_wait().map_err(failed)? {
            return Ok(status);
        }
        thread::sleep(PAUSE);
    }
    // An error means that it has just ended.
    let _ = child.kill();
    let _ = child.wait();
    Err(format!("{name} did not end within {} s", TIME_LIMIT.as_secs()))
}

/// The line of a program's output that has the cause of its failure: the first with "error", or else the last.
fn cause(output: &str) -> Option<&str> {
    let lines = last_lines(output, usize::MAX);
    let error = lines.iter().find(|line| line.to_lowercase().contains("error"));
    error.or(lines.last()).map(|line| line.trim())
}

fn is_program(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|data| data.is_file() && data.permissions().mode() & 0o111 != 0)
}

#[cfg(test)]
pub mod fake {
    //! Machines for tests: a root with shell scripts for programs.

    use super::*;

    /// A machine in a temporary directory.
    pub struct Machine {
        pub root: PathBuf,
        pub variables: BTreeMap<String, OsString>,
        _directory: TempDir,
    }

    impl Machine {
        /// A machine without any program; scripts run by this system's shell.
        pub fn bare() -> Self {
            let directory = Shell::new().unwrap().create_temp_dir().unwrap();
            let root = directory.path().to_path_buf();
            Self { root, variables: BTreeMap::new(), _directory: directory }
        }

        pub fn host(&self) -> Host {
            Host::new(self.root.clone(), self.root.join("usr/bin").into(), self.variables.clone()).unwrap()
        }

        /// Adds an empty file.
        pub fn add(&self, path: &str) -> PathBuf {
            let file = self.root.join(path.trim_start_matches('/'));
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(&file, "").unwrap();
            file
        }

        /// Adds a program to `/usr/bin`: a script that finds this system's own programs.
        pub fn program(&self, name: &str, script: &str) {
            let file = self.add(&format!("/usr/bin/{name}"));
            fs::write(&file, format!("#!/bin/sh\nPATH=/usr/bin:/bin\n{script}\n")).unwrap();
            fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
        }

        /// Adds a program of this system's own.
        pub fn own_program(&self, name: &str) {
            self.program(name, &format!("exec {name} \"$@\""));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::fake::Machine;
    use super::*;

    const NOTHING: [&str; 0] = [];

    #[test]
    fn programs_are_found_on_the_search_path_only() {
        let machine = Machine::bare();
        machine.program("speak", "echo \"$1\"");
        machine.add("/usr/bin/file");
        let host = machine.host();
        assert_eq!(host.run("speak", ["word"]), Ok("word\n".into()));
        assert_eq!(host.run("sh", ["-c", "true"]), Err("no program sh".into()));
        assert_eq!(host.run("file", NOTHING), Err("no program file".into()));
        assert_eq!(host.run("/bin/echo", ["x"]), Ok("x\n".into()));
    }

    #[test]
    fn a_failure_is_told_in_one_line() {
        let machine = Machine::bare();
        machine.program("cc", "echo 'x.c: In function main:'; echo 'x.c:1: error: no y' >&2; echo done >&2; exit 1");
        machine.program("silent", "exit 3");
        let host = machine.host();
        assert_eq!(host.run("cc", NOTHING), Err("cc: x.c:1: error: no y".into()));
        assert_eq!(host.run("silent", NOTHING), Err("silent ended with exit status: 3".into()));
    }

    #[test]
    fn paths_are_below_the_root_and_variables_are_the_machines() {
        let mut machine = Machine::bare();
        machine.variables.insert("SET".into(), "value".into());
        machine.variables.insert("EMPTY".into(), "".into());
        let file = machine.add("/usr/lib/x");
        let host = machine.host();
        assert_eq!(host.file("/usr/lib/x"), file);
        assert_eq!(host.file(&file), file);
        assert_eq!(host.variable("SET"), Some(OsStr::new("value")));
        assert_eq!((host.variable("EMPTY"), host.variable("HOME")), (None, None));
    }
}
