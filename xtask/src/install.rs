//! `cargo xtask install`: the C library, where models find it.

mod archive;
mod place;
mod template;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use crate::disk;
use crate::elf::{self, Shared};
use crate::error::Error;
use crate::host::Host;
use crate::libclang;
use crate::options::InstallOptions;
use crate::requirements;
use crate::step::{Step, Steps, say};
use crate::system;
use crate::workspace::Workspace;
use place::{Content, Item};

/// The version of the whole workspace.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The name that programs look for at run time. Its number changes when a program that was compiled before could no
/// longer run: with each 0.x, as it is for Rust and for CMake's version file.
pub const SONAME: &str = "libicoray.so.0.1";
/// The cargo profile, in the workspace's `Cargo.toml`.
const PROFILE: &str = "dist";
/// Megabytes that the build takes.
const SPACE: u64 = 1000;
/// The Fortran module's source, below the workspace's root.
const FORTRAN: &str = "include/icoray.f90";

/// The shared library's file.
fn shared_name(version: &str) -> String {
    format!("libicoray.so.{version}")
}

/// Where things go.
pub struct Layout {
    /// The prefix as programs will know it.
    pub prefix: PathBuf,
    /// The libraries' place below the prefix.
    pub libdir: PathBuf,
    /// Stands before the prefix while packages are made.
    pub destdir: Option<PathBuf>,
}

/// What was installed.
pub struct Installed {
    /// Each file with its size, or what it links to.
    pub files: Vec<(PathBuf, String)>,
    /// The shared library.
    pub shared: PathBuf,
    /// What it says of itself.
    pub properties: Shared,
}

/// Installs, and says what.
pub fn run(workspace: &Workspace, options: &InstallOptions) -> Result<(), Error> {
    let layout = Layout {
        prefix: workspace.given(&options.prefix),
        libdir: options.libdir.clone(),
        destdir: env::var_os("DESTDIR")
            .filter(|dir| !dir.is_empty())
            .map(|dir| workspace.given(Path::new(&dir))),
    };
    let mut steps = Steps::new(3);
    steps.run("looking for system packages", |step| {
        let needed = if options.mpi { requirements::FOR_INSTALL_MPI } else { requirements::FOR_INSTALL };
        system::provide(needed, options.install, step)
    })?;
    // Found out now rather than after the build.
    layout.check()?;
    disk::has_space(
        &workspace.products(PROFILE),
        SPACE,
        "free some, or let CARGO_TARGET_DIR name a directory on another disk",
    )?;
    let built = steps.run("building the library", |step| build(workspace, options.mpi, options.gpu, step))?;
    let installed = steps.run("installing", |_| install(workspace, &built, &layout))?;
    say("");
    let width = installed.files.iter().map(|(path, _)| path.as_os_str().len()).max().unwrap_or_default();
    for (path, what) in &installed.files {
        say(&format!("{:<width$}  {what:>10}", path.display()));
    }
    let Shared { soname, needed, .. } = &installed.properties;
    say(&format!("\n{} needs {}", soname.as_deref().unwrap_or_default(), needed.join(", ")));
    say(&format!(
        "\nto link with it:\n  export PKG_CONFIG_PATH={}\n  {} model.c $(pkg-config --cflags --libs icoray)",
        layout.prefix.join(&layout.libdir).join("pkgconfig").display(),
        if options.mpi { "mpicc" } else { "cc" }
    ));
    Ok(())
}

/// The libraries as built, before they are installed.
pub struct Built {
    shared: PathBuf,
    archive: PathBuf,
}

/// Builds both libraries, with MPI or without, and with GPUs or without.
pub fn build(workspace: &Workspace, mpi: bool, gpu: bool, step: &mut Step) -> Result<Built, Error> {
    if mpi {
        // Cargo does not see that there is another MPI than before.
        step.quiet(&mut workspace.cargo(["clean", "--package", "mpi-sys", "--profile", PROFILE]))?;
    }
    let mut cargo = workspace.cargo(["rustc", "--package", "icoray-capi", "--lib", "--profile", PROFILE]);
    cargo.args(mpi.then_some("--features=mpi")).args((!gpu).then_some("--no-default-features"));
    if mpi {
        libclang::tell(&mut cargo, &Host::here()?)?;
    }
    // Only here: the libraries in target/debug and target/release are found by the names that they have there.
    step.quiet(cargo.args(["--", "-C"]).arg(format!("link-arg=-Wl,-soname,{SONAME}")))?;
    let products = workspace.products(PROFILE);
    let shared = products.join("libicoray.so");
    let functions = functions(workspace)?;
    elf::same_names("the shared library exports", &elf::defined(&shared, &["-D"])?, &functions)?;
    refuse_faults(&shared, &Shared::read(&shared)?, mpi)?;
    let directory = products.join("reduced");
    let archive = archive::reduce(workspace, &products.join("libicoray.a"), &functions, &directory, step)?;
    Ok(Built { shared, archive })
}

