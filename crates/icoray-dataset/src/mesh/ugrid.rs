//! UGRID's tables, as in files of many tools and datasets of uxarray: the corners of each face, and positions.
//!
//! Faces of more than three corners are cells. If all faces are triangles they are corners, as for ICON: the nodes are
//! the middles of cells. The same holds if the file has values at nodes only: then other faces are cut into triangles.
//! Corners of more than three cells are cut likewise. Tables that uxarray has derived from MPAS's are read as MPAS's.
//! Format: UGRID conventions 1.0, <https://ugrid-conventions.github.io/ugrid-conventions>.

use super::angles::{of_directions, positions};
use super::columns::{is_coordinate, of_points};
use super::polygons::{NONE, Polygons};
use super::tables::{FileCorners, Mesh, MeshLayout, Positions, missing};
use crate::source::{Source, SourceVariable, Variable, without_group};
use crate::sources::Sources;
use glam::DVec3;
use icoray::{Error, ErrorKind, Result, circumcenter, cut_polygon};
use std::collections::HashMap;
use std::path::Path;

/// Names in uxarray's datasets; those of other tools are in the attributes of the mesh's variable.
const FACE_NODES: &str = "face_node_connectivity";
const NODES: [&str; 2] = ["node_lon", "node_lat"];
const FACES: [&str; 2] = ["face_lon", "face_lat"];

/// Attributes that name tables of edges: of the faces beside each, and of the nodes at its ends.
const EDGE_FACES: &str = "edge_face_connectivity";
const EDGE_NODES: &str = "edge_node_connectivity";

/// Names of the variables of a mesh.
pub(crate) struct Topology<'a> {
    /// The variable with these names, which uxarray's datasets lack.
    variable: Option<SourceVariable<'a>>,
    face_nodes: SourceVariable<'a>,
    /// The name of the dimension that counts faces, if the file has it.
    face_dimension: Option<String>,
    nodes: [String; 2],
    /// Coordinates of the faces' middles, which may be missing.
    faces: Option<[String; 2]>,
}

impl<'a> Topology<'a> {
    /// The mesh of a source, if there is one; of several, the one that most variables name.
    fn of(source: &'a dyn Source) -> Result<Option<Self>> {
        let mut named: Option<(usize, SourceVariable, String)> = None;
        for found in source.each_variable() {
            if found.text("cf_role")?.as_deref() != Some("mesh_topology") {
                continue;
            }
            let Some(face_nodes) = found.text("face_node_connectivity")? else { continue };
            let names_it = |user: &SourceVariable| {
                user.text("mesh").ok().flatten().is_some_and(|mesh| without_group(&mesh) == found.own_name())
            };
            let users = source.each_variable().filter(names_it).count();
            if named.as_ref().is_none_or(|(max_users, ..)| users > *max_users) {
                named = Some((users, found, face_nodes));
            }
        }
        match named {
            Some((_, found, face_nodes)) => Self::named(found, &face_nodes).map(Some),
            None => Ok(source.find(FACE_NODES).map(|face_nodes| {
                let faces = FACES.iter().all(|name| source.variable(name).is_some());
                let faces = faces.then(|| FACES.map(str::to_owned));
                Topology { variable: None, face_nodes, face_dimension: None, nodes: NODES.map(str::to_owned), faces }
            })),
        }
    }

    /// The mesh that a variable describes, whose table is `face_nodes`.
    fn named(found: SourceVariable<'a>, face_nodes: &str) -> Result<Self> {
        let source = found.source;
        let face_nodes = source.find(face_nodes).ok_or_else(|| missing(source, face_nodes))?;
        let two = |names: Option<String>| {
            let names: Vec<String> = names.iter().flat_map(|names| names.split_whitespace()).map(Into::into).collect();
            <[String; 2]>::try_from(names).ok()
        };
        let nodes = two(found.text("node_coordinates")?).ok_or_else(|| {
            let context = format!("{}: no attribute node_coordinates, expected two names", found.name());
            found.error(ErrorKind::Grid, context)
        })?;
        let is_there = |names: &[String; 2]| names.iter().all(|name| source.variable(name).is_some());
        let faces = two(found.text("face_coordinates")?).filter(is_there);
        let faces = faces.map(|names| lon_first(source, names)).transpose()?;
        let face_dimension = found.text("face_dimension")?;
        Ok(Topology { variable: Some(found), face_nodes, face_dimension, nodes: lon_first(source, nodes)?, faces })
    }

