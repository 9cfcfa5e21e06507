//! Checks the code of the README and the book: each block is run, parsed, or equal to lines of a file.

use std::fs;
use std::path::{Path, PathBuf};

use super::commands;
use super::markdown::{Fence, Page};
use crate::files;

/// A line of a snippet that stands for lines that are left out.
const GAP: &str = "...";

/// The tests that run blocks of Python; they name the pages.
const PYTHON_TESTS: &str = "crates/icoray-python/tests";

/// A sentence for each block of code that no test would notice, or that differs from its file.
pub fn faults(root: &Path, page: &Page) -> Vec<String> {
    let at = |line: usize, what: String| format!("{}:{line}: {what}", page.path);
    let indented = page.indented.iter().map(|line| at(*line, "indented code; use a fenced block".into()));
    let fences = page.fences.iter().filter_map(|fence| Some(at(fence.line, fault(root, &page.path, fence)?)));
    indented.chain(fences).collect()
}

fn fault(root: &Path, page: &str, fence: &Fence) -> Option<String> {
    match (fence.language.as_str(), &fence.source) {
        ("text", None) if fence.attributes.is_empty() => None,
        ("toml", None) if fence.attributes.iter().all(|word| word == "part") => None,
        ("sh", None) => commands::attribute_fault(fence),
        ("python", None) if fence.attributes.is_empty() => {
            let is_named = |test: &PathBuf| fs::read_to_string(test).is_ok_and(|text| text.contains(page));
            let is_run = files::fitting(&root.join(PYTHON_TESTS), "*.py").iter().any(is_named);
            (!is_run).then(|| format!("no test in {PYTHON_TESTS} names {page}, whose blocks of python are to be run"))
        }
        ("c" | "fortran" | "make" | "cmake", Some(source)) => {
            let code = match fs::read_to_string(root.join(source)) {
                Ok(code) => code,
                Err(cause) => return Some(format!("{source}: {cause}")),
            };
            missing(&fence.text, &code).map(|lines| format!("{source} does not contain these lines:\n{lines}"))
        }
        ("c" | "fortran" | "make" | "cmake", None) => {
            Some("expected <!-- from FILE --> above it: code is compared with a file".into())
        }
        (other, _) => Some(format!("a block of {other:?}, expected sh, python, toml, text, c, fortran, make or cmake")),
    }
}

/// The first run of lines, between gaps, that `code` does not contain after those before it.
fn missing(snippet: &str, code: &str) -> Option<String> {
    let mut rest = code;
    for run in snippet.split(&format!("{GAP}\n")).filter(|run| !run.trim().is_empty()) {
        match rest.find(run) {
            Some(place) => rest = &rest[place + run.len()..],
            None => return Some(run.to_owned()),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_is_compared_run_by_run() {
        let code = "a\nb\nc\nd\n";
        assert_eq!(missing("a\nb\n...\nd\n", code), None);
        assert_eq!(missing("a\nc\n", code), Some("a\nc\n".into()));
        assert_eq!(missing("c\n...\na\n", code), Some("a\n".into()));
    }

    #[test]
    fn blocks_that_nothing_checks_are_faults() {
        let fault_of = |block: &str| {
            let page = Page::parse("p.md", &format!("{block}\n```\n"));
            faults(Path::new("/nonexistent"), &page).len()
        };
        assert_eq!(fault_of("```text\nx"), 0);
        assert_eq!(fault_of("```sh needs=mpi slow\nx"), 0);
        assert_eq!(fault_of("```toml part\nx = 1"), 0);
        assert_eq!(fault_of("```sh\nicoray sample a.nc\nicoray info a.nc x"), 0);
        for bad in [
            "```\nx",
            "```python\nx",
            "```c\nx",
            "```rust\nx",
            "```sh needs=luck\nx",
            "```sh often\nx",
            "```sh\nicoray info a.nc x",
            "```toml x\ny",
        ] {
            assert_eq!(fault_of(bad), 1, "{bad}");
        }
    }
}
