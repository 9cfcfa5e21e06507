//! ICON's triangles as the corners of hexagons: icoray's cells are the triangles' points, its corners the triangles.
//!
//! Grid files have `vertex_of_cell`. Files with data mostly have no tables, but each triangle's own three points
//! (`clon_bnds`, `clat_bnds`; extpar's `clon_vertices`, `clat_vertices`): coincident points count as one, which gives
//! the same table. If the triangles' middles are missing, they are the centres of the circles through their points, as
//! ICON's are. Formats: ICON grid files, <https://gitlab.dkrz.de/icon>; CF conventions 1.11, §7.1.

use super::angles::{Bounds, distance, of_directions, positions, read_bounds};
use super::points;
use super::tables::{Convention, Mesh, Positions, find, missing};
use crate::source::Source;
use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, OwnedReals, Result, circumcenter};

/// Points nearer to each other than this fraction of the shortest side count as one. Degrees in f32 are accurate to
/// 1e-3 of a side of 2 km.
pub(super) const SAME: f64 = 0.02;

/// Whether any of the files has triangles with their points.
pub(super) fn has_triangles(sources: &Sources) -> bool {
    let has_points = |source| Triangles::of(source).is_some_and(|triangles| triangles.points.is_some());
    sources.all().any(|source| source.variable("vertex_of_cell").is_some() || has_points(source))
}

/// Whether any of the files has triangles.
pub(super) fn is_in(sources: &Sources) -> bool {
    sources.all().any(|source| source.variable("vertex_of_cell").is_some() || Triangles::of(source).is_some())
}

pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    let with_tables = sources.others_first().find(|source| source.variable("vertex_of_cell").is_some());
    if let Some(source) = with_tables {
        return of_tables(source);
    }
    let found = sources.others_first().find_map(|source| Some((source, Triangles::of(source)?)));
    let (source, triangles) = found.expect("one has triangles, or this is not called");
    of_bounds(source, &triangles)
}

/// The mesh of a grid file.
fn of_tables(source: &dyn Source) -> Result<Mesh> {
    if let Some(geometry) = source.number("grid_geometry")?.filter(|geometry| *geometry != 1.0) {
        let context = format!("grid_geometry is {geometry}, expected 1: only meshes on a sphere are rendered");
        return Err(source.error(ErrorKind::Unsupported, context));
    }
    let variable = source.variable("vertex_of_cell").ok_or_else(|| missing(source, "vertex_of_cell"))?;
    let [three, cells] = match variable.after_time() {
        [three, cells] if three.len == 3 => [three, cells],
        _ => {
            let context = format!("variable {variable}, expected vertex_of_cell(nv = 3, cell) of integer");
            return Err(source.error(ErrorKind::Grid, context));
        }
    };
    let table = find(source, "vertex_of_cell", &[&three.name, &cells.name], true)?;
    let corner = positions(source, "clon", "clat", &cells.name)?;
    let vertex = source.variable("vlon").ok_or_else(|| missing(source, "vlon"))?;
    let vertices = vertex.after_time().first().map_or("", |d| d.name.as_str());
    let center = positions(source, "vlon", "vlat", vertices)?;
    // The file has the triangles' first points, then their second, then their third.
    let by_column = source.all_integers(table)?;
    let triangles = by_column.len() / 3;
    let corner_cell = (0..by_column.len()).map(|i| by_column[i % 3 * triangles + i / 3].saturating_sub(1)).collect();
    mesh(source, center, corner, corner_cell)
}

/// The mesh of a file that has each triangle's points.
fn of_bounds(source: &dyn Source, triangles: &Triangles) -> Result<Mesh> {
    let bounds = triangles.bounds(source)?;
    let points = bounds.directions();
    let mut shortest = f64::INFINITY;
    for (triangle, three) in points.chunks_exact(3).enumerate() {
        let side = (0..3).map(|k| distance(three[k], three[(k + 1) % 3])).fold(f64::INFINITY, f64::min);
        if !(side > 0.0 && three.as_flattened().iter().all(|x| x.is_finite())) {
            let context = format!(
                "the bounds of triangle {triangle} are {:?} degrees, expected three different points",
                bounds.degrees(triangle)
            );
            return Err(source.error(ErrorKind::Grid, context));
        }
        shortest = shortest.min(side);
    }
    let corner = match triangles.middle {
        Some([lon, lat]) => positions(source, lon, lat, &source.expect(lon)?.after_time()[0].name)?,
        None => of_directions(points.as_chunks().0.iter().map(|three| circumcenter(*three))),
    };
    let (corner_cell, first) = points::number(points.into_iter(), SAME * shortest);
    let of = |angle: &[f64]| OwnedReals::F64(first.iter().map(|&i| angle[i]).collect());
    let center = Positions { lon: of(&bounds.lon), lat: of(&bounds.lat) };
    mesh(source, center, corner, corner_cell)
}

fn mesh(source: &dyn Source, center: Positions, corner: Positions, corner_cell: Vec<i32>) -> Result<Mesh> {
    Mesh::of_triangles(source.path(), Convention::Icon, [center, corner], corner_cell)
        .map_err(|e| e.within(source.path().display()))
}

/// Names of a file's variables of triangles: of their middles, which may be missing, and of their points.
struct Triangles {
    middle: Option<[&'static str; 2]>,
    points: Option<[String; 2]>,
}

impl Triangles {
    /// `None` if the file has neither `clon` nor points of triangles.
    fn of(source: &dyn Source) -> Option<Self> {
        let declared = |name: &str| source.text_of(name, "bounds").ok().flatten();
        for middle in [["clon", "clat"], ["lon", "lat"]] {
            let [lon, lat] = middle;
            let has_middle = source.variable(lon).is_some_and(|v| v.after_time().len() == 1);
            let names =
                |name: &str| declared(name).into_iter().chain([format!("{name}_bnds"), format!("{name}_vertices")]);
            let is_of_three = |name: &String| {
                let variable = source.variable(name);
                variable.is_some_and(|v| matches!(v.after_time(), [_, three] if three.len == 3))
            };
            let points = names(lon).find(is_of_three).zip(names(lat).find(is_of_three));
            let points = points.map(|(lon, lat)| [lon, lat]);
            let middle = has_middle.then_some(middle);
            // Only ICON has clon; others have lon.
            if points.is_some() || middle.is_some() && lon == "clon" {
                return Some(Triangles { middle, points });
            }
        }
        None
    }

    fn bounds(&self, source: &dyn Source) -> Result<Bounds> {
        let Some([lon, lat]) = &self.points else {
            return Err(source.error(
                ErrorKind::Grid,
                format_args!(
                    "no clon_bnds or clon_vertices, clat_bnds or clat_vertices of triangles with 3 points: without them or \
                     vertex_of_cell the triangles are not known; {IN_ANOTHER_FILE}"
                ),
            ));
        };
        let [lon_of, lat_of] = [0, 1].map(|k| self.middle.map(|names| names[k]));
        let bounds = read_bounds(source, [(source.expect(lon)?, lon_of), (source.expect(lat)?, lat_of)])?;
        let triangles = bounds.lon.len() / 3;
        let there = lon_of.and_then(|name| source.variable(name)).map_or(triangles, |v| v.after_time()[0].len);
        if there == triangles {
            return Ok(bounds);
        }
        let context = format!("{lon} has {triangles} triangles, expected {there} as in {}", lon_of.unwrap_or(""));
        Err(source.error(ErrorKind::Grid, context))
    }
}
