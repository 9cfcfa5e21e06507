//! Installs the library as a package would be, and uses it as a model would: in C, C++ and Fortran, shared and static,
//! through pkg-config, make and CMake; a whole model among them.
//!
//! Everything is installed below another directory than the prefix says, so what does not find its parts from where it
//! lies itself does not work. The command lines are those of the README.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::elf;
use crate::error::Error;
use crate::install::{self, Layout, SONAME};
use crate::pictures::check_picture;
use crate::step::Step;
use crate::workspace::Workspace;

/// A way to build programs.
struct Way {
    title: &'static str,
    /// The sources below the workspace's root, files and whole directories; they are copied to an empty directory.
    sources: &'static [&'static str],
    /// What the shell does in that directory.
    build: &'static str,
    /// How each program is run, and which library is in it.
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
        sources: &["examples/c", "examples/scenes/tracer.toml"],
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
        sources: &["examples/fortran/shallow_water", "examples/scenes/shallow_water.toml"],
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

/// Versions that a CMake project may ask for, and whether it is to get the library.
const VERSIONS: [(&str, bool); 6] =
    [("", true), ("0.1", true), ("0.1.99", false), ("0.2", false), ("1.0", false), ("0.0.9", false)];

/// The check.
pub fn check(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let scratch = workspace.products("tmp").join("link");
    if scratch.exists() {
        fs::remove_dir_all(&scratch).map_err(Error::while_doing(scratch.display()))?;
    }
    let layout =
        Layout { prefix: "/opt/icoray".into(), libdir: "lib".into(), destdir: Some(scratch.join("a place")) };
    let built = install::build(workspace, false, true, step)?;
    let installed = install::install(workspace, &built, &layout)?;
    check_library(workspace, &installed.shared, &installed.properties)?;
    let binary = |(path, what): &(PathBuf, String)| {
        let name = path.file_name().unwrap_or_default().display();
        (path.parent()?.ends_with("lib") && !what.starts_with("->")).then(|| format!("{name}: {what}"))
    };
    step.note(&installed.files.iter().filter_map(binary).collect::<Vec<_>>().join(", "));

    // The shell's words end at blanks; pkg-config's answers are for it.
    let root = scratch.join("prefix");
    fs::rename(layout.root(), &root).map_err(Error::while_doing(root.display()))?;
    let shell = Shell { workspace, root, scratch };
    for way in WAYS {
        shell.build(way, step).and_then(|()| shell.run(way, step)).map_err(of(way))?;
    }
    shell.check_versions(step)?;
    shell.check_without_library(step)
}

/// Looks at the installed shared library; the build has compared the symbols.
fn check_library(workspace: &Workspace, library: &Path, properties: &elf::Shared) -> Result<(), Error> {
    let functions = install::functions(workspace)?;
    elf::same_names("the installed library exports", &elf::defined(library, &["-D"])?, &functions)?;
    install::refuse_faults(library, properties, false)
}

fn of(way: &Way) -> impl FnOnce(Error) -> Error {
    |error| Error::Failed(format!("{}: {error}", way.title))
}

/// A user at work with the installed library.
struct Shell<'a> {
    workspace: &'a Workspace,
    root: PathBuf,
    scratch: PathBuf,
}

impl Shell<'_> {
    fn directory(&self, way: &Way) -> PathBuf {
        self.scratch.join(way.title.replace([',', ' ', '+'], "_"))
    }

    /// A shell that knows of the prefix and of nothing else: a search path of cargo's would have other builds.
    fn command(&self, script: &str, directory: &Path) -> Command {
        let mut shell = self.workspace.command("sh");
        shell.args(["-e", "-c", script]).current_dir(directory);
        shell.env_remove("LD_LIBRARY_PATH").env_remove("MAKEFLAGS").env_remove("DESTDIR");
        shell.env("PKG_CONFIG_PATH", self.root.join("lib/pkgconfig")).env("CMAKE_PREFIX_PATH", &self.root);
        shell
    }

    fn build(&self, way: &Way, step: &mut Step) -> Result<(), Error> {
        let directory = self.directory(way);
        for source in way.sources {
            for source in files(&self.workspace.root().join(source))? {
                copy(&source, &directory.join(source.file_name().unwrap_or_default()))?;
            }
        }
        step.quiet(&mut self.command(way.build, &directory))
    }

    /// Runs the way's programs, each of which must leave pictures.
    fn run(&self, way: &Way, step: &mut Step) -> Result<(), Error> {
        way.programs.iter().try_for_each(|(program, _)| self.draw(way, program, step))
    }

    fn draw(&self, way: &Way, program: &str, step: &mut Step) -> Result<(), Error> {
        let directory = self.directory(way);
        for picture in pictures(&directory)? {
            fs::remove_file(&picture).map_err(Error::while_doing(picture.display()))?;
        }
        step.quiet(&mut self.command(program, &directory))?;
        let pictures = pictures(&directory)?;
        if pictures.is_empty() {
            return Err(Error::Failed(format!("{program} left no picture in {}", directory.display())));
        }
        pictures.iter().try_for_each(|picture| check_picture(picture))
    }

    /// A project gets the library if it asks for a version that it is.
    fn check_versions(&self, step: &mut Step) -> Result<(), Error> {
        let directory = self.scratch.join("version");
        copy(
            &self.workspace.root().join("tests/link/version/CMakeLists.txt"),
            &directory.join("CMakeLists.txt"),
        )?;
        for (version, suits) in VERSIONS {
            let script = format!("cmake -B 'build{version}' -DWANTED={version}");
            let found = step.quiet(&mut self.command(&script, &directory));
            if found.is_ok() != suits {
                let cause = found.err().map_or("it is found".into(), |error| error.to_string());
                return Err(Error::Failed(format!("CMake, asked for icoray '{version}': {cause}")));
            }
        }
        Ok(())
    }

    /// Without the shared library the programs that were linked with it do not run, and the others do: otherwise all
    /// of them have found some other library, or the static ones are not.
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

/// The files that a source is: itself, or those in it.
fn files(source: &Path) -> Result<Vec<PathBuf>, Error> {
    if !source.is_dir() {
        return Ok(vec![source.to_path_buf()]);
    }
    let entries = fs::read_dir(source).map_err(Error::while_doing(source.display()))?;
    Ok(entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()).collect())
}

fn copy(from: &Path, to: &Path) -> Result<(), Error> {
    let directory = to.parent().unwrap_or(to);
    fs::create_dir_all(directory)
        .and_then(|()| fs::copy(from, to))
        .map(drop)
        .map_err(|cause| Error::Failed(format!("{} to {}: {cause}", from.display(), to.display())))
}

/// The pictures in a directory and in `pictures` below it.
fn pictures(directory: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut found = Vec::new();
    for directory in [directory.to_path_buf(), directory.join("pictures")] {
        if !directory.is_dir() {
            continue;
        }
        let entries = fs::read_dir(&directory).map_err(Error::while_doing(directory.display()))?;
        found.extend(entries.flatten().map(|entry| entry.path()));
    }
    found.retain(|path| path.extension() == Some(OsStr::new("png")));
    Ok(found)
}
