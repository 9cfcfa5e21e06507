//! `cargo xtask install`: builds and installs the C library.

mod catalyst;
mod comin;
mod place;
mod template;

use std::path::{Path, PathBuf};

use xshell::Cmd;

use crate::error::Error;
use crate::options::InstallOptions;
use crate::step::{Step, Steps, print_line};
use crate::workspace::{Workspace, variable};
use crate::{libclang, requirements, system};
use comin::Comin;
use place::{Content, Item};

pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The name by which programs find the library at run time. Its number changes when programs must be compiled anew:
/// with each 0.x, as in Rust and in CMake's version file.
pub const SONAME: &str = "libicoray.so.0.1";
/// The cargo profile, in the workspace's `Cargo.toml`.
const PROFILE: &str = "dist";
/// The Fortran module's source, below the workspace's root.
const FORTRAN: &str = "include/icoray.f90";

fn shared_name() -> String {
    format!("libicoray.so.{VERSION}")
}

/// The directories of an installation.
pub struct Layout {
    /// The prefix at run time.
    pub prefix: PathBuf,
    /// The libraries' directory, relative to the prefix.
    pub libdir: PathBuf,
    /// Put before the prefix while packages are made.
    pub destdir: Option<PathBuf>,
}

/// Builds and installs the library; prints the installed files.
pub fn run(workspace: &Workspace, options: &InstallOptions, may_install: bool) -> Result<(), Error> {
    let layout = Layout {
        prefix: workspace.given(&options.prefix),
        libdir: options.libdir.clone(),
        destdir: variable("DESTDIR").map(|directory| workspace.given(directory)),
    };
    let comin = options.comin.as_ref().map(|prefix| Comin::find(&workspace.given(prefix))).transpose()?;
    // The plugin draws over the ranks of ICON.
    let mpi = options.mpi || comin.is_some();
    let mut steps =
        Steps::new(3 + usize::from(comin.is_some()) + usize::from(options.catalyst) + usize::from(options.command));
    steps.run("looking for system packages", |step| {
        let needed = if mpi { requirements::FOR_INSTALL_MPI } else { requirements::FOR_C };
        let files = if options.command { requirements::FOR_FILES } else { &[] };
        system::provide(&[needed, files].concat(), may_install, step)
    })?;
    // Before the build, which takes minutes.
    layout.check(options.command)?;
    let gpu = !options.no_gpu;
    let title = format!("building the library (about {} minutes)", if gpu { 5 } else { 3 });
    let mut built = steps.run(&title, |step| build(workspace, mpi, gpu, step))?;
    let lib = layout.libdir.as_path();
    if let Some(comin) = &comin {
        let plugin = steps.run("building the plugin", |step| comin.build(workspace, &built.shared, step))?;
        built.others.push((lib.join(comin::PLUGIN), plugin));
    }
    if options.catalyst {
        let title = "building the implementation of Catalyst (about 2 minutes)";
        let library = steps.run(title, |step| catalyst::build(workspace, PROFILE, mpi, gpu, step))?;
        built.others.push((lib.join(catalyst::DIRECTORY).join(catalyst::LIBRARY), library));
    }
    if options.command {
        let title = "building the command (about 3 minutes)";
        let program = steps.run(title, |step| build_command(workspace, mpi, gpu, step))?;
        built.others.push(("bin/icoray".into(), program));
    }
    let installed = steps.run("installing", |step| {
        let installed = install(workspace, &built, &layout)?;
        if options.command {
            let program = workspace.shell.cmd(layout.root().join("bin/icoray"));
            step.quiet(program.arg("manual").arg(layout.root().join("share")))?;
        }
        Ok(installed)
    })?;
    print_line("");
    installed.iter().for_each(|path| print_line(&path.display().to_string()));
    let needed = check_shared(workspace, &layout.root().join(lib).join(SONAME), mpi).quiet().read()?;
    print_line(&format!("\n{SONAME} needs {needed}"));
    let lib = layout.prefix.join(lib);
    print_line(&format!(
        "\nto link with it:\n  export PKG_CONFIG_PATH={}\n  {} model.c $(pkg-config --cflags --libs icoray)",
        lib.join("pkgconfig").display(),
        if mpi { "mpicc" } else { "cc" }
    ));
    if options.command {
        print_line(&format!("\nto run the command:\n  export PATH={}:$PATH", layout.prefix.join("bin").display()));
    }
    if comin.is_some() {
        print_line(&format!(
            "\nto draw from ICON, in its namelist comin_nml:\n  plugin_list(1)%plugin_library = \"{}\"\n  \
             plugin_list(1)%options = \"scene.toml\"",
            lib.join(comin::PLUGIN).display()
        ));
    }
    if options.catalyst {
        print_line(&format!(
            "\nto draw from a host of Catalyst 2, with a path to a scene in its catalyst/scripts:\n  \
             export CATALYST_IMPLEMENTATION_NAME=icoray\n  export CATALYST_IMPLEMENTATION_PATHS={}",
            lib.join(catalyst::DIRECTORY).display()
        ));
    }
    Ok(())
}

