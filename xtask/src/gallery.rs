//! `cargo xtask gallery`: draws the pictures of the gallery's page by the commands that stand there, and writes their
//! errors and seconds into it.
//!
//! A section of the page has pictures, `![what](file.png)`; the scene with the command,
//! `[x.toml](../scenes/x.toml): ` and the command in backticks; and a line `- what: ` for each picture, which is
//! completed here.

use std::collections::BTreeMap;

use csv::{ReaderBuilder, Trim};

use crate::error::Error;
use crate::models::{MPI_PACKAGE, ShallowWater, compile_tracer};
use crate::mpi::Mpi;
use crate::step::{Step, Steps, print_line};
use crate::workspace::Workspace;
use crate::{book, files, requirements, system};

const FOLDER: &str = "examples/gallery";
const PROFILE: &str = "release";
/// An artificial ocean on a real mesh, which a test writes: no real file is small enough.
const OCEAN: &str = "ocean.nc";

/// A scene of the page.
struct Section<'a> {
    /// The scene's file in `examples/scenes`.
    scene: &'a str,
    /// The command that draws it.
    command: &'a str,
    /// The files of its pictures, as they are drawn.
    pictures: Vec<&'a str>,
}

impl<'a> Section<'a> {
    /// Reads the text of a section; `None` if it has no scene.
    fn parse(text: &'a str) -> Option<Self> {
        let (scene, rest) = text.split_once("](../scenes/")?.1.split_once("): `")?;
        let pictures = text.lines().filter_map(|line| Some(picture(line)?.1)).collect();
        Some(Self { scene, command: rest.split_once('`')?.0, pictures })
    }
}

fn sections(page: &str) -> Vec<Section<'_>> {
    page.split("\n## ").skip(1).filter_map(Section::parse).collect()
}

/// The words and the file of a line with a picture.
fn picture(line: &str) -> Option<(&str, &str)> {
    line.strip_prefix("![")?.strip_suffix(')')?.split_once("](")
}

/// The page with other numbers for some files.
fn with_numbers(page: &str, numbers: &BTreeMap<&str, String>) -> String {
    let mut files = BTreeMap::new();
    let mut text = String::new();
    for line in page.lines() {
        files.extend(picture(line));
        let what = line.strip_prefix("- ").and_then(|line| line.rsplit_once(": ")).map(|(what, _)| what);
        match what.and_then(|what| Some((what, numbers.get(files.get(what)?)?))) {
            Some((what, numbers)) => text += &format!("- {what}: {numbers}\n"),
            None => text += &format!("{line}\n"),
        }
    }
    text
}

/// Errors and cost of one picture, by its last row in the text of `report.csv`.
fn numbers(csv: &str, picture: &str) -> Result<String, Error> {
    let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(csv.as_bytes());
    let rows: Vec<BTreeMap<String, String>> = reader.deserialize().flatten().collect();
    let row = rows.iter().rfind(|row| row.get("file").is_some_and(|file| file == picture));
    let number = |name: &str| {
        let lacking = || Error(format!("report.csv has no {name} of {picture}"));
        row.and_then(|row| row.get(name)?.parse::<f64>().ok()).ok_or_else(lacking)
    };
    let seconds = number("prepare_s")? + number("render_s")?;
    Ok(format!("error ≤ {:.1e}, mean {:.1e}; {seconds:.1} s", number("error_max")?, number("error_mean")?))
}

/// Draws the scenes whose files exist, and writes the page. Other scenes keep their pictures and their numbers.
pub fn run(workspace: &Workspace, install: bool) -> Result<(), Error> {
    let file = workspace.root.join(FOLDER).join("README.md");
    let page = workspace.shell.read_file(&file)?;
    let sections = sections(&page);
    let mut steps = Steps::new(sections.len() + 2);
    let mpi = steps.run("looking for system packages", |step| {
        system::provide(requirements::FOR_C, install, step)?;
        let found = system::provide(requirements::FOR_DEMO_MPI, install, step);
        let found = found.and_then(|()| Mpi::find().map_err(Error));
        if let Err(error) = &found {
            step.note(&format!("the shallow-water model is left out: {}", error.brief()));
        }
        Ok(found.ok())
    })?;
    let model = mpi.as_ref().map(|mpi| ShallowWater::new(workspace, PROFILE, mpi));
    steps.run("building icoray and the models (about 4 minutes)", |step| build(workspace, model.as_ref(), step))?;
    let mut numbers = BTreeMap::new();
    for section in &sections {
        steps.run(&format!("drawing {}", section.scene), |step| {
            match lacking(workspace, section, model.is_some()) {
                Some(lacking) => step.note(&format!("left out: {lacking} is missing; the picture is kept")),
                None => numbers.extend(draw(workspace, section, step)?),
            }
            Ok(())
        })?;
    }
    workspace.shell.write_file(&file, with_numbers(&page, &numbers))?;
    print_line(&format!("\npage:\n  {}", workspace.shown(&file)));
    Ok(())
}

