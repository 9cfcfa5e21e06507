//! Puts the tables where people read them.

use crate::io_error;
use icoray::{Error, ErrorKind, Result};
use std::path::Path;

/// Lines between which the tables stand.
const MARKS: [&str; 2] = ["<!-- icoray study speed -->\n", "<!-- icoray study speed: end -->\n"];

/// Replaces what stands between the marks in a file.
///
/// # Errors
/// [`ErrorKind::Io`] where the file cannot be read or written; [`ErrorKind::Argument`] where it has no marks.
pub(super) fn put(path: &Path, text: &str) -> Result<()> {
    let old = std::fs::read_to_string(path).map_err(|e| io_error(path, e))?;
    let new = replaced(&old, text).ok_or_else(|| {
        let [begin, end] = MARKS.map(str::trim);
        let context = format!("{}: expected a line {begin} and behind it {end}", path.display());
        Error::new(ErrorKind::Argument, context)
    })?;
    std::fs::write(path, new).map_err(|e| io_error(path, e))
}

fn replaced(old: &str, text: &str) -> Option<String> {
    let [begin, end] = MARKS;
    let (before, rest) = old.split_once(begin)?;
    let (_, after) = rest.split_once(end)?;
    Some(format!("{before}{begin}{text}{end}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_take_the_place_of_older_ones_and_of_nothing_else() {
        let [begin, end] = MARKS;
        let old = format!("a\n{begin}old\nlines\n{end}b\n");
        let new = replaced(&old, "| new |\n").unwrap();
        assert_eq!(new, format!("a\n{begin}| new |\n{end}b\n"));
        assert_eq!(replaced(&new, "| new |\n").unwrap(), new);
        assert_eq!(replaced("a\nb\n", "| new |\n"), None);
        assert_eq!(replaced(&format!("{end}{begin}"), "| new |\n"), None);
    }
}
