//! Polygons with bounds: each cell's points without tables, as in DYNAMICO's files and in grid files of SCRIP; and
//! ICON's triangles as the corners of hexagons: icoray's cells are the triangles' points, its corners the triangles.
//!
//! Coincident points are one corner. A polygon with fewer points than the row length repeats some. ICON's grid files
//! have a table of triangles ([`super::triangles`]); files with data mostly have none, but each triangle's own three
//! points (`clon_bnds`, `clat_bnds`; extpar's `clon_vertices`, `clat_vertices`). Triangles without middles have the
//! centres of the circles through their points, as ICON's are.
//! Formats: CF conventions 1.11, §7.1; SCRIP user's guide 1.4, §2.2.3.

use super::angles::{of_directions, positions, read_bounds};
use super::columns::{number_of_fields, of_points};
use super::points::DistinctPoints;
use super::polygons::Polygons;
use super::tables::{Mesh, MeshLayout, Positions};
use crate::source::{Source, SourceVariable};
use crate::sources::{IN_ANOTHER_FILE, Sources};
use glam::DVec3;
use icoray::{ErrorKind, Result, circumcenter};

/// Points nearer to each other than this fraction of the shortest side count as one. Degrees in f32 are accurate to
/// 1e-3 of a side of 2 km.
const SAME: f64 = 0.02;

/// Sides shorter than this fraction of the polygon's longest are degenerate.
const NO_SIDE: f64 = 1e-3;

/// Coordinates of the polygons' middles; their bounds are named by the attribute `bounds`, or after them.
const MIDDLES: [[&str; 2]; 5] =
    [["lon", "lat"], ["lon_i", "lat_i"], ["lon_mesh", "lat_mesh"], ["longitude", "latitude"], SCRIP];
/// Those of triangles.
const MIDDLES_OF_TRIANGLES: [[&str; 2]; 2] = [["clon", "clat"], ["lon", "lat"]];

/// Coordinates of SCRIP's cells, whose points are `grid_corner_lon` and `grid_corner_lat`.
const SCRIP: [&str; 2] = ["grid_center_lon", "grid_center_lat"];

/// The variables of polygons in a file.
pub(super) struct PolygonVariables<'a> {
    /// Names of the middles' coordinates, if present.
    middle: Option<[&'static str; 2]>,
    points: [SourceVariable<'a>; 2],
    /// Whether the polygons are triangles whose points are the middles of cells, as ICON's are.
    are_corners: bool,
}

impl<'a> PolygonVariables<'a> {
    /// Cells of 4 points or more, of SCRIP 3; those of SCRIP only if there are fields of as many columns, which the
    /// rows and columns of a lat-lon grid become later.
    fn of(sources: &Sources, source: &'a dyn Source) -> Option<Self> {
        MIDDLES.into_iter().find_map(|middle| {
            let found = Self::named(source, middle, |points| points > if middle == SCRIP { 2 } else { 3 });
            found.filter(|of| middle != SCRIP || number_of_fields(sources, &of.points[0].variable.after_time()[0]) > 0)
        })
    }

    /// Triangles.
    fn of_triangles(source: &'a dyn Source) -> Option<Self> {
        let found =
            MIDDLES_OF_TRIANGLES.into_iter().find_map(|middle| Self::named(source, middle, |points| points == 3));
        found.map(|found| PolygonVariables { are_corners: true, ..found })
    }

    fn named(source: &'a dyn Source, middle: [&'static str; 2], has_points: impl Fn(usize) -> bool) -> Option<Self> {
        let [lon, lat] = middle.map(|name| bounds_of(source, name, &has_points));
        let has = |name: &str| source.variable(name).is_some_and(|v| v.after_time().len() == 1);
        let middle = middle.into_iter().all(has).then_some(middle);
        Some(PolygonVariables { middle, points: [lon?, lat?], are_corners: false })
    }

    /// Reads the mesh.
    pub fn mesh(&self) -> Result<Mesh> {
        let PolygonVariables { middle, points, are_corners } = *self;
        let source = points[0].source;
        let [cells, corners] = points[0].variable.after_time() else { unreachable!("points are over two dimensions") };
        let bounds = read_bounds(points, middle)?;
        let row = corners.len;
        let directions: Vec<[f64; 3]> =
            (0..bounds.lon.as_reals().len() as i32).map(|point| bounds.direction(point)).collect();
        let places = |names: [&str; 2]| positions(source, names, &cells.name);
        // SCRIP's masked cells may have no polygon.
        let is_point = |cell: &[[f64; 3]]| cell.iter().all(|point| *point == cell[0]);
        if middle == Some(SCRIP) && directions.chunks_exact(row).any(is_point) {
            return of_points(source.path(), places(SCRIP)?, &SCRIP.join(" and "));
        }
        let shortest = shortest(source, &bounds, directions.chunks_exact(row))?;
        let center = match middle {
            Some(names) => places(names)?,
            None if are_corners => of_directions(directions.as_chunks().0.iter().map(|three| circumcenter(*three))),
            None => {
                let sum = |points: &[[f64; 3]]| points.iter().copied().map(DVec3::from).sum::<DVec3>();
                of_directions(directions.chunks_exact(row).map(sum))
            }
        };
        let (mut found, mut first) = (DistinctPoints::new(SAME * shortest), Vec::new());
        let number = |(direction, i)| {
            let number = found.find_or_add(direction);
            if number == first.len() {
                first.push(i);
            }
            number as i32
        };
        let numbers = directions.into_iter().zip(0..).map(number).collect::<Vec<i32>>();
        let points = bounds.of_rows(&first);
        let mesh = match are_corners {
            true => Mesh::of_triangles(source.path(), MeshLayout::Triangles, [points, center], numbers),
            false => Mesh::of_polygons(source.path(), [center, points], Polygons::of_rows(&numbers, row)),
        };
        mesh.map_err(|e| e.within(source.path().display()))
    }
}

