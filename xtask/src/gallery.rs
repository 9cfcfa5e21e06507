//! `cargo xtask gallery`: the pictures of the example scenes, and a page of them.

mod list;
mod page;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;
use crate::options::{GalleryOptions, Size};
use crate::pictures::{Pictures, check_picture};
use crate::requirements;
use crate::shallow_water::{self, ShallowWater};
use crate::step::{Step, Steps, say};
use crate::system;
use crate::tracer::{Linkage, Tracer};
use crate::workspace::Workspace;
use list::{Entry, GALLERY, Subject};
use page::{Numbers, Page};

const FOLDER: &str = "examples/gallery";
const RANKS: usize = 2;

/// What the pictures are made with.
struct Studio<'a> {
    workspace: &'a Workspace,
    profile: &'a str,
    /// Where real files are.
    data: PathBuf,
    /// Where all is drawn: models make more pictures than the page shows.
    out: PathBuf,
    with_mpi: bool,
}

/// Draws what there are files for, and writes the page. What cannot be drawn keeps its pictures and what the page says.
pub fn run(workspace: &Workspace, options: &GalleryOptions) -> Result<(), Error> {
    let folder = workspace.root().join(FOLDER);
    let named = env::var_os("ICORAY_TEST_DATA").filter(|named| !named.is_empty());
    let data = named
        .map_or_else(|| workspace.root().join("../shared/data"), |named| workspace.given(named.as_ref()));
    let out = workspace.root().join("out/gallery");
    let mut steps = Steps::new(GALLERY.len() + 3);
    let with_mpi = steps.run("looking for system packages", |step| {
        system::provide(requirements::FOR_TEST, options.install, step)?;
        Ok(system::provide_for("the shallow-water model", requirements::FOR_DEMO_MPI, options.install, step))
    })?;
    let studio = Studio { workspace, profile: options.profile, data, out, with_mpi };
    steps.run("building icoray", |step| step.quiet(&mut studio.build()))?;
    steps.run("building the models", |step| studio.build_models(step))?;
    let mut page = Page::read(&folder.join("README.md"));
    let mut skipped = Vec::new();
    for entry in GALLERY {
        steps.run(&format!("drawing {}", entry.scene), |step| match studio.lacking(entry) {
            Some(lacking) => {
                step.note(&format!("left out, for want of {lacking}"));
                skipped.push(entry.scene);
                Ok(())
            }
            None => {
                page.put(entry, &studio.draw(entry, &folder, step)?);
                Ok(())
            }
        })?;
    }
    page.write(&folder.join("README.md"))?;
    say(&format!("\nthe page:\n  {}", workspace.shown(&folder.join("README.md"))));
    if !skipped.is_empty() {
        say(&format!("left as they were:\n  {}", skipped.join("\n  ")));
    }
    Ok(())
}

