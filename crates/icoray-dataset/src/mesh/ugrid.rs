//! UGRID's tables, as in files of many tools and datasets of uxarray: the corners of each face, and positions.
//!
//! Faces of more than three corners are cells. If all faces are triangles they are corners, as for ICON: the nodes are
//! the middles of cells. The same holds if the file has values at nodes only: then other faces are cut into triangles.
//! Corners of more than three cells are cut likewise. Tables that uxarray has derived from MPAS's are read as MPAS's.
//! Format: UGRID conventions 1.0, <https://ugrid-conventions.github.io/ugrid-conventions>.

use super::angles::{of_directions, positions};
use super::columns::is_coordinate;
use super::polygons::{NONE, Polygons};
use super::tables::{Convention, FileCorners, Mesh, Positions, missing};
use crate::source::{Source, Variable};
use crate::sources::Sources;
use icoray::{Error, ErrorKind, Result, circumcenter, cut_polygon};
use std::path::Path;

/// Names in uxarray's datasets; those of other tools are in the attributes of the mesh's variable.
const FACE_NODES: &str = "face_node_connectivity";
const NODES: [&str; 2] = ["node_lon", "node_lat"];
const FACES: [&str; 2] = ["face_lon", "face_lat"];

/// Names of the variables of a mesh.
pub(super) struct Topology<'a> {
    source: &'a dyn Source,
    face_nodes: &'a Variable,
    /// The name of the dimension that counts faces, if the file has it.
    face_dimension: Option<String>,
    nodes: [String; 2],
    /// Coordinates of the faces' middles, which may be missing.
    faces: Option<[String; 2]>,
}

impl<'a> Topology<'a> {
    /// The mesh of a source, if there is one; of several, the one that most variables name.
    fn of(source: &'a dyn Source) -> Result<Option<Self>> {
        let mut named: Option<(usize, &Variable, String)> = None;
        for variable in source.variables() {
            let text = |attribute: &str| source.text_of(&variable.name, attribute);
            if text("cf_role")?.as_deref() != Some("mesh_topology") {
                continue;
            }
            let Some(face_nodes) = text("face_node_connectivity")? else { continue };
            let names_it = |v: &&Variable| {
                source.text_of(&v.name, "mesh").ok().flatten().is_some_and(|mesh| mesh == variable.name)
            };
            let users = source.variables().iter().filter(names_it).count();
            if named.as_ref().is_none_or(|(most, ..)| users > *most) {
                named = Some((users, variable, face_nodes));
            }
        }
        match named {
            Some((_, variable, face_nodes)) => Self::named(source, &variable.name, &face_nodes).map(Some),
            None => Ok(source.variable(FACE_NODES).map(|face_nodes| {
                let faces = FACES.iter().all(|name| source.variable(name).is_some());
                let faces = faces.then(|| FACES.map(str::to_owned));
                Topology { source, face_nodes, face_dimension: None, nodes: NODES.map(str::to_owned), faces }
            })),
        }
    }

    /// The mesh that the variable `name` describes, whose table is `face_nodes`.
    fn named(source: &'a dyn Source, name: &str, face_nodes: &str) -> Result<Self> {
        let text = |attribute: &str| source.text_of(name, attribute);
        let face_nodes = source.variable(face_nodes).ok_or_else(|| missing(source, face_nodes))?;
        let two = |names: Option<String>| {
            let names: Vec<String> = names.iter().flat_map(|names| names.split_whitespace()).map(Into::into).collect();
            <[String; 2]>::try_from(names).ok()
        };
        let nodes = two(text("node_coordinates")?).ok_or_else(|| {
            source.error(ErrorKind::Grid, format_args!("{name}: no attribute node_coordinates, expected two names"))
        })?;
        let is_there = |names: &[String; 2]| names.iter().all(|name| source.variable(name).is_some());
        let faces = two(text("face_coordinates")?).filter(is_there);
        let in_order = |names: [String; 2]| lon_first(source, names);
        let (nodes, faces) = (in_order(nodes)?, faces.map(in_order).transpose()?);
        Ok(Topology { source, face_nodes, face_dimension: text("face_dimension")?, nodes, faces })
    }