/// Fails where a shared library is not as an installed one should be.
pub fn refuse_faults(library: &Path, properties: &Shared, mpi: bool) -> Result<(), Error> {
    let complaints = properties.complaints(SONAME, mpi);
    if complaints.is_empty() {
        return Ok(());
    }
    Err(Error::Failed(format!("{}: {}", library.display(), complaints.join("; "))))
}

/// The functions that the header declares.
pub fn functions(workspace: &Workspace) -> Result<Vec<String>, Error> {
    let header = workspace.root().join("include/icoray.h");
    let text = fs::read_to_string(&header).map_err(Error::while_doing(header.display()))?;
    Ok(elf::declared(&text))
}

/// Puts everything in its place.
pub fn install(workspace: &Workspace, built: &Built, layout: &Layout) -> Result<Installed, Error> {
    let (header, fortran) = (workspace.root().join("include/icoray.h"), workspace.root().join(FORTRAN));
    let text = |template| Content::Text(template::filled(template, &layout.libdir, VERSION));
    let library = shared_name(VERSION);
    let lib = |name: &str| layout.libdir.join(name);
    let root = layout.root();
    let item = |path: PathBuf, content, mode| Item { path: root.join(path), content, mode };
    let items = [
        item(lib(&library), Content::File(&built.shared), 0o755),
        // The links after what they lead to.
        item(lib(SONAME), Content::Link(&library), 0),
        item(lib("libicoray.so"), Content::Link(SONAME), 0),
        item(lib("libicoray.a"), Content::File(&built.archive), 0o644),
        item(PathBuf::from("include/icoray.h"), Content::File(&header), 0o644),
        item(PathBuf::from(FORTRAN), Content::File(&fortran), 0o644),
        item(lib("pkgconfig/icoray.pc"), text(template::PKG_CONFIG), 0o644),
        item(lib("pkgconfig/icoray-static.pc"), text(template::PKG_CONFIG_STATIC), 0o644),
        item(lib("cmake/icoray/icorayConfig.cmake"), text(template::CMAKE), 0o644),
        item(lib("cmake/icoray/icorayConfigVersion.cmake"), text(template::CMAKE_VERSION), 0o644),
    ];
    place::place(&items)?;
    let mut files = Vec::new();
    for Item { path, content, .. } in items {
        let what = match content {
            Content::Link(target) => format!("-> {target}"),
            _ => kilobytes(fs::metadata(&path).map_err(Error::while_doing(path.display()))?.len()),
        };
        files.push((path, what));
    }
    let shared = root.join(lib(&library));
    let properties = Shared::read(&shared)?;
    Ok(Installed { files, shared, properties })
}

impl Layout {
    /// The prefix where it is now.
    pub fn root(&self) -> PathBuf {
        match &self.destdir {
            // Joined as it is, an absolute prefix would be all that is left.
            Some(destdir) => destdir.join(self.prefix.strip_prefix("/").unwrap_or(&self.prefix)),
            None => self.prefix.clone(),
        }
    }

    /// Fails where files could not be put in their places.
    fn check(&self) -> Result<(), Error> {
        let lib = &self.libdir;
        let directories = [lib.clone(), lib.join("pkgconfig"), lib.join("cmake/icoray"), "include".into()];
        directories.iter().try_for_each(|directory| place::check(&self.root().join(directory)))
    }
}

fn kilobytes(bytes: u64) -> String {
    format!("{} kB", bytes.div_ceil(1000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn destdir_stands_before_the_prefix() {
        let mut layout = Layout { prefix: "/usr".into(), libdir: "lib".into(), destdir: None };
        assert_eq!(layout.root(), Path::new("/usr"));
        layout.destdir = Some("/tmp/package".into());
        assert_eq!(layout.root(), Path::new("/tmp/package/usr"));
    }

    #[test]
    fn the_soname_is_the_start_of_the_file_name() {
        assert!(shared_name(VERSION).starts_with(&format!("{SONAME}.")));
        assert_eq!(kilobytes(2_108_120), "2109 kB");
    }
}
