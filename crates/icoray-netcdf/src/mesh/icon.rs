//! ICON's triangles as the corners of hexagons: icoray's cells are the triangles' points, its corners the triangles.
//!
//! Grid files have `vertex_of_cell`. Files with data mostly have no tables, but each triangle's own three points
//! (`clon_bnds`, `clat_bnds`): points that lie in one place are one, and that gives the same table.
//! Formats: ICON grid files, <https://gitlab.dkrz.de/icon>; CF conventions 1.11, §7.1.

use super::triangles::{Connectivity, connect};
use super::{Convention, Mesh, Positions, find, missing, points};
use crate::reals::OwnedReals;
use crate::source::{Kind, Source, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, Result};
use std::f64::consts::TAU;

/// Points nearer to each other than this part of the shortest side are one. Degrees in f32 are right to 1e-3 of a side of 2 km.
const SAME: f64 = 0.02;

/// Whether any of the files has triangles.
pub(super) fn is_in(sources: &Sources) -> bool {
    sources
        .all()
        .iter()
        .any(|source| source.variable("vertex_of_cell").is_some() || longitudes(source).is_some())
}

pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    let with_tables = sources.others_first().find(|source| source.variable("vertex_of_cell").is_some());
    if let Some(source) = with_tables {
        return of_tables(source);
    }
    let source = sources.others_first().find(|source| longitudes(source).is_some());
    of_bounds(source.expect("one has triangles, or this is not called"))
}

/// The mesh of a grid file.
fn of_tables(source: &Source) -> Result<Mesh> {
    if let Some(geometry) = source.number("grid_geometry")?.filter(|geometry| *geometry != 1.0) {
        let context =
            format!("grid_geometry is {geometry}, expected 1: only meshes on a sphere are rendered");
        return Err(source.error(ErrorKind::Unsupported, context));
    }
    let variable = source.variable("vertex_of_cell").ok_or_else(|| missing(source, "vertex_of_cell"))?;
    let [three, cells] = match &variable.dimensions[..] {
        [three, cells] if three.len == 3 => [three, cells],
        _ => {
            let context = format!("variable {variable}, expected vertex_of_cell(nv = 3, cell) of integer");
            return Err(source.error(ErrorKind::Grid, context));
        }
    };
    let table = find(source, "vertex_of_cell", &[&three.name, &cells.name], true)?;
    let corner = positions(source, "clon", "clat", &cells.name)?;
    let vertex = source.variable("vlon").ok_or_else(|| missing(source, "vlon"))?;
    let vertices = vertex.dimensions.first().map_or("", |d| d.name.as_str());
    let center = positions(source, "vlon", "vlat", vertices)?;
    // The file goes by the triangle's first points, then its second, then its third.
    let by_column = source.all_integers(table)?;
    let triangles = by_column.len() / 3;
    let corner_cell =
        (0..by_column.len()).map(|i| by_column[i % 3 * triangles + i / 3].saturating_sub(1)).collect();
    mesh(source, center, corner, corner_cell)
}

/// The mesh of a file that has each triangle's points.
fn of_bounds(source: &Source) -> Result<Mesh> {
    let (lon, lat) = longitudes(source).ok_or_else(|| missing(source, "clon"))?;
    let triangles = &lon.dimensions[0];
    let corner = positions(source, &lon.name, lat, &triangles.name)?;
    let [lon, lat] =
        [(&lon.name[..], lon.name.as_str()), (lat, lat)].map(|(name, of)| bounds(source, name, of));
    let (lon, lat) = (lon?, lat?);
    let points: Vec<[f64; 3]> = (0..lon.len()).map(|i| direction(lon[i], lat[i])).collect();
    let mut shortest = f64::INFINITY;
    for (triangle, three) in points.chunks_exact(3).enumerate() {
        let side = (0..3).map(|k| distance(three[k], three[(k + 1) % 3])).fold(f64::INFINITY, f64::min);
        if !(side > 0.0 && three.as_flattened().iter().all(|x| x.is_finite())) {
            let place =
                [0, 1, 2].map(|k| [lon[3 * triangle + k], lat[3 * triangle + k]].map(f64::to_degrees));
            let context = format!(
                "the bounds of triangle {triangle} are {place:?} degrees, expected three different points"
            );
            return Err(source.error(ErrorKind::Grid, context));
        }
        shortest = shortest.min(side);
    }
    let (corner_cell, first) = points::number(points.into_iter(), SAME * shortest);
    let of = |angle: &[f64]| OwnedReals::F64(first.iter().map(|&i| angle[i]).collect());
    let center = Positions { lon: of(&lon), lat: of(&lat) };
    mesh(source, center, corner, corner_cell)
}

