//! From TOML to a checked [`Scene`]: every error names the line and the key.

mod camera;
mod clip;
mod derive;
pub(crate) mod hint;
mod labels;
mod light;
mod lines;
mod place;
mod surface;
mod text;
mod transfer;
pub(crate) mod views;
mod volume;

use crate::keys::{Key, Kind, flag, integer, keys, number, of, section, sections_of, word};
use crate::name::{NameTemplate, Output};
use crate::quality::Quality;
use crate::scene::{Adapter, Backend, Method, Precision, Scene, Scheme};
use crate::scenery::{Ground, Heights, Scenery};
use icoray_grid::{Error, ErrorKind, Result};
use serde::Deserialize;
use text::Text;
use toml::Spanned;
use toml::de::DeTable;

keys! {
    struct RawScene {
        /// Field of the volume; without a volume, the field whose layers the scene has. The first field is the one that
        /// `icoray render` selects in a file, or that a model sets first.
        field: Option<Spanned<String>> = of(Kind::Text).or_else("the first field"),
        /// Draws the steps that are multiples of this number.
        every: Option<Spanned<i64>> = integer(1..=1_000_000_000).or(1.0),
        /// Factor on heights above the planet's surface; 1 is true to scale.
        exaggeration: Option<Spanned<f64>> = number(1e-6..=1e6).or(1.0),
        /// Colour behind the planet and all volumes.
        background: Option<Spanned<String>> = of(COLOR_OR_NONE).or_word("black"),
        /// The planet below the innermost layer; `"transparent"` is hollow, and rays continue on the far side.
        core: Option<Spanned<String>> = of(COLOR_OR_NONE).or_else("dark grey"),
        /// Integration: to the tolerance, or the paper's piecewise linear scheme.
        method: Method = word(&["exact", "paper"]).or_word("exact"),
        /// Largest error allowed in a channel of a premultiplied pixel, 0 to 1.
        tolerance: Option<Spanned<f64>> = number(Scene::TOLERANCE).or(Scene::DEFAULT_TOLERANCE),
        /// Pixels with the edge of a surface in them show the mean of 8 rays; `false` traces one ray per pixel
        /// ([edges](accuracy.md#edges)).
        antialias: Option<bool> = flag(true),
        /// Most rays per pixel. 1 traces the ray through the pixel's middle; more rays are averaged where the estimated
        /// error of their mean is above the tolerance ([samples](accuracy.md#samples)).
        samples: Option<Spanned<i64>> = integer(1..=Scene::MAX_SAMPLES).or(1.0),
        /// Milliseconds that a frame may take; the quality is reduced to stay within it.
        time_budget_ms: Option<Spanned<f64>> = number(1.0..=1e9),
        /// Precision of the inner loop; positions are in f64 either way.
        precision: Precision = word(&["f32", "f64"]).or_word("f32"),
        /// How several ranks share a picture ([MPI](mpi.md)).
        ranks: Scheme = word(&["auto", "tiles", "fragments"]).or_word("auto"),
        /// Device that renders ([GPU](gpu.md)).
        backend: Backend = word(&["auto", "cpu", "gpu"]).or_word("auto"),
        /// GPU by number, or by part of its name.
        device: Option<Spanned<toml::Value>> = of(Kind::Either(&Kind::Integer, &Kind::Text))
            .or_else("one of the fastest kind")
            .note("from 0"),
        /// Layers at their mean heights, or at the heights of each column where these are given, at cells or at corners.
        heights: Heights = word(&["mean", "native"]).or_word("mean"),
        image: Option<RawImage> = section(&[RawImage::KEYS]),
        /// Either `lon`, `lat` and one of `distance` and `altitude` (looking at the centre, north up), or `eye` with
        /// `target` and `up`. The x axis goes through 0°E 0°N, the z axis through the north pole.
        camera: Option<Spanned<camera::RawCamera>> = section(&[camera::RawCamera::KEYS, views::motion::KEYS]),
        /// Either `knots`, or a colour map with `range` and `opacity`. Without the section a volume has a colour map with
        /// all defaults, unless the scene has no `[opacity]` and shows surfaces, isosurfaces, lines or `[ground]`: then
        /// it has no volume.
        transfer: Option<Spanned<transfer::RawTransfer>> = section(transfer::KEYS),
        /// The opacity of the volume comes from another field than its colours.
        opacity: Option<Spanned<volume::RawOpacity>> = section(&[volume::RawOpacity::KEYS]),
        /// In place of `field`, `[transfer]` and `[opacity]`: several volumes. Extinctions add up, colours mix by
        /// extinction.
        volumes: Vec<Spanned<volume::RawVolume>> = sections_of(&[volume::RawVolume::KEYS]).count(0, MAX_SECTIONS),
        /// Layers as coloured surfaces. Either `color`, or `field` with `transfer`. Fields of files without layers
        /// (`icoray render`) are shown in this way where the scene gives no opacity.
        surfaces: Vec<Spanned<surface::RawSurface>> = sections_of(&[surface::RawSurface::KEYS]).count(0, MAX_SECTIONS),
        /// Surfaces on which a field has one value. A section may have several values.
        isosurfaces: Vec<Spanned<surface::RawIsosurface>> =
            sections_of(&[surface::RawIsosurface::KEYS]).count(0, MAX_SECTIONS),
        lines: Vec<Spanned<lines::RawLines>> = sections_of(&[lines::RawLines::KEYS]).count(0, MAX_SECTIONS),
        /// Colours of the opaque core.
        ground: Option<Spanned<RawGround>> = section(&[RawGround::KEYS]),
        /// Cuts away the places where all of the keys given hold (`cut = "inside"`), or all other places (`"outside"`).
        /// At least one key beside `cut` is given.
        clip: Vec<Spanned<clip::RawClip>> = sections_of(&[clip::RawClip::KEYS]).count(0, MAX_SECTIONS),
        /// Fields that are computed from the model's, or from those derived above. Each has one of `magnitude`, `sum` and
        /// `anomaly`.
        derive: Vec<Spanned<derive::RawDerivation>> =
            sections_of(&[derive::RawDerivation::KEYS]).count(0, MAX_SECTIONS),
        /// Blinn-Phong light with the field's gradient as normal. Without the section, or with `kind = "none"`, colours
        /// are those of the transfer function.
        light: Option<Spanned<light::RawLight>> = section(&[light::RawLight::KEYS]),
        /// Labels in PNGs. The section alone switches them on.
        labels: Option<labels::RawLabels> = section(&[labels::RawLabels::KEYS]),
        output: Option<RawOutput> = section(&[RawOutput::KEYS, views::extras::OUTPUT_KEYS]),
    }
}

