//! Requirements of tests that not every machine has.

/// Declares the needs: each with its name in `ICORAY_REQUIRE`, and what the last lines of `cargo xtask test` say.
macro_rules! needs {
    ($($(#[$doc:meta])* $need:ident $name:literal, $cause:literal;)*) => {
        /// Something that some tests need and not every machine has.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Need {
            $($(#[$doc])* $need,)*
        }

        const NEEDS: &[Need] = &[$(Need::$need),*];

        impl Need {
            /// Its name in `ICORAY_REQUIRE`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Need::$need => $name,)*
                }
            }

            /// Why a test without it was skipped.
            pub fn cause(self) -> &'static str {
                match self {
                    $(Need::$need => $cause,)*
                }
            }
        }
    };
}

needs! {
    /// The long run: see [`is_long`](crate::is_long).
    Long "long", "only with --all";
    /// An adapter that Vulkan lists, which may be a processor.
    Gpu "gpu", "no Vulkan adapter";
    /// An MPI with its compiler for C.
    Mpi "mpi", "no MPI";
    /// MPICH beside another MPI, as Debian names them.
    Mpich "mpich", "no MPICH beside another MPI";
    /// GNU's Fortran compiler, and MPI's where a test needs both.
    Fortran "fortran", "no gfortran";
    /// A C++ compiler.
    Cxx "c++", "no C++ compiler";
    /// GNU make.
    Make "make", "no make";
    /// The tools that look into libraries.
    Binutils "binutils", "no binutils";
    /// Address and undefined-behaviour sanitizers of the C compiler, in programs that may be run.
    Sanitizers "sanitizers", "no sanitizers";
    /// Valgrind, in a place where it can run programs.
    Valgrind "valgrind", "no valgrind";
    /// The browser Chromium, and ChromeDriver, which steers it.
    Chromium "chromium", "no Chromium";
    /// Python 3.10 with environments of its own: `cargo xtask test` runs the tests of the Python package there.
    Python "python", "no Python";
    /// mdBook: `cargo xtask test --all` builds the book with it.
    Mdbook "mdbook", "no mdbook";
    /// Counted instructions, by perf or valgrind.
    Counters "counters", "instructions cannot be counted";
    /// The right to mount a small file system in a namespace of one's own.
    Mount "mount", "no right to mount a file system";
    /// The GNU C library, whose allocator can be looked at.
    Glibc "glibc", "not the GNU C library";
    /// 6 GB of free memory.
    Memory "memory", "less than 6 GB of free memory";
    /// A pseudo-terminal, and `script`, which runs a program on it.
    Terminal "terminal", "no pseudo-terminal";
    /// The library of ICON's ComIn, with its program `comin_replay`, in the prefix that ICORAY_COMIN names, and
    /// libnetcdf.
    Comin "comin", "no ComIn";
    /// Kitware's libcatalyst with MPI and its headers, in the prefix that ICORAY_CATALYST names.
    Catalyst "catalyst", "no libcatalyst";
    /// A NetCDF library that reads Zarr.
    Zarr "zarr", "the NetCDF library has no Zarr";
    /// The files of models: see [`data_file`](crate::data_file).
    Data "data", "no test data";
}

/// The needs in a comma-separated list of names; `all` has every one.
pub(crate) fn required(list: &str) -> Result<Vec<Need>, String> {
    let mut needs = Vec::new();
    for name in list.split(',').map(str::trim).filter(|name| !name.is_empty()) {
        let before = needs.len();
        needs.extend(NEEDS.iter().filter(|need| name == "all" || need.name() == name));
        if needs.len() == before {
            let known: Vec<_> = NEEDS.iter().map(|need| need.name()).collect();
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
        for (i, need) in NEEDS.iter().enumerate() {
            let mut others = NEEDS[..i].iter();
            assert!(others.all(|other| other.name() != need.name() && other.cause() != need.cause()), "{need:?}");
        }
    }
}
