//! One MPI for everything: the C compiler that rsmpi is built for, the Fortran compiler of the model, and the launcher.
//!
//! A machine may have Open MPI and MPICH, and Debian selects `mpicc` and `mpirun` independently. Small programs are
//! compiled and run here: they print which library they are linked with, and the number of their ranks.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::host::{Host, Probe};
use crate::requirements::Lack;

/// Endings of the names of one MPI's programs; programs without one are the machine's default.
const ENDINGS: [&str; 3] = ["", ".openmpi", ".mpich"];

static C: Probe = Probe { name: "mpi.c", text: include_str!("probes/mpi.c") };
static FORTRAN: Probe = Probe { name: "mpi.f90", text: include_str!("probes/mpi.f90") };

/// The programs of one MPI.
#[derive(Debug, PartialEq)]
pub struct Mpi {
    /// The C compiler.
    pub cc: PathBuf,
    /// The Fortran compiler: GNU's.
    pub fortran: PathBuf,
    /// Starts programs on several ranks.
    pub run: PathBuf,
    /// The options with which `run` starts any number of ranks on any machine.
    pub options: Vec<&'static str>,
    /// Name and version, as the library returns them.
    pub library: String,
}

impl Mpi {
    /// Finds the MPI of `mpicc`, or of the compiler that MPICC names, with its Fortran compiler and launcher.
    pub fn find(host: &Host) -> Result<Self, Lack> {
        let (cc, fortran, run) = (Compiled::by_c(host)?, fortran(host)?, launcher(host)?);
        Ok(Self { cc: cc.compiler, fortran, run, options: options(host, &cc.library), library: cc.library })
    }
}

/// A probe that a compiler has built.
struct Compiled {
    compiler: PathBuf,
    program: PathBuf,
    library: String,
}

impl Compiled {
    /// By the C compiler that rsmpi takes.
    fn by_c(host: &Host) -> Result<Self, Lack> {
        let name = host.variable("MPICC").unwrap_or(OsStr::new("mpicc"));
        let compiler = host.program(name).ok_or_else(|| format!("no program {}", name.display()));
        let found = compiler.and_then(|compiler| {
            // rsmpi reads the directory of the library from this.
            let shown = host.run(&compiler, ["-show"])?;
            if !shown.contains("-l") {
                return Err(format!("{} -show names no library", compiler.display()));
            }
            Self::new(host, compiler, &C)
        });
        found.map_err(|why| Lack::of(why).from(package(host)))
    }

    fn new(host: &Host, compiler: PathBuf, source: &Probe) -> Result<Self, String> {
        let program = host.build(&compiler, source, [""; 0])?;
        let library = host.run(&program, ["version"])?.trim().to_owned();
        Ok(Self { compiler, program, library })
    }

    fn is_mpich(&self) -> bool {
        self.library.contains("MPICH")
    }
}

/// Fails unless C programs with MPI can be compiled.
pub fn check_c(host: &Host) -> Result<(), Lack> {
    Compiled::by_c(host).map(drop)
}

/// The Fortran compiler of the C compiler's MPI. It must be GNU's: no other compiler reads the module files of the
/// library.
pub fn fortran(host: &Host) -> Result<PathBuf, Lack> {
    let c = Compiled::by_c(host)?;
    let package = if c.is_mpich() { "libmpich-dev" } else { "libopenmpi-dev" };
    first_program(host, &c, &["mpifort"], package, |compiler| {
        if !host.run(compiler, ["--version"])?.contains("GNU Fortran") {
            return Err(format!("{} is not GNU Fortran", compiler.display()));
        }
        let fortran = Compiled::new(host, compiler.to_path_buf(), &FORTRAN)?;
        if fortran.library == c.library { Ok(()) } else { Err(other(compiler, &fortran.library, &c)) }
    })
}

/// The launcher of the C compiler's MPI: the first that starts a program as two ranks of one communicator.
pub fn launcher(host: &Host) -> Result<PathBuf, Lack> {
    let c = Compiled::by_c(host)?;
    let package = if c.is_mpich() { "mpich" } else { "openmpi-bin" };
    first_program(host, &c, &["mpirun", "mpiexec"], package, |run| {
        let options = options(host, &c.library);
        let words = ["-n", "2"].iter().chain(&options).map(OsStr::new);
        let printed = host.run(run, words.chain([c.program.as_os_str()]))?;
        if printed.matches("size 2\n").count() == 2 { Ok(()) } else { Err(other(run, "another MPI", &c)) }
    })
}

