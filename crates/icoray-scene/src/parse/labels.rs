//! Keys of `[labels]`.

use super::text::Text;
use crate::keys::{Kind, flag, keys, number, of, word};
use crate::labels::{LabelPlace, Labels};
use icoray_grid::Result;
use toml::Spanned;

keys! {
    pub(super) struct RawLabels {
        /// `false` switches labels off.
        on: Option<bool> = flag(true),
        /// Title; see [placeholders](#placeholders).
        title: Option<Spanned<String>> = of(Kind::Text).or_word("{time}"),
        /// Name beside the colour bar.
        name: Option<String> = of(Kind::Text).or_else("the field's"),
        /// Units beside the colour bar.
        units: Option<String> = of(Kind::Text).or_else("the field's"),
        /// Place of the colour bar; `"below"` adds rows below the picture.
        place: LabelPlace = word(&["auto", "right", "bottom", "left", "below"]).or_word("auto"),
        /// Factor on the size of text.
        size: Option<Spanned<f64>> = number(0.25..=4.0).or(1.0),
        /// Colour of text; by itself light on dark and dark on light.
        color: Option<Spanned<String>> = of(Kind::Color(&["auto"])).or_word("auto"),
        /// Colour bar.
        bar: Option<bool> = flag(true),
        /// Note on exaggeration.
        scale: Option<bool> = flag(true),
        /// Note on the error; in orange (red on bright backgrounds) where it is above the tolerance in more than one in a
        /// thousand of the pixels that have one, with their number.
        error: Option<bool> = of(Kind::Boolean).or_else("only where it is above the tolerance"),
    }
}

/// The labels, unless they are switched off.
pub(super) fn labels(source: &Text, raw: &RawLabels) -> Result<Option<Labels>> {
    let title = match &raw.title {
        None => Labels::title("{time}")?,
        Some(title) => {
            Labels::title(title.get_ref()).map_err(|e| source.bad(title.span(), "labels.title", e.context()))?
        }
    };
    let labels = Labels {
        title,
        name: raw.name.clone(),
        units: raw.units.clone(),
        place: raw.place,
        size: source.number(raw.size.as_ref(), "labels.size")?,
        color: raw.color.as_ref().map_or(Ok(None), |color| source.color_or_word(color, "labels.color"))?,
        bar: raw.bar.unwrap_or(true),
        scale_note: raw.scale.unwrap_or(true),
        error_note: raw.error,
    };
    Ok(raw.on.unwrap_or(true).then_some(labels))
}
