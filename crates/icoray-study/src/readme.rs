//! Puts the tables where people read them.

use crate::io_error;
use icoray::{Error, ErrorKind, Result};
use std::path::Path;

/// Replaces what stands between the marks of a study in a file: `<!-- icoray-study NAME -->` and `<!-- end -->`.
///
/// # Errors
/// [`ErrorKind::Io`] where the file cannot be read or written; [`ErrorKind::Argument`] where it has no marks.
pub(crate) fn put(path: &Path, study: &str, text: &str) -> Result<()> {
    let old = std::fs::read_to_string(path).map_err(|e| io_error(path, e))?;
    let new = replaced(&old, study, text).ok_or_else(|| {
        let context = format!("{}: expected a line {}and behind it {END}", path.display(), begin(study));
        Error::new(ErrorKind::Argument, context.replace('\n', " "))
    })?;
    std::fs::write(path, new).map_err(|e| io_error(path, e))
}

const END: &str = "<!-- end -->\n";

fn begin(study: &str) -> String {
    format!("<!-- icoray-study {study} -->\n")
}

fn replaced(old: &str, study: &str, text: &str) -> Option<String> {
    let begin = begin(study);
    let (before, rest) = old.split_once(&begin)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{begin}{text}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_take_the_place_of_older_ones_and_of_nothing_else() {
        let other = format!("{}other\n{END}", begin("other"));
        let with = |text: &str| format!("a\n{other}{}{text}{END}b\n{other}", begin("speed"));
        let new = replaced(&with("old\nlines\n"), "speed", "| new |\n").unwrap();
        assert_eq!(new, with("| new |\n"));
        assert_eq!(replaced("a\nb\n", "speed", "| new |\n"), None);
        assert_eq!(replaced(&format!("{END}{}", begin("speed")), "speed", "| new |\n"), None);
    }

    #[test]
    fn a_file_without_marks_is_told_what_they_are() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("README.md");
        std::fs::write(&path, "nothing").unwrap();
        let error = put(&path, "speed", "").unwrap_err().to_string();
        assert!(
            error.contains("expected a line <!-- icoray-study speed --> and behind it <!-- end -->"),
            "{error}"
        );
    }
}
