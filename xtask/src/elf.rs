//! Symbols and properties of libraries, read with the binutils.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use crate::error::Error;

/// Libraries that an installed shared library may need: those of any C program, and the unwinder.
const SYSTEM: [&str; 6] = ["libc.so.", "libm.so.", "libgcc_s.so.", "libpthread.so.", "libdl.so.", "ld-linux"];
/// The MPI libraries that one with MPI needs: Open MPI's, or that of MPICH and its derivatives.
const MPI: [&str; 2] = ["libmpi.so.", "libmpich.so."];

/// Checks the dynamic section and the stack of a shared library that is to be installed under this name, with MPI or
/// without. Returns the libraries that it needs.
///
/// # Errors
/// Another SONAME, another library than the system's and MPI's, a search path, text relocations, an executable stack.
pub fn check_shared(library: &Path, soname: &str, mpi: bool) -> Result<Vec<String>, Error> {
    let text = printed("readelf", &["-dlW"], library)?;
    let faults = faults(&text, soname, mpi);
    if faults.is_empty() { Ok(entries(&text, "(NEEDED)")) } else { Err(fault(library, &faults.join("; "))) }
}

/// The values of the entries of this kind in the dynamic section, as `readelf -d` prints them.
fn entries(text: &str, kind: &str) -> Vec<String> {
    let lines = text.lines().filter(|line| line.contains(kind));
    lines.filter_map(|line| Some(line.split_once('[')?.1.split_once(']')?.0.to_owned())).collect()
}

fn faults(text: &str, soname: &str, mpi: bool) -> Vec<String> {
    let mut faults = Vec::new();
    let found = entries(text, "(SONAME)");
    if found != [soname] {
        faults.push(format!("its SONAME is {found:?}, expected {soname:?}"));
    }
    let is_one_of = |library: &String, known: &[&str]| known.iter().any(|start| library.starts_with(start));
    let (of_mpi, others): (Vec<_>, Vec<_>) =
        entries(text, "(NEEDED)").into_iter().partition(|library| is_one_of(library, &MPI));
    if mpi && of_mpi.is_empty() {
        faults.push("it needs no MPI".into());
    }
    let unexpected = others.iter().filter(|library| !is_one_of(library, &SYSTEM));
    faults.extend(unexpected.chain(of_mpi.iter().filter(|_| !mpi)).map(|library| format!("it needs {library}")));
    let search = ["(RPATH)", "(RUNPATH)"].iter().flat_map(|kind| entries(text, kind));
    faults.extend(search.map(|path| format!("it searches {path}")));
    if text.contains("TEXTREL") {
        faults.push("it has text relocations".into());
    }
    // The stack is executable unless the library has a header that says otherwise.
    let stack = text.lines().find(|line| line.trim_start().starts_with("GNU_STACK"));
    if stack.is_none_or(|line| line.contains(" RWE ")) {
        faults.push("it makes the stack executable".into());
    }
    faults
}

/// The functions that a C header declares.
pub fn declared(header: &str) -> Vec<String> {
    // Outside of comments, whose lines start with a star, only the name of a prototype is followed by a bracket.
    let code = header.lines().filter(|line| !line.trim_start().starts_with(['*', '/']));
    let before_bracket = code.filter_map(|line| line.split_once('(').map(|(before, _)| before));
    let names = before_bracket.filter_map(|before| before.rsplit([' ', '*']).next());
    names.filter(|name| name.starts_with("icoray_")).map(str::to_owned).collect()
}

/// Fails unless the global names that a library defines are these; `-D` in `options` is for shared libraries.
pub fn check_names(library: &Path, options: &[&str], expected: &[String]) -> Result<(), Error> {
    let text = printed("nm", &[&["-g", "--defined-only"], options].concat(), library)?;
    match difference(&text, expected) {
        None => Ok(()),
        Some(difference) => Err(fault(library, &difference)),
    }
}

/// What differs between the names that `nm` prints, in the third words of its lines, and the expected ones.
fn difference(text: &str, expected: &[String]) -> Option<String> {
    let found: BTreeSet<_> = text.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    let expected: BTreeSet<_> = expected.iter().map(String::as_str).collect();
    let (surplus, lacking): (Vec<_>, Vec<_>) =
        (found.difference(&expected).collect(), expected.difference(&found).collect());
    // A comparison of nothing with nothing would always hold.
    let is_same = found == expected && !expected.is_empty();
    (!is_same).then(|| format!("its names are not those declared; not declared: {surplus:?}; not there: {lacking:?}"))
}

fn fault(library: &Path, what: &str) -> Error {
    Error::Failed(format!("{}: {what}", library.display()))
}

fn printed(program: &str, options: &[&str], file: &Path) -> Result<String, Error> {
    // Without translations.
    let output = Command::new(program).env("LC_ALL", "C").args(options).arg(file).output();
    let output = output.map_err(Error::while_doing(program))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(fault(file, &format!("{program}: {}", String::from_utf8_lossy(&output.stderr).trim())))
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

    #[test]
    fn each_fault_is_found() {
        assert_eq!(entries(GOOD, "(NEEDED)"), ["libgcc_s.so.1", "ld-linux-x86-64.so.2"]);
        assert_eq!(faults(GOOD, "libx.so.0", false), [""; 0]);
        assert_eq!(faults(GOOD, "libx.so.0", true), ["it needs no MPI"]);
        for name in ["libmpi.so.40", "libmpich.so.12"] {
            assert_eq!(faults(&GOOD.replace("libgcc_s.so.1", name), "libx.so.0", true), [""; 0]);
        }
        for (from, to, fault) in [
            ("libx.so.0", "libx.so", "its SONAME is [\"libx.so\"], expected \"libx.so.0\""),
            ("(SONAME)", "(OTHER)", "its SONAME is [], expected \"libx.so.0\""),
            ("libgcc_s.so.1", "libmpi.so.40", "it needs libmpi.so.40"),
            ("libgcc_s.so.1", "libnetcdf.so.19", "it needs libnetcdf.so.19"),
            ("\n 0x", "\n 0x1d (RUNPATH)   Library runpath: [/home/me]\n 0x", "it searches /home/me"),
            ("\n 0x", "\n 0x16 (TEXTREL)   0x0\n 0x", "it has text relocations"),
            (" RW ", " RWE ", "it makes the stack executable"),
            ("GNU_STACK", "GNU_RELRO", "it makes the stack executable"),
        ] {
            assert_eq!(faults(&GOOD.replacen(from, to, 1), "libx.so.0", false), [fault]);
        }
    }

    #[test]
    fn names_must_be_those_that_the_header_declares() {
        let header =
            "/* icoray_x(no) */\n * icoray_y(no)\nconst char *icoray_b(void);\nint icoray_a(int a,\n  int b);\n";
        let declared = declared(header);
        assert_eq!(declared, ["icoray_b", "icoray_a"]);
        let nm = "\na.o:\n0000000000000010 T icoray_b\n0000000000000000 T icoray_a\n\nb.o:\n00 D icoray_b\n";
        assert_eq!(difference(nm, &declared), None);
        assert!(difference(&nm.replace("D icoray_b", "T other"), &declared).unwrap().contains("declared: [\"other\"]"));
        assert!(difference("", &declared).unwrap().contains("not there: [\"icoray_a\", \"icoray_b\"]"));
        assert!(difference("", &[]).is_some());
    }
}
