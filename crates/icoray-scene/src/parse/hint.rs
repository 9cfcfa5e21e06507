//! Suggests a known word for a misspelt one.

use crate::keys;
use icoray_grid::Error;

/// The word of `words` that differs from `found` by the fewest letters, where these are few and not all.
pub(super) fn nearest<'w>(found: &str, words: impl IntoIterator<Item = &'w str>) -> Option<&'w str> {
    let found = found.to_lowercase();
    let letters = found.chars().count();
    let max_distance = (letters / 3).max(1).min(letters.saturating_sub(1));
    let distance = |word: &str| strsim::damerau_levenshtein(&found, &word.to_lowercase());
    let near = words.into_iter().map(|word| (distance(word), word)).filter(|(distance, _)| *distance <= max_distance);
    near.min_by_key(|(distance, _)| *distance).map(|(_, word)| word)
}

/// The question to put behind a word that is not one of `words`, before these are listed; empty where none is near.
///
/// ```
/// let names = ["theta", "vorticity"];
/// assert_eq!(icoray_scene::did_you_mean("thita", names), " (did you mean \"theta\"?)");
/// assert_eq!(icoray_scene::did_you_mean("rain", names), "");
/// ```
pub fn did_you_mean<'w>(found: &str, words: impl IntoIterator<Item = &'w str>) -> String {
    nearest(found, words).map_or_else(String::new, |word| format!(" (did you mean {word:?}?)"))
}

/// The same for an error of serde's, which names an unknown key or word and those that it knows in backquotes.
pub(crate) fn with_hint(error: &Error) -> Error {
    let context = error.context();
    let is_of_serde = ["unknown field `", "unknown variant `"].iter().any(|start| context.contains(start));
    let quoted: Vec<&str> = context.split('`').skip(1).step_by(2).collect();
    let [found, known @ ..] = quoted.as_slice() else { return error.clone() };
    if !is_of_serde {
        return error.clone();
    }
    let asked = match nearest(found, known.iter().copied()) {
        Some(word) => context.replacen(&format!("`{found}`"), &format!("`{found}` (did you mean `{word}`?)"), 1),
        None => format!("{context}{}", elsewhere(found)),
    };
    Error::new(error.kind(), asked)
}

/// Where a key of this name belongs, to put behind an error about it; empty where no section has it.
fn elsewhere(key: &str) -> String {
    let sections = keys::sections().into_iter().filter(|section| section.keys.iter().any(|listed| listed.name == key));
    let named = sections.map(|section| match section.name.as_str() {
        "" => "the scene itself".to_owned(),
        name => format!("`{name}`"),
    });
    let named: Vec<String> = named.collect();
    if named.is_empty() { String::new() } else { format!("; `{key}` is a key of {}", named.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_found_and_others_are_not() {
        let words = ["camera", "transfer", "core", "clip", "q"];
        for (found, expected) in [
            ("camra", Some("camera")),
            ("Tranfser", Some("transfer")),
            ("cor", Some("core")),
            ("zebra", None),
            ("x", None),
        ] {
            assert_eq!(nearest(found, words), expected, "{found}");
        }
    }
}
