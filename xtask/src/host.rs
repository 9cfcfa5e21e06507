//! The machine as the probes of [`crate::requirements`] see it: programs on a search path, environment variables, and files below
//! a root. Tests build such machines in temporary directories.

use std::collections::BTreeMap;
use std::env;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{self, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::{Error, last_lines};

/// A probe that runs longer has failed. Compilers and `mpirun` take a second or two.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// Time between two looks at a program that runs.
const PAUSE: Duration = Duration::from_millis(5);
/// Bytes that the programs of the probes take, and more.
const ROOM: usize = 1 << 20;

/// A machine to be probed.
pub struct Host {
    /// Directory that stands for `/` where files are looked for.
    root: PathBuf,
    path: OsString,
    variables: BTreeMap<String, OsString>,
    /// Holds what the probes compile; removed at the end.
    scratch: PathBuf,
    /// Number of files in `scratch` so far.
    count: AtomicUsize,
}

/// A text that a probe compiles or reads.
pub struct Probe {
    /// The name of its file, whose ending tells the language.
    pub name: &'static str,
    /// Its text.
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
    pub fn new(root: PathBuf, path: OsString, variables: BTreeMap<String, OsString>) -> Result<Self, Error> {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("icoray-probe-{}-{}", process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let scratch = env::temp_dir().join(name);
        let room = scratch.join("room");
        let written = fs::create_dir_all(&scratch).and_then(|()| fs::write(&room, [0; ROOM]));
        if let Err(cause) = written.and_then(|()| fs::remove_file(&room)) {
            let _ = fs::remove_dir_all(&scratch);
            let place = env::temp_dir();
            let advice = "let TMPDIR name a directory with free space that can be written";
            return Err(Error::Failed(format!(
                "cannot write temporary files to {}: {cause}; {advice}",
                place.display()
            )));
        }
        Ok(Self { root, path, variables, scratch, count: AtomicUsize::new(0) })
    }

    /// The value of an environment variable that is set and not empty.
    pub fn variable(&self, name: &str) -> Option<&OsStr> {
        self.variables.get(name).map(OsString::as_os_str).filter(|value| !value.is_empty())
    }

    /// Where the file with this absolute path lies.
    pub fn file(&self, path: impl AsRef<Path>) -> PathBuf {
        let path = path.as_ref();
        // Paths of this machine's own, such as those that programs print, may already be below the root.
        if path.starts_with(&self.root) {
            return path.to_path_buf();
        }
        self.root.join(path.strip_prefix("/").unwrap_or(path))
    }

    /// The directories in which programs are looked for.
    pub fn program_directories(&self) -> Vec<PathBuf> {
        env::split_paths(&self.path).collect()
    }

    /// The file of a program; names without a slash are looked for on the search path.
    pub fn program(&self, name: impl AsRef<Path>) -> Option<PathBuf> {
        let name = name.as_ref();
        if name.components().count() > 1 {
            return is_program(name).then(|| name.to_path_buf());
        }
        self.program_directories()
            .into_iter()
            .map(|directory| directory.join(name))
            .find(|file| is_program(file))
    }

    /// Runs a program; returns what it wrote to standard output, or else in one line why it failed.
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
        command.args(arguments).current_dir(&self.scratch).env("PATH", &self.path).env("LC_ALL", "C");
        command.stdin(Stdio::null()).stdout(create(&stdout)?).stderr(create(&stderr)?);
        let status = self.wait(command, &name)?;
        let text = |path| String::from_utf8_lossy(&fs::read(path).unwrap_or_default()).into_owned();
        let printed = text(&stdout);
        if status.success() {
            return Ok(printed);
        }
        let errors = text(&stderr);
        let cause = cause(&errors).or_else(|| cause(&printed));
        Err(match cause {
            Some(line) => format!("{name}: {line}"),
            None => format!("{name} ended with {status}"),
        })
    }

    /// Compiles and links a program; returns its file, or else in one line why that failed.
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
        self.scratch.join(format!("{}-{name}", self.count.fetch_add(1, Ordering::Relaxed)))
    }

    fn wait(&self, mut command: Command, name: &str) -> Result<process::ExitStatus, String> {
        let failed = |cause| format!("{name}: {cause}");
        let started = Instant::now();
        let mut child = loop {
            match command.spawn() {
                // A program that was just written is busy while a process that another thread starts has its file open.
                Err(cause)
                    if cause.kind() == io::ErrorKind::ExecutableFileBusy
                        && started.elapsed() < TIME_LIMIT =>
                {
                    thread::sleep(PAUSE);
                }
                result => break result.map_err(failed)?,
            }
        };
        loop {
            if let Some(status) = child.try_wait().map_err(failed)? {
                return Ok(status);
            }
            if started.elapsed() > TIME_LIMIT {
                // It may just have ended.
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("{name} did not end within {} s", TIME_LIMIT.as_secs()));
            }
            thread::sleep(PAUSE);
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.scratch);
    }
}

/// The line of a program's output that tells why it failed: the first that has "error", or else the last.
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

    /// A machine in a temporary directory, which is removed at the end.
    pub struct Machine {
        pub root: PathBuf,
        pub variables: BTreeMap<String, OsString>,
    }

    impl Machine {
        /// A machine without anything but a shell.
        pub fn bare(name: &str) -> Self {
            let root = env::temp_dir().join(format!("icoray-machine-{name}-{}", process::id()));
            let _ = fs::remove_dir_all(&root);
            fs::create_dir_all(root.join("usr/bin")).unwrap();
            Self { root, variables: BTreeMap::new() }
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

    impl Drop for Machine {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.root);
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
        let machine = Machine::bare("path");
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
        let machine = Machine::bare("failure");
        machine.program(
            "cc",
            "echo 'x.c: In function main:'; echo 'x.c:1: error: no y' >&2; echo done >&2; exit 1",
        );
        machine.program("silent", "exit 3");
        let host = machine.host();
        assert_eq!(host.run("cc", NOTHING), Err("cc: x.c:1: error: no y".into()));
        assert_eq!(host.run("silent", NOTHING), Err("silent ended with exit status: 3".into()));
    }

    #[test]
    fn paths_are_below_the_root_and_variables_are_the_machines() {
        let mut machine = Machine::bare("files");
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
