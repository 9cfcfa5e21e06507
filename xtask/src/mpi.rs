//! Selects one MPI: the C compiler for rsmpi, the Fortran compiler for the model, and the launcher.
//!
//! A machine may have Open MPI and another MPI, and Debian selects `mpicc` and `mpirun` independently.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::system::output;
use crate::workspace::variable;

/// The programs of one MPI.
#[derive(Debug, Clone, PartialEq)]
pub struct Mpi {
    pub cc: PathBuf,
    pub fortran: PathBuf,
    pub run: PathBuf,
}

impl Mpi {
    /// Finds the MPI of `mpicc`, or of the compiler that MPICC names, with its Fortran compiler and launcher.
    pub fn find() -> Result<Self, String> {
        let cc = cc()?;
        let (fortran, run) = (partner(&cc, "mpifort")?, partner(&cc, "mpirun")?);
        Ok(Self { cc, fortran, run })
    }

    /// A text that differs for builds with different MPIs.
    pub fn identity(&self) -> String {
        let printed = [output(&self.cc, ["-show"]), output(&self.run, ["--version"])].map(Option::unwrap_or_default);
        format!("{}\n{}\n", self.cc.display(), printed.join("\n"))
    }
}

/// Fails unless there are compilers for C and Fortran of one MPI.
pub fn check_compilers() -> Result<(), String> {
    partner(&cc()?, "mpifort").map(drop)
}

/// Fails unless there is a launcher, of the MPI of the compiler where there is one.
pub fn check_launcher() -> Result<(), String> {
    match cc() {
        Ok(cc) => partner(&cc, "mpirun").map(drop),
        Err(_) => program("mpirun").map(drop),
    }
}

/// Whether the machine has another MPI than Open MPI, by its compiler, or else by its launcher.
pub fn is_other() -> bool {
    cc().or_else(|_| program("mpirun")).is_ok_and(|program| !is_open_mpi(program))
}

pub fn cc() -> Result<PathBuf, String> {
    program(variable("MPICC").unwrap_or("mpicc".into()))
}

/// The file of a program of the search path.
fn program(name: impl AsRef<Path>) -> Result<PathBuf, String> {
    let name = name.as_ref();
    let mut files = search_path().into_iter().map(|directory| directory.join(name));
    files.find(|file| file.is_file()).ok_or_else(|| format!("no program {}", name.display()))
}

fn search_path() -> Vec<PathBuf> {
    env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect()
}

/// The program of this name that belongs to the MPI of the C compiler: beside it or on the search path, with one of
/// Debian's endings or without.
fn partner(cc: &Path, name: &str) -> Result<PathBuf, String> {
    let is_open = is_open_mpi(cc);
    let names = ["", ".openmpi", ".mpich"].map(|ending| format!("{name}{ending}"));
    let directories = cc.parent().map(Path::to_path_buf).into_iter().chain(search_path());
    let mut files = directories.flat_map(|directory| names.clone().map(|name| directory.join(name)));
    let found = files.find(|file| file.is_file() && is_open_mpi(file) == is_open);
    found.ok_or_else(|| format!("no program {name} of the MPI of {}", cc.display()))
}

/// Whether a compiler or launcher is Open MPI's: it takes one of these options, and names itself.
fn is_open_mpi(program: impl AsRef<OsStr>) -> bool {
    let texts = ["--showme:version", "--version"].map(|option| output(program.as_ref(), [option]));
    texts.iter().flatten().any(|text| text.contains("Open MPI") || text.contains("open-mpi.org"))
}
