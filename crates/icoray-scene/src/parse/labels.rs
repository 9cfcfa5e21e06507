//! Keys of `[labels]`.

use super::text::Text;
use crate::labels::{LabelPlace, Labels};
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLabels {
    on: Option<bool>,
    title: Option<Spanned<String>>,
    name: Option<String>,
    units: Option<String>,
    #[serde(default)]
    place: LabelPlace,
    size: Option<Spanned<f64>>,
    color: Option<Spanned<String>>,
    bar: Option<bool>,
    scale: Option<bool>,
    error: Option<bool>,
}

/// The labels, unless they are switched off.
pub(super) fn labels(source: &Text, raw: &RawLabels) -> Result<Option<Labels>> {
    let title = match &raw.title {
        None => Labels::title("{time}")?,
        Some(title) => {
            Labels::title(title.get_ref()).map_err(|e| source.bad(title.span(), "labels.title", e.context()))?
        }
    };
    let color = source.color_or_auto(raw.color.as_ref(), "labels.color")?;
    let labels = Labels {
        title,
        name: raw.name.clone(),
        units: raw.units.clone(),
        place: raw.place,
        size: source.number(raw.size.as_ref(), "labels.size", 0.25, 4.0, 1.0)?,
        color,
        bar: raw.bar.unwrap_or(true),
        scale_note: raw.scale.unwrap_or(true),
        error_note: raw.error.unwrap_or(true),
    };
    Ok(raw.on.unwrap_or(true).then_some(labels))
}
