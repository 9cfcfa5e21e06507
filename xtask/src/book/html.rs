//! Builds the book with mdBook, and checks the links of what it wrote.

use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::files;
use crate::step::Step;
use crate::workspace::Workspace;

/// The directory of the book, as in `docs/book.toml`.
const BUILT: &str = "docs/book";

/// Builds the book.
///
/// # Errors
/// If mdBook fails, or a link of a page leads nowhere.
pub fn build(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    step.quiet(workspace.shell.cmd("mdbook").args(["build", "docs"]))?;
    let mut faults = Vec::new();
    for page in files::fitting(&workspace.root.join(BUILT), "**/*.html") {
        // The page for printing has the links of all pages.
        if !page.ends_with("print.html") {
            faults.extend(repaired(&page)?);
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(Error::Failed(faults.join("\n"))) }
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