keys! {
    struct RawImage {
        /// Width in pixels.
        width: Option<Spanned<i64>> = integer(1..=16384).or(512.0),
        /// Height in pixels.
        height: Option<Spanned<i64>> = integer(1..=16384).or(512.0),
    }
}

keys! {
    struct RawGround {
        /// Land.
        land: Option<Spanned<String>> = of(Kind::Color(&[])).or_else("`core`"),
        /// Sea.
        ocean: Option<Spanned<String>> = of(Kind::Color(&[])).or_else("`core`"),
    }
}

keys! {
    struct RawOutput {
        /// Name of the picture. Of a view `{view}_` stands before it, and swept keys after it.
        file: Option<Spanned<String>> = of(Kind::Text)
            .or_else("`\"{field}_{step:06}.png\"`, in a model `\"{field}_{when}.png\"`")
            .note("ends in `.png` or `.exr`"),
        /// Name of a map of errors.
        error: Option<Spanned<String>> = of(Kind::Text).note("ends in `.png`"),
    }
}

/// Largest number of volumes of a scene, and of what else it lists: far more than a picture can show.
const MAX_SECTIONS: usize = 64;
const COLOR_OR_NONE: Kind = Kind::Color(&["transparent"]);
/// The keys of a scene, as those of a table.
pub(super) static SCENE: Key = section(&[RawScene::KEYS]);
/// The keys of a scene file: those of its scene and those of scripts.
pub(super) static FILE: Key = section(&[RawScene::KEYS, views::extras::KEYS]);

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
        let source = Text::new(text);
        let table = source.table()?;
        expect_keys(table.get_ref())?;
        checked(&source, table).map_err(|e| hint::with_hint(&e))
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