    /// The nodes of each face, of which there are `nodes`.
    fn rows(&self, nodes: usize) -> Result<Rows> {
        let dimension = self.face_dimension.clone();
        RowTable { table: self.face_nodes, item: "face", dimension, expected: "at least 3 nodes" }.read(nodes)
    }

    /// Positions of nodes or faces.
    fn positions(&self, [lon, lat]: &[String; 2]) -> Result<Positions> {
        let source = self.face_nodes.source;
        let found = source.find(lon).ok_or_else(|| missing(source, lon))?;
        positions(source, [lon, lat], found.variable.after_time().first().map_or("", |d| &d.name))
    }

    /// The table of edges in an attribute of the mesh's variable; in uxarray's datasets, the one of that name.
    fn edge_table(&self, attribute: &str) -> Result<Option<RowTable<'a>>> {
        let text = |attribute| self.variable.map_or(Ok(None), |variable| variable.text(attribute));
        let name = if self.variable.is_some() { text(attribute)? } else { Some(attribute.to_owned()) };
        let table = name.and_then(|name| self.face_nodes.source.find(&name));
        let dimension = text("edge_dimension")?;
        Ok(table.map(|table| RowTable { table, item: "edge", dimension, expected: "2 faces or nodes" }))
    }

    /// The number of edges for which the file has the faces beside them or the nodes at their ends.
    pub(crate) fn edges(&self) -> Option<usize> {
        let mut tables = [EDGE_FACES, EDGE_NODES].into_iter().filter_map(|name| self.edge_table(name).ok()?);
        Some(tables.next()?.sizes().ok()?.items)
    }

    /// The faces beside each edge, of `faces` faces: those with its two nodes; or if the file has faces of edges alone,
    /// these, of which the edge has the common nodes.
    pub(crate) fn faces_of_edges(&self, faces: usize) -> Result<FacesOfEdges> {
        let nodes = self.positions(&self.nodes)?;
        let count = nodes.lon.as_reals().len();
        let Rows { nodes: rows, len } = self.rows(count)?;
        let around = |face: i32| rows[len * face as usize..][..len].iter().copied().filter(|node| *node >= 0);
        let place = |node: i32| DVec3::from(nodes.direction(node));
        let middle = |face: i32| around(face).map(place).sum::<DVec3>();
        if let Some(table) = self.edge_table(EDGE_NODES)? {
            let ends = table.read(count)?.nodes.as_chunks().0.to_vec();
            let to_right = |[from, to]: [i32; 2]| {
                if from.min(to) < 0 { DVec3::NAN } else { place(to).cross(place(from)) }
            };
            let normals: Vec<DVec3> = ends.iter().map(|ends| to_right(*ends)).collect();
            let sorted = |[one, other]: [i32; 2]| [one.min(other), one.max(other)];
            let numbers: HashMap<[i32; 2], usize> = ends.iter().map(|ends| sorted(*ends)).zip(0..).collect();
            let mut beside = vec![[NONE; 2]; ends.len()];
            for face in 0..(rows.len() / len) as i32 {
                for (one, other) in around(face).zip(around(face).cycle().skip(1)) {
                    if let Some(edge) = numbers.get(&sorted([one, other])) {
                        beside[*edge][usize::from(normals[*edge].dot(middle(face)) > 0.0)] = face;
                    }
                }
            }
            return Ok(FacesOfEdges { faces: beside, normals });
        }
        let table = self.edge_table(EDGE_FACES)?.ok_or_else(|| missing(self.face_nodes.source, EDGE_FACES))?;
        let beside = table.read(faces)?.nodes.as_chunks().0.to_vec();
        let from_first = |[first, second]: [i32; 2]| {
            let is_common = |node: &i32| second >= 0 && around(second).any(|other| other == *node);
            let mut ends = (first >= 0).then(|| around(first).filter(is_common)).into_iter().flatten().map(place);
            let normal = ends.next().zip(ends.next()).map(|(one, other)| one.cross(other));
            normal.map_or(DVec3::NAN, |normal| -normal * normal.dot(middle(first)).signum())
        };
        Ok(FacesOfEdges { normals: beside.iter().map(|faces| from_first(*faces)).collect(), faces: beside })
    }
}

