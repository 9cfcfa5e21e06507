//! Lines on the ground or on a level.

use super::place::{RawLayer, RawRegion, level, region};
use super::text::Text;
use crate::scenery::{Level, Lines, Pattern};
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLines {
    #[serde(default)]
    pattern: PatternName,
    on: Option<Spanned<RawLayer>>,
    height_m: Option<Spanned<f64>>,
    color: Option<Spanned<String>>,
    width: Option<Spanned<f64>>,
    opacity: Option<Spanned<f64>>,
    spacing: Option<Spanned<f64>>,
    region: Option<Spanned<RawRegion>>,
}

#[derive(Deserialize, Clone, Copy, Default)]
#[serde(rename_all = "lowercase")]
enum PatternName {
    Cells,
    Triangles,
    #[default]
    Graticule,
    Coast,
}

pub(super) fn lines(source: &Text, raw: &Spanned<RawLines>, has_core: bool) -> Result<Lines> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let on = level(source, ("on", raw.on.as_ref()), raw.height_m.as_ref())?.unwrap_or(Level::Ground);
    if on == Level::Ground && !has_core {
        let what = "lines on the ground need an opaque core; expected \"top\", \"bottom\", the number of a layer or height_m, \
                    or another core than \"transparent\"";
        return Err(source.bad(raw.on.as_ref().map_or(span, Spanned::span), "on", what));
    }
    let pattern = match raw.pattern {
        PatternName::Cells => Pattern::Cells,
        PatternName::Triangles => Pattern::Triangles,
        PatternName::Coast => Pattern::Coast,
        PatternName::Graticule => {
            Pattern::Graticule { spacing_deg: source.number(raw.spacing.as_ref(), "spacing", 0.1, 90.0, 30.0)? }
        }
    };
    if let (Some(stray), false) = (&raw.spacing, matches!(pattern, Pattern::Graticule { .. })) {
        return Err(source.bad(stray.span(), "spacing", "is valid only with pattern = \"graticule\""));
    }
    Ok(Lines {
        pattern,
        on,
        color: raw.color.as_ref().map_or(Ok([1.0; 3]), |color| source.color(color, "color"))?,
        width_px: source.number(raw.width.as_ref(), "width", 0.1, 50.0, 1.0)?,
        opacity: source.opacity(raw.opacity.as_ref())?,
        region: raw.region.as_ref().map(|raw| region(source, raw)).transpose()?,
    })
}