/// The first program of these names that passes a check; or else the first cause, and the package to install.
fn first_program(
    host: &Host,
    c: &Compiled,
    names: &[&str],
    package: &'static str,
    check: impl Fn(&Path) -> Result<(), String>,
) -> Result<PathBuf, Lack> {
    let mut first_cause = None;
    for program in named(host, &c.compiler, names) {
        match check(&program) {
            Ok(()) => return Ok(program),
            Err(cause) => first_cause.get_or_insert(cause),
        };
    }
    Err(Lack::of(first_cause.unwrap_or_else(|| format!("no program {}", names[0]))).from(package))
}

fn other(program: &Path, library: &str, c: &Compiled) -> String {
    let first = |library: &str| library.split([',', '\n', '\t']).next().unwrap_or_default().trim().to_owned();
    let (program, compiler) = (program.display(), c.compiler.display());
    format!("{program} is of {}, {compiler} of {}", first(library), first(&c.library))
}

/// Programs of these names: those beside `compiler`, then those of the search path, with each ending.
fn named(host: &Host, compiler: &Path, names: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let beside = compiler.parent().unwrap_or(Path::new("/"));
    for ending in ENDINGS {
        for name in names.iter().map(|name| format!("{name}{ending}")) {
            found.extend([host.program(beside.join(&name)), host.program(&name)].into_iter().flatten());
        }
    }
    found.dedup();
    found
}

/// The package to install where there is no C compiler for MPI: MPICH's where its launcher is installed.
fn package(host: &Host) -> &'static str {
    let launcher = host.run("mpirun", ["--version"]).unwrap_or_default();
    if launcher.contains("HYDRA") { "libmpich-dev" } else { "libopenmpi-dev" }
}