impl Studio<'_> {
    fn build(&self) -> Command {
        let mut cargo = self.workspace.cargo(["build", "--profile", self.profile]);
        cargo.args(["--package", "icoray-cli", "--package", "icoray-capi"]);
        if self.with_mpi {
            // The compiler that Fortran's programs are linked with.
            cargo.args(["--package", shallow_water::LIBRARY_PACKAGE]).env_remove("MPICC");
        }
        cargo
    }

    /// Cargo's name for the folder of the profile's products.
    fn products(&self) -> &str {
        if self.profile == "dev" { "debug" } else { self.profile }
    }

    fn tracer(&self) -> Tracer<'_> {
        Tracer::new(self.workspace, self.products(), Linkage::Shared)
    }

    fn shallow_water(&self) -> ShallowWater<'_> {
        ShallowWater::new(self.workspace, self.products())
    }

    fn build_models(&self, step: &mut Step) -> Result<(), Error> {
        step.quiet(&mut self.tracer().compile())?;
        if self.with_mpi { step.quiet(&mut self.shallow_water().compile()) } else { Ok(()) }
    }

    /// What is not there of that which the pictures are made of.
    fn lacking(&self, entry: &Entry) -> Option<String> {
        let file = match entry.subject {
            Subject::File { name, .. } => name,
            Subject::MadeOcean => list::OCEAN_MESH,
            Subject::ShallowWater if !self.with_mpi => return Some("MPI and gfortran".into()),
            Subject::Tracer | Subject::ShallowWater => return None,
        };
        let path = self.data.join(file);
        (!path.is_file()).then(|| self.workspace.shown(&path))
    }

    /// Draws an entry's pictures into the gallery's folder, and returns what they cost.
    fn draw(&self, entry: &Entry, folder: &Path, step: &mut Step) -> Result<Vec<Numbers>, Error> {
        let drawn = Pictures::new(self.out.join(entry.scene.trim_end_matches(".toml")), "");
        drawn.prepare()?;
        self.make(entry, drawn.folder(), step)?;
        fs::create_dir_all(folder).map_err(Error::while_doing(folder.display()))?;
        let keep = |picture: &list::Picture| {
            let (from, to) = (drawn.folder().join(picture.drawn), folder.join(picture.file));
            check_picture(&from)?;
            fs::copy(&from, &to).map_err(Error::while_doing(to.display()))?;
            // Each folder has its report; a database is a folder.
            let report = from.with_file_name("report.csv");
            let csv = fs::read_to_string(&report).map_err(Error::while_doing(report.display()))?;
            let name = picture.drawn.rsplit('/').next().unwrap_or_default();
            Numbers::of(&csv, name)
        };
        entry.pictures.iter().map(keep).collect()
    }

    fn make(&self, entry: &Entry, out: &Path, step: &mut Step) -> Result<(), Error> {
        let scene = self.workspace.root().join("examples/scenes").join(entry.scene);
        match entry.subject {
            Subject::File { name, time, options } => {
                let mut render = self.render(&scene, out);
                step.quiet(render.arg(self.data.join(name)).args(["--time", time]).args(options))
            }
            Subject::MadeOcean => {
                let mesh = self.data.join(list::OCEAN_MESH);
                step.quiet(&mut self.make_ocean(out))?;
                step.quiet(self.render(&scene, out).arg(out.join("ocean.nc")).arg("--mesh").arg(mesh))
            }
            Subject::Tracer => step.quiet(&mut self.tracer().run(list::TRACER, &scene, out)?),
            Subject::ShallowWater => step.quiet(&mut self.shallow_water().run(RANKS, &scene, out)?),
        }
    }

    fn render(&self, scene: &Path, out: &Path) -> Command {
        let mut icoray = self.workspace.command(self.workspace.products(self.products()).join("icoray"));
        icoray.arg("render").arg("--scene").arg(scene).arg("-o").arg(out);
        icoray
    }

    /// The test of an ocean's pictures leaves the file that it makes of a real mesh.
    fn make_ocean(&self, out: &Path) -> Command {
        let mut cargo = self.workspace.cargo(["test", "--profile", self.profile, "--package", "icoray-cli"]);
        cargo.args(["--test", "cli", "the_ocean_ends"]);
        cargo.env("ICORAY_TEST_KEEP", out).env("ICORAY_TEST_DATA", &self.data);
        cargo
    }
}

impl Entry {
    /// The command that a reader types for the same pictures.
    fn command(&self) -> String {
        let scene = format!("examples/scenes/{}", self.scene);
        match self.subject {
            Subject::File { name, time, options } => {
                let more = options.iter().fold(String::new(), |text, word| text + " " + word);
                format!("icoray render {name} --scene {scene} --time {time}{more}")
            }
            Subject::MadeOcean => {
                format!("icoray render ocean.nc --mesh {} --scene {scene}", list::OCEAN_MESH)
            }
            Subject::Tracer => {
                let Size { level, layers, days } = list::TRACER;
                format!("tracer --level {level} --layers {layers} --days {days} --scene {scene}")
            }
            Subject::ShallowWater => {
                let size = shallow_water::SIZE.join(" ");
                format!("mpirun -n {RANKS} shallow_water {size} --scene {scene}")
            }
        }
    }
}
