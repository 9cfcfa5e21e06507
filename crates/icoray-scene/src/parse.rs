//! From TOML to a checked [`Scene`]: every error names the line and the key.

mod camera;
mod clip;
mod derive;
mod ground;
pub(crate) mod hint;
mod isosurface;
mod labels;
mod light;
mod lines;
mod output;
mod paint;
mod place;
mod surface;
mod text;
mod transfer;
pub(crate) mod views;
mod volume;

use crate::backend::{Adapter, Backend};
use crate::method::Method;
use crate::scene::{Precision, Scene, Scheme};
use crate::scenery::{Ground, Heights, Scenery};
use icoray_grid::{Error, ErrorKind, Result};
use serde::Deserialize;
use text::Text;
use toml::Spanned;
use toml::de::DeTable;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScene {
    field: Option<Spanned<String>>,
    every: Option<Spanned<i64>>,
    exaggeration: Option<Spanned<f64>>,
    background: Option<Spanned<String>>,
    core: Option<Spanned<String>>,
    #[serde(default)]
    method: Method,
    tolerance: Option<Spanned<f64>>,
    antialias: Option<bool>,
    samples: Option<Spanned<i64>>,
    time_budget_ms: Option<Spanned<f64>>,
    #[serde(default)]
    precision: Precision,
    #[serde(default)]
    ranks: Scheme,
    #[serde(default)]
    backend: Backend,
    device: Option<Spanned<toml::Value>>,
    image: Option<RawImage>,
    camera: Option<Spanned<camera::RawCamera>>,
    transfer: Option<Spanned<transfer::RawTransfer>>,
    opacity: Option<Spanned<volume::RawOpacity>>,
    #[serde(default)]
    volumes: Vec<Spanned<volume::RawVolume>>,
    #[serde(default)]
    surfaces: Vec<Spanned<surface::RawSurface>>,
    #[serde(default)]
    isosurfaces: Vec<Spanned<isosurface::RawIsosurface>>,
    #[serde(default)]
    lines: Vec<Spanned<lines::RawLines>>,
    ground: Option<Spanned<ground::RawGround>>,
    #[serde(default)]
    clip: Vec<Spanned<clip::RawClip>>,
    #[serde(default)]
    derive: Vec<Spanned<derive::RawDerivation>>,
    #[serde(default)]
    heights: Heights,
    light: Option<Spanned<light::RawLight>>,
    labels: Option<labels::RawLabels>,
    output: Option<output::RawOutput>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawImage {
    width: Option<Spanned<i64>>,
    height: Option<Spanned<i64>>,
}

impl Scene {
    /// Parses a scene from the text of a scene file.
    ///
    /// ```
    /// use icoray_scene::Scene;
    ///
    /// let text = "field = 'theta'
    ///             camera = { lon = 190, lat = 45, distance = 2.6 }
    ///             [transfer]
    ///             map = 'plasma'
    ///             range = [300, 400]
    ///             opacity = [[300, 0], [400, 0.9]]";
    /// let scene = Scene::parse(text)?;
    /// assert_eq!((scene.field(), scene.width), ("theta", 512));
    ///
    /// let error = Scene::parse(&text.replace("[300, 400]", "[400, 300]")).unwrap_err();
    /// assert!(error.to_string().contains("line 5, key transfer.range"), "{error}");
    /// # Ok::<(), icoray_grid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] with the line, the key, the value and what was expected.
    pub fn parse(text: &str) -> Result<Self> {
        scene(text)
    }

    /// As [`Scene::parse`], with `None` for a text of nothing but blanks and comments: nothing is to be drawn.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn parse_optional(text: &str) -> Result<Option<Self>> {
        let is_empty = toml::from_str::<toml::Table>(text).is_ok_and(|table| table.is_empty());
        if is_empty { Ok(None) } else { Self::parse(text).map(Some) }
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
        let value = text::shown(raw.get_ref());
        source.bad(raw.span(), "device", format!("{value}, expected a number from 0 or a part of a name"))
    })
}

