//! The radius of the sphere.

use crate::source::SourceVariable;
use crate::sources::Sources;
use icoray::{ErrorKind, Result};

/// Earth's radius in ICON and DYNAMICO, metres, for files without one.
pub(crate) const EARTH_M: f64 = 6_371_229.0;

/// The radius from the user, or from the files, or from positions of cells; else that of the Earth.
pub(crate) fn of(sources: &Sources) -> Result<f64> {
    if let Some(radius_m) = sources.options.radius_m {
        return Ok(radius_m);
    }
    match sources.number("sphere_radius")? {
        Some(r) if r.is_finite() && r > 0.0 => Ok(r),
        Some(r) => {
            let context = format!("sphere_radius: {r}, expected a positive number");
            Err(sources.fields().error(ErrorKind::Grid, context))
        }
        None => Ok(of_positions(sources)?.unwrap_or(EARTH_M)),
    }
}

/// The distance of the first of MPAS's cells from the centre of the sphere.
fn of_positions(sources: &Sources) -> Result<Option<f64>> {
    let mut square = 0.0;
    for name in ["xCell", "yCell", "zCell"] {
        let Some(SourceVariable { source, variable }) = sources.find(name) else { return Ok(None) };
        let (start, count) = (vec![0; variable.dimensions.len()], vec![1; variable.dimensions.len()]);
        if !variable.kind.is_real() || variable.dimensions.iter().any(|dimension| dimension.len == 0) {
            return Ok(None);
        }
        square += source.reals(variable, &start, &count)?.as_reals().get(0).powi(2);
    }
    // Rounded, so that a unit sphere has radius 1.
    Ok(Some((1e3 * square.sqrt()).round() / 1e3).filter(|radius| radius.is_finite() && *radius > 0.0))
}
