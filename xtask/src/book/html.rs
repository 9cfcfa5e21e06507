//! Builds the book with mdBook, and checks the links of what it wrote.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::step::Step;
use crate::system::succeeds;
use crate::workspace::Workspace;

/// Where `docs/book.toml` puts the book.
const BUILT: &str = "docs/book";
/// The version that is installed where there is none.
const VERSION: &str = "0.4.52";

/// Builds the book.
///
/// # Errors
/// Where mdBook fails, or a link of a page leads nowhere; where mdBook cannot be had and `ICORAY_REQUIRE` names `mdbook`.
pub fn build(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let program = match mdbook(workspace, step) {
        Ok(program) => program,
        Err(error) => {
            let required = env::var("ICORAY_REQUIRE").unwrap_or_default();
            if required.split(',').any(|word| word == "mdbook") {
                return Err(error);
            }
            step.note(&format!("skipped: no mdbook, and cargo cannot install it\n{error}"));
            return Ok(());
        }
    };
    step.quiet(workspace.command(program).args(["build", "docs"]))?;
    let built = workspace.root().join(BUILT);
    let mut faults = Vec::new();
    for page in pages(&built)? {
        faults.extend(repaired(&page)?);
    }
    if faults.is_empty() { Ok(()) } else { Err(Error::Failed(faults.join("\n"))) }
}

/// An installed mdBook, or one that cargo installs beside the builds.
fn mdbook(workspace: &Workspace, step: &mut Step) -> Result<OsString, Error> {
    let tools = workspace.products("tools");
    let own = tools.join("bin/mdbook");
    for program in [OsString::from("mdbook"), own.clone().into()] {
        if succeeds(&program, ["--version"]) {
            return Ok(program);
        }
    }
    let mut cargo =
        workspace.cargo(["install", "mdbook", "--locked", "--no-default-features", "--version", VERSION]);
    step.quiet(cargo.arg("--root").arg(&tools))?;
    Ok(own.into())
}

/// The pages that mdBook wrote, without the one for printing, whose links are those of all pages.
fn pages(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut pages = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::while_doing(folder.display()))? {
        let path = entry.map_err(Error::while_doing(folder.display()))?.path();
        if path.is_dir() {
            pages.extend(self::pages(&path)?);
        } else if path.extension().is_some_and(|ending| ending == "html") && !path.ends_with("print.html") {
            pages.push(path);
        }
    }
    Ok(pages)
}

/// Repairs links of a page to Markdown files outside the book, whose ending mdBook replaces; returns links that lead nowhere.
fn repaired(page: &Path) -> Result<Vec<String>, Error> {
    let text = fs::read_to_string(page).map_err(Error::while_doing(page.display()))?;
    let (mut repaired, mut faults) = (text.clone(), Vec::new());
    for target in text.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        let file = target.split('#').next().unwrap_or_default();
        let exists = |file: &str| page.with_file_name(file).exists();
        if file.is_empty() || target.contains(':') || exists(file) {
            continue;
        }
        match file.strip_suffix(".html").map(|stem| format!("{stem}.md")) {
            Some(source) if exists(&source) => {
                repaired = repaired.replace(&format!("href=\"{file}"), &format!("href=\"{source}"));
            }
            _ => faults.push(format!("{}: {target}: there is no such file", page.display())),
        }
    }
    if repaired != text {
        fs::write(page, repaired).map_err(Error::while_doing(page.display()))?;
    }
    Ok(faults)
}
