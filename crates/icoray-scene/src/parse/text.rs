//! Keys and values with their places in a scene file.

use super::hint;
use crate::color;
use crate::keys::{self, Key, Kind};
use crate::values::Magnitudes;
use icoray_grid::{Error, ErrorKind, Result, numbers};
use std::fmt::Display;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The word for no colour.
const TRANSPARENT: &str = "transparent";
/// Words that users write for it by mistake.
const NOTHING: [&str; 8] = ["none", "no", "off", "null", "nothing", "clear", "empty", "hollow"];

/// The text of a scene file: locates keys and values for error messages.
#[derive(Clone, Copy)]
pub(super) struct Text<'t> {
    text: &'t str,
    /// The section of keys, such as `volumes`; empty at the top.
    section: &'static str,
    /// Whether a program composed the text: messages name keys, not lines.
    is_composed: bool,
}

/// A value as it stands in a message.
pub(super) fn shown(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) => numbers::text(*number),
        toml::Value::Array(values) => {
            format!("[{}]", values.iter().map(shown).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

/// A message of serde's without the names of Rust's types.
fn in_words(message: &str) -> String {
    let (before, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let expected = match expected {
        "f64" => "a number",
        "i64" => "an integer",
        "a sequence" => "a list",
        structure if structure.starts_with("struct ") => "a table",
        other => other,
    };
    let before = before.replace("type: map", "type: table").replace("type: sequence", "type: list");
    if expected.is_empty() { before } else { format!("{before}, expected {expected}") }
}

/// The key of a table whose name or value is at a place.
fn key_at(table: &DeTable, place: &Range<usize>) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let name = key.get_ref();
        let within = if key.span() == *place { Some(String::new()) } else { key_within(value, place) };
        within.map(|within| if within.is_empty() { name.to_string() } else { format!("{name}.{within}") })
    })
}

/// The key within a value that is at a place; empty where that is the value itself or an entry of it.
fn key_within(value: &Spanned<DeValue>, place: &Range<usize>) -> Option<String> {
    match value.get_ref() {
        _ if value.span() == *place => Some(String::new()),
        DeValue::Table(table) => key_at(table, place),
        DeValue::Array(list) => list.iter().find_map(|entry| key_within(entry, place)),
        _ => None,
    }
}

impl<'t> Text<'t> {
    pub fn new(text: &'t str) -> Self {
        Text { text, section: "", is_composed: false }
    }

    /// A text that no user has seen.
    pub fn composed(text: &'t str) -> Self {
        Text { is_composed: true, ..Self::new(text) }
    }

    /// The same where keys are those of a section.
    pub fn within(self, section: &'static str) -> Self {
        Text { section, ..self }
    }

