//! Reads the mesh tables of a file in any of the conventions, and checks that the files of a dataset have one mesh:
//! another one of the same size would show fields in wrong places.

mod angles;
mod cf;
mod columns;
mod esmf;
mod healpix;
mod mpas;
mod points;
mod polygons;
mod tables;
mod triangles;
pub(crate) mod ugrid;

pub(crate) use columns::{is_angle, is_coordinate};
pub use points::DistinctPoints;
pub use tables::{Mesh, MeshLayout};

use crate::source::{Source, Variable};
use crate::sources::{IN_ANOTHER_FILE, Sources};
use angles::positions;
use columns::NAMES;
use glam::DVec3;
use icoray::{ErrorKind, Result};
use tables::Positions;

/// Reads a mesh that was found.
type Reader<'a> = Box<dyn FnOnce() -> Result<Mesh> + 'a>;

fn boxed<'a>(read: impl FnOnce() -> Result<Mesh> + 'a) -> Reader<'a> {
    Box::new(read)
}

/// The reader of the mesh in the files.
fn reader(sources: &Sources) -> Result<Option<Reader<'_>>> {
    let columns = columns::find(sources);
    // Without a table of neighbours, columns suffice.
    let is_mpas = mpas::is_in(sources)? && (mpas::has_tables(sources) || columns.is_none());
    let is_icon = cf::has_triangles(sources) || cf::has_middles(sources) && columns.is_none();
    let all = [
        ugrid::find(sources)?.map(|found| boxed(move || Ok(ugrid::read(sources, &found)?.with_format("UGRID")))),
        esmf::find(sources).map(|found| boxed(move || Ok(esmf::read(sources, found)?.with_format("ESMF")))),
        triangles::find(sources).map(|found| boxed(move || triangles::read(found))),
        is_mpas.then(|| boxed(|| mpas::read(sources))),
        is_icon.then(|| boxed(|| cf::read_triangles(sources))),
        cf::find(sources).map(|found| boxed(move || found.mesh())),
        columns.map(|found| boxed(move || columns::read(&found))),
        healpix::find(sources).map(|found| boxed(move || healpix::read(sources, found))),
    ];
    Ok(all.into_iter().flatten().next())
}

/// Whether the files have a mesh of a kind that [`read`] supports.
pub(crate) fn is_known(sources: &Sources) -> Result<bool> {
    Ok(reader(sources)?.is_some())
}

/// Reads the tables in the convention of the files; their content is checked by [`Mesh::grid`].
pub(crate) fn read(sources: &Sources) -> Result<Mesh> {
    if let Some(reader) = reader(sources)? {
        return reader();
    }
    let there = sources.fields().numbers_in_words();
    Err(sources.error(
        ErrorKind::Grid,
        format_args!(
            "no mesh is known of {there}: looked for MPAS's (dimension nCells, variables lonCell, verticesOnCell and more) and for \
             ICON's (variable vertex_of_cell, or clon_bnds or clon_vertices) and for polygons with bounds (lon_bnds(cell, \
             6), or SCRIP's grid_corner_lon), for UGRID's (a variable with cf_role mesh_topology), for ESMF's (variable \
             elementConn), for FESOM's and FVCOM's (variables elements and nodes, or nv), for HEALPix (a variable with \
             grid_mapping_name healpix), and for places of columns (lon(ncol), lat(ncol) and a field over ncol, or \
             lon(y, x) and lat(y, x)); {IN_ANOTHER_FILE}"
        ),
    ))
}

/// Number of columns whose positions are compared.
const COMPARED: usize = 1000;

/// ICON's name of a grid, in grid files and data files.
const GRID_NAME: &str = "uuidOfHGrid";

/// Checks that all files have the mesh that was read: by the numbers of cells and corners, the name of ICON's grid, and
/// the positions of columns.
pub(crate) fn expect_one_mesh(sources: &Sources, mesh: &Mesh) -> Result<()> {
    expect_one_name(sources.all())?;
    for source in sources.all() {
        expect_sizes(source, mesh)?;
        if source.path() != mesh.path() {
            expect_places(source, mesh)?;
        }
    }
    Ok(())
}

/// Checks that all files that name their grid name the same.
pub(crate) fn expect_one_name<'a>(sources: impl Iterator<Item = &'a dyn Source>) -> Result<()> {
    let mut named: Vec<(&dyn Source, String)> = Vec::new();
    for source in sources {
        named.extend(source.text(GRID_NAME)?.map(|name| (source, name)));
    }
    let Some(pair) = named.windows(2).find(|pair| !pair[0].1.eq_ignore_ascii_case(&pair[1].1)) else { return Ok(()) };
    let [(other, its), (source, name)] = pair else { unreachable!("a window of two") };
    let other = other.path().display();
    let context = format!(
        "{GRID_NAME} is {name}, that of {other} is {its}: they are of different grids; give the grid file of the data as \
         `mesh`"
    );
    Err(source.error(ErrorKind::Grid, context))
}

fn expect_sizes(source: &dyn Source, mesh: &Mesh) -> Result<()> {
    let dimensions: &[(&str, usize)] = match mesh.layout() {
        MeshLayout::Mpas => &[("nCells", mesh.cells()), ("nVertices", mesh.corners_in_file())],
        MeshLayout::Triangles => &[("ncells", mesh.corners_in_file()), ("cell", mesh.corners_in_file())],
        MeshLayout::Polygons => &[("ncells", mesh.cells()), ("cell", mesh.cells())],
    };
    for &(dimension, expected) in dimensions {
        let there = source.dimension_len(dimension)?.unwrap_or(expected);
        if there != expected {
            let mesh_path = mesh.path().display();
            let context = format!("{dimension} is {there}, expected {expected} as in the mesh of {mesh_path}");
            return Err(source.error(ErrorKind::Grid, context));
        }
    }
    Ok(())
}

/// Checks that columns with coordinates lie at their positions in the mesh, to about the distance between columns.
fn expect_places(source: &dyn Source, mesh: &Mesh) -> Result<()> {
    for [lon, lat] in NAMES {
        let dimension = |name| match source.variable(name).map(Variable::after_time) {
            Some([only]) => Some(only),
            _ => None,
        };
        let Some(columns) = dimension(lon).filter(|of| dimension(lat) == Some(of)) else { continue };
        let expected = match columns.len {
            len if len == mesh.cells() => &mesh.center,
            len if len == mesh.corners() && mesh.corner_rows().is_none() => &mesh.corner,
            _ => continue,
        };
        // Unreadable coordinates are no reason to refuse fields.
        let Ok(there) = positions(source, [lon, lat], &columns.name) else { continue };
        let place = |of: &Positions, i: usize| DVec3::from(of.direction(i as i32));
        let apart = |i: usize| place(&there, i).distance(place(expected, i));
        let near = (4.0 * std::f64::consts::PI / columns.len as f64).sqrt().max(0.01);
        let step = columns.len.div_ceil(COMPARED).max(1);
        if let Some(i) = (0..columns.len).step_by(step).find(|i| apart(*i) > near) {
            let [own, its] = [there.at(i), expected.at(i)].map(|place| place.map(f64::to_degrees));
            let context = format!(
                "{lon}, {lat} of column {i} are {own:.2?} degrees, but the mesh of {} has it at {its:.2?}: they are of \
                 different meshes of the same size; give the mesh of the data as `mesh`",
                mesh.path().display()
            );
            return Err(source.error(ErrorKind::Grid, context));
        }
    }
    Ok(())
}
