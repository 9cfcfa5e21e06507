//! The camera, by a place above which it is or by where it stands and looks.

use super::Text;
use crate::error::Result;
use crate::scene::Camera;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    lon: Option<Spanned<f64>>,
    lat: Option<Spanned<f64>>,
    distance: Option<Spanned<f64>>,
    altitude: Option<Spanned<f64>>,
    eye: Option<Spanned<[f64; 3]>>,
    target: Option<Spanned<[f64; 3]>>,
    up: Option<Spanned<[f64; 3]>>,
    fov: Option<Spanned<f64>>,
}

pub(super) fn camera(source: &Text, raw: &Spanned<RawCamera>) -> Result<Camera> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let fov = source.number(raw.fov.as_ref(), "camera.fov", 1e-3, 179.0, 30.0)?;
    let camera = match (&raw.eye, &raw.lon, &raw.lat) {
        (Some(eye), None, None) => {
            if let Some(stray) = raw.distance.as_ref().or(raw.altitude.as_ref()) {
                return Err(source.bad(
                    stray.span(),
                    "camera",
                    "distance and altitude go with lon and lat, not with eye",
                ));
            }
            let target = raw.target.as_ref().map_or([0.0; 3], |t| *t.get_ref());
            let up = raw.up.as_ref().map_or([0.0, 0.0, 1.0], |u| *u.get_ref());
            Camera::look_at(*eye.get_ref(), target, up, fov)
        }
        (None, Some(lon), Some(lat)) => {
            let lon = source.number(Some(lon), "camera.lon", -360.0, 360.0, 0.0)?;
            let lat = source.number(Some(lat), "camera.lat", -90.0, 90.0, 0.0)?;
            if let Some(stray) = raw.target.as_ref().or(raw.up.as_ref()) {
                return Err(source.bad(
                    stray.span(),
                    "camera",
                    "target and up go with eye, not with lon and lat",
                ));
            }
            let distance = match (&raw.distance, &raw.altitude) {
                (Some(d), None) => source.number(Some(d), "camera.distance", 1e-6, 1e6, 0.0)?,
                (None, Some(a)) => 1.0 + source.number(Some(a), "camera.altitude", -0.999_999, 1e6, 0.0)?,
                _ => {
                    return Err(source.bad(
                        span,
                        "camera",
                        "expected either distance or altitude beside lon and lat",
                    ));
                }
            };
            Camera::above(lon, lat, distance, fov)
        }
        _ => {
            return Err(source.bad(
                span,
                "camera",
                "expected lon, lat and distance (or altitude), or eye, target and up",
            ));
        }
    };
    camera.ok_or_else(|| {
        source.bad(
            span,
            "camera",
            "eye and target coincide, up points along the view, or a number is not finite",
        )
    })
}
