//! `cargo xtask gallery`: the pictures of the example scenes, and a page of them.

mod list;
mod page;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;
use crate::host::Host;
use crate::mpi::Mpi;
use crate::options::{GalleryOptions, Size};
use crate::pictures::{Pictures, check_picture};
use crate::requirements;
use crate::shallow_water::{self, ShallowWater};
use crate::step::{Step, Steps, say};
use crate::system;
use crate::tracer::Tracer;
use crate::workspace::Workspace;
use list::{Entry, GALLERY, Subject};
use page::{Numbers, Page};

const FOLDER: &str = "examples/gallery";
const RANKS: usize = 2;

/// Paths and settings of a gallery.
struct Studio<'a> {
    workspace: &'a Workspace,
    profile: &'a str,
    /// Directory of the data files.
    data: PathBuf,
    /// Directory of all pictures: models make more than the page shows.
    out: PathBuf,
    mpi: Option<Mpi>,
}

/// Renders the scenes whose files are there, and writes the page. Other scenes keep their pictures and their part of the page.
pub fn run(workspace: &Workspace, options: &GalleryOptions) -> Result<(), Error> {
    let folder = workspace.root().join(FOLDER);
    let named = env::var_os("ICORAY_TEST_DATA").filter(|named| !named.is_empty());
    let data = named
        .map_or_else(|| workspace.root().join("../shared/data"), |named| workspace.given(named.as_ref()));
    let out = workspace.root().join("out/gallery");
    let mut steps = Steps::new(GALLERY.len() + 3);
    let mpi = steps.run("looking for system packages", |step| {
        system::provide(requirements::FOR_TEST, options.install, step)?;
        let found =
            system::provide(requirements::FOR_DEMO_MPI, options.install, step).and_then(|()| find_mpi());
        if let Err(error) = &found {
            step.note(&format!("the shallow-water model is left out: {}", error.brief()));
        }
        Ok(found.ok())
    })?;
    let studio = Studio { workspace, profile: options.profile, data, out, mpi };
    steps.run("building icoray", |step| studio.build(step))?;
    steps.run("building the models", |step| studio.build_models(step))?;
    let mut page = Page::read(&folder.join("README.md"));
    let mut skipped = Vec::new();
    for entry in GALLERY {
        steps.run(&format!("drawing {}", entry.scene), |step| match studio.lacking(entry) {
            Some(lacking) => {
                step.note(&format!("left out: {lacking} is missing"));
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
    say(&format!("\npage:\n  {}", workspace.shown(&folder.join("README.md"))));
    if !skipped.is_empty() {
        say(&format!("pictures of an earlier run were kept:\n  {}", skipped.join("\n  ")));
    }
    Ok(())
}

fn find_mpi() -> Result<Mpi, Error> {
    Mpi::find(&Host::here()?).map_err(|lack| Error::Failed(lack.why))
}

impl Studio<'_> {
    fn build(&self, step: &mut Step) -> Result<(), Error> {
        let mut cargo = self.workspace.cargo(["build", "--profile", self.profile]);
        cargo.args(["--package", "icoray-cli", "--package", "icoray-capi"]);
        if let Some(model) = self.shallow_water() {
            model.forget_other_mpi(step)?;
            model.tell(cargo.args(["--package", shallow_water::LIBRARY_PACKAGE]), &Host::here()?)?;
        }
        step.quiet(&mut cargo)
    }

    /// Cargo's name for the folder of the profile's products.
    fn products(&self) -> &str {
        if self.profile == "dev" { "debug" } else { self.profile }
    }

    fn tracer(&self) -> Tracer<'_> {
        Tracer::new(self.workspace, self.products())
    }

    /// The model over MPI, where there is what it needs.
    fn shallow_water(&self) -> Option<ShallowWater<'_>> {
        self.mpi.as_ref().map(|mpi| ShallowWater::new(self.workspace, self.profile, mpi))
    }

    fn build_models(&self, step: &mut Step) -> Result<(), Error> {
        step.quiet(&mut self.tracer().compile())?;
        self.shallow_water().map_or(Ok(()), |model| step.quiet(&mut model.compile()))
    }

    /// What an entry needs and is missing.
    fn lacking(&self, entry: &Entry) -> Option<String> {
        let file = match entry.subject {
            Subject::File { name, .. } => name,
            Subject::MadeOcean => list::OCEAN_MESH,
            Subject::ShallowWater if self.mpi.is_none() => return Some("a working MPI with Fortran".into()),
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
            Subject::ShallowWater => match self.shallow_water() {
                Some(model) => step.quiet(&mut model.run(RANKS, &scene, out)?),
                None => Err(Error::Failed("there is no MPI".into())),
            },
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