/// Reads each of the sections `key`, no more than a scene may have.
fn each<R, S>(
    source: &Text,
    key: &'static str,
    raw: &[Spanned<R>],
    read: impl Fn(&Text, &Spanned<R>) -> Result<S>,
) -> Result<Vec<S>> {
    source.expect_count(raw.len(), raw.last().map_or(0..0, Spanned::span), key)?;
    raw.iter().map(|raw| read(&source.within(key), raw)).collect()
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
    let color = |raw: &Option<Spanned<String>>, key, default: [f64; 3]| {
        raw.as_ref().map_or(Ok(Some(default)), |raw| source.color_or_word(raw, key))
    };
    let core = color(&raw.core, "core", [0.0225; 3])?;
    let mut volumes = volume::volumes(source, &raw)?;
    let scenery = scenery(source, &raw, core.is_some())?;
    if volumes.is_empty() {
        volumes.push(volume::none(source, &raw, &scenery)?);
    }
    let mut scene = Scene {
        every: source.count(raw.every.as_ref(), "every")?,
        width: source.count(raw.image.as_ref().and_then(|i| i.width.as_ref()), "image.width")?,
        height: source.count(raw.image.as_ref().and_then(|i| i.height.as_ref()), "image.height")?,
        background: color(&raw.background, "background", [0.0; 3])?,
        exaggeration: source.number(raw.exaggeration.as_ref(), "exaggeration")?,
        core,
        camera: camera::camera(source, raw.camera.as_ref())?,
        volumes,
        scenery,
        lighting: raw.light.as_ref().map(|light| light::lighting(source, light)).transpose()?.flatten(),
        method: raw.method,
        tolerance: source.number(raw.tolerance.as_ref(), "tolerance")?,
        antialias: raw.antialias.unwrap_or(true),
        samples: source.count(raw.samples.as_ref(), "samples")?,
        time_budget_ms: source.optional_number(raw.time_budget_ms.as_ref(), "time_budget_ms")?,
        largest_step: Quality::LARGEST_STEP,
        precision: raw.precision,
        ranks: raw.ranks,
        backend: raw.backend,
        device: raw.device.as_ref().map(|device| adapter(source, device)).transpose()?,
        labels: raw.labels.as_ref().map(|labels| labels::labels(source, labels)).transpose()?.flatten(),
        output: output(source, raw.output.as_ref())?,
    };
    let first = scene.field().to_owned();
    scene.name_first_field(&first);
    Ok(scene)
}

/// Surfaces, lines, clips and ground beside volumes.
fn scenery(source: &Text, raw: &RawScene, has_core: bool) -> Result<Scenery> {
    let isosurfaces = each(source, "isosurfaces", &raw.isosurfaces, surface::isosurfaces)?.concat();
    // A section may have several.
    let last = raw.isosurfaces.last().map_or(0..0, Spanned::span);
    source.expect_count(isosurfaces.len(), last, "isosurfaces")?;
    Ok(Scenery {
        surfaces: each(source, "surfaces", &raw.surfaces, surface::surface)?,
        isosurfaces,
        lines: each(source, "lines", &raw.lines, |s, raw| lines::lines(s, raw, has_core))?,
        ground: match &raw.ground {
            Some(raw) => ground(source.within("ground"), raw, has_core)?,
            None => Ground::default(),
        },
        clips: each(source, "clip", &raw.clip, clip::clip)?,
        derived: derive::derivations(source, &raw.derive)?,
        heights: raw.heights,
    })
}

fn ground(source: Text, raw: &Spanned<RawGround>, has_core: bool) -> Result<Ground> {
    let (span, raw) = (raw.span(), raw.get_ref());
    if !has_core {
        let what = "land and ocean need an opaque core, expected another core than \"transparent\"";
        return Err(source.bad(span, "", what));
    }
    let color = |raw: &Option<Spanned<String>>, key| raw.as_ref().map(|raw| source.color(raw, key)).transpose();
    Ok(Ground { land: color(&raw.land, "land")?, ocean: color(&raw.ocean, "ocean")? })
}

fn template(source: &Text, raw: &Spanned<String>, key: &str) -> Result<NameTemplate> {
    NameTemplate::new(raw.get_ref()).map_err(|e| source.bad(raw.span(), key, e.context()))
}

fn output(source: &Text, raw: Option<&RawOutput>) -> Result<Output> {
    let (file, error) = raw.map_or((None, None), |o| (o.file.as_ref(), o.error.as_ref()));
    let file = match file {
        Some(raw) => template(source, raw, "output.file")?,
        None => NameTemplate::new("{field}_{step:06}.png")?,
    };
    let Some(raw) = error else { return Ok(file.into()) };
    let (text, key) = (raw.get_ref(), "output.error");
    let error = template(source, raw, key)?;
    if !text.ends_with(".png") {
        return Err(source.bad(raw.span(), key, format!("{text:?}: expected a name that ends in .png")));
    }
    if error == file {
        let what = "the same as output.file, expected another name";
        return Err(source.bad(raw.span(), key, format!("{text:?}: {what}")));
    }
    Ok(Output { error: Some(error), ..file.into() })
}

#[cfg(test)]
mod tests;
