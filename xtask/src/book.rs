//! Checks the documentation: the README and the book in `docs`.
//!
//! [`check_links`] checks relative links and anchors, and compares code with the files that it is taken from.
//! [`run_commands`] runs the blocks marked `sh`, from the text of the pages.
//! Scenes in the pages are parsed by `crates/icoray-scene/tests/pages.rs`.

mod commands;
mod links;
mod markdown;
mod snippets;

use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::files;
use crate::step::Step;
use crate::workspace::Workspace;
use markdown::Page;

pub use commands::{run as run_commands, scripted};

const PAGES: &str = "docs/src";
/// The page that lists the others.
const SUMMARY: &str = "docs/src/SUMMARY.md";

/// Pages outside the book whose links are checked; their code is not.
const OTHERS: [&str; 3] = ["*.md", "examples/**/*.md", "crates/**/*.md"];

/// Checks that relative links and anchors exist, and that code in the README and the book is that of the files it
/// names. Fails with all faults, each with page and line.
pub fn check_links(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let book = book(&workspace.root)?;
    let files = OTHERS.iter().flat_map(|pattern| files::fitting(&workspace.root, pattern));
    let paths = files.filter_map(|file| Some(file.strip_prefix(&workspace.root).ok()?.to_str()?.to_owned()));
    let others = paths.filter(|path| book.iter().all(|page| page.path != *path));
    let others = others.map(|path| page(&workspace.root, &path)).collect::<Result<Vec<_>, _>>()?;
    let pages: Vec<&Page> = book.iter().chain(&others).collect();
    let mut faults = links::faults(&workspace.root, &pages);
    faults.extend(links::unlisted(&workspace.root, &book));
    for page in &book {
        faults.extend(snippets::faults(&workspace.root, page));
    }
    if faults.is_empty() {
        let count: usize = pages.iter().map(|page| page.links.len()).sum();
        step.note(&format!("{count} links on {} pages", pages.len()));
        return Ok(());
    }
    Err(Error(faults.join("\n")))
}

/// The README, the summary and the pages that it lists, in this order.
fn book(root: &Path) -> Result<Vec<Page>, Error> {
    let summary = page(root, SUMMARY)?;
    let listed: Vec<String> = summary.links.iter().map(|link| format!("{PAGES}/{}", link.target)).collect();
    let mut pages = vec![page(root, "README.md")?, summary];
    // A listed page that is missing is a fault of the summary's link.
    for path in listed.iter().filter(|path| root.join(path).is_file()) {
        pages.push(page(root, path)?);
    }
    Ok(pages)
}

fn page(root: &Path, path: &str) -> Result<Page, Error> {
    let text = fs::read_to_string(root.join(path)).map_err(Error::while_doing(path))?;
    Ok(Page::parse(path, &text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_readme_is_short() {
        let readme = fs::read_to_string(Workspace::find().unwrap().root.join("README.md")).unwrap();
        assert!(readme.lines().count() <= 150);
        let long = readme.lines().find(|line| line.chars().count() > 120);
        assert_eq!(long, None);
    }
}