fn build(workspace: &Workspace, model: Option<&ShallowWater>, step: &mut Step) -> Result<(), Error> {
    let cargo = workspace.cargo(["build", "--profile", PROFILE, "--package", "icoray-cli", "--package", "icoray-capi"]);
    if let Some(model) = model {
        model.remove_other_mpi(step)?;
        step.quiet(model.with_mpi(cargo.args(["--package", MPI_PACKAGE])))?;
        step.quiet(model.compile())?;
    } else {
        step.quiet(cargo)?;
    }
    step.quiet(compile_tracer(workspace, PROFILE))
}

/// The file or software that a section's command needs, if it is missing.
fn lacking(workspace: &Workspace, section: &Section, has_mpi: bool) -> Option<String> {
    if section.command.starts_with("mpirun ") && !has_mpi {
        return Some("a working MPI with Fortran".into());
    }
    let words = section.command.split(' ').filter(|word| word.ends_with(".nc") && *word != OCEAN);
    let mut files = words.map(|word| workspace.data().join(word));
    files.find(|file| !file.is_file()).map(|file| workspace.shown(&file))
}

/// Draws a section's pictures into the gallery's folder; returns their numbers.
fn draw<'s>(workspace: &Workspace, section: &Section<'s>, step: &mut Step) -> Result<Vec<(&'s str, String)>, Error> {
    let sh = &workspace.shell;
    let mut script = format!("block={} PATH=$PROGRAMS/shallow_water:$PATH\nmkdir out\n", section.scene);
    if section.command.contains(&format!(" {OCEAN} ")) {
        // The test of an ocean's pictures leaves it.
        script += "export ICORAY_TEST_KEEP=$PWD ICORAY_TEST_DATA=$DATA\n\
                   cargo test --release --package icoray-cli --test cli the_ocean_ends\n";
    }
    let out = if section.command.starts_with("icoray ") { "-o" } else { "--out" };
    script += &format!("{} {out} out\n", section.command);
    let name = format!("gallery/{}", section.scene);
    let command = book::scripted(workspace, &name, PROFILE, &script)?;
    let out = command.get_current_dir().unwrap_or(&workspace.root).join("out");
    step.quiet(command)?;
    let keep = |file: &&'s str| {
        // A Cinema database has a directory and a report of its own.
        let from = files::fitting(&out, &format!("**/{file}")).pop().unwrap_or_else(|| out.join(file));
        sh.copy_file(&from, workspace.root.join(FOLDER).join(file))?;
        let csv = sh.read_file(from.with_file_name("report.csv"))?;
        Ok((*file, numbers(&csv, file)?))
    };
    section.pictures.iter().map(keep).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_scenes_are_on_the_page_with_their_pictures() {
        let workspace = Workspace::find().unwrap();
        let page = workspace.shell.read_file(workspace.root.join(FOLDER).join("README.md")).unwrap();
        let sections = sections(&page);
        let scenes: Vec<_> = sections.iter().map(|section| section.scene.to_owned()).collect();
        for file in files::fitting(&workspace.root, "examples/scenes/*.toml") {
            assert!(scenes.contains(&files::name(&file)), "{}", file.display());
        }
        let pictures: Vec<_> = sections.iter().flat_map(|section| &section.pictures).copied().collect();
        assert!(sections.iter().all(|section| !section.pictures.is_empty()));
        let numbers = pictures.iter().map(|file| (*file, "error ≤ 1, mean 0; 77.0 s".to_owned())).collect();
        assert_eq!(with_numbers(&page, &numbers).matches("77.0 s").count(), pictures.len());
        assert_eq!(with_numbers(&page, &BTreeMap::new()), page);
        let programs = sections.iter().map(|section| section.command.split(' ').next().unwrap());
        assert!(programs.into_iter().all(|program| ["icoray", "tracer", "mpirun"].contains(&program)));
    }

    #[test]
    fn numbers_are_those_of_the_picture() {
        let csv = "file,prepare_s,render_s,error_max,error_mean\na.png,1,2,3,4\n\"b, c.png\",1,0.26,3.456e-4,2e-5\n";
        assert_eq!(numbers(csv, "b, c.png"), Ok("error ≤ 3.5e-4, mean 2.0e-5; 1.3 s".into()));
        assert_eq!(numbers(csv, "c.png"), Err(Error("report.csv has no prepare_s of c.png".into())));
    }
}
