//! Installs the library as a package does, and links programs with it as models do: in C, C++ and Fortran, shared and
//! static, with pkg-config, make and CMake.
//!
//! The installation is moved away from its prefix, so it works only if its files find each other by relative paths. The
//! command lines are those of the README.

use std::fs;
use std::path::{Path, PathBuf};

use xshell::cmd;

use crate::error::Error;
use crate::files;
use crate::install::{self, Layout, SONAME};
use crate::pictures::check_picture;
use crate::step::Step;
use crate::workspace::Workspace;

/// A way to build programs.
struct Way {
    title: &'static str,
    /// Patterns of the sources below the workspace's root; they are copied to an empty directory.
    sources: &'static [&'static str],
    /// The shell commands that build, in that directory.
    build: &'static str,
    /// The shell commands that run the programs, each with the library that is linked.
    programs: &'static [(&'static str, Linkage)],
}

#[derive(Clone, Copy, PartialEq)]
enum Linkage {
    Shared,
    Static,
}
use Linkage::{Shared, Static};

static WAYS: &[Way] = &[
    Way {
        title: "C, shared, found by LD_LIBRARY_PATH",
        sources: &["examples/c/minimal.c"],
        build: "cc minimal.c -o minimal $(pkg-config --cflags --libs icoray) -lm",
        programs: &[("LD_LIBRARY_PATH=$(pkg-config --variable=libdir icoray) ./minimal", Shared)],
    },
    Way {
        title: "C, shared, found by rpath, as strict C99",
        sources: &["examples/c/minimal.c"],
        build: "cc -std=c99 -Wall -Wextra -Werror -pedantic minimal.c -o minimal \
                $(pkg-config --cflags --libs icoray) -lm -Wl,-rpath,$(pkg-config --variable=libdir icoray)",
        programs: &[("./minimal", Shared)],
    },
    Way {
        title: "C, static",
        sources: &["examples/c/minimal.c"],
        build: "cc minimal.c -o minimal $(pkg-config --cflags --libs icoray-static)",
        programs: &[("./minimal", Static)],
    },
    Way {
        title: "C, wholly static",
        sources: &["examples/c/minimal.c"],
        build: "cc -static minimal.c -o minimal $(pkg-config --static --cflags --libs icoray)",
        programs: &[("./minimal", Static)],
    },
    Way {
        title: "C, static, beside all of another Rust static library",
        sources: &["examples/c/minimal.c", "tests/link/two_rusts.c", "tests/link/other.rs"],
        build: "${RUSTC:-rustc} --edition 2024 --crate-type staticlib other.rs && \
                cc -Dmain=draw -c minimal.c $(pkg-config --cflags icoray-static) && \
                cc two_rusts.c minimal.o -o two_rusts -Wl,--whole-archive libother.a -Wl,--no-whole-archive \
                $(pkg-config --libs icoray-static)",
        programs: &[("./two_rusts", Static)],
    },
    Way {
        title: "C, the tracer model, shared and static",
        sources: &["examples/c/*", "examples/scenes/tracer.toml"],
        build: "rm minimal.c && options='-std=c99 -O2 -Wall -Wextra -Werror -pedantic' && \
                cc $options *.c -o shared $(pkg-config --cflags --libs icoray) -lm && \
                cc $options *.c -o static $(pkg-config --cflags --libs icoray-static)",
        programs: &[
            (
                "LD_LIBRARY_PATH=$(pkg-config --variable=libdir icoray) ./shared --level 3 --layers 8 --days 1 \
                 --scene tracer.toml --out pictures",
                Shared,
            ),
            ("./static --level 3 --layers 8 --days 1 --scene tracer.toml --out pictures", Static),
        ],
    },
    Way {
        title: "C++",
        sources: &["tests/link/minimal.cpp"],
        build: "c++ -std=c++11 -Wall -Wextra -Werror -pedantic minimal.cpp -o minimal \
                $(pkg-config --cflags --libs icoray) -Wl,-rpath,$(pkg-config --variable=libdir icoray)",
        programs: &[("./minimal", Shared)],
    },
    Way {
        title: "Fortran, make",
        sources: &["tests/link/Makefile", "examples/fortran/minimal.f90"],
        build: "make",
        programs: &[("LD_LIBRARY_PATH=$(pkg-config --variable=libdir icoray) ./minimal", Shared)],
    },
    Way {
        title: "Fortran, the shallow-water model",
        sources: &["examples/fortran/shallow_water/*", "examples/scenes/shallow_water.toml"],
        build: "make -j2 && LD_LIBRARY_PATH=$(pkg-config --variable=libdir icoray) build/shallow_water --self-test --level 3",
        programs: &[(
            "LD_LIBRARY_PATH=$(pkg-config --variable=libdir icoray) build/shallow_water --level 3 --layers 4 \
             --days 0.5 --scene shallow_water.toml --out pictures",
            Shared,
        )],
    },
    Way {
        title: "C and Fortran, CMake",
        sources: &["tests/link/CMakeLists.txt", "examples/c/minimal.c", "examples/fortran/minimal.f90"],
        build: "cmake -B build && cmake --build build",
        programs: &[
            ("build/c_shared", Shared),
            ("build/c_static", Static),
            ("build/fortran_shared", Shared),
            ("build/fortran_static", Static),
        ],
    },
];

/// Versions that a CMake project requests, and whether it is to find the library.
const VERSIONS: [(&str, bool); 6] =
    [("", true), ("0.1", true), ("0.1.99", false), ("0.2", false), ("1.0", false), ("0.0.9", false)];