fn mesh(source: &Source, center: Positions, corner: Positions, corner_cell: Vec<i32>) -> Result<Mesh> {
    let Connectivity { corner_edge, edge_corner, cell_corner, cell_corner_row, cell_corner_count } =
        connect(&corner_cell, center.lon.as_reals().len()).map_err(|e| e.within(source.path().display()))?;
    Ok(Mesh {
        path: source.path().to_owned(),
        convention: Convention::Icon,
        index_base: 0,
        center,
        corner,
        cell_corner,
        cell_corner_row,
        cell_corner_count,
        corner_cell,
        corner_edge,
        edge_corner,
    })
}

/// The triangles' longitudes and the name of their latitudes, where they have bounds too.
fn longitudes(source: &Source) -> Option<(&Variable, &'static str)> {
    [("clon", "clat"), ("lon", "lat")].into_iter().find_map(|(lon, lat)| {
        let variable = source.variable(lon).filter(|v| v.dimensions.len() == 1)?;
        let is_own = lon == "clon" || matches!(source.text_of(lon, "bounds"), Ok(Some(_)));
        is_own.then_some((variable, lat))
    })
}

/// Positions over one dimension, in radians.
fn positions(source: &Source, lon: &str, lat: &str, dimension: &str) -> Result<Positions> {
    let read = |name: &str| {
        let variable = find(source, name, &[dimension], false)?;
        let mut values = source.all_reals(variable)?;
        into_radians(source, name, &mut values)?;
        Ok(values)
    };
    Ok(Positions { lon: read(lon)?, lat: read(lat)? })
}

/// The bounds of coordinate `name`: three numbers for each triangle, in radians.
fn bounds(source: &Source, name: &str, unit_of: &str) -> Result<Vec<f64>> {
    let told = source.text_of(name, "bounds")?;
    let names: Vec<String> =
        told.into_iter().chain([format!("{name}_bnds"), format!("{name}_vertices")]).collect();
    let Some(variable) = names.iter().find_map(|bounds| source.variable(bounds)) else {
        return Err(source.error(
            ErrorKind::Grid,
            format_args!(
                "no variable {}: {name} has no bounds, and without them or vertex_of_cell the triangles are not known; \
                 vertex_of_cell may be in another file, such as the run's grid file",
                names.join(" or ")
            ),
        ));
    };
    let rows = source.variable(name).map_or(0, |v| v.dimensions[0].len);
    let fine = matches!(&variable.dimensions[..], [triangles, three] if triangles.len == rows && three.len == 3)
        && matches!(variable.kind, Kind::F32 | Kind::F64);
    if !fine {
        let context =
            format!("variable {variable}, expected {rows} triangles with 3 points of float or double");
        return Err(source.error(ErrorKind::Grid, context));
    }
    let own = source.text_of(&variable.name, "units")?;
    let mut values = OwnedReals::F64(source.all_numbers(variable)?);
    into_radians(source, if own.is_some() { &variable.name } else { unit_of }, &mut values)?;
    Ok((0..3 * rows).map(|i| values.as_reals().get(i)).collect())
}

/// Makes radians of angles in the unit that coordinate `name` has. Without one they are degrees if any is beyond 2π, as on a
/// whole sphere some are.
fn into_radians(source: &Source, name: &str, values: &mut OwnedReals) -> Result<()> {
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

fn direction(lon: f64, lat: f64) -> [f64; 3] {
    [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}
