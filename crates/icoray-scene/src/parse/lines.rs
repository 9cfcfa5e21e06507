//! Lines on the ground or on a level.

use super::place::{HEIGHT_M, RawLayer, RawRegion, level, region};
use super::text::Text;
use crate::keys::{Kind, keys, layer, number, of, table, word};
use crate::outlines::Outlines;
use crate::scenery::{Level, Lines, Pattern};
use icoray_grid::{Error, Result};
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;

keys! {
    pub(super) struct RawLines {
        /// Outlines of cells, of dual triangles, meridians and parallels, coasts or borders between countries
        /// (Natural Earth 1:110m, and 1:50m where pixels are smaller than 0.06 degrees).
        pattern: Option<Spanned<PatternName>> =
            word(&["cells", "triangles", "graticule", "coast", "borders"]).or_word("graticule"),
        /// Level of the lines; `"ground"` needs an opaque core.
        on: Option<Spanned<RawLayer>> = layer(&["ground", "top", "bottom"]).or_word("ground"),
        /// In place of `on`: height in metres.
        height_m: Option<Spanned<f64>> = HEIGHT_M,
        /// Colour.
        color: Option<Spanned<String>> = of(Kind::Color(&[])).or_word("white"),
        /// Width in pixels.
        width: Option<Spanned<f64>> = number(0.1..=50.0).or(1.0),
        /// Part of the light that a line absorbs.
        opacity: Option<Spanned<f64>> = number(0.0..=1.0).above(0.0).or(1.0),
        /// In place of `pattern`: a GeoJSON file of at most 64 MiB, whose lines and outlines of polygons are drawn,
        /// straight in longitude and latitude; relative paths begin where the program runs.
        file: Option<Spanned<String>> = of(Kind::Text),
        /// With `"graticule"`: degrees between lines.
        spacing: Option<Spanned<f64>> = number(0.1..=90.0).or(30.0),
        /// Box to which lines are limited: `lon`, `lat` or both.
        region: Option<Spanned<RawRegion>> = table(&[RawRegion::KEYS]).or_else("everywhere"),
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum PatternName {
    Cells,
    Triangles,
    Graticule,
    Coast,
    Borders,
}

pub(super) fn lines(source: &Text, raw: &Spanned<RawLines>, has_core: bool) -> Result<Lines> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let on = level(source, "on", raw.on.as_ref(), raw.height_m.as_ref())?.unwrap_or(Level::Ground);
    if on == Level::Ground && !has_core {
        let what = "lines on the ground need an opaque core; expected \"top\", \"bottom\", the number of a layer or height_m, \
                    or another core than \"transparent\"";
        return Err(source.bad(raw.on.as_ref().map_or(span, Spanned::span), "on", what));
    }
    let pattern = match (&raw.pattern, &raw.file) {
        (Some(pattern), Some(_)) => {
            return Err(source.bad(pattern.span(), "pattern", "expected either pattern or file"));
        }
        (None, Some(file)) => {
            let bad = |cause: Error| source.bad(file.span(), "file", cause.context());
            Pattern::Outlines(Outlines::read(Path::new(file.get_ref())).map_err(bad)?)
        }
        (pattern, None) => match pattern.as_ref().map(Spanned::get_ref) {
            Some(PatternName::Cells) => Pattern::Cells,
            Some(PatternName::Triangles) => Pattern::Triangles,
            Some(PatternName::Coast) => Pattern::Coast,
            Some(PatternName::Borders) => Pattern::Borders,
            Some(PatternName::Graticule) | None => {
                Pattern::Graticule { spacing_deg: source.number(raw.spacing.as_ref(), "spacing")? }
            }
        },
    };
    if let (Some(stray), false) = (&raw.spacing, matches!(pattern, Pattern::Graticule { .. })) {
        return Err(source.bad(stray.span(), "spacing", "is valid only with pattern = \"graticule\""));
    }
    Ok(Lines {
        pattern,
        on,
        color: raw.color.as_ref().map_or(Ok([1.0; 3]), |color| source.color(color, "color"))?,
        width_px: source.number(raw.width.as_ref(), "width")?,
        opacity: source.number(raw.opacity.as_ref(), "opacity")?,
        region: raw.region.as_ref().map(|raw| region(source, raw)).transpose()?,
    })
}