/// The variable with polygons of a number of points that belongs to a coordinate.
fn bounds_of<'a>(source: &'a dyn Source, name: &str, has_points: impl Fn(usize) -> bool) -> Option<SourceVariable<'a>> {
    let declared = source.text_of(name, "bounds").ok().flatten();
    let named = [
        format!("{name}_bnds"),
        format!("{name}_bounds"),
        format!("bounds_{name}"),
        format!("{name}_vertices"),
        name.replace("grid_center", "grid_corner"),
    ];
    let mut variables = declared.into_iter().chain(named).filter_map(|name| source.find(&name));
    let has_points = |of: &SourceVariable| matches!(of.variable.after_time(), [_, points] if has_points(points.len));
    variables.find(|found| found.name() != name && has_points(found))
}

/// The polygons of the first file that has some.
pub(super) fn find(sources: &Sources) -> Option<PolygonVariables<'_>> {
    sources.others_first().find_map(|source| PolygonVariables::of(sources, source))
}

/// The shortest side of all polygons.
fn shortest<'p>(
    source: &dyn Source,
    bounds: &Positions,
    polygons: impl Iterator<Item = &'p [[f64; 3]]>,
) -> Result<f64> {
    let mut shortest = f64::INFINITY;
    for (polygon, points) in polygons.enumerate() {
        let side = |k: usize| DVec3::from(points[k]).distance(points[(k + 1) % points.len()].into());
        let longest = (0..points.len()).map(side).fold(0.0, f64::max);
        let sides = (0..points.len()).map(side).filter(|side| *side > NO_SIDE * longest);
        let is_polygon = sides.clone().count() > 2 && points.as_flattened().iter().all(|x| x.is_finite());
        if !is_polygon {
            let row = points.len() * polygon..points.len() * (polygon + 1);
            let degrees = row.map(|i| bounds.at(i).map(f64::to_degrees)).collect::<Vec<_>>();
            let kind = if points.len() == 3 { "triangle" } else { "cell" };
            let context = format!(
                "the bounds of {kind} {polygon} are {degrees:?} degrees, expected three different points at least"
            );
            return Err(source.error(ErrorKind::Grid, context));
        }
        shortest = sides.fold(shortest, f64::min);
    }
    Ok(shortest)
}

/// Whether any of the files has triangles with their points.
pub(super) fn has_triangles(sources: &Sources) -> bool {
    sources.all().any(|source| PolygonVariables::of_triangles(source).is_some())
}

/// Whether any of the files has triangles' middles. Only ICON has `clon`.
pub(super) fn has_middles(sources: &Sources) -> bool {
    sources.all().any(|source| source.variable("clon").is_some_and(|v| v.after_time().len() == 1))
}

pub(super) fn read_triangles(sources: &Sources) -> Result<Mesh> {
    match sources.others_first().find_map(PolygonVariables::of_triangles) {
        Some(triangles) => triangles.mesh(),
        None => Err(sources.error(
            ErrorKind::Grid,
            format_args!(
                "no clon_bnds or clon_vertices, clat_bnds or clat_vertices of triangles with 3 points: without them or \
                 vertex_of_cell(nv, cell) with vlon and vlat the triangles are not known; {IN_ANOTHER_FILE}"
            ),
        )),
    }
}