/// The check.
pub fn check(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let scratch = workspace.products("tmp").join("link");
    workspace.shell.remove_path(&scratch)?;
    let layout = Layout { prefix: "/opt/icoray".into(), libdir: "lib".into(), destdir: Some(scratch.join("a place")) };
    let built = install::build(workspace, false, true, step)?;
    let installed = install::install(workspace, &built, &layout)?;
    install::check_shared(workspace, &installed.shared, false)?;
    let binary = |(path, what): &(PathBuf, String)| {
        let is_library = path.parent()?.ends_with("lib") && !what.starts_with("->");
        is_library.then(|| format!("{}: {what}", files::name(path)))
    };
    step.note(&installed.files.iter().filter_map(binary).collect::<Vec<_>>().join(", "));

    // Not below "a place": the shell splits the flags that pkg-config prints at blanks.
    let root = scratch.join("prefix");
    fs::rename(layout.root(), &root).map_err(Error::while_doing(root.display()))?;
    let shell = Shell { workspace, root, scratch };
    for way in WAYS {
        shell.check(way, step).map_err(of(way))?;
    }
    shell.check_versions(step)?;
    shell.check_without_library(step)
}

fn of(way: &Way) -> impl FnOnce(Error) -> Error {
    |error| Error::Failed(format!("{}: {error}", way.title))
}

/// A shell that uses the installed library.
struct Shell<'a> {
    workspace: &'a Workspace,
    root: PathBuf,
    scratch: PathBuf,
}

impl Shell<'_> {
    fn directory(&self, way: &Way) -> PathBuf {
        self.scratch.join(way.title.replace([',', ' ', '+'], "_"))
    }

    /// Runs a script in a directory. The library search path that cargo sets would have other builds of the library.
    fn run(&self, script: &str, directory: &Path, step: &mut Step) -> Result<(), Error> {
        let sh = &self.workspace.shell;
        let _in = sh.push_dir(directory);
        let shell = cmd!(sh, "sh -e -c {script}");
        let shell = shell.env_remove("LD_LIBRARY_PATH").env_remove("MAKEFLAGS").env_remove("DESTDIR");
        let shell = shell.env("PKG_CONFIG_PATH", self.root.join("lib/pkgconfig"));
        step.quiet(shell.env("CMAKE_PREFIX_PATH", &self.root))
    }

    /// Copies the files that fit a pattern in the workspace.
    fn copy(&self, pattern: &str, directory: &Path) -> Result<(), Error> {
        let sh = &self.workspace.shell;
        sh.create_dir(directory)?;
        let files = files::fitting(&self.workspace.root, pattern);
        Ok(files.iter().filter(|path| path.is_file()).try_for_each(|file| sh.copy_file(file, directory))?)
    }

    /// Builds the programs, and runs each.
    fn check(&self, way: &Way, step: &mut Step) -> Result<(), Error> {
        let directory = self.directory(way);
        way.sources.iter().try_for_each(|source| self.copy(source, &directory))?;
        self.run(way.build, &directory, step)?;
        way.programs.iter().try_for_each(|(program, _)| self.draw(way, program, step))
    }

    /// Runs a program, which must write pictures.
    fn draw(&self, way: &Way, program: &str, step: &mut Step) -> Result<(), Error> {
        let directory = self.directory(way);
        pictures(&directory).iter().try_for_each(|picture| self.workspace.shell.remove_path(picture))?;
        self.run(program, &directory, step)?;
        let pictures = pictures(&directory);
        if pictures.is_empty() {
            return Err(Error::Failed(format!("{program} left no picture in {}", directory.display())));
        }
        pictures.iter().try_for_each(|picture| check_picture(picture))
    }

    /// Checks that a project finds the library if and only if it requests a compatible version.
    fn check_versions(&self, step: &mut Step) -> Result<(), Error> {
        let directory = self.scratch.join("version");
        self.copy("tests/link/version/CMakeLists.txt", &directory)?;
        for (version, suits) in VERSIONS {
            let script = format!("cmake -B 'build{version}' -DWANTED={version}");
            let found = self.run(&script, &directory, step);
            if found.is_ok() != suits {
                let cause = found.err().map_or("it is found".into(), |error| error.to_string());
                return Err(Error::Failed(format!("CMake, asked for icoray '{version}': {cause}")));
            }
        }
        Ok(())
    }

    /// Checks that without the shared library the programs that were linked with it do not run, and the others do:
    /// otherwise the former use another library, or the latter are not static.
    fn check_without_library(&self, step: &mut Step) -> Result<(), Error> {
        let (here, gone) = (self.root.join("lib").join(SONAME), self.root.join("gone"));
        fs::rename(&here, &gone).map_err(Error::while_doing(here.display()))?;
        for way in WAYS {
            for &(program, linkage) in way.programs {
                let drawn = self.draw(way, program, step);
                match linkage {
                    Static => drawn.map_err(of(way))?,
                    Shared => {
                        let message = drawn.err().map(|error| error.to_string()).unwrap_or_default();
                        if !message.contains(SONAME) {
                            let what = format!("{program} does not miss {SONAME}, which is gone: {message}");
                            return Err(of(way)(Error::Failed(what)));
                        }
                    }
                }
            }
        }
        fs::rename(&gone, &here).map_err(Error::while_doing(here.display()))
    }
}

/// The pictures in a directory and in its subdirectory `pictures`.
fn pictures(directory: &Path) -> Vec<PathBuf> {
    ["*.png", "pictures/*.png"].iter().flat_map(|pattern| files::fitting(directory, pattern)).collect()
}