    /// The text's keys, with their places in it.
    pub fn table(&self) -> Result<Spanned<DeTable<'t>>> {
        DeTable::parse(self.text).map_err(|e| self.refused(&e))
    }

    /// An error of the TOML reader's.
    pub fn refused(&self, e: &toml::de::Error) -> Error {
        let place = e.span().map_or_else(String::new, |span| {
            if self.is_composed {
                // Of a text that is no TOML there are no keys.
                let table = DeTable::parse(self.text).ok();
                let key = table.and_then(|table| key_at(table.get_ref(), &span));
                return key.map_or_else(String::new, |key| format!("key {key}: "));
            }
            let line = self.line(&span);
            format!("line {line} ({}): ", self.text.lines().nth(line - 1).unwrap_or("").trim())
        });
        Error::new(ErrorKind::Scene, format!("{place}{}", in_words(e.message())))
    }

    pub fn line(&self, span: &Range<usize>) -> usize {
        1 + self.text[..span.start.min(self.text.len())].bytes().filter(|b| *b == b'\n').count()
    }

    /// The path of a key; with an empty one, that of the section.
    fn path(&self, key: &str) -> String {
        format!("{}.{key}", self.section).trim_matches('.').to_owned()
    }

    pub fn bad(&self, span: Range<usize>, key: &str, what: impl Display) -> Error {
        let key = self.path(key);
        let line = if self.is_composed { String::new() } else { format!("line {}, ", self.line(&span)) };
        Error::new(ErrorKind::Scene, format!("{line}key {key}: {what}"))
    }

    /// The schema's entry of a key.
    ///
    /// # Panics
    /// If the schema has no such key.
    pub fn schema(&self, key: &str) -> &'static Key {
        let path = self.path(key);
        keys::find(&path).unwrap_or_else(|| panic!("{path} is not in the schema"))
    }

    /// A number within the key's bounds, or the key's default where it is absent.
    ///
    /// # Panics
    /// If the schema has no number as the default.
    pub fn number(&self, raw: Option<&Spanned<f64>>, key: &str) -> Result<f64> {
        Ok(self.optional_number(raw, key)?.unwrap_or_else(|| self.schema(key).default_number()))
    }

    /// A number within the key's bounds, or `None` where it is absent.
    pub fn optional_number(&self, raw: Option<&Spanned<f64>>, key: &str) -> Result<Option<f64>> {
        let Some(raw) = raw else { return Ok(None) };
        let (value, schema) = (*raw.get_ref(), self.schema(key));
        if schema.contains(value) {
            return Ok(Some(value));
        }
        let kind = if schema.kind == Kind::Integer { "an integer" } else { "a number" };
        let what = format!("{}, expected {kind} {}", numbers::text(value), schema.bounds_text());
        Err(self.bad(raw.span(), key, what))
    }

    /// An integer within the key's bounds, which are those of a `u32` at most, or the key's default where it is absent.
    pub fn count(&self, raw: Option<&Spanned<i64>>, key: &str) -> Result<u32> {
        let as_number = raw.map(|raw| Spanned::new(raw.span(), *raw.get_ref() as f64));
        self.number(as_number.as_ref(), key).map(|count| count as u32)
    }

    /// Refuses a list at `span` whose number of entries is outside of the key's bounds.
    pub fn expect_count(&self, found: usize, span: Range<usize>, key: &str) -> Result<()> {
        let [min, max] = self.schema(key).count;
        let what = || format!("{found} entries, expected {min} to {max}");
        if (min..=max).contains(&found) { Ok(()) } else { Err(self.bad(span, key, what())) }
    }

    /// A number that is neither infinite nor NaN.
    pub fn finite(&self, raw: &Spanned<f64>, key: &str) -> Result<f64> {
        let value = *raw.get_ref();
        let bad = || self.bad(raw.span(), key, format!("{}, expected a finite number", numbers::text(value)));
        if value.is_finite() { Ok(value) } else { Err(bad()) }
    }

    /// A field's value, finite and of a magnitude that kernels represent.
    pub fn value(&self, raw: &Spanned<f64>, key: &str, magnitudes: &Magnitudes) -> Result<f64> {
        let value = self.finite(raw, key)?;
        self.in_magnitudes(value, raw.span(), key, magnitudes)
    }

    /// The value, if it is of a magnitude that kernels represent.
    pub fn in_magnitudes(&self, value: f64, span: Range<usize>, key: &str, magnitudes: &Magnitudes) -> Result<f64> {
        let bad = || self.bad(span, key, format!("{}, expected {}", numbers::text(value), magnitudes.text));
        if magnitudes.contain(value) { Ok(value) } else { Err(bad()) }
    }

    /// Two finite numbers, the lower first.
    pub fn range(&self, raw: &Spanned<[f64; 2]>, key: &str) -> Result<[f64; 2]> {
        let [low, high] = *raw.get_ref();
        let what = || format!("{}, expected two finite numbers, the lower first", numbers::list(&[low, high]));
        if low < high && low.is_finite() && high.is_finite() {
            return Ok([low, high]);
        }
        Err(self.bad(raw.span(), key, what()))
    }

    /// The name of a field.
    pub fn name(&self, raw: &Spanned<String>, key: &str) -> Result<String> {
        let name = raw.get_ref();
        if name.is_empty() { Err(self.bad(raw.span(), key, "an empty name")) } else { Ok(name.clone()) }
    }

    /// The name of a field, or "" for the scene's first one where the key is absent.
    pub fn name_or_first(&self, raw: Option<&Spanned<String>>, key: &str) -> Result<String> {
        raw.map_or(Ok(String::new()), |raw| self.name(raw, key))
    }

    /// A colour; an error also suggests the words that the key may have in place of one.
    pub fn color(&self, raw: &Spanned<String>, key: &str) -> Result<[f64; 3]> {
        let text = raw.get_ref();
        color::css(text).ok_or_else(|| {
            let words = self.schema(key).choices();
            let is_nothing = words == [TRANSPARENT] && NOTHING.contains(&text.to_lowercase().as_str());
            let hint = hint::did_you_mean(if is_nothing { TRANSPARENT } else { text }, words.iter().copied());
            let or: String = words.iter().map(|word| format!(", or {word:?}")).collect();
            let what = format!("{text:?}{hint}, expected an opaque CSS colour such as \"#ff8800\"{or}");
            self.bad(raw.span(), key, what)
        })
    }

    /// A colour, or `None` for the word that the key may have in place of one.
    pub fn color_or_word(&self, raw: &Spanned<String>, key: &str) -> Result<Option<[f64; 3]>> {
        let is_word = self.schema(key).choices().contains(&raw.get_ref().as_str());
        if is_word { Ok(None) } else { self.color(raw, key).map(Some) }
    }

    /// The error of a word that is not one of the key's choices.
    pub fn unknown_word(&self, raw: &Spanned<String>, key: &str) -> Error {
        let (found, words) = (raw.get_ref(), self.schema(key).choices());
        let quoted: Vec<String> = words.iter().map(|word| format!("{word:?}")).collect();
        let (hint, words) = (hint::did_you_mean(found, words.iter().copied()), keys::alternatives(&quoted));
        self.bad(raw.span(), key, format!("{found:?}{hint}, expected {words}"))
    }
}
