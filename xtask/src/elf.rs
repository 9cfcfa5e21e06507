//! Symbols and properties of libraries, read with the binutils.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use crate::error::Error;

/// Libraries that an installed shared library may need: those of any C program, and the unwinder.
const SYSTEM: [&str; 6] = ["libc.so.", "libm.so.", "libgcc_s.so.", "libpthread.so.", "libdl.so.", "ld-linux"];

/// The MPI libraries that one with MPI needs: Open MPI's, or that of MPICH and its derivatives.
const MPI: [&str; 2] = ["libmpi.so.", "libmpich.so."];

/// A shared library's dynamic section and segments.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shared {
    /// The name by which programs find it at run time.
    pub soname: Option<String>,
    /// The libraries that it depends on.
    pub needed: Vec<String>,
    /// RPATH and RUNPATH.
    search: Vec<String>,
    /// Whether it makes the stack of the program that loads it executable.
    executable_stack: bool,
}

impl Shared {
    /// Reads a file.
    pub fn read(library: &Path) -> Result<Self, Error> {
        Ok(Self::parse(&printed("readelf", &["-dlW"], library)?))
    }

    fn parse(text: &str) -> Self {
        // The stack is executable unless the library has a header that says otherwise.
        let mut shared = Self { executable_stack: true, ..Self::default() };
        for line in text.lines() {
            let bracketed = || Some(line.split_once('[')?.1.split_once(']')?.0.to_owned());
            if line.contains("(SONAME)") {
                shared.soname = bracketed();
            } else if line.contains("(NEEDED)") {
                shared.needed.extend(bracketed());
            } else if line.contains("(RPATH)") || line.contains("(RUNPATH)") {
                shared.search.extend(bracketed());
            } else if let Some(stack) = line.trim_start().strip_prefix("GNU_STACK") {
                shared.executable_stack = stack.split_whitespace().any(|word| word == "RWE");
            }
        }
        shared
    }

    /// The faults that it has as an installed library of this name, with MPI or without.
    pub fn complaints(&self, soname: &str, mpi: bool) -> Vec<String> {
        let mut complaints = Vec::new();
        if self.soname.as_deref() != Some(soname) {
            complaints.push(format!("its SONAME is {:?}, expected {soname:?}", self.soname));
        }
        let is_mpi = |library: &&String| MPI.iter().any(|known| library.starts_with(known));
        if mpi && !self.needed.iter().any(|library| is_mpi(&library)) {
            complaints.push("it needs no MPI".into());
        }
        for library in self.needed.iter().filter(|library| !(mpi && is_mpi(library))) {
            if !SYSTEM.iter().any(|known| library.starts_with(known)) {
                complaints.push(format!("it needs {library}"));
            }
        }
        if !self.search.is_empty() {
            complaints.push(format!("it searches {}", self.search.join(", ")));
        }
        if self.executable_stack {
            complaints.push("it makes the stack executable".into());
        }
        complaints
    }
}

/// The global names that a library defines; `-D` in `options` is for shared libraries.
pub fn defined(library: &Path, options: &[&str]) -> Result<Vec<String>, Error> {
    let options: Vec<_> = ["-g", "--defined-only"].iter().chain(options).copied().collect();
    Ok(names(&printed("nm", &options, library)?))
}

/// The third words of nm's lines; headings of an archive's members have one.
fn names(text: &str) -> Vec<String> {
    let name = |line: &str| line.split_whitespace().nth(2).map(str::to_owned);
    distinct(text.lines().filter_map(name))
}

/// The functions that a C header declares.
pub fn declared(header: &str) -> Vec<String> {
    // Outside of comments, whose lines start with a star, only the name of a prototype is followed by a bracket.
    let code = header.lines().filter(|line| !line.trim_start().starts_with(['*', '/']));
    let before_bracket = code.filter_map(|line| line.split_once('(').map(|(before, _)| before));
    let name = before_bracket.filter_map(|before| before.rsplit([' ', '*']).next());
    distinct(name.filter(|name| name.starts_with("icoray_")).map(str::to_owned))
}

/// The names in order, each once.
fn distinct(names: impl Iterator<Item = String>) -> Vec<String> {
    names.collect::<BTreeSet<_>>().into_iter().collect()
}

