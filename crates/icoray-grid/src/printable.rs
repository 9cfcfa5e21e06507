//! Escapes text from a file, a path or a host, for terminals, tables and pictures.

use std::borrow::Cow;

/// The text with its control characters escaped as in Rust (`\u{1b}`, `\n`), and those that change the direction of
/// text or end a line: a terminal would obey them. Escaped text stays unchanged.
///
/// ```
/// assert_eq!(icoray_grid::printable("K \u{1b}[2J"), r"K \u{1b}[2J");
/// ```
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return text.into();
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        match acts(character) {
            true => escaped.extend(character.escape_default()),
            false => escaped.push(character),
        }
    }
    escaped.into()
}

fn acts(character: char) -> bool {
    let is_format =
        matches!(character, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    is_format || character.is_control()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_once() {
        assert!(matches!(printable("Größe, m s⁻¹ \\"), Cow::Borrowed("Größe, m s⁻¹ \\")));
        let text = "a\u{1b}]0;b\u{7}\r\n\t\0\u{7f}\u{9b}2J\u{202e}c";
        let escaped = r"a\u{1b}]0;b\u{7}\r\n\t\u{0}\u{7f}\u{9b}2J\u{202e}c";
        assert_eq!(printable(text), escaped);
        assert_eq!(printable(escaped), escaped);
    }
}