    /// The nodes of each face, from 0 and with marks for missing entries; and the length of a row.
    fn rows(&self, nodes: usize) -> Result<(Vec<i32>, usize)> {
        let (source, table) = (self.source, self.face_nodes);
        let [first, second] = match table.after_time() {
            [first, second] if table.kind.is_number() => [first, second],
            _ => {
                let context = format!("variable {table}, expected the nodes of each face, as integers");
                return Err(source.error(ErrorKind::Grid, context));
            }
        };
        // Without the attribute the dimension of faces is the first; no mesh has fewer faces than a face has nodes.
        let is_transposed = match &self.face_dimension {
            Some(name) => *name == second.name && *name != first.name,
            None => first.len < second.len,
        };
        let [faces, row] = if is_transposed { [second.len, first.len] } else { [first.len, second.len] };
        if row < 3 {
            let context = format!("variable {table}, expected at least 3 nodes of each of {faces} faces");
            return Err(source.error(ErrorKind::Grid, context));
        }
        let table_values = source.all_numbers(table)?;
        let fill = source.numbers_of(&table.name, "_FillValue")?.first().copied();
        let is_from_1 = || {
            let is_there = |number: &&f64| Some(**number) != fill && !number.is_nan();
            let there = || table_values.iter().filter(is_there);
            there().any(|number| *number == nodes as f64) && !there().any(|number| *number == 0.0)
        };
        let given = source.numbers_of(&table.name, "start_index")?.first().copied();
        let base = given.unwrap_or_else(|| if is_from_1() { 1.0 } else { 0.0 });
        let mut numbers = Vec::with_capacity(table_values.len());
        for i in 0..faces * row {
            let (face, place) = (i / row, i % row);
            let number = table_values[if is_transposed { place * faces + face } else { i }];
            let node = number - base;
            // Marks of other tools lie far outside.
            let is_marked = Some(number) == fill || number.is_nan() || node < 0.0 || node >= f64::from(i32::MAX);
            if !is_marked && node >= nodes as f64 {
                let of = nodes as f64 - 1.0 + base;
                let context = format!("{} of face {face} is {number}, expected {base} to {of}", table.name);
                return Err(source.error(ErrorKind::Grid, context));
            }
            numbers.push(if is_marked { NONE } else { node as i32 });
        }
        Ok((numbers, row))
    }
}

/// Two coordinates with the longitude first, by their standard names or units.
fn lon_first(source: &dyn Source, [one, two]: [String; 2]) -> Result<[String; 2]> {
    let is_lat = |name: &String| -> Result<bool> {
        let named = source.text_of(name, "standard_name")?.is_some_and(|text| text == "latitude");
        Ok(named || source.text_of(name, "units")?.is_some_and(|text| text.contains("north")))
    };
    Ok(if is_lat(&one)? { [two, one] } else { [one, two] })
}

/// The mesh of the first source that has one.
pub(super) fn find(sources: &Sources) -> Result<Option<Topology<'_>>> {
    sources.others_first().map(Topology::of).find_map(Result::transpose).transpose()
}

pub(super) fn read(sources: &Sources, topology: &Topology) -> Result<Mesh> {
    let Topology { source, face_nodes, nodes: [lon, lat], faces, .. } = topology;
    let place = |name: &String| source.variable(name).ok_or_else(|| missing(*source, name));
    let over = |variable: &Variable| variable.after_time().first().map_or(String::new(), |d| d.name.clone());
    let nodes = positions(*source, lon, lat, &over(place(lon)?))?;
    let count = nodes.lon.as_reals().len();
    let (rows, row) = topology.rows(count)?;
    let given = match faces {
        Some([lon, lat]) => Some(positions(*source, lon, lat, &over(place(lon)?))?),
        None => None,
    };
    of_rows(sources, (*source, &face_nodes.name), nodes, given, (rows, row))
}