/// The built libraries and programs.
pub struct Built {
    shared: PathBuf,
    archive: PathBuf,
    /// Requested files besides the libraries: the path below the prefix, and the file.
    others: Vec<(PathBuf, PathBuf)>,
}

/// Builds both libraries, with MPI or without, and with GPUs or without.
pub fn build(workspace: &Workspace, mpi: bool, gpu: bool, step: &mut Step) -> Result<Built, Error> {
    if mpi {
        // Cargo does not notice another MPI than that of an earlier build.
        step.quiet(workspace.cargo(["clean", "--package", "mpi-sys", "--profile", PROFILE]))?;
    }
    let mut cargo = workspace.cargo(["rustc", "--package", "icoray-capi", "--lib", "--profile", PROFILE]);
    let without_gpu = ["--no-default-features", "--features=live"];
    cargo = cargo
        .args(mpi.then_some("--features=mpi"))
        .args(without_gpu.iter().filter(|_| !gpu))
        .envs(libclang::variable());
    // Not in other profiles: programs find the libraries in target/debug and target/release by their file names.
    step.quiet(cargo.args(["--", "-C"]).arg(format!("link-arg=-Wl,-soname,{SONAME}")))?;
    let products = workspace.products(PROFILE);
    let (shared, reduced) = (products.join("libicoray.so"), products.join("reduced"));
    step.quiet(check_shared(workspace, &shared, mpi))?;
    step.quiet(library(workspace, "reduce", &products.join("libicoray.a")).arg(&reduced))?;
    Ok(Built { shared, archive: reduced.join("libicoray.a"), others: Vec::new() })
}

/// Builds the command as the library is built.
fn build_command(workspace: &Workspace, mpi: bool, gpu: bool, step: &mut Step) -> Result<PathBuf, Error> {
    let cargo = workspace.cargo(["build", "--package", "icoray-cli", "--profile", PROFILE]);
    let cargo = cargo.args((!gpu).then_some("--no-default-features")).args(mpi.then_some("--features=mpi"));
    step.quiet(cargo.envs(libclang::variable()))?;
    Ok(workspace.products(PROFILE).join("icoray"))
}

/// The command by which a shared library must export the functions of the header, and have the properties of an
/// installed one. Prints the libraries that it needs.
pub fn check_shared<'a>(workspace: &'a Workspace, file: &Path, mpi: bool) -> Cmd<'a> {
    library(workspace, "shared", file).arg(SONAME).arg(linkage(mpi))
}

/// The word of `library.sh` for a library with MPI or without.
fn linkage(mpi: bool) -> &'static str {
    if mpi { "mpi" } else { "plain" }
}

/// A task of `library.sh`; its further arguments are to be added.
fn library<'a>(workspace: &'a Workspace, task: &str, file: &Path) -> Cmd<'a> {
    workspace.shell.cmd("bash").arg("xtask/src/install/library.sh").arg(task).arg(file)
}

/// Installs the libraries and the files that belong to them; returns their paths.
pub fn install(workspace: &Workspace, built: &Built, layout: &Layout) -> Result<Vec<PathBuf>, Error> {
    let (header, fortran) = (workspace.root.join("include/icoray.h"), workspace.root.join(FORTRAN));
    let library = shared_name();
    let lib = |name: &str| layout.libdir.join(name);
    let root = layout.root();
    let item = |path: PathBuf, content, mode| Item { path: root.join(path), content, mode };
    let mut items = vec![
        item(lib(&library), Content::File(&built.shared), 0o755),
        // Links follow their targets.
        item(lib(SONAME), Content::Link(&library), 0),
        item(lib("libicoray.so"), Content::Link(SONAME), 0),
        item(lib("libicoray.a"), Content::File(&built.archive), 0o644),
        item(PathBuf::from("include/icoray.h"), Content::File(&header), 0o644),
        item(PathBuf::from(FORTRAN), Content::File(&fortran), 0o644),
    ];
    items.extend(
        template::FILES
            .map(|(path, template)| item(lib(path), Content::Text(template::filled(template, &layout.libdir)), 0o644)),
    );
    items.extend(built.others.iter().map(|(path, file)| item(path.clone(), Content::File(file), 0o755)));
    place::place(&items)?;
    Ok(items.into_iter().map(|item| item.path).collect())
}

impl Layout {
    /// The prefix at the time of installation.
    pub fn root(&self) -> PathBuf {
        match &self.destdir {
            // Joining an absolute prefix would drop DESTDIR.
            Some(destdir) => destdir.join(self.prefix.strip_prefix("/").unwrap_or(&self.prefix)),
            None => self.prefix.clone(),
        }
    }

