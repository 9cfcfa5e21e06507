//! Keys and values with their places in a scene file.

use super::hint;
use crate::color;
use crate::values::Magnitudes;
use icoray_grid::numbers;
use icoray_grid::{Error, ErrorKind, Result};
use std::fmt::Display;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;

/// The word for no colour.
const TRANSPARENT: &str = "transparent";
/// Words that users write for it by mistake.
const NOTHING: [&str; 8] = ["none", "no", "off", "null", "nothing", "clear", "empty", "hollow"];

/// The text of a scene file: locates keys and values for error messages.
#[derive(Clone, Copy)]
pub(super) struct Text<'t> {
    text: &'t str,
    /// Prefix of keys in messages, such as `volumes.`
    section: &'static str,
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

impl<'t> Text<'t> {
    pub fn new(text: &'t str) -> Self {
        Text { text, section: "" }
    }

    /// The same where keys are those of a section, whose name ends in a dot.
    pub fn within(self, section: &'static str) -> Self {
        Text { section, ..self }
    }

    /// The text's keys, with their places in it.
    pub fn table(&self) -> Result<Spanned<DeTable<'t>>> {
        DeTable::parse(self.text).map_err(|e| self.refused(&e))
    }

    /// An error of the TOML reader's.
    pub fn refused(&self, e: &toml::de::Error) -> Error {
        let line = e.span().map_or_else(String::new, |span| {
            let line = self.line(&span);
            format!("line {line} ({}): ", self.text.lines().nth(line - 1).unwrap_or("").trim())
        });
        Error::new(ErrorKind::Scene, format!("{line}{}", e.message()))
    }

    pub fn line(&self, span: &Range<usize>) -> usize {
        1 + self.text[..span.start.min(self.text.len())].bytes().filter(|b| *b == b'\n').count()
    }

    pub fn bad(&self, span: Range<usize>, key: &str, what: impl Display) -> Error {
        // An error of a whole section names that.
        let key = format!("{}{key}", self.section);
        let key = key.trim_end_matches('.');
        Error::new(ErrorKind::Scene, format!("line {}, key {key}: {what}", self.line(&span)))
    }

    /// A number between `low` and `high`, or `default` where the key is absent.
    pub fn number(&self, raw: Option<&Spanned<f64>>, key: &str, low: f64, high: f64, default: f64) -> Result<f64> {
        let Some(raw) = raw else { return Ok(default) };
        let value = *raw.get_ref();
        if value >= low && value <= high {
            return Ok(value);
        }
        Err(self.bad(raw.span(), key, {
            let [value, low, high] = [value, low, high].map(numbers::text);
            format!("{value}, expected a number from {low} to {high}")
        }))
    }

    /// A whole number from 1 to `most`, or `default` where the key is absent; `unit` is put after `most` in an error.
    pub fn count(&self, raw: Option<&Spanned<i64>>, key: &str, most: u32, unit: &str, default: u32) -> Result<u32> {
        let Some(raw) = raw else { return Ok(default) };
        let count = u32::try_from(*raw.get_ref()).ok().filter(|count| (1..=most).contains(count));
        count.ok_or_else(|| self.bad(raw.span(), key, format!("{}, expected 1 to {most}{unit}", raw.get_ref())))
    }

    /// A number that is neither infinite nor NaN.
    pub fn finite(&self, raw: &Spanned<f64>, key: &str) -> Result<f64> {
        let value = *raw.get_ref();
        let bad = || self.bad(raw.span(), key, format!("{}, expected a finite number", numbers::text(value)));
        if value.is_finite() { Ok(value) } else { Err(bad()) }
    }

    /// A field's value, finite and of a magnitude that kernels hold.
    pub fn value(&self, raw: &Spanned<f64>, key: &str, magnitudes: &Magnitudes) -> Result<f64> {
        let value = self.finite(raw, key)?;
        self.held(value, raw.span(), key, magnitudes)
    }

    /// The value, if it is of a magnitude that kernels hold.
    pub fn held(&self, value: f64, span: Range<usize>, key: &str, magnitudes: &Magnitudes) -> Result<f64> {
        let bad = || self.bad(span, key, format!("{}, {}", numbers::text(value), magnitudes.wish));
        if magnitudes.hold(value) { Ok(value) } else { Err(bad()) }
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

    /// The part of the light that something absorbs, or 1 where the key is absent.
    pub fn opacity(&self, raw: Option<&Spanned<f64>>) -> Result<f64> {
        let Some(raw) = raw else { return Ok(1.0) };
        let value = *raw.get_ref();
        if value > 0.0 && value <= 1.0 {
            return Ok(value);
        }
        Err(self.bad(raw.span(), "opacity", format!("{}, expected above 0 and at most 1", numbers::text(value))))
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

    pub fn color(&self, raw: &Spanned<String>, key: &str) -> Result<[f64; 3]> {
        self.color_or_word(raw, key, "")
    }

    /// A colour; an error also suggests the keyword `word`, unless that is "".
    fn color_or_word(&self, raw: &Spanned<String>, key: &str, word: &str) -> Result<[f64; 3]> {
        let text = raw.get_ref();
        color::css(text).ok_or_else(|| {
            let (or, hint) = match word {
                "" => (String::new(), String::new()),
                word if word == TRANSPARENT && NOTHING.contains(&text.to_lowercase().as_str()) => {
                    (format!(", or {word:?}"), format!("; did you mean {word:?}?"))
                }
                word => (format!(", or {word:?}"), hint::meant(text, &[word])),
            };
            let what = format!("{text:?}, expected an opaque CSS colour such as \"#ff8800\"{or}{hint}");
            self.bad(raw.span(), key, what)
        })
    }

    /// A colour, or `None` for the word "auto".
    pub fn color_or_auto(&self, raw: Option<&Spanned<String>>, key: &str) -> Result<Option<[f64; 3]>> {
        let given = raw.filter(|raw| raw.get_ref() != "auto");
        given.map(|raw| self.color_or_word(raw, key, "auto")).transpose()
    }

    /// The error of a word that is not one of `words`.
    pub fn unknown_word(&self, raw: &Spanned<String>, key: &str, words: &[&str]) -> Error {
        let found = raw.get_ref();
        let quoted: Vec<String> = words.iter().map(|word| format!("{word:?}")).collect();
        let (last, others) = quoted.split_last().map_or(("", &[][..]), |(last, others)| (last.as_str(), others));
        let hint = hint::meant(found, words);
        self.bad(raw.span(), key, format!("{found:?}, expected {} or {last}{hint}", others.join(", ")))
    }

    /// A colour, or `None` for the word "transparent".
    pub fn color_or_none(
        &self,
        raw: Option<&Spanned<String>>,
        key: &str,
        default: Option<[f64; 3]>,
    ) -> Result<Option<[f64; 3]>> {
        match raw {
            None => Ok(default),
            Some(raw) if raw.get_ref() == TRANSPARENT => Ok(None),
            Some(raw) => self.color_or_word(raw, key, TRANSPARENT).map(Some),
        }
    }
}