/// The faces beside the edges of a mesh.
pub(crate) struct FacesOfEdges {
    /// Those left and right of each edge, on the way from its first node to its second; -1 for a missing one.
    pub faces: Vec<[i32; 2]>,
    /// The pole of each edge's great circle on the right side, of any length; NaN where it is not known.
    pub normals: Vec<DVec3>,
}

/// A table with a row of numbers for each face or edge.
struct RowTable<'a> {
    table: SourceVariable<'a>,
    /// What has a row, in words.
    item: &'static str,
    /// The name of the dimension that counts these, if the file has it.
    dimension: Option<String>,
    /// The numbers of a row, in words.
    expected: &'static str,
}

/// The layout of a [`RowTable`].
struct RowSizes {
    items: usize,
    len: usize,
    is_transposed: bool,
}

impl RowTable<'_> {
    fn sizes(&self) -> Result<RowSizes> {
        let RowTable { table, item, dimension, expected } = self;
        let unexpected = |what: String| Err(table.unexpected(ErrorKind::Grid, what));
        let [first, second] = match table.variable.after_time() {
            [first, second] if table.variable.kind.is_number() => [first, second],
            _ => return unexpected(format!("the {expected} of each {item}, as integers")),
        };
        // Without the attribute the dimension of items is the first; no mesh has fewer of them than numbers in a row.
        let is_transposed = match dimension {
            Some(name) => *name == second.name && *name != first.name,
            None => first.len < second.len,
        };
        let [items, len] = if is_transposed { [second.len, first.len] } else { [first.len, second.len] };
        match *item {
            "face" if len < 3 => unexpected(format!("{expected} of each of {items} faces")),
            "edge" if len != 2 => unexpected(format!("{expected} of each of {items} edges")),
            _ => Ok(RowSizes { items, len, is_transposed }),
        }
    }

    /// Reads the rows, whose numbers are of `count` nodes or faces.
    fn read(&self, count: usize) -> Result<Rows> {
        let RowTable { table, item, .. } = self;
        let RowSizes { items, len, is_transposed } = self.sizes()?;
        let table_values = table.all_numbers()?;
        let fill = table.numbers("_FillValue")?.first().copied();
        let is_from_1 = || {
            let is_there = |number: &&f64| Some(**number) != fill && !number.is_nan();
            let there = || table_values.iter().filter(is_there);
            there().any(|number| *number == count as f64) && !there().any(|number| *number == 0.0)
        };
        let given = table.numbers("start_index")?.first().copied();
        let base = given.unwrap_or_else(|| if is_from_1() { 1.0 } else { 0.0 });
        let mut nodes = Vec::with_capacity(table_values.len());
        for i in 0..items * len {
            let (row, place) = (i / len, i % len);
            let number = table_values[if is_transposed { place * items + row } else { i }];
            let node = number - base;
            // Marks of other tools lie far outside.
            let is_marked = Some(number) == fill || number.is_nan() || node < 0.0 || node >= f64::from(i32::MAX);
            if !is_marked && node >= count as f64 {
                let last = count as f64 - 1.0 + base;
                let context = format!("{} of {item} {row} is {number}, expected {base} to {last}", table.name());
                return Err(table.error(ErrorKind::Grid, context));
            }
            nodes.push(if is_marked { NONE } else { node as i32 });
        }
        Ok(Rows { nodes, len })
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
pub(crate) fn find(sources: &Sources) -> Result<Option<Topology<'_>>> {
    sources.others_first().map(Topology::of).find_map(Result::transpose).transpose()
}

pub(super) fn read(sources: &Sources, topology: &Topology) -> Result<Mesh> {
    let nodes = topology.positions(&topology.nodes)?;
    let rows = topology.rows(nodes.lon.as_reals().len())?;
    let faces = topology.faces.as_ref().map(|names| topology.positions(names)).transpose()?;
    of_rows(sources, topology.face_nodes, nodes, faces, rows)
}

/// The nodes of each face, from 0 and with marks after the last one, in rows of one length.
pub(super) struct Rows {
    pub nodes: Vec<i32>,
    /// Length of a row.
    pub len: usize,
}

