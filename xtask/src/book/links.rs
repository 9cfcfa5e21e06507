//! Checks links between files.

use std::path::Path;

use super::markdown::Page;
use super::{PAGES, SUMMARY};
use crate::files;

/// A sentence for each relative link whose file or anchor does not exist.
pub fn faults(root: &Path, pages: &[&Page]) -> Vec<String> {
    let mut faults = Vec::new();
    for page in pages {
        for link in &page.links {
            if let Some(what) = fault(root, pages, page, &link.target) {
                faults.push(format!("{}:{}: {}: {what}", page.path, link.line, link.target));
            }
        }
    }
    faults
}

/// A sentence for each page of the book that the summary does not list.
pub fn unlisted(root: &Path, book: &[Page]) -> Vec<String> {
    let is_listed = |path: &Path| book.iter().any(|page| root.join(&page.path) == path);
    let files = files::fitting(&root.join(PAGES), "**/*.md").into_iter().filter(|path| !is_listed(path));
    files.map(|path| format!("{SUMMARY}: does not list {}", path.display())).collect()
}

fn fault(root: &Path, pages: &[&Page], page: &Page, target: &str) -> Option<String> {
    if ["https://", "http://", "mailto:"].iter().any(|scheme| target.starts_with(scheme)) {
        return None;
    }
    let (file, anchor) = target.split_once('#').map_or((target, None), |(f, a)| (f, Some(a)));
    let here = root.join(&page.path);
    let path = if file.is_empty() { here } else { here.with_file_name(file) };
    let Ok(path) = path.canonicalize() else { return Some("there is no such file".into()) };
    let anchor = anchor?;
    let is_linked = |page: &&&Page| root.join(&page.path).canonicalize().is_ok_and(|known| known == path);
    let Some(other) = pages.iter().find(is_linked) else {
        return Some("an anchor in a file that is not checked".into());
    };
    (!other.anchors.iter().any(|known| known == anchor)).then(|| "there is no such heading".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_that_lead_nowhere_are_faults() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        // The files exist; their text is given here.
        let a = Page::parse(
            "docs/src/mpi.md",
            "# Here\n[ok](../../Cargo.toml) [ok](#here) [ok](gpu.md#there) [ok](https://x.org)\n\
             [bad](nowhere.md) [bad](#there) [bad](../../Cargo.toml#x)\n",
        );
        let b = Page::parse("docs/src/gpu.md", "# There\n");
        let found = faults(root, &[&a, &b]);
        let expected = [
            "docs/src/mpi.md:3: nowhere.md: there is no such file",
            "docs/src/mpi.md:3: #there: there is no such heading",
            "docs/src/mpi.md:3: ../../Cargo.toml#x: an anchor in a file that is not checked",
        ];
        assert_eq!(found, expected);
    }
}
