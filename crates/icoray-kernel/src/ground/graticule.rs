//! Meridians and parallels.

use super::paint::LineStyle;
use super::screen_jacobian::ScreenJacobian;
use icoray_grid::grid::unit_vector;

/// The fraction of the pixel that lines `spacing` degrees apart cover. Meridians end at the last parallel, except for
/// those at each quarter turn, which extend to the poles.
pub(super) fn covered(spacing: f64, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    let (along, across) = (parallels(spacing.to_radians(), jacobian, pen), meridians(spacing, jacobian, pen));
    // They meet at a right angle.
    along + across - along * across
}

fn parallels(spacing: f64, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    let stretch = jacobian.stretch_of_latitude();
    let shown = pen.shows(spacing * stretch);
    if shown == 0.0 {
        return 0.0;
    }
    let lat = jacobian.place[1];
    let last = last(spacing.to_degrees());
    let nearest = (lat / spacing).round().clamp(-last, last) * spacing;
    shown * pen.covers((lat - nearest).abs() * stretch)
}

/// The number of parallels from the equator to the last before the pole.
fn last(spacing: f64) -> f64 {
    (90.0 / spacing).ceil() - 1.0
}

fn meridians(spacing: f64, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    let (lon, lat) = (jacobian.lon_deg(), jacobian.lat_deg());
    let outermost = last(spacing) * spacing;
    // Beyond the last parallel the few remaining meridians are shown as at it.
    let wide = lat.abs().min(outermost).to_radians().cos();
    let shown = pen.shows(spacing.to_radians() * wide * jacobian.stretch_across_meridians());
    if shown == 0.0 {
        return 0.0;
    }
    let most = (180.0 / spacing).floor();
    let nearest = (lon / spacing).round().clamp(-most, most) * spacing;
    let quarter = (lon / 90.0).round() * 90.0;
    // If the spacing does not divide a turn, the nearest may be on the other side of 180.
    let ends = [nearest, -most.copysign(lon) * spacing].map(|lon| (lon, outermost));
    let to_pole = Some((quarter, 90.0)).filter(|_| is_multiple(quarter, spacing));
    let distance = ends.into_iter().chain(to_pole).map(|(lon, end)| meridian(lon, end, jacobian));
    shown * pen.covers(distance.fold(f64::INFINITY, f64::min))
}

fn is_multiple(lon: f64, spacing: f64) -> bool {
    let times = lon / spacing;
    (times - times.round()).abs() < 1e-9
}

/// Pixels to the meridian of `lon`, which runs from latitude `-end` to `end`.
fn meridian(lon: f64, end: f64, jacobian: &ScreenJacobian) -> f64 {
    /// Degrees of latitude on either side within which it is near enough.
    const AROUND: f64 = 30.0;
    let at = |lat: f64| unit_vector(lon.to_radians(), lat.clamp(-end, end).to_radians());
    jacobian.distance(at(jacobian.lat_deg() - AROUND), at(jacobian.lat_deg() + AROUND))
}
