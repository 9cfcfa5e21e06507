//! Keys of `[[clips]]`.

use super::place::{LATITUDES, LONGITUDES, layers, lon_lat_box};
use super::text::Text;
use crate::keys::{Kind, keys, number, of, table, word};
use crate::scenery::{Clip, HalfSpace};
use icoray_grid::{Result, numbers};
use serde::Deserialize;
use toml::Spanned;

keys! {
    pub(super) struct RawClip {
        /// Which side is removed.
        cut: ClipSide = word(&["inside", "outside"]).or_word("inside"),
        /// Longitudes, degrees.
        lon: Option<Spanned<[f64; 2]>> = LONGITUDES,
        /// Latitudes, degrees.
        lat: Option<Spanned<[f64; 2]>> = LATITUDES,
        /// Layers, both included.
        layers: Option<Spanned<[i64; 2]>> = of(LOW_HIGH).or_else("all").note("from 0, the innermost"),
        /// Heights above the planet's surface, metres.
        height_m: Option<Spanned<[f64; 2]>> = of(LOW_HIGH).or_else("all").note("finite"),
        /// The space beyond a plane: `towards` and `distance`.
        half_space: Option<Spanned<RawHalfSpace>> = table(&[RawHalfSpace::KEYS]),
    }
}

const LOW_HIGH: Kind = Kind::Vector(&["low", "high"]);

#[derive(Deserialize, Clone, Copy, PartialEq, Default)]
#[serde(rename_all = "lowercase")]
enum ClipSide {
    #[default]
    Inside,
    Outside,
}

keys! {
    struct RawHalfSpace {
        /// Direction of the plane's normal.
        towards: Option<Spanned<[f64; 2]>> =
            of(Kind::Vector(&["lon", "lat"])).required().note("-360 to 360, -90 to 90"),
        /// Distance of the plane from the centre, planet radii.
        distance: Option<Spanned<f64>> = number(-1e6..=1e6).or(0.0),
    }
}

pub(super) fn clip(source: &Text, raw: &Spanned<RawClip>) -> Result<Clip> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let clip = Clip {
        cuts_inside: raw.cut == ClipSide::Inside,
        region: lon_lat_box(source, "", raw.lon.as_ref(), raw.lat.as_ref())?,
        layers: raw.layers.as_ref().map(|raw| layers(source, raw, "layers")).transpose()?,
        height_m: raw.height_m.as_ref().map(|raw| source.range(raw, "height_m")).transpose()?,
        half_space: raw.half_space.as_ref().map(|raw| half_space(source, raw)).transpose()?,
    };
    let Clip { cuts_inside: _, region, layers, height_m, half_space } = &clip;
    if region.is_none() && layers.is_none() && height_m.is_none() && half_space.is_none() {
        let what = "expected one of lon, lat, layers, height_m and half_space at least";
        return Err(source.bad(span, "", what));
    }
    Ok(clip)
}

fn half_space(source: &Text, raw: &Spanned<RawHalfSpace>) -> Result<HalfSpace> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let Some(towards) = &raw.towards else {
        return Err(source.bad(span, "half_space.towards", "is absent, expected longitude and latitude"));
    };
    let [lon, lat] = *towards.get_ref();
    if !((-360.0..=360.0).contains(&lon) && (-90.0..=90.0).contains(&lat)) {
        let found = numbers::list(&[lon, lat]);
        let what = format!("{found}, expected longitude and latitude, from -360 to 360 and from -90 to 90");
        return Err(source.bad(towards.span(), "half_space.towards", what));
    }
    let distance = source.number(raw.distance.as_ref(), "half_space.distance")?;
    Ok(HalfSpace { towards_deg: [lon, lat], distance })
}
