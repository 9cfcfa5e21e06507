//! Suggests a known word for a misspelt one.

use crate::keys;
use icoray_grid::Error;

/// The word of `words` that differs from `found` by the fewest letters, where these are few.
pub(super) fn nearest<'w>(found: &str, words: impl IntoIterator<Item = &'w str>) -> Option<&'w str> {
    let found = found.to_lowercase();
    let most = (found.chars().count() / 3).max(1);
    let off = |word: &str| strsim::damerau_levenshtein(&found, &word.to_lowercase());
    let near = words.into_iter().map(|word| (off(word), word)).filter(|(off, _)| *off <= most);
    near.min_by_key(|(off, _)| *off).map(|(_, word)| word)
}

/// The question to put behind a sentence that has listed the words.
pub(super) fn meant(found: &str, words: &[&str]) -> String {
    nearest(found, words.iter().copied()).map_or_else(String::new, |word| format!("; did you mean {word:?}?"))
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
    let hint = match nearest(found, known.iter().copied()) {
        Some(word) => format!("; did you mean `{word}`?"),
        None => elsewhere(found),
    };
    Error::new(error.kind(), format!("{context}{hint}"))
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
    use icoray_grid::ErrorKind;

    #[test]
    fn near_words_are_found_and_others_are_not() {
        let words = ["camera", "transfer", "core", "clip"];
        for (found, expected) in
            [("camra", Some("camera")), ("Tranfser", Some("transfer")), ("cor", Some("core")), ("zebra", None)]
        {
            assert_eq!(nearest(found, words), expected, "{found}");
        }
    }

    #[test]
    fn hints_stand_behind_the_known_words() {
        let error = |text: &str| with_hint(&Error::new(ErrorKind::Scene, text)).to_string();
        let unknown = "line 1: unknown field `feild`, expected one of `field`, `every`";
        assert!(error(unknown).ends_with("`every`; did you mean `field`?"), "{}", error(unknown));
        assert!(!error("line 1: unknown field `xyz`, expected one of `field`, `every`").contains("mean"));
        assert!(!error("`a` is no `b`").contains("mean"));
    }
}
