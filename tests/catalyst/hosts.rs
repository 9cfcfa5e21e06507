//! Hosts in C, each with the libcatalyst that it was built against.

use icoray_tests::native::{catalyst_library, command, compile_to, new_directory, root};
use icoray_tests::pictures::{Pictures, assert_drew};
use icoray_tests::ranks::FIRST;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Files in C of the host, from `tests/c`; it makes its mesh with icoray's library.
pub(super) const HOST: [&str; 2] = ["catalyst/host", "catalyst/ball"];
/// Those of the program that gives whole arrays.
pub(super) const DIRECT: [&str; 2] = ["catalyst/direct", "catalyst/ball"];

/// A libcatalyst with the host that was built against it.
pub(super) struct Host {
    pub(super) program: PathBuf,
    /// Directory of libcatalyst-icoray.so.
    pub(super) implementation: PathBuf,
    pub(super) library: PathBuf,
    is_on_ranks: bool,
}

impl Host {
    /// Compiles the host against a header and library.
    pub(super) fn new(directory: &Path, include: &Path, library: &Path, options: &[&str], is_on_ranks: bool) -> Self {
        let implementation = directory.join("implementation");
        if !implementation.is_dir() {
            std::fs::create_dir(&implementation).unwrap();
            std::os::unix::fs::symlink(catalyst_library(), implementation.join("libcatalyst-icoray.so")).unwrap();
        }
        let program = library.with_file_name(if is_on_ranks { "host-mpi" } else { "host" });
        let program = directory.join(program.file_name().unwrap());
        let libraries = library.parent().unwrap();
        let include = format!("-I{}", include.display());
        let (at, rpath) = (format!("-L{}", libraries.display()), format!("-Wl,-rpath,{}", libraries.display()));
        let mut options = [&[include.as_str()], options].concat();
        options.extend(is_on_ranks.then_some("-DHOST_MPI"));
        let compiler = if is_on_ranks { "mpicc" } else { "cc" };
        compile_to(&program, compiler, &options, &HOST, &[&at, "-lcatalyst", &rpath]);
        Host { program, implementation, library: library.to_owned(), is_on_ranks }
    }

    /// Against the double, whose functions of Conduit have other names if `kind` is not empty.
    pub(super) fn of_kind(directory: &Path, kind: &str, is_on_ranks: bool) -> Self {
        let directory = new_directory(directory, &format!("double {kind} {is_on_ranks}"));
        let include = root().join("tests/c/catalyst/double");
        let flag = format!("-I{}", include.display());
        let kind = format!("-D{kind}");
        let options = if kind == "-D" { vec![] } else { vec![kind.as_str()] };
        let library = directory.join("libcatalyst.so");
        let of_library =
            [&[flag.as_str(), "-fPIC", "-shared", "-Wno-pedantic", "-Wl,--as-needed"], &options[..]].concat();
        compile_to(&library, "cc", &of_library, &["catalyst/double/double"], &[]);
        Self::new(&directory, &include, &library, &options, is_on_ranks)
    }

    /// A run on so many ranks.
    pub(super) fn command(&self, ranks: usize, run: &Path, arguments: &[&str]) -> Command {
        let mut command =
            if self.is_on_ranks { FIRST.on_ranks(ranks, &self.program, run) } else { command(&self.program, run) };
        command.args(arguments).env("CATALYST_IMPLEMENTATION_NAME", "icoray");
        command.env("CATALYST_IMPLEMENTATION_PATHS", &self.implementation);
        command.env("LD_LIBRARY_PATH", self.library.parent().unwrap());
        command
    }

    /// What the host printed, which ended well on all ranks and never got another status than that all is well.
    pub(super) fn run(&self, ranks: usize, run: &Path, arguments: &[&str]) -> String {
        ended_well(ranks, &mut self.command(ranks, run, arguments))
    }

    /// Fails where the host or icoray has something to say, or draws other pictures.
    pub(super) fn draws(&self, ranks: usize, run: &Path, arguments: &[&str], expected: &Pictures) {
        let log = self.run(ranks, run, arguments);
        assert!(!log.contains("icoray:"), "{}: {log}", run.display());
        assert_drew(run, expected);
    }
}

pub(super) fn ended_well(ranks: usize, host: &mut Command) -> String {
    let log = icoray_tests::native::ended_well(ranks, host);
    assert!(!log.contains("returned") && log.contains("implementation icoray"), "{log}");
    log
}

/// A directory for a run, with the test's scene: in it are the views that `kind` names or else all, on native heights
/// where there are "hills", and without opacities if it is "opaque".
pub(super) fn prepared(directory: &Path, name: &str, kind: &str) -> PathBuf {
    let scene = std::fs::read_to_string(root().join("tests/c/catalyst/scene.toml")).unwrap();
    let is_shown = |part: &&str| {
        let mut others = ["theta", "q"].into_iter().filter(|field| !has_view(kind, field));
        others.all(|field| !part.contains(&format!("field = \"{field}\"")))
    };
    let shown: Vec<&str> = scene.split("[[views]]").filter(is_shown).collect();
    let heights = if kind.starts_with("hills") { "heights = \"native\"\n" } else { "" };
    let scene = heights.to_owned() + &shown.join("[[views]]");
    let is_kept = |line: &&str| kind != "opaque" || !line.starts_with("transfer.opacity");
    let to = new_directory(directory, name);
    std::fs::write(to.join("scene.toml"), scene.lines().filter(is_kept).collect::<Vec<_>>().join("\n")).unwrap();
    to
}

/// Whether the scene of a kind has a view of a field.
pub(super) fn has_view(kind: &str, field: &str) -> bool {
    kind.split_once(' ').is_none_or(|(_, only)| only == field)
}
