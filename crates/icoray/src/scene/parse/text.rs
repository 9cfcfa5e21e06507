//! Keys and values with their places in a scene file.

use crate::error::{Error, ErrorKind, Result};
use crate::scene::color;
use std::fmt::Display;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;

/// The text of a scene file, for saying where in it something stands.
#[derive(Clone, Copy)]
pub(super) struct Text<'t> {
    text: &'t str,
    /// What stands before the keys, such as `volumes.`
    section: &'static str,
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
    pub fn number(
        &self,
        raw: Option<&Spanned<f64>>,
        key: &str,
        low: f64,
        high: f64,
        default: f64,
    ) -> Result<f64> {
        let Some(raw) = raw else { return Ok(default) };
        let value = *raw.get_ref();
        if value >= low && value <= high {
            return Ok(value);
        }
        Err(self.bad(raw.span(), key, format!("{value}, expected a number from {low} to {high}")))
    }

    /// A whole number from 1 to `most`, or `default` where the key is absent; `unit` is put after `most` in an error.
    pub fn count(
        &self,
        raw: Option<&Spanned<i64>>,
        key: &str,
        most: u32,
        unit: &str,
        default: u32,
    ) -> Result<u32> {
        let Some(raw) = raw else { return Ok(default) };
        let count = u32::try_from(*raw.get_ref()).ok().filter(|count| (1..=most).contains(count));
        count.ok_or_else(|| {
            self.bad(raw.span(), key, format!("{}, expected 1 to {most}{unit}", raw.get_ref()))
        })
    }

    /// A number that is neither infinite nor NaN.
    pub fn finite(&self, raw: &Spanned<f64>, key: &str) -> Result<f64> {
        let value = *raw.get_ref();
        let bad = || self.bad(raw.span(), key, format!("{value}, expected a finite number"));
        if value.is_finite() { Ok(value) } else { Err(bad()) }
    }

    /// Two finite numbers, the lower first.
    pub fn range(&self, raw: &Spanned<[f64; 2]>, key: &str) -> Result<[f64; 2]> {
        let [low, high] = *raw.get_ref();
        let what = || format!("[{low}, {high}], expected two finite numbers, the lower first");
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
        Err(self.bad(raw.span(), "opacity", format!("{value}, expected above 0 and at most 1")))
    }

    /// The name of a field.
    pub fn name(&self, raw: &Spanned<String>, key: &str) -> Result<String> {
        let name = raw.get_ref();
        if name.is_empty() { Err(self.bad(raw.span(), key, "an empty name")) } else { Ok(name.clone()) }
    }

    pub fn color(&self, raw: &Spanned<String>, key: &str) -> Result<[f64; 3]> {
        color::css(raw.get_ref()).ok_or_else(|| {
            self.bad(
                raw.span(),
                key,
                format!("{:?}, expected an opaque CSS colour such as \"#ff8800\"", raw.get_ref()),
            )
        })
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
            Some(raw) if raw.get_ref() == "transparent" => Ok(None),
            Some(raw) => self.color(raw, key).map(Some),
        }
    }
}