    /// Fails if files cannot be written to the directories, with those of the command or without.
    fn check(&self, has_command: bool) -> Result<(), Error> {
        let lib = &self.libdir;
        let mut directories = vec![lib.clone(), lib.join("pkgconfig"), lib.join("cmake/icoray"), "include".into()];
        if has_command {
            directories.extend(["bin", "share"].map(PathBuf::from));
        }
        directories.iter().try_for_each(|directory| {
            let directory = self.root().join(directory);
            let existing = directory.ancestors().find(|path| path.exists()).unwrap_or(&directory);
            tempfile::tempfile_in(existing).map(drop).map_err(|cause| {
                let what = format!("cannot write to {}: {cause}", directory.display());
                Error(format!("{what}; --prefix takes another place, such as \"$HOME/.local\""))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn destdir_stands_before_the_prefix() {
        let mut layout = Layout { prefix: "/usr".into(), libdir: "lib".into(), destdir: None };
        assert_eq!(layout.root(), Path::new("/usr"));
        layout.destdir = Some("/tmp/package".into());
        assert_eq!(layout.root(), Path::new("/tmp/package/usr"));
    }

    #[test]
    fn directories_that_cannot_be_written_are_found_before_the_build() {
        let scratch = xshell::Shell::new().unwrap().create_temp_dir().unwrap();
        let at = |prefix: &Path| Layout { prefix: prefix.into(), libdir: "lib".into(), destdir: None };
        assert_eq!(at(&scratch.path().join("a/b")).check(true), Ok(()));
        assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0);
        fs::write(scratch.path().join("file"), "").unwrap();
        assert!(at(&scratch.path().join("file")).check(false).is_err());
        fs::write(scratch.path().join("share"), "").unwrap();
        assert!(at(scratch.path()).check(true).is_err() && at(scratch.path()).check(false).is_ok());
        let message = at(Path::new("/proc/nothing")).check(false).unwrap_err().to_string();
        let start = "cannot write to /proc/nothing/lib: ";
        assert!(message.starts_with(start) && message.contains("; --prefix takes another place"), "{message}");
    }

    #[test]
    fn the_soname_is_the_start_of_the_file_name() {
        assert!(shared_name().starts_with(&format!("{SONAME}.")));
    }

    #[test]
    fn each_fault_of_a_shared_library_is_found() {
        const GOOD: &str = "int icoray_a(void) { return 0; }";
        const MOVED: &str = "int icoray_a(void) { return 0; } __asm__(\".text\\n.quad icoray_a\");";
        let workspace = Workspace::find().unwrap();
        let sh = &workspace.shell;
        let scratch = sh.create_temp_dir().unwrap();
        let [source, file, other, mpi] = ["x.c", "x.so", "o.so", "m.so"].map(|name| scratch.path().join(name));
        let build = |file: &Path, soname: &str, code: &str, options: &[&str]| {
            sh.write_file(&source, code).unwrap();
            let soname = format!("-Wl,-soname,{soname},--no-as-needed");
            xshell::cmd!(sh, "cc -shared -fPIC -o {file} {source} {soname} {options...}").quiet().run().unwrap();
        };
        build(&other, "libother.so.1", GOOD, &[]);
        build(&mpi, "libmpi.so.40", GOOD, &[]);
        let (other, mpi) = (other.to_str().unwrap(), mpi.to_str().unwrap());
        let faults = |code: &str, options: &[&str], is_mpi: bool| {
            build(&file, "libx.so.0", code, options);
            let check = library(&workspace, "shared", &file).args(["libx.so.0", linkage(is_mpi), "icoray_a"]);
            let output = check.quiet().ignore_status().output().unwrap();
            let faults = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.success(), faults.is_empty(), "{faults}");
            faults
        };
        assert_eq!(faults(GOOD, &[], false), "");
        assert_eq!(faults(GOOD, &[mpi], true), "");
        for (code, option, is_mpi, fault) in [
            (GOOD, "-Wl,-soname,libx.so", false, "its SONAME is [libx.so], expected [libx.so.0]"),
            (GOOD, "-lm", true, "it needs no MPI"),
            (GOOD, mpi, false, "it needs libmpi.so.40"),
            (GOOD, other, false, "it needs libother.so.1"),
            (GOOD, "-Wl,-rpath,/home/me", false, "it searches /home/me"),
            (GOOD, "-Wl,-z,execstack", false, "it makes the stack executable"),
            (MOVED, "-Wl,-z,notext", false, "it has text relocations"),
        ] {
            assert_eq!(faults(code, &[option], is_mpi), format!("{}: {fault}\n", file.display()));
        }
        let renamed = faults("int icoray_b(void) { return 0; }", &[], false);
        assert!(renamed.contains("\n-icoray_a\n") && renamed.contains("\n+icoray_b\n"), "{renamed}");
        // Without names, those of the header are expected.
        let output = library(&workspace, "names", &file).quiet().ignore_status().output().unwrap();
        let lacking = String::from_utf8(output.stderr).unwrap();
        assert!(lacking.contains("\n-icoray_execute\n") && lacking.matches("\n-icoray_").count() > 20, "{lacking}");
    }
}
