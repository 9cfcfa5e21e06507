//! Requirements of tests that not every machine has.

/// Something that some tests need and not every machine has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// The long run: see [`is_long`](crate::is_long).
    Long,
    /// An adapter that Vulkan lists, which may be a processor.
    Gpu,
    /// An MPI with its compiler for C.
    Mpi,
    /// MPICH beside another MPI, as Debian names them.
    Mpich,
    /// GNU's Fortran compiler, and MPI's where a test needs both.
    Fortran,
    /// A C++ compiler.
    Cxx,
    /// GNU make.
    Make,
    /// The tools that look into libraries.
    Binutils,
    /// Address and undefined-behaviour sanitizers of the C compiler, in programs that may be run.
    Sanitizers,
    /// Valgrind, in a place where it can run programs.
    Valgrind,
    /// The browser Chromium, and ChromeDriver, which steers it.
    Chromium,
    /// Python 3.10 with environments of its own: `cargo xtask test` runs the tests of the Python package there.
    Python,
    /// mdBook: `cargo xtask test --all` builds the book with it.
    Mdbook,
    /// Counted instructions, by perf or valgrind.
    Counters,
    /// The right to mount a small file system in a namespace of one's own.
    Mount,
    /// The GNU C library, whose allocator can be looked at.
    Glibc,
    /// 6 GB of free memory.
    Memory,
    /// A pseudo-terminal, and `script`, which runs a program on it.
    Terminal,
    /// The library of ICON's ComIn, with its program `comin_replay`, in the prefix that ICORAY_COMIN names, and libnetcdf.
    Comin,
    /// Kitware's libcatalyst with MPI and its headers, in the prefix that ICORAY_CATALYST names.
    Catalyst,
    /// The files of models: see [`data_file`](crate::data_file).
    Data,
}

/// Each need with its name in `ICORAY_REQUIRE`, and what the last lines of `cargo xtask test` say.
const NEEDS: [(Need, &str, &str); 21] = [
    (Need::Long, "long", "only with --all"),
    (Need::Gpu, "gpu", "no Vulkan adapter"),
    (Need::Mpi, "mpi", "no MPI"),
    (Need::Mpich, "mpich", "no MPICH beside another MPI"),
    (Need::Fortran, "fortran", "no gfortran"),
    (Need::Cxx, "c++", "no C++ compiler"),
    (Need::Make, "make", "no make"),
    (Need::Binutils, "binutils", "no binutils"),
    (Need::Sanitizers, "sanitizers", "no sanitizers"),
    (Need::Valgrind, "valgrind", "no valgrind"),
    (Need::Chromium, "chromium", "no Chromium"),
    (Need::Python, "python", "no Python"),
    (Need::Mdbook, "mdbook", "no mdbook"),
    (Need::Counters, "counters", "instructions cannot be counted"),
    (Need::Mount, "mount", "no right to mount a file system"),
    (Need::Glibc, "glibc", "not the GNU C library"),
    (Need::Memory, "memory", "less than 6 GB of free memory"),
    (Need::Terminal, "terminal", "no pseudo-terminal"),
    (Need::Comin, "comin", "no ComIn"),
    (Need::Catalyst, "catalyst", "no libcatalyst"),
    (Need::Data, "data", "no test data"),
];

impl Need {
    fn row(self) -> &'static (Need, &'static str, &'static str) {
        NEEDS.iter().find(|row| row.0 == self).expect("the table has every need")
    }

    /// Its name in `ICORAY_REQUIRE`.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Why a test without it was skipped.
    pub fn cause(self) -> &'static str {
        self.row().2
    }
}

/// The needs in a comma-separated list of names; `all` has every one.
pub(crate) fn required(list: &str) -> Result<Vec<Need>, String> {
    let mut needs = Vec::new();
    for name in list.split(',').map(str::trim).filter(|name| !name.is_empty()) {
        let of_that_name = NEEDS.iter().filter(|row| name == "all" || row.1 == name).map(|row| row.0);
        let before = needs.len();
        needs.extend(of_that_name);
        if needs.len() == before {
            let known: Vec<_> = NEEDS.iter().map(|row| row.1).collect();
            return Err(format!("unknown name `{name}`; known are all, {}", known.join(", ")));
        }
    }
    Ok(needs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_name_needs() {
        assert_eq!(required(""), Ok(vec![]));
        assert_eq!(required("gpu"), Ok(vec![Need::Gpu]));
        assert_eq!(required(" mpi, data,"), Ok(vec![Need::Mpi, Need::Data]));
        assert_eq!(required("all").unwrap().len(), NEEDS.len());
        let error = required("mpi,netcdf").unwrap_err();
        assert!(error.starts_with("unknown name `netcdf`; known are all, long, gpu, "), "{error}");
    }

    #[test]
    fn names_and_causes_differ() {
        for (i, (need, name, cause)) in NEEDS.iter().enumerate() {
            assert_eq!((need.name(), need.cause()), (*name, *cause));
            assert!(NEEDS[..i].iter().all(|other| other.1 != *name && other.2 != *cause), "{name}");
        }
    }
}