/// Fails unless both lists have the same names.
pub fn same_names(what: &str, found: &[String], expected: &[String]) -> Result<(), Error> {
    let lacking: Vec<_> = expected.iter().filter(|name| !found.contains(name)).collect();
    let surplus: Vec<_> = found.iter().filter(|name| !expected.contains(name)).collect();
    if lacking.is_empty() && surplus.is_empty() && !expected.is_empty() {
        return Ok(());
    }
    Err(Error::Failed(format!(
        "{what} {} names where {} are declared; not declared: {surplus:?}; not there: {lacking:?}",
        found.len(),
        expected.len()
    )))
}

fn printed(program: &str, options: &[&str], file: &Path) -> Result<String, Error> {
    let mut command = Command::new(program);
    // Without translations.
    let output = command.env("LC_ALL", "C").args(options).arg(file).output();
    let output = output.map_err(Error::while_doing(program))?;
    if !output.status.success() {
        let cause = String::from_utf8_lossy(&output.stderr);
        return Err(Error::Failed(format!("{program} {}: {}", file.display(), cause.trim())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "
  GNU_STACK      0x000000 0x0000000000000000 0x0000000000000000 0x000000 0x000000 RW  0
 0x0000000000000001 (NEEDED)             Shared library: [libgcc_s.so.1]
 0x0000000000000001 (NEEDED)             Shared library: [ld-linux-x86-64.so.2]
 0x000000000000000e (SONAME)             Library soname: [libx.so.0]
";

    fn strings(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn a_good_library_is_not_complained_of() {
        let shared = Shared::parse(GOOD);
        assert_eq!(shared.needed, ["libgcc_s.so.1", "ld-linux-x86-64.so.2"]);
        assert_eq!(shared.complaints("libx.so.0", false), [""; 0]);
    }

    #[test]
    fn mpi_is_needed_where_it_is_wanted_and_nowhere_else() {
        for name in ["libmpi.so.40", "libmpich.so.12"] {
            let shared = Shared::parse(&GOOD.replace("libgcc_s.so.1", name));
            assert_eq!(shared.complaints("libx.so.0", true), [""; 0]);
            assert_eq!(shared.complaints("libx.so.0", false), [format!("it needs {name}")]);
        }
        assert_eq!(Shared::parse(GOOD).complaints("libx.so.0", true), ["it needs no MPI"]);
    }

    #[test]
    fn each_fault_is_complained_of() {
        let complaint = |from: &str, to: &str| {
            assert!(GOOD.contains(from));
            Shared::parse(&GOOD.replace(from, to)).complaints("libx.so.0", false).join("; ")
        };
        assert_eq!(complaint("libx.so.0", "libx.so"), "its SONAME is Some(\"libx.so\"), expected \"libx.so.0\"");
        assert!(complaint("(SONAME)", "(OTHER)").starts_with("its SONAME is None"));
        assert_eq!(complaint("libgcc_s.so.1", "libnetcdf.so.19"), "it needs libnetcdf.so.19");
        assert_eq!(complaint(" RW ", " RWE "), "it makes the stack executable");
        assert_eq!(complaint("GNU_STACK", "GNU_RELRO"), "it makes the stack executable");
        let rpath = " 0x1d (RUNPATH)   Library runpath: [/home/me]\n";
        assert_eq!(Shared::parse(&format!("{GOOD}{rpath}")).complaints("libx.so.0", false), ["it searches /home/me"]);
    }

    #[test]
    fn a_name_too_many_or_too_few_is_found() {
        let declared = strings(&["icoray_close", "icoray_open"]);
        assert_eq!(same_names("x has", &declared, &declared), Ok(()));
        let message = |found: &[&str]| same_names("x has", &strings(found), &declared).unwrap_err().to_string();
        let surplus = message(&["icoray_close", "icoray_open", "rust_eh_personality"]);
        assert!(surplus.contains("not declared: [\"rust_eh_personality\"]"), "{surplus}");
        assert!(message(&["icoray_open"]).contains("not there: [\"icoray_close\"]"));
        // A comparison of nothing with nothing would always hold.
        assert!(same_names("x has", &[], &[]).is_err());
    }

    #[test]
    fn names_are_read_from_nm_and_the_header() {
        let nm = "\na.o:\n0000000000000010 T icoray_b\n0000000000000000 T icoray_a\n\nb.o:\n00 D icoray_b\n";
        assert_eq!(names(nm), ["icoray_a", "icoray_b"]);
        let header =
            "/* icoray_x(no) */\n * icoray_y(no)\nconst char *icoray_b(void);\nint icoray_a(int a,\n  int b);\n";
        assert_eq!(declared(header), ["icoray_a", "icoray_b"]);
    }
}