/// Reads each of a list of sections.
fn each<R, S>(source: Text, raw: &[Spanned<R>], read: impl Fn(&Text, &Spanned<R>) -> Result<S>) -> Result<Vec<S>> {
    raw.iter().map(|raw| read(&source, raw)).collect()
}

/// Parses and checks a scene.
pub(super) fn scene(text: &str) -> Result<Scene> {
    let source = Text::new(text);
    let table = source.table()?;
    expect_keys(table.get_ref())?;
    checked(&source, table).map_err(|e| hint::with_hint(&e))
}

/// Refuses a scene without any key, which draws nothing.
fn expect_keys(table: &DeTable) -> Result<()> {
    if !table.is_empty() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Scene, "the scene has no keys: nothing is drawn"))
}

/// Checks the keys of a scene.
fn checked(source: &Text, table: Spanned<DeTable>) -> Result<Scene> {
    let raw = RawScene::deserialize(toml::Deserializer::from(table)).map_err(|e| source.refused(&e))?;
    let side = |raw, key| source.count(raw, key, 16384, " pixels", 512);
    let [tolerance_min, tolerance_max] = [*Scene::TOLERANCE.start(), *Scene::TOLERANCE.end()];
    let core = source.color_or_none(raw.core.as_ref(), "core", Some([0.0225, 0.0225, 0.0225]))?;
    let mut volumes = volume::volumes(*source, &raw)?;
    let scenery = scenery(*source, &raw, core.is_some())?;
    if volumes.is_empty() {
        volumes.push(volume::none(*source, &raw, &scenery)?);
    }
    let mut scene = Scene {
        every: source.count(raw.every.as_ref(), "every", 1_000_000_000, "", 1)?,
        width: side(raw.image.as_ref().and_then(|i| i.width.as_ref()), "image.width")?,
        height: side(raw.image.as_ref().and_then(|i| i.height.as_ref()), "image.height")?,
        background: source.color_or_none(raw.background.as_ref(), "background", Some([0.0; 3]))?,
        exaggeration: source.number(raw.exaggeration.as_ref(), "exaggeration", 1e-6, 1e6, 1.0)?,
        core,
        camera: camera::camera(source, raw.camera.as_ref())?,
        volumes,
        scenery,
        lighting: raw.light.as_ref().map(|light| light::lighting(source, light)).transpose()?.flatten(),
        method: raw.method,
        tolerance: source.number(
            raw.tolerance.as_ref(),
            "tolerance",
            tolerance_min,
            tolerance_max,
            Scene::DEFAULT_TOLERANCE,
        )?,
        antialias: raw.antialias.unwrap_or(true),
        samples: source.count(raw.samples.as_ref(), "samples", Scene::MAX_SAMPLES, " rays per pixel", 1)?,
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
    };
    let first = scene.field().to_owned();
    scene.name_first_field(&first);
    Ok(scene)
}

/// Surfaces, lines, clips and ground beside volumes.
fn scenery(source: Text, raw: &RawScene, has_core: bool) -> Result<Scenery> {
    Ok(Scenery {
        surfaces: each(source.within("surfaces."), &raw.surfaces, surface::surface)?,
        isosurfaces: each(source.within("isosurfaces."), &raw.isosurfaces, isosurface::isosurfaces)?.concat(),
        lines: each(source.within("lines."), &raw.lines, |s, raw| lines::lines(s, raw, has_core))?,
        ground: match &raw.ground {
            Some(raw) => ground::ground(source.within("ground."), raw, has_core)?,
            None => Ground::default(),
        },
        clips: each(source.within("clip."), &raw.clip, clip::clip)?,
        derived: derive::derivations(source.within("derive."), &raw.derive)?,
        heights: raw.heights,
    })
}

#[cfg(test)]
mod tests;
