//! UGRID's tables, as files of many tools and datasets of uxarray have them: the corners of each face, and places.
//!
//! Faces of more than three corners are cells. Where all faces are triangles they are corners, as ICON's: the nodes are
//! the middles of cells. The tables of a dataset that uxarray has made of MPAS's are MPAS's.
//! Format: UGRID conventions 1.0, <https://ugrid-conventions.github.io/ugrid-conventions>.

use super::angles::{circumcenter, direction, of_directions, positions};
use super::polygons::{NONE, Polygons};
use super::tables::{Convention, Mesh, Positions, missing};
use crate::source::{Source, Variable};
use crate::sources::Sources;
use icoray::{Connectivity, ErrorKind, Result};
use std::path::Path;

/// Names that uxarray gives; other tools' are in the attributes of the mesh's variable.
const FACE_NODES: &str = "face_node_connectivity";
const NODES: [&str; 2] = ["node_lon", "node_lat"];
const FACES: [&str; 2] = ["face_lon", "face_lat"];

/// Names of the variables of a mesh.
struct Topology<'a> {
    source: &'a dyn Source,
    face_nodes: &'a Variable,
    nodes: [String; 2],
    /// Of the faces' middles, which may lack.
    faces: Option<[String; 2]>,
}

impl<'a> Topology<'a> {
    /// The mesh of a source, if there is one.
    fn of(source: &'a dyn Source) -> Result<Option<Self>> {
        if let Some(face_nodes) = source.variable(FACE_NODES) {
            let faces = FACES.iter().all(|name| source.variable(name).is_some());
            let faces = faces.then(|| FACES.map(str::to_owned));
            return Ok(Some(Topology { source, face_nodes, nodes: NODES.map(str::to_owned), faces }));
        }
        for variable in source.variables() {
            let text = |attribute: &str| source.text_of(&variable.name, attribute);
            if text("cf_role")?.as_deref() != Some("mesh_topology") {
                continue;
            }
            let Some(face_nodes) = text("face_node_connectivity")? else { continue };
            let face_nodes = source.variable(&face_nodes).ok_or_else(|| missing(source, &face_nodes))?;
            let two = |names: Option<String>| {
                let names: Vec<String> =
                    names.iter().flat_map(|names| names.split_whitespace()).map(Into::into).collect();
                <[String; 2]>::try_from(names).ok()
            };
            let nodes = two(text("node_coordinates")?).ok_or_else(|| {
                let name = &variable.name;
                source.error(ErrorKind::Grid, format_args!("{name}: no attribute node_coordinates, expected two names"))
            })?;
            let faces = two(text("face_coordinates")?);
            let in_order = |names: [String; 2]| lon_first(source, names);
            let (nodes, faces) = (in_order(nodes)?, faces.map(in_order).transpose()?);
            return Ok(Some(Topology { source, face_nodes, nodes, faces }));
        }
        Ok(None)
    }

