//! Checks that the files of a dataset have one mesh: another one of the same size would show fields in wrong places.

use super::angles::{distance, positions};
use super::columns::NAMES;
use super::tables::{Mesh, MeshLayout};
use crate::source::{Source, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, Result};

/// Number of columns whose positions are compared.
const COMPARED: usize = 1000;

/// ICON's name of a grid, in grid files and data files.
const GRID_NAME: &str = "uuidOfHGrid";

/// Checks that all files have the mesh that was read: by the numbers of cells and corners, the name of ICON's grid, and
/// the positions of columns.
pub(crate) fn expect(sources: &Sources, mesh: &Mesh) -> Result<()> {
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
        let apart = |i: usize| distance(there.direction(i as i32), expected.direction(i as i32));
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
