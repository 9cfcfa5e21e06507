//! The box within which lines are drawn.

use super::paint::LineStyle;
use super::screen_jacobian::ScreenJacobian;
use icoray_scene::LonLatBox;

/// The fraction of the pixel inside of `limits`, widened by half a line, so that lines on its sides are drawn whole.
pub(super) fn inside(limits: &LonLatBox, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    let ([west, east], [south, north]) = (limits.lon_deg, limits.lat_deg);
    let (lon, lat) = (jacobian.lon_deg(), jacobian.lat_deg());
    let mut depth = f64::INFINITY;
    let stretch = jacobian.stretch_of_latitude();
    for (is_there, degrees) in [(south > -90.0, lat - south), (north < 90.0, north - lat)] {
        if is_there {
            depth = depth.min(degrees.to_radians() * stretch);
        }
    }
    if east - west < 360.0 {
        let past = (lon - west).rem_euclid(360.0);
        let wide = east - west;
        let degrees = if past <= wide { past.min(wide - past) } else { -(past - wide).min(360.0 - past) };
        let stretch = jacobian.place[1].cos() * jacobian.stretch_across_meridians();
        depth = depth.min(degrees.to_radians() * stretch);
    }
    (depth + pen.reach()).clamp(0.0, 1.0)
}