    /// The nodes of each face, from 0 and with marks for entries that are missing; and the length of a row.
    fn rows(&self, nodes: usize) -> Result<(Vec<i32>, usize)> {
        let (source, table) = (self.source, self.face_nodes);
        let [_, row] = match table.after_time() {
            [faces, row] if table.kind.is_number() && row.len > 2 => [faces, row],
            _ => {
                let context = format!("variable {table}, expected the nodes of each face, at least 3, as integers");
                return Err(source.error(ErrorKind::Grid, context));
            }
        };
        let base = source.numbers_of(&table.name, "start_index")?.first().copied().unwrap_or(0.0);
        let fill = source.numbers_of(&table.name, "_FillValue")?.first().copied();
        let mut numbers = Vec::new();
        for (i, number) in source.all_numbers(table)?.into_iter().enumerate() {
            let node = number - base;
            // Marks of other tools lie far outside.
            let is_marked = Some(number) == fill || number.is_nan() || node < 0.0 || node >= f64::from(i32::MAX);
            if !is_marked && node >= nodes as f64 {
                let (face, of) = (i / row.len, nodes as f64 - 1.0 + base);
                let context = format!("{} of face {face} is {number}, expected {base} to {of}", table.name);
                return Err(source.error(ErrorKind::Grid, context));
            }
            numbers.push(if is_marked { NONE } else { node as i32 });
        }
        Ok((numbers, row.len))
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

/// Whether any of the sources has a mesh.
pub(super) fn is_in(sources: &Sources) -> Result<bool> {
    for source in sources.all() {
        if Topology::of(source)?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    for source in sources.others_first() {
        if let Some(topology) = Topology::of(source)? {
            return mesh(sources, &topology);
        }
    }
    unreachable!("one has a mesh, or this is not called")
}

fn mesh(sources: &Sources, topology: &Topology) -> Result<Mesh> {
    let Topology { source, face_nodes, nodes: [lon, lat], faces } = topology;
    let place = |name: &String| source.variable(name).ok_or_else(|| missing(*source, name));
    let over = |variable: &Variable| variable.after_time().first().map_or(String::new(), |d| d.name.clone());
    let nodes = positions(*source, lon, lat, &over(place(lon)?))?;
    let count = nodes.lon.as_reals().len();
    let (rows, row) = topology.rows(count)?;
    let given = match faces {
        Some([lon, lat]) => Some(positions(*source, lon, lat, &over(place(lon)?))?),
        None => None,
    };
    let fewer = rows.chunks_exact(row).position(|face| face.iter().filter(|i| **i >= 0).count() < 3);
    if let Some(face) = fewer {
        let context = format!("{}: face {face} has fewer than 3 nodes", face_nodes.name);
        return Err(source.error(ErrorKind::Grid, context));
    }
    let mesh = of_faces(source.path(), nodes, given, rows, row).map_err(|e| e.within(source.path().display()))?;
    let is_mpas = mesh.convention == Convention::Cf && super::mpas::is_in(sources)?;
    Ok(if is_mpas { mesh.into_mpas() } else { mesh })
}

impl Mesh {
    /// The tables of a mesh of faces, numbered from 0: `nodes` are directions of any length, of which `faces` has a row of
    /// `row` for each face, in order around it, with -1 after the last one. Where all faces are triangles they are the
    /// corners of cells around the nodes, as ICON's ([`Convention::Icon`]); otherwise faces are cells and nodes their
    /// corners ([`Convention::Cf`]). `middles` are directions of the faces' middles; without them triangles have the middles
    /// of their circles, and others the means of their nodes. `path` is what messages name.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] and [`ErrorKind::Unsupported`] name a face or node that fits no mesh of cells whose corners each
    /// join three of them.
    pub fn of_faces(
        path: &Path,
        nodes: &[[f64; 3]],
        middles: Option<&[[f64; 3]]>,
        faces: Vec<i32>,
        row: usize,
    ) -> Result<Self> {
        let positions = |of: &[[f64; 3]]| of_directions(of.iter().copied());
        of_faces(path, positions(nodes), middles.map(positions), faces, row)
    }
}

/// The tables of a mesh of faces; `rows` has the nodes of each, numbered from 0, and marks after the last of them. Where
/// `given` has no middles of faces, triangles have the middles of their circles, and others the means of their nodes.
fn of_faces(path: &Path, nodes: Positions, given: Option<Positions>, rows: Vec<i32>, row: usize) -> Result<Mesh> {
    let count = nodes.lon.as_reals().len();
    let node = |i: i32| {
        let i = i as usize;
        direction(nodes.lon.as_reals().get(i), nodes.lat.as_reals().get(i))
    };
    let around = || rows.chunks_exact(row).map(|face| face.iter().filter(|i| **i >= 0).map(|i| node(*i)));
    let path = path.to_owned();
    if around().all(|face| face.count() == 3) {
        let middle = |face: Vec<[f64; 3]>| circumcenter([face[0], face[1], face[2]]);
        let corner = given.unwrap_or_else(|| of_directions(around().map(|face| middle(face.collect()))));
        let corner_cell: Vec<i32> = rows.into_iter().filter(|i| *i >= 0).collect();
        let made = Connectivity::new(&corner_cell, count)?;
        let polygons = Polygons { corners: made.cell_corner, row: made.cell_corner_row, count: made.cell_corner_count };
        let (corner_edge, edge_corner) = (made.corner_edge, made.edge_corner);
        let (convention, center) = (Convention::Icon, nodes);
        return Ok(Mesh { path, convention, center, corner, polygons, corner_cell, corner_edge, edge_corner });
    }
    let sum = |sum: [f64; 3], point: [f64; 3]| [0, 1, 2].map(|k| sum[k] + point[k]);
    let center = given.unwrap_or_else(|| of_directions(around().map(|face| face.fold([0.0; 3], sum))));
    let polygons = Polygons::of_rows(&rows, row);
    let corner_cell = polygons.corner_cells(count)?;
    let (corner_edge, edge_corner) = polygons.edges(count)?;
    let (convention, corner) = (Convention::Cf, nodes);
    Ok(Mesh { path, convention, center, corner, polygons, corner_cell, corner_edge, edge_corner })
}
