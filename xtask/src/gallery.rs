//! `cargo xtask gallery`: renders the example scenes, and writes a page with their pictures.

mod list;
mod page;

use std::path::{Path, PathBuf};

use xshell::{Cmd, cmd};

use crate::error::Error;
use crate::files;
use crate::host::Host;
use crate::mpi::Mpi;
use crate::options::Size;
use crate::pictures::{Pictures, check_picture};
use crate::requirements;
use crate::shallow_water::{self, ShallowWater};
use crate::step::{Step, Steps, print_line};
use crate::system;
use crate::tracer::Tracer;
use crate::workspace::Workspace;
use list::{Entry, GALLERY, Subject};
use page::{Numbers, Page};

const FOLDER: &str = "examples/gallery";
const RANKS: usize = 2;

/// Renders the scenes of the gallery.
struct Gallery<'a> {
    workspace: &'a Workspace,
    profile: &'a str,
    /// Directory of the data files.
    data: PathBuf,
    /// Directory of all pictures; models write more than the page shows.
    out: PathBuf,
    mpi: Option<Mpi>,
}

/// Renders the scenes whose files exist, and writes the page. Other scenes keep their pictures and their sections.
pub fn run(workspace: &Workspace, profile: &str, install: bool) -> Result<(), Error> {
    let folder = workspace.root.join(FOLDER);
    let (data, out) = (workspace.data(), workspace.root.join("out/gallery"));
    let mut steps = Steps::new(GALLERY.len() + 3);
    let mpi = steps.run("looking for system packages", |step| {
        system::provide(requirements::FOR_TEST, install, step)?;
        let found = system::provide(requirements::FOR_DEMO_MPI, install, step);
        let found = found.and_then(|()| Ok(Mpi::find(&Host::here()?)?));
        if let Err(error) = &found {
            step.note(&format!("the shallow-water model is left out: {}", error.brief()));
        }
        Ok(found.ok())
    })?;
    let gallery = Gallery { workspace, profile, data, out, mpi };
    steps.run("building icoray", |step| gallery.build(step))?;
    steps.run("building the models", |step| gallery.build_models(step))?;
    let mut page = Page::read(&folder.join("README.md"));
    let mut skipped = Vec::new();
    for entry in GALLERY {
        steps.run(&format!("drawing {}", entry.scene), |step| match gallery.lacking(entry) {
            Some(lacking) => {
                step.note(&format!("left out: {lacking} is missing"));
                skipped.push(entry.scene);
                Ok(())
            }
            None => {
                page.put(entry, &gallery.draw(entry, &folder, step)?);
                Ok(())
            }
        })?;
    }
    page.write(&folder.join("README.md"))?;
    print_line(&format!("\npage:\n  {}", workspace.shown(&folder.join("README.md"))));
    if !skipped.is_empty() {
        print_line(&format!("pictures of an earlier run were kept:\n  {}", skipped.join("\n  ")));
    }
    Ok(())
}

impl Gallery<'_> {
    fn build(&self, step: &mut Step) -> Result<(), Error> {
        let cargo = self.workspace.cargo(["build", "--profile", self.profile]);
        let mut cargo = cargo.args(["--package", "icoray-cli", "--package", "icoray-capi"]);
        if let Some(model) = self.shallow_water() {
            model.remove_other_mpi(step)?;
            cargo = model.with_mpi(cargo.args(["--package", shallow_water::LIBRARY_PACKAGE]), &Host::here()?)?;
        }
        step.quiet(cargo)
    }

    fn tracer(&self) -> Tracer<'_> {
        Tracer::new(self.workspace, self.profile)
    }

    /// The model over MPI, if there is an MPI.
    fn shallow_water(&self) -> Option<ShallowWater<'_>> {
        self.mpi.as_ref().map(|mpi| ShallowWater::new(self.workspace, self.profile, mpi))
    }

    fn build_models(&self, step: &mut Step) -> Result<(), Error> {
        step.quiet(self.tracer().compile())?;
        self.shallow_water().map_or(Ok(()), |model| step.quiet(model.compile()))
    }

    /// The file or software that an entry needs, if it is missing.
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
        let sh = &self.workspace.shell;
        let drawn = self.out.join(entry.scene.trim_end_matches(".toml"));
        Pictures::new(self.workspace, drawn.clone(), "").prepare()?;
        self.make(entry, &drawn, step)?;
        sh.create_dir(folder)?;
        let keep = |picture: &list::Picture| {
            let from = drawn.join(picture.drawn);
            check_picture(&from)?;
            sh.copy_file(&from, folder.join(picture.file))?;
            // Each directory has its report, that of a Cinema database too.
            let csv = sh.read_file(from.with_file_name("report.csv"))?;
            Numbers::of(&csv, &files::name(&from))
        };
        entry.pictures.iter().map(keep).collect()
    }

    fn make(&self, entry: &Entry, out: &Path, step: &mut Step) -> Result<(), Error> {
        let scene = self.workspace.root.join("examples/scenes").join(entry.scene);
        match entry.subject {
            Subject::File { name, time, options } => {
                let render = self.render(&scene, out).arg(self.data.join(name));
                step.quiet(render.args(["--time", time]).args(options))
            }
            Subject::MadeOcean => {
                let mesh = self.data.join(list::OCEAN_MESH);
                step.quiet(self.make_ocean(out))?;
                step.quiet(self.render(&scene, out).arg(out.join("ocean.nc")).arg("--mesh").arg(mesh))
            }
            Subject::Tracer => step.quiet(self.tracer().run(list::TRACER, &scene, out)?),
            Subject::ShallowWater => match self.shallow_water() {
                Some(model) => step.quiet(model.run(RANKS, &scene, out)?),
                None => Err(Error::Failed("there is no MPI".into())),
            },
        }
    }

    fn render(&self, scene: &Path, out: &Path) -> Cmd<'_> {
        let icoray = self.workspace.products(self.profile).join("icoray");
        cmd!(self.workspace.shell, "{icoray} render --scene {scene} -o {out}")
    }

    /// Runs the test of an ocean's pictures, which writes an ocean on a real mesh to the directory.
    fn make_ocean(&self, out: &Path) -> Cmd<'_> {
        let cargo = self.workspace.cargo(["test", "--profile", self.profile, "--package", "icoray-cli"]);
        let cargo = cargo.args(["--test", "cli", "the_ocean_ends"]);
        cargo.env("ICORAY_TEST_KEEP", out).env("ICORAY_TEST_DATA", &self.data)
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
