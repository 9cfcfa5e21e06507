//! Builds the book with mdBook, and checks the links of what it wrote.

use std::ffi::OsString;
use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::files;
use crate::step::Step;
use crate::system::succeeds;
use crate::workspace::{Workspace, is_required};

/// The directory of the book, as in `docs/book.toml`.
const BUILT: &str = "docs/book";
/// The version of mdBook that is installed if there is none.
const VERSION: &str = "0.4.52";

/// Builds the book.
///
/// # Errors
/// If mdBook fails, or a link of a page leads nowhere; if there is no mdBook and `ICORAY_REQUIRE` names `mdbook`.
pub fn build(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let program = match mdbook(workspace, step) {
        Ok(program) => program,
        Err(error) => {
            if is_required("mdbook") {
                return Err(error);
            }
            step.note(&format!("skipped: no mdbook, and cargo cannot install it\n{error}"));
            return Ok(());
        }
    };
    step.quiet(workspace.shell.cmd(program).args(["build", "docs"]))?;
    let mut faults = Vec::new();
    for page in files::fitting(&workspace.root.join(BUILT), "**/*.html") {
        // The page for printing has the links of all pages.
        if !page.ends_with("print.html") {
            faults.extend(repaired(&page)?);
        }
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
    let cargo = workspace.cargo(["install", "mdbook", "--locked", "--no-default-features", "--version", VERSION]);
    step.quiet(cargo.arg("--root").arg(&tools))?;
    Ok(own.into())
}

/// Repairs links of a page to Markdown files outside the book, whose ending mdBook replaces; returns links that lead
/// nowhere.
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