/// The options that the launcher of this library needs; MPICH's needs none.
fn options(host: &Host, library: &str) -> Vec<&'static str> {
    if !library.contains("Open MPI") {
        return Vec::new();
    }
    let mut options = vec!["--oversubscribe", "--bind-to", "none"];
    // Waiting ranks yield their processor, on machines with fewer processors than ranks.
    options.extend(["--mca", "mpi_yield_when_idle", "1"]);
    // In containers ranks cannot read each other's memory, and without the option each prints a warning.
    options.extend(["--mca", "btl_vader_single_copy_mechanism", "none"]);
    if host.run("id", ["-u"]).is_ok_and(|id| id.trim() == "0") {
        options.push("--allow-run-as-root");
    }
    options
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::fake::Machine;

    const OPEN_MPI: &str = "Open MPI v4.1.4, package: Debian OpenMPI";
    const MPICH: &str = "MPICH Version:\t4.0.2";

    fn machine() -> Machine {
        let machine = Machine::bare();
        machine.own_program("id");
        machine
    }

    /// Adds a compiler whose programs are scripts: they print the library and the number of ranks that its launcher
    /// sets.
    fn add_compiler(machine: &Machine, name: &str, library: &str) {
        let ranks = variable(library);
        machine.program(
            name,
            &format!(
                "case $1 in -show) echo cc -I/usr/include/mpi -lmpi; exit;; --version) echo GNU Fortran; exit;; esac
                 {{ echo '#!/bin/sh'
                    echo '[ \"$1\" = version ] || echo size ${{{ranks}:-1}}'
                    echo \"echo '{library}'\"; }} >$2
                 chmod +x $2"
            ),
        );
    }

    fn add_launcher(machine: &Machine, name: &str, library: &str) {
        let (ranks, version) = (variable(library), if library == MPICH { "HYDRA" } else { library });
        machine.program(
            name,
            &format!(
                "[ $1 = --version ] && {{ echo {version}; exit; }}
                 for last; do :; done
                 export {ranks}=2; $last; $last"
            ),
        );
    }

    fn variable(library: &str) -> &'static str {
        if library == MPICH { "MPICH_RANKS" } else { "OPEN_MPI_RANKS" }
    }

    fn add_all(machine: &Machine, ending: &str, library: &str) {
        add_compiler(machine, &format!("mpicc{ending}"), library);
        add_compiler(machine, &format!("mpifort{ending}"), library);
        add_launcher(machine, &format!("mpirun{ending}"), library);
    }

    fn names(mpi: &Mpi) -> [String; 3] {
        [&mpi.cc, &mpi.fortran, &mpi.run].map(|file| file.file_name().unwrap().to_string_lossy().into_owned())
    }

    #[test]
    fn a_bare_machine_lacks_open_mpi() {
        let machine = machine();
        assert_eq!(check_c(&machine.host()), Err(Lack::of("no program mpicc").from("libopenmpi-dev")));
    }

    #[test]
    fn each_mpi_alone_is_found() {
        for library in [OPEN_MPI, MPICH] {
            let machine = machine();
            add_all(&machine, "", library);
            let mpi = Mpi::find(&machine.host()).unwrap();
            assert_eq!(names(&mpi), ["mpicc", "mpifort", "mpirun"]);
            assert_eq!(mpi.library, library);
            assert_eq!(mpi.options.contains(&"--oversubscribe"), library == OPEN_MPI);
        }
    }

    #[test]
    fn of_two_the_parts_of_one_are_taken() {
        let machine = machine();
        add_all(&machine, ".openmpi", OPEN_MPI);
        add_all(&machine, ".mpich", MPICH);
        // A mixture that update-alternatives allows.
        add_compiler(&machine, "mpicc", MPICH);
        add_compiler(&machine, "mpifort", OPEN_MPI);
        add_launcher(&machine, "mpirun", OPEN_MPI);
        let mpi = Mpi::find(&machine.host()).unwrap();
        assert_eq!(names(&mpi), ["mpicc", "mpifort.mpich", "mpirun.mpich"]);
        assert_eq!(mpi.library, MPICH);
    }

    #[test]
    fn what_lacks_of_an_mpi_comes_from_its_packages() {
        let machine = machine();
        add_compiler(&machine, "mpicc", MPICH);
        assert_eq!(fortran(&machine.host()), Err(Lack::of("no program mpifort").from("libmpich-dev")));
        assert_eq!(launcher(&machine.host()), Err(Lack::of("no program mpirun").from("mpich")));
        add_compiler(&machine, "mpifort", OPEN_MPI);
        add_launcher(&machine, "mpirun", OPEN_MPI);
        let lack = fortran(&machine.host()).unwrap_err();
        assert!(lack.why.contains("mpifort is of Open MPI v4.1.4"), "{lack:?}");
        assert_eq!(launcher(&machine.host()).unwrap_err().package, Some("mpich"));
    }

    #[test]
    fn a_launcher_that_is_there_decides_what_is_installed() {
        let machine = machine();
        add_launcher(&machine, "mpirun", MPICH);
        assert_eq!(check_c(&machine.host()).unwrap_err().package, Some("libmpich-dev"));
    }

    #[test]
    fn a_wrapper_without_its_compiler_does_not_do() {
        let machine = machine();
        machine.program("mpicc", "[ $1 = -show ] && echo gcc -lmpi || { echo 'error: gcc not found' >&2; exit 1; }");
        let why = check_c(&machine.host()).unwrap_err().why;
        assert!(why.ends_with("mpicc: error: gcc not found"), "{why}");
        machine.program("mpicc", "echo cc");
        assert!(check_c(&machine.host()).unwrap_err().why.ends_with("-show names no library"));
    }

    #[test]
    fn the_compiler_that_mpicc_names_brings_its_own() {
        let mut machine = machine();
        add_all(&machine, "", OPEN_MPI);
        let bin = machine.root.join("opt/bin");
        std::fs::create_dir_all(&bin).unwrap();
        add_all(&machine, ".mine", MPICH);
        for name in ["mpicc", "mpifort", "mpirun"] {
            std::fs::rename(machine.root.join(format!("usr/bin/{name}.mine")), bin.join(name)).unwrap();
        }
        machine.variables.insert("MPICC".into(), bin.join("mpicc").into());
        let mpi = Mpi::find(&machine.host()).unwrap();
        assert_eq!([mpi.cc, mpi.fortran, mpi.run], ["mpicc", "mpifort", "mpirun"].map(|name| bin.join(name)));
    }
}