/// The mesh of faces whose nodes are in `rows`, as for [`of_faces`]; `table` is the name of their table.
pub(super) fn of_rows(
    sources: &Sources,
    (source, table): (&dyn Source, &str),
    nodes: Positions,
    given: Option<Positions>,
    (rows, row): (Vec<i32>, usize),
) -> Result<Mesh> {
    let fewer = rows.chunks_exact(row).position(|face| face.iter().filter(|i| **i >= 0).count() < 3);
    if let Some(face) = fewer {
        let context = format!("{table}: face {face} has fewer than 3 nodes");
        return Err(source.error(ErrorKind::Grid, context));
    }
    let (faces, count) = (rows.len() / row, nodes.lon.as_reals().len());
    let fields = sources.fields();
    let has_field_of = |len: usize| {
        let is_field = |v: &&Variable| v.kind.is_real() && v.after_time().iter().any(|d| d.len == len);
        fields.variables().iter().filter(is_field).any(|variable| !is_coordinate(fields, variable))
    };
    let are_nodes_cells = has_field_of(count) && !has_field_of(faces);
    let mesh = of_faces(source.path(), nodes, given, (rows, row), are_nodes_cells)
        .map_err(|e| e.within(format_args!("{}: {table}", source.path().display())))?;
    let is_mpas = mesh.convention == Convention::Cf && mesh.file_corners.is_none() && super::mpas::is_in(sources)?;
    Ok(if is_mpas { mesh.into_mpas() } else { mesh })
}

impl Mesh {
    /// The tables of a mesh of faces, numbered from 0: `nodes` are directions of any length, of which `faces` has a row
    /// of `row` for each face, in order around it, with -1 after the last one. If all faces are triangles they are the
    /// corners of cells around the nodes, as for ICON ([`Convention::Icon`]); otherwise faces are cells and nodes their
    /// corners ([`Convention::Cf`]). `middles` are directions of the faces' middles; without them triangles have the
    /// middles of their circles, and others the means of their nodes. Messages name `path`.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] and [`ErrorKind::Unsupported`] name a face or node that does not fit a mesh of cells whose
    /// corners each join three of them.
    pub fn of_faces(
        path: &Path,
        nodes: &[[f64; 3]],
        middles: Option<&[[f64; 3]]>,
        faces: Vec<i32>,
        row: usize,
    ) -> Result<Self> {
        let positions = |of: &[[f64; 3]]| of_directions(of.iter().copied());
        of_faces(path, positions(nodes), middles.map(positions), (faces, row), false)
    }
}

/// The tables of a mesh of faces; `rows` has the nodes of each, numbered from 0, and marks after the last of them, in
/// rows of one length. If `given` has no middles of faces, triangles have the middles of their circles, and others the
/// means of their nodes. Nodes are the middles of cells if `are_nodes_cells`, and if all faces are triangles: other
/// faces are cut into such.
fn of_faces(
    path: &Path,
    nodes: Positions,
    given: Option<Positions>,
    (rows, row): (Vec<i32>, usize),
    are_nodes_cells: bool,
) -> Result<Mesh> {
    let faces = rows.len() / row;
    if let Some(middles) = given.as_ref().map(|given| given.lon.as_reals().len()).filter(|middles| *middles != faces) {
        let context = format!("the middles of {faces} faces are {middles}, expected {faces}");
        return Err(Error::new(ErrorKind::Grid, context));
    }
    let around = || rows.chunks_exact(row).map(|face| face.iter().copied().filter(|i| *i >= 0));
    let are_triangles = around().all(|face| face.count() == 3);
    if !are_triangles && !are_nodes_cells {
        let middle = |face: &mut dyn Iterator<Item = i32>| {
            face.map(|i| nodes.direction(i)).fold([0.0; 3], |sum, point| [0, 1, 2].map(|k| sum[k] + point[k]))
        };
        let center = given.unwrap_or_else(|| of_directions(around().map(|mut face| middle(&mut face))));
        return Mesh::of_polygons(path, [center, nodes], Polygons::of_rows(&rows, row));
    }
    let (mut corner_cell, mut of_face) = (Vec::with_capacity(rows.len()), Vec::new());
    for (face, around) in around().enumerate() {
        let around: Vec<i32> = around.collect();
        let triangles = cut_polygon(&around, |node| nodes.direction(node));
        of_face.extend(std::iter::repeat_n(face as u32, triangles.len()));
        corner_cell.extend(triangles.into_flattened());
    }
    let middle = |triangle: &[i32; 3]| circumcenter(triangle.map(|node| nodes.direction(node)));
    let corner = match given {
        Some(given) => given.of_rows(&of_face),
        None => of_directions(corner_cell.as_chunks().0.iter().map(middle)),
    };
    let file_corners = (!are_triangles).then_some(FileCorners { count: faces, row: of_face });
    Ok(Mesh { file_corners, ..Mesh::of_triangles(path, Convention::Icon, [nodes, corner], corner_cell)? })
}
