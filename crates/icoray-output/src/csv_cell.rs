//! Cells of comma-separated tables.

use icoray_grid::printable;

/// A CSV cell (RFC 4180), without control characters.
pub(super) fn quoted(cell: &str) -> String {
    let cell = printable(cell);
    if cell.contains([',', '"']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.into_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(quoted("plain"), "plain");
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
        assert_eq!(quoted("a\nb\u{1b}[31m"), r"a\nb\u{1b}[31m");
    }
}
