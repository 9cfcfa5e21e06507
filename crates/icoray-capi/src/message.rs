//! Shortens messages: models print them into lines of their own, some of which have 512 characters. They quote user data,
//! whose control characters are escaped.

use icoray_core::printable;
use std::borrow::Cow;

/// Maximum bytes of the message of a status or of a log line.
pub(crate) const MAX_BYTES: usize = 400;
/// Maximum bytes of one word, such as a path or a name, in a message that is too long.
const MAX_WORD: usize = 80;
/// Of a message that is still too long, the bytes at its head: the call, step, view and field.
const HEAD: usize = 230;
const GAP: &str = " ... ";

/// The message on one line, shortened where it is too long: in the middle of long words first, then between its head and its end,
/// where table, row and value and what was expected stand.
pub(crate) fn fitted(message: &str) -> Cow<'_, str> {
    let message = printable(message);
    if message.len() <= MAX_BYTES {
        return message;
    }
    let words: String = message.split_inclusive(' ').map(short_word).collect();
    if words.len() <= MAX_BYTES {
        return words.into();
    }
    cut(&words, HEAD, MAX_BYTES, GAP).into()
}

fn short_word(word: &str) -> String {
    if word.len() <= MAX_WORD { word.into() } else { cut(word, MAX_WORD / 2, MAX_WORD, "...") }
}

/// At most `head` bytes of the beginning and as many of the end as make at most `total`, with `gap` between them.
fn cut(text: &str, head: usize, total: usize, gap: &str) -> String {
    let tail = text.len() - (total - head - gap.len());
    let tail = (tail..text.len()).find(|index| text.is_char_boundary(*index)).unwrap_or(text.len());
    format!("{}{gap}{}", &text[..floor_char_boundary(text, head)], &text[tail..])
}

/// The last boundary between characters up to `index`: `str::floor_char_boundary` of Rust 1.91.
pub(crate) fn floor_char_boundary(text: &str, index: usize) -> usize {
    (0..=index.min(text.len())).rev().find(|index| text.is_char_boundary(*index)).unwrap_or(0)
}

/// Names as a list that stays short: the first six, and how many more there are.
pub(crate) fn listed<'n>(names: impl ExactSizeIterator<Item = &'n str>) -> String {
    const SHOWN: usize = 6;
    let more = names.len().saturating_sub(SHOWN);
    let shown: Vec<String> = names.take(SHOWN).map(|name| format!("{:?}", short_word(name))).collect();
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("[{}{more}]", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_keeps_its_head_and_its_end() {
        assert_eq!(fitted("units \u{1b}[31m\n"), r"units \u{1b}[31m\n");
        assert_eq!(fitted("field \"q\" is missing"), "field \"q\" is missing");
        let exact = "x".repeat(MAX_BYTES);
        assert_eq!(fitted(&exact), exact);
        let path = format!("/scratch/{}/scene.toml: line 3: key map: \"x\"", "deep/".repeat(100));
        let short = fitted(&path);
        assert!(short.len() < 150 && short.starts_with("/scratch/deep/"), "{short}");
        assert!(short.ends_with("scene.toml: line 3: key map: \"x\""), "{short}");
        let long = format!("step 5: view \"w\": {}corner_cell row 3: 99, expected 0 to 41", "word ".repeat(200));
        let short = fitted(&long);
        assert!(short.len() <= MAX_BYTES && short.len() > MAX_BYTES - 10, "{}", short.len());
        assert!(short.starts_with("step 5: view \"w\": word"), "{short}");
        assert!(short.contains(" ... ") && short.ends_with("corner_cell row 3: 99, expected 0 to 41"), "{short}");
    }

    #[test]
    fn characters_are_not_cut_apart() {
        for shift in 0..4 {
            let long = format!("{}{}", "x".repeat(shift), "\u{1f30d}".repeat(300));
            let short = fitted(&long);
            assert!(short.len() <= MAX_BYTES, "{}", short.len());
            let words = format!("{}{}", "x".repeat(shift), "\u{1f30d} ".repeat(300));
            let short = fitted(&words);
            assert!(short.len() <= MAX_BYTES && short.len() > MAX_BYTES - 10, "{}", short.len());
        }
    }

    #[test]
    fn lists_of_names_stay_short() {
        let names: Vec<String> = (0..50).map(|i| format!("field {i}")).collect();
        let list = |count: usize| listed(names[..count].iter().map(String::as_str));
        assert_eq!(list(0), "[]");
        assert_eq!(list(2), "[\"field 0\", \"field 1\"]");
        assert!(list(6).ends_with("\"field 5\"]") && list(50).ends_with("\"field 5\" and 44 more]"));
    }
}
