//! Land and sea.

use super::text::Text;
use crate::keys::{Kind, keys, of};
use crate::scenery::Ground;
use icoray_grid::Result;
use toml::Spanned;

keys! {
    pub(super) struct RawGround {
        /// Land.
        land: Option<Spanned<String>> = of(Kind::Color(&[])).or_else("`core`"),
        /// Sea.
        ocean: Option<Spanned<String>> = of(Kind::Color(&[])).or_else("`core`"),
    }
}

pub(super) fn ground(source: Text, raw: &Spanned<RawGround>, has_core: bool) -> Result<Ground> {
    let (span, raw) = (raw.span(), raw.get_ref());
    if !has_core {
        let what = "land and ocean need an opaque core, expected another core than \"transparent\"";
        return Err(source.bad(span, "", what));
    }
    let color = |raw: &Option<Spanned<String>>, key| raw.as_ref().map(|raw| source.color(raw, key)).transpose();
    Ok(Ground { land: color(&raw.land, "land")?, ocean: color(&raw.ocean, "ocean")? })
}