/// The mesh of the faces in `rows`, as for [`of_faces`], which were read from `table`.
pub(super) fn of_rows(
    sources: &Sources,
    table: SourceVariable,
    nodes: Positions,
    given: Option<Positions>,
    rows: Rows,
) -> Result<Mesh> {
    let fewer = rows.nodes.chunks_exact(rows.len).position(|face| face.iter().filter(|i| **i >= 0).count() < 3);
    if let Some(face) = fewer {
        let context = format!("{}: face {face} has fewer than 3 nodes", table.name());
        return Err(table.error(ErrorKind::Grid, context));
    }
    let has_field_of = |len: usize| {
        let is_over = |v: &Variable| v.kind.is_real() && v.after_time().iter().any(|d| d.len == len);
        sources.fields().each_variable().any(|found| is_over(found.variable) && !is_coordinate(found))
    };
    let are_nodes_cells = has_field_of(nodes.lon.as_reals().len()) && !has_field_of(rows.nodes.len() / rows.len);
    let path = table.source.path();
    let mesh = of_faces(path, nodes, given, rows, are_nodes_cells)
        .map_err(|e| e.within(format_args!("{}: {}", path.display(), table.name())))?;
    let is_mpas = mesh.layout == MeshLayout::Polygons && mesh.file_corners.is_none() && super::mpas::is_in(sources)?;
    Ok(if is_mpas { mesh.into_mpas() } else { mesh })
}

impl Mesh {
    /// The tables of a mesh whose cells are faces, numbered from 0: `nodes` are directions of any length, of which
    /// `faces` has a row of `row` for each face, in order around it, with -1 after the last one. The nodes are corners
    /// ([`MeshLayout::Polygons`]), and `middles` are directions of the faces' middles. Messages name `path`.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] and [`ErrorKind::Unsupported`] name a face or node that does not fit a mesh.
    pub fn of_faces(
        path: &Path,
        nodes: &[[f64; 3]],
        middles: &[[f64; 3]],
        faces: Vec<i32>,
        row: usize,
    ) -> Result<Self> {
        let [nodes, middles] = [nodes, middles].map(|of| of_directions(of.iter().copied()));
        of_faces(path, nodes, Some(middles), Rows { nodes: faces, len: row }, false)
    }

    /// As [`Mesh::of_faces`], of the mesh whose cells are the nodes ([`MeshLayout::Triangles`]): its corners are the
    /// faces, cut into triangles, or the Delaunay triangles of the nodes if there are no faces.
    ///
    /// # Errors
    /// As [`Mesh::of_faces`] and [`OwnedTables::of_points`](icoray::OwnedTables::of_points).
    pub fn of_nodes(path: &Path, nodes: &[[f64; 3]], faces: Vec<i32>, row: usize) -> Result<Self> {
        let nodes = of_directions(nodes.iter().copied());
        if faces.is_empty() {
            return of_points(path, nodes, "points");
        }
        of_faces(path, nodes, None, Rows { nodes: faces, len: row }, true)
    }
}

/// The tables of a mesh of faces; `rows` has the nodes of each. If `given` has no middles of faces, triangles have the
/// middles of their circles, and others the means of their nodes. Nodes are the middles of cells if `are_nodes_cells`,
/// and if all faces are triangles: other faces are cut into such.
fn of_faces(
    path: &Path,
    nodes: Positions,
    given: Option<Positions>,
    Rows { nodes: rows, len: row }: Rows,
    are_nodes_cells: bool,
) -> Result<Mesh> {
    let faces = rows.len() / row;
    if let Some(middles) = given.as_ref().map(|given| given.lon.as_reals().len()).filter(|middles| *middles != faces) {
        let context = format!("{middles} middles of faces, expected {faces}, one per face");
        return Err(Error::new(ErrorKind::Grid, context));
    }
    let around = || rows.chunks_exact(row).map(|face| face.iter().copied().filter(|i| *i >= 0));
    let are_triangles = around().all(|face| face.count() == 3);
    if !are_triangles && !are_nodes_cells {
        let place = |node: i32| DVec3::from(nodes.direction(node));
        let middles = || of_directions(around().map(|face| face.map(place).sum::<DVec3>()));
        let center = given.unwrap_or_else(middles);
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
    Ok(Mesh { file_corners, ..Mesh::of_triangles(path, MeshLayout::Triangles, [nodes, corner], corner_cell)? })
}
