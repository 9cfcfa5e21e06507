//! From TOML to a checked [`Scene`]: every error names the line and the key.

mod camera;
mod labels;
mod light;
mod output;
mod transfer;
pub(crate) mod views;

use super::{Adapter, Backend, Precision, Scene, Scenery, Scheme, color};
use crate::error::{Error, ErrorKind, Result};
use crate::kernel::piece::Method;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScene {
    field: Spanned<String>,
    every: Option<Spanned<i64>>,
    exaggeration: Option<Spanned<f64>>,
    background: Option<Spanned<String>>,
    core: Option<Spanned<String>>,
    #[serde(default)]
    method: Method,
    tolerance: Option<Spanned<f64>>,
    time_budget_ms: Option<Spanned<f64>>,
    #[serde(default)]
    precision: Precision,
    #[serde(default)]
    ranks: Scheme,
    #[serde(default)]
    backend: Backend,
    device: Option<Spanned<toml::Value>>,
    image: Option<RawImage>,
    camera: Spanned<camera::RawCamera>,
    transfer: Spanned<transfer::RawTransfer>,
    light: Option<Spanned<light::RawLight>>,
    labels: Option<labels::RawLabels>,
    output: Option<output::RawOutput>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawImage {
    width: Spanned<i64>,
    height: Spanned<i64>,
}

/// The text of a scene file, for saying where in it something stands.
struct Text<'t> {
    text: &'t str,
}

impl<'t> Text<'t> {
    /// The text's keys, with their places in it.
    fn table(&self) -> Result<Spanned<DeTable<'t>>> {
        DeTable::parse(self.text).map_err(|e| self.refused(&e))
    }

    /// An error of the TOML reader's.
    fn refused(&self, e: &toml::de::Error) -> Error {
        let line = e.span().map_or_else(String::new, |span| {
            let line = self.line(&span);
            format!("line {line} ({}): ", self.text.lines().nth(line - 1).unwrap_or("").trim())
        });
        Error::new(ErrorKind::Scene, format!("{line}{}", e.message()))
    }

    fn line(&self, span: &Range<usize>) -> usize {
        1 + self.text[..span.start.min(self.text.len())].bytes().filter(|b| *b == b'\n').count()
    }

    fn bad(&self, span: Range<usize>, key: &str, what: impl std::fmt::Display) -> Error {
        Error::new(ErrorKind::Scene, format!("line {}, key {key}: {what}", self.line(&span)))
    }

    /// A number between `low` and `high`, or `default` where the key is absent.
    fn number(
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
    fn count(
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

    fn color(&self, raw: &Spanned<String>, key: &str) -> Result<[f64; 3]> {
        color::css(raw.get_ref()).ok_or_else(|| {
            self.bad(
                raw.span(),
                key,
                format!("{:?}, expected an opaque CSS colour such as \"#ff8800\"", raw.get_ref()),
            )
        })
    }

    /// A colour, or `None` for the word "transparent".
    fn color_or_none(
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

/// A GPU's number or a part of its name.
fn adapter(source: &Text, raw: &Spanned<toml::Value>) -> Result<Adapter> {
    let number = |number: &i64| usize::try_from(*number).ok().map(Adapter::Number);
    let adapter = match raw.get_ref() {
        toml::Value::Integer(value) => number(value),
        toml::Value::String(name) if !name.is_empty() => Some(Adapter::Name(name.clone())),
        _ => None,
    };
    adapter.ok_or_else(|| {
        let value = raw.get_ref();
        source.bad(raw.span(), "device", format!("{value}, expected a number from 0 or a part of a name"))
    })
}

/// Parses and checks a scene.
pub(super) fn scene(text: &str) -> Result<Scene> {
    let source = Text { text };
    checked(&source, source.table()?)
}

/// Checks the keys of a scene.
fn checked(source: &Text, table: Spanned<DeTable>) -> Result<Scene> {
    let raw = RawScene::deserialize(toml::Deserializer::from(table)).map_err(|e| source.refused(&e))?;
    let side = |raw, key| source.count(raw, key, 16384, " pixels", 512);
    if raw.field.get_ref().is_empty() {
        return Err(source.bad(raw.field.span(), "field", "an empty name"));
    }
    let coloring;
    let [tolerance_min, tolerance_max] = [*Scene::TOLERANCE.start(), *Scene::TOLERANCE.end()];
    Ok(Scene {
        every: source.count(raw.every.as_ref(), "every", 1_000_000_000, "", 1)?,
        width: side(raw.image.as_ref().map(|i| &i.width), "image.width")?,
        height: side(raw.image.as_ref().map(|i| &i.height), "image.height")?,
        background: source.color_or_none(raw.background.as_ref(), "background", Some([0.0; 3]))?,
        exaggeration: source.number(raw.exaggeration.as_ref(), "exaggeration", 1e-6, 1e6, 1.0)?,
        core: source.color_or_none(raw.core.as_ref(), "core", Some([0.0225, 0.0225, 0.0225]))?,
        camera: camera::camera(source, &raw.camera)?,
        transfer: {
            let (transfer, made_of) = transfer::transfer_function(source, &raw.transfer)?;
            coloring = made_of;
            transfer
        },
        coloring,
        scenery: Scenery::default(),
        lighting: raw.light.as_ref().map(|light| light::lighting(source, light)).transpose()?.flatten(),
        method: raw.method,
        tolerance: source.number(
            raw.tolerance.as_ref(),
            "tolerance",
            tolerance_min,
            tolerance_max,
            Scene::DEFAULT_TOLERANCE,
        )?,
        time_budget_ms: raw
            .time_budget_ms
            .as_ref()
            .map(|ms| source.number(Some(ms), "time_budget_ms", 1.0, 1e9, 0.0))
            .transpose()?,
        precision: raw.precision,
        ranks: raw.ranks,
        backend: raw.backend,
        device: raw.device.as_ref().map(|device| adapter(source, device)).transpose()?,
        labels: raw.labels.as_ref().map(|labels| labels::labels(source, labels)).transpose()?.flatten(),
        output: output::output(source, raw.output.as_ref())?,
        field: raw.field.into_inner(),
    })
}

#[cfg(test)]
mod tests;
