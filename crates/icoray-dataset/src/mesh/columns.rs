//! Columns without tables: only the longitude and latitude of each, without neighbours, as written by CAM-SE, E3SM,
//! LFRic, GEOS and WAVEWATCH III, and for HEALPix or files of any model without the mesh.
//!
//! The cells are the columns, and the corners their Delaunay triangles ([`OwnedTables::of_points`]).
//! Format: CF conventions 1.11, §4.1, §4.2 and §5.2.

use super::angles::positions;
use super::tables::{Mesh, MeshLayout, POINTS, Positions};
use crate::source::{Dimension, SourceVariable, without_group};
use crate::sources::Sources;
use icoray::{OwnedReals, OwnedTables, Result};
use std::path::Path;

/// Names of longitudes, and of the latitudes that belong to them.
pub(super) const NAMES: [[&str; 2]; 9] = [
    ["lon", "lat"],
    ["longitude", "latitude"],
    ["lons", "lats"],
    ["nav_lon", "nav_lat"],
    ["grid_center_lon", "grid_center_lat"],
    ["clon", "clat"],
    ["lonCell", "latCell"],
    ["vlon", "vlat"],
    ["lonVertex", "latVertex"],
];

/// CF's units of longitudes and of latitudes.
const UNITS: [[&str; 6]; 2] = [
    ["degrees_east", "degree_east", "degrees_E", "degree_E", "degreesE", "degreeE"],
    ["degrees_north", "degree_north", "degrees_N", "degree_N", "degreesN", "degreeN"],
];

/// Longitudes and latitudes of columns in a file.
pub(super) struct Columns<'a> {
    lon: SourceVariable<'a>,
    lat: SourceVariable<'a>,
}

/// The coordinates over the dimension that most variables of the fields' file have; `None` if there are none.
pub(super) fn find(sources: &Sources) -> Option<Columns<'_>> {
    let mut columns = None;
    let mut max_fields = 0;
    for source in sources.others_first() {
        let all = || source.each_variable().filter(|found| found.variable.kind.is_real());
        for lon in all().filter(|found| is_angle(*found, 0)) {
            let [column] = lon.variable.after_time() else { continue };
            let named = NAMES.iter().find(|[name, _]| *name == lon.own_name()).and_then(|[_, lat]| source.find(lat));
            let is_beside = |lat: &SourceVariable| lat.variable.after_time() == lon.variable.after_time();
            let other = || all().find(|lat| is_beside(lat) && is_angle(*lat, 1));
            let Some(lat) = named.filter(is_beside).or_else(other) else { continue };
            let fields = number_of_fields(sources, column);
            if fields > max_fields {
                max_fields = fields;
                columns = Some(Columns { lon, lat });
            }
        }
    }
    columns
}

/// Whether a variable is a longitude (`which` is 0) or a latitude (1), by its standard name, its units or its name.
pub(crate) fn is_angle(found: SourceVariable, which: usize) -> bool {
    let text = |attribute: &str| found.text(attribute).ok().flatten();
    text("standard_name").is_some_and(|name| name == ["longitude", "latitude"][which])
        || text("units").is_some_and(|units| UNITS[which].contains(&units.as_str()))
        || NAMES.iter().any(|names| names[which] == found.own_name())
}

/// Whether a variable is a coordinate of a mesh: a longitude or latitude, or named by one of UGRID's attributes for
/// coordinates.
pub(crate) fn is_coordinate(found: SourceVariable) -> bool {
    let names_it = |topology: SourceVariable| {
        ["node_coordinates", "face_coordinates", "edge_coordinates"].iter().any(|attribute| {
            let names = topology.text(attribute).ok().flatten();
            names.is_some_and(|names| names.split_whitespace().any(|name| without_group(name) == found.own_name()))
        })
    };
    let mut scalars = found.source.each_variable().filter(|other| other.variable.dimensions.is_empty());
    (0..2).any(|which| is_angle(found, which)) || scalars.any(names_it)
}

/// Number of variables in the fields' file over a dimension as long as `column`, besides coordinates.
pub(super) fn number_of_fields(sources: &Sources, column: &Dimension) -> usize {
    let is_field = |found: &SourceVariable| {
        let variable = found.variable;
        variable.kind.is_number()
            && variable.after_time().iter().any(|d| d.len == column.len)
            && (0..2).all(|k| !is_angle(*found, k))
    };
    sources.fields().each_variable().filter(is_field).count()
}

pub(super) fn read(Columns { lon, lat }: &Columns) -> Result<Mesh> {
    let names = [lon.name(), lat.name()];
    let center = positions(lon.source, names, &lon.variable.after_time()[0].name)?;
    of_points(lon.source.path(), center, &names.join(" and "))
}

/// The mesh whose cells are at places and whose corners are their Delaunay triangles; `name` is that of the places.
pub(super) fn of_points(path: &Path, center: Positions, name: &str) -> Result<Mesh> {
    let of_points = OwnedTables::of_points(center.borrowed());
    let OwnedTables { corner, corner_cell, connectivity, .. } =
        of_points.map_err(|e| e.within(format_args!("{}: {name}", path.display())))?;
    let [lon, lat] = corner.map(OwnedReals::F64);
    let places = [center, Positions { lon, lat }];
    let mesh = Mesh::of_tables(path, MeshLayout::Polygons, places, corner_cell, connectivity);
    Ok(Mesh { format: POINTS, ..mesh })
}
