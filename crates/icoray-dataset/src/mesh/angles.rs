//! Longitudes and latitudes in radians, converted from the unit in the file, and places on the unit sphere.

use super::tables::{Positions, find};
use crate::source::{Source, SourceVariable};
use crate::values::change_each;
use icoray::{ErrorKind, OwnedReals, Result};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Reads the polygons' points of two variables; angles without a unit of their own have that of the coordinates in
/// `middles`, if any.
pub(super) fn read_bounds(bounds: [SourceVariable; 2], middles: Option<[&str; 2]>) -> Result<Positions> {
    let [lon, lat] = bounds;
    if lon.variable.dimensions != lat.variable.dimensions || bounds.iter().any(|found| !found.variable.kind.is_real()) {
        let [lon, lat] = bounds.map(|found| found.variable);
        let context = format!("variables {lon} and {lat}, expected the same dimensions of float or double");
        return Err(bounds[0].error(ErrorKind::Grid, context));
    }
    let mut names = bounds.map(SourceVariable::name);
    for (k, middle) in middles.iter().flatten().enumerate() {
        if bounds[k].text("units")?.is_none() {
            names[k] = middle;
        }
    }
    in_radians(lon.source, names, [lon.all_numbers()?, lat.all_numbers()?].map(OwnedReals::F64))
}

/// Positions over one dimension, in radians.
pub(super) fn positions(source: &dyn Source, [lon, lat]: [&str; 2], dimension: &str) -> Result<Positions> {
    let read = |name: &str| find(source, name, &[dimension], false)?.all_reals();
    in_radians(source, [lon, lat], [read(lon)?, read(lat)?])
}

/// Positions in one variable, over two and the positions, or over the positions and two: longitudes before latitudes.
pub(super) fn positions_of_pairs(found: SourceVariable) -> Result<Positions> {
    let (count, stride, step) = match found.variable.after_time() {
        [two, count] if two.len == 2 && found.variable.kind.is_real() => (count.len, 1, count.len),
        [count, of] if of.len >= 2 && found.variable.kind.is_real() => (count.len, of.len, 1),
        _ => return Err(found.unexpected(ErrorKind::Grid, "longitudes and latitudes as float or double")),
    };
    let all = found.all_numbers()?;
    let part = |k: usize| OwnedReals::F64((0..count).map(|i| all[i * stride + k * step]).collect());
    in_radians(found.source, [found.name(); 2], [part(0), part(1)])
}

/// Positions with longitudes and latitudes, converted to radians from the units of the coordinates with these names. If
/// one has none, it has the unit of the other; if neither has, both are degrees if a longitude is beyond 2π or a
/// latitude beyond π/2.
fn in_radians(source: &dyn Source, names: [&str; 2], mut values: [OwnedReals; 2]) -> Result<Positions> {
    let unit = |name: &str| {
        let units = source.text_of(name, "units")?.map(|units| units.to_ascii_lowercase());
        match units.as_deref() {
            None | Some("" | "1") => Ok(None),
            Some(units) if units.starts_with("rad") => Ok(Some(false)),
            Some(units) if units.starts_with("deg") => Ok(Some(true)),
            Some(units) => {
                let context = format!("{name} is in {units:?}, expected radian or degrees");
                Err(source.error(ErrorKind::Grid, context))
            }
        }
    };
    let is_beyond = |values: &OwnedReals, end: f64| {
        let reals = values.as_reals();
        (0..reals.len()).any(|i| reals.get(i).abs() > end + 1e-6)
    };
    let is_degrees = match [unit(names[0])?, unit(names[1])?] {
        [Some(lon), Some(lat)] => [lon, lat],
        [Some(one), None] | [None, Some(one)] => [one; 2],
        [None, None] => [is_beyond(&values[0], TAU) || is_beyond(&values[1], FRAC_PI_2); 2],
    };
    for (values, _) in values.iter_mut().zip(is_degrees).filter(|(_, is_degrees)| *is_degrees) {
        change_each(values, f64::to_radians);
    }
    let [lon, lat] = values;
    Ok(Positions { lon, lat })
}

/// Longitude and latitude of directions of any length.
pub(super) fn of_directions(directions: impl Iterator<Item = impl Into<[f64; 3]>>) -> Positions {
    let (mut lon, mut lat) = (Vec::new(), Vec::new());
    for [x, y, z] in directions.map(Into::into) {
        lon.push(y.atan2(x));
        lat.push(z.atan2(x.hypot(y)));
    }
    Positions { lon: OwnedReals::F64(lon), lat: OwnedReals::F64(lat) }
}
