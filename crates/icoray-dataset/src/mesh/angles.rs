//! Longitudes and latitudes in radians, whatever unit a file has them in, and places on the unit sphere.

use super::tables::{Positions, find};
use crate::reals::ChangeReals;
use crate::source::{Source, Variable};
use icoray::{ErrorKind, OwnedReals, Result};
use std::f64::consts::TAU;

/// The polygons' points: as many for each polygon.
pub(super) struct Bounds {
    /// Radians.
    pub lon: Vec<f64>,
    pub lat: Vec<f64>,
    /// Points of a polygon.
    pub row: usize,
}

impl Bounds {
    /// The points' directions, polygon by polygon.
    pub fn directions(&self) -> Vec<[f64; 3]> {
        (0..self.lon.len()).map(|i| direction(self.lon[i], self.lat[i])).collect()
    }

    /// Longitudes and latitudes of a polygon's points, degrees, for an error.
    pub fn degrees(&self, polygon: usize) -> Vec<[f64; 2]> {
        let row = self.row * polygon..self.row * (polygon + 1);
        row.map(|i| [self.lon[i], self.lat[i]].map(f64::to_degrees)).collect()
    }
}

/// Reads the polygons' points of two variables; angles without a unit of their own have that of the coordinate, if any.
pub(super) fn read_bounds(source: &dyn Source, [lon, lat]: [(&Variable, Option<&str>); 2]) -> Result<Bounds> {
    let row = lon.0.after_time()[1].len;
    if lon.0.dimensions != lat.0.dimensions || !lon.0.kind.is_real() || !lat.0.kind.is_real() {
        let context = format!("variables {} and {}, expected the same dimensions of float or double", lon.0, lat.0);
        return Err(source.error(ErrorKind::Grid, context));
    }
    let read = |(variable, coordinate): (&Variable, Option<&str>)| -> Result<Vec<f64>> {
        let own = source.text_of(&variable.name, "units")?;
        let unit_of = coordinate.filter(|_| own.is_none()).unwrap_or(&variable.name);
        let mut values = OwnedReals::F64(source.all_numbers(variable)?);
        into_radians(source, unit_of, &mut values)?;
        Ok((0..values.as_reals().len()).map(|i| values.as_reals().get(i)).collect())
    };
    Ok(Bounds { lon: read(lon)?, lat: read(lat)?, row })
}

/// Positions over one dimension, in radians.
pub(super) fn positions(source: &dyn Source, lon: &str, lat: &str, dimension: &str) -> Result<Positions> {
    let read = |name: &str| {
        let variable = find(source, name, &[dimension], false)?;
        let mut values = source.all_reals(variable)?;
        into_radians(source, name, &mut values)?;
        Ok(values)
    };
    Ok(Positions { lon: read(lon)?, lat: read(lat)? })
}

/// Makes radians of angles in the unit that coordinate `name` has. Without one they are degrees if any is beyond 2π, as
/// on a whole sphere some are.
pub(super) fn into_radians(source: &dyn Source, name: &str, values: &mut OwnedReals) -> Result<()> {
    let units = source.text_of(name, "units")?.map(|units| units.to_ascii_lowercase());
    let reals = values.as_reals();
    let is_degrees = match units.as_deref() {
        Some(units) if units.starts_with("rad") => false,
        Some(units) if units.starts_with("deg") => true,
        None => (0..reals.len()).any(|i| reals.get(i).abs() > TAU + 1e-6),
        Some(units) => {
            let context = format!("{name} is in {units:?}, expected radian or degrees");
            return Err(source.error(ErrorKind::Grid, context));
        }
    };
    if is_degrees {
        values.each(f64::to_radians);
    }
    Ok(())
}

pub(super) fn direction(lon: f64, lat: f64) -> [f64; 3] {
    [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()]
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Longitude and latitude of directions of any length.
pub(super) fn of_directions(directions: impl Iterator<Item = [f64; 3]>) -> Positions {
    let (mut lon, mut lat) = (Vec::new(), Vec::new());
    for [x, y, z] in directions {
        lon.push(y.atan2(x));
        lat.push(z.atan2(x.hypot(y)));
    }
    Positions { lon: OwnedReals::F64(lon), lat: OwnedReals::F64(lat) }
}
