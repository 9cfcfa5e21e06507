//! Fields at edges, as fields at the centres beside these: MPAS's cells, ICON's triangles, UGRID's faces.
//!
//! A scalar is the mean over the edges of a centre. A vector is in files as the component u along the normal n of each
//! edge, which points from the first centre beside it to the second: (U, V) at a centre, zonal and meridional, minimise
//! Σ (n · (U, V) − u)² over its edges. The great circle through both centres crosses the edge along n, so that n at a
//! centre is the direction of that circle there. In UGRID's files the middles of faces may be any points within these,
//! and n is the direction of the pole of the edge's great circle on its right, also at the face on the left.
//! Tables: MPAS mesh specification 1.0; ICON's grid files; FESOM2's `fesom.mesh.diag.nc`; UGRID 1.0.

use crate::field::FieldInfo;
use crate::mesh::ugrid::{self, FacesOfEdges, Topology};
use crate::mesh::{Mesh, MeshLayout};
use crate::source::{Dimension, SourceVariable, Variable};
use crate::sources::{IN_ANOTHER_FILE, Sources};
use crate::values::ShapedValues;
use glam::DVec3;
use icoray::{Description, Error, ErrorKind, Location, Result};

/// A field at centres that is made of a variable at edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// The mean of the edges.
    Mean,
    /// The eastward component of a vector, from its components normal to edges.
    Zonal,
    /// The northward component.
    Meridional,
}

/// Names, or words of names such as `u_init`, of vectors' components normal to edges; others have "normal" in their
/// name or long name, or are fluxes.
const NORMAL: [&str; 3] = ["u", "ru", "vn"];
/// Names of components along edges, from which no vector follows; others have "tangential" in their long name.
const TANGENTIAL: [&str; 2] = ["v", "vt"];

impl Part {
    /// The fields that are made of a variable at edges; none of a component along them. Lengths are scalars, such as
    /// the thickness of layers with which MPAS-Ocean makes fluxes.
    pub(crate) fn all_of(name: &str, description: &Description) -> &'static [Self] {
        let long_name = description.long_name.as_deref().unwrap_or_default();
        let words = format!("{name} {long_name}").to_lowercase().replace("normali", "");
        let is_named = name.split('_').any(|word| NORMAL.contains(&word));
        match () {
            () if description.is_length() => &[Part::Mean],
            () if TANGENTIAL.contains(&name) || words.contains("tangential") => &[],
            () if is_named || words.contains("normal") || words.contains("flux") => &[Part::Zonal, Part::Meridional],
            () => &[Part::Mean],
        }
    }

    /// Suffix of a variable's name.
    pub(crate) fn ending(self) -> &'static str {
        match self {
            Part::Mean => "",
            Part::Zonal => "_zonal",
            Part::Meridional => "_meridional",
        }
    }

    /// A description of the field, for a note.
    pub(crate) fn in_words(self) -> &'static str {
        match self {
            Part::Mean => "the mean over the edges of each cell",
            Part::Zonal | Part::Meridional => "reconstructed from the components normal to the edges of each cell",
        }
    }
}

/// The variable at edges of which a field of this name is a component; `None` if it has no such name.
///
/// ```
/// assert_eq!(icoray_dataset::variable_at_edges("vn_zonal"), Some("vn"));
/// assert_eq!(icoray_dataset::variable_at_edges("theta"), None);
/// ```
pub fn variable_at_edges(field: &str) -> Option<&str> {
    [Part::Zonal, Part::Meridional].into_iter().find_map(|part| field.strip_suffix(part.ending()))
}

/// The location of centres beside edges, if a dimension is probably that of edges.
fn location_beside(mesh: &Mesh, dimension: &Dimension) -> Option<Location> {
    match mesh.layout() {
        MeshLayout::Mpas => (dimension.name == "nEdges").then_some(Location::Center),
        MeshLayout::Triangles => (dimension.len == mesh.edges()).then_some(Location::Corner),
        MeshLayout::Polygons => None,
    }
}

/// The tables of a model for the two centres beside each edge, the likeliest first.
fn table_names(mesh: &Mesh) -> &'static [&'static str] {
    match mesh.layout() {
        MeshLayout::Mpas => &["cellsOnEdge"],
        MeshLayout::Triangles => &["adjacent_cell_of_edge", "edge_tri"],
        MeshLayout::Polygons => &[],
    }
}

/// A table from which the centres beside edges follow.
enum Table<'a> {
    /// The numbers, from 1, of the two centres beside each edge.
    Centers(SourceVariable<'a>),
    /// A mesh of UGRID, whose faces are the centres.
    Faces(Topology<'a>),
}

/// The edges of the files' mesh.
pub(crate) struct EdgesInFiles<'a> {
    table: Table<'a>,
    count: usize,
    /// The location of the centres.
    location: Location,
}

impl<'a> EdgesInFiles<'a> {
    /// The edges for which a file has a table; `None` if there is no table, or if the mesh's corners are not the faces
    /// of the file.
    pub(crate) fn find(sources: &'a Sources, mesh: &Mesh) -> Option<Self> {
        let location = if mesh.layout() == MeshLayout::Triangles { Location::Corner } else { Location::Center };
        if let Some(found) = table_names(mesh).iter().find_map(|name| sources.find(name)) {
            let count = found.variable.after_time().iter().map(|dimension| dimension.len).max()?;
            return Some(EdgesInFiles { table: Table::Centers(found), count, location });
        }
        let is_of_faces = location == Location::Center || mesh.corner_rows().is_none();
        let is_ugrid = is_of_faces && mesh.layout() != MeshLayout::Mpas;
        let topology = if is_ugrid { ugrid::find(sources).ok()?? } else { return None };
        Some(EdgesInFiles { count: topology.edges()?, table: Table::Faces(topology), location })
    }

    /// The location of the centres beside edges, if a dimension is that of edges.
    pub(crate) fn location_beside(&self, dimension: &Dimension) -> Option<Location> {
        let is_of_edges = match self.table {
            Table::Centers(found) if found.own_name() == "cellsOnEdge" => dimension.name == "nEdges",
            _ => dimension.len == self.count,
        };
        is_of_edges.then_some(self.location)
    }

    /// Reads the table, of edges between `columns` centres.
    fn read(&self, columns: usize) -> Result<Edges> {
        let topology = match &self.table {
            Table::Centers(found) => return Ok(Edges::new(self.location, centers(*found, columns)?, columns)),
            Table::Faces(topology) => topology,
        };
        let FacesOfEdges { faces, normals } = topology.faces_of_edges(columns)?;
        let centers = faces.iter().map(|pair| pair.map(|face| u32::try_from(face).unwrap_or(NONE))).collect();
        Ok(Edges { normals, ..Edges::new(self.location, centers, columns) })
    }
}

/// The numbers, from 0, of the centres beside each edge in a table that counts them from 1.
fn centers(found: SourceVariable, columns: usize) -> Result<Vec<[u32; 2]>> {
    let is_transposed = match found.variable.after_time() {
        [_, two] if two.len == 2 => false,
        [two, _] if two.len == 2 => true,
        _ => return Err(found.unexpected(ErrorKind::Grid, "the two cells beside each edge")),
    };
    let table = found.all_integers()?;
    let count = table.len() / 2;
    let mut centers = Vec::with_capacity(count);
    for edge in 0..count {
        let beside = [0, 1].map(|k| table[if is_transposed { k * count + edge } else { 2 * edge + k }]);
        // One past the last marks a missing cell, as do numbers below 1.
        if let Some(number) = beside.iter().find(|number| **number > columns as i32 + 1) {
            let name = found.name();
            let context = format!("{name}: cell {number} beside edge {}, expected 1 to {columns}", edge + 1);
            return Err(found.error(ErrorKind::Grid, context));
        }
        let is_there = |number: &i32| (1..=columns as i32).contains(number);
        centers.push(beside.map(|number| Some(number).filter(is_there).map_or(NONE, |number| number as u32 - 1)));
    }
    Ok(centers)
}

/// The reason why a variable at edges is not a field itself; `made` are the names of fields that are made of it.
pub(crate) fn reason(sources: &Sources, mesh: &Mesh, variable: &Variable, made: &[&str]) -> Option<String> {
    variable.dimensions.iter().find_map(|dimension| location_beside(mesh, dimension))?;
    let table = table_names(mesh).first()?;
    let has_triangles = ["vertex_of_cell", "clon"].iter().any(|name| sources.find(name).is_some());
    if made.is_empty() && mesh.layout() == MeshLayout::Triangles && !has_triangles {
        return None;
    }
    Some(match made {
        [] if EdgesInFiles::find(sources, mesh).is_none() => format!(
            "variable {variable} is at edges, and variable {table}, which has the cells beside each, is missing: \
             {IN_ANOTHER_FILE}"
        ),
        [] => format!(
            "variable {variable} is at edges, expected there a scalar or a component normal to edges that changes \
             with time or has layers (`at` picks an entry of a further dimension)"
        ),
        made => format!("variable {variable} is at edges, its fields at cells are {}", made.join(" and ")),
    })
}

/// Marks a missing centre beside an edge.
const NONE: u32 = u32::MAX;

/// The edges of each centre: 16 bytes per edge and 8 bytes per centre; of UGRID's meshes 40 bytes per edge.
#[derive(Debug)]
pub(crate) struct Edges {
    /// The location of the centres.
    location: Location,
    /// The two centres beside each edge: the normal points from the first to the second.
    centers: Vec<[u32; 2]>,
    /// The pole of each edge's great circle toward which the normal points; empty if the circle through both centres
    /// has the direction of the normal.
    normals: Vec<DVec3>,
    /// The edges of all centres behind each other.
    edges: Vec<u32>,
    /// The first of each centre's edges in `edges`, and the end of the last one's.
    starts: Vec<usize>,
}

/// An edge of a centre.
#[derive(Clone, Copy)]
struct Side {
    edge: usize,
    /// Zonal and meridional component, at the centre, of the edge's normal; `None` at the rim, where it is not known,
    /// and for means.
    normal: Option<[f64; 2]>,
}

impl Edges {
    /// Reads the table for the fields that `info` and others are.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Self> {
        let found = EdgesInFiles::find(sources, mesh);
        let found = found.ok_or_else(|| sources.error(ErrorKind::Field, "no table has the cells beside edges"))?;
        found.read(info.columns)
    }

    /// Sorts the edges by their centres, of which there are `columns`.
    fn new(location: Location, centers: Vec<[u32; 2]>, columns: usize) -> Self {
        let sides = || centers.iter().flatten().zip(0u32..).filter(|(center, _)| **center != NONE);
        let mut starts = vec![0; columns + 1];
        sides().for_each(|(center, _)| starts[*center as usize + 1] += 1);
        for center in 0..columns {
            starts[center + 1] += starts[center];
        }
        let (mut next, mut edges) = (starts.clone(), vec![0; starts[columns]]);
        for (center, side) in sides() {
            let place = &mut next[*center as usize];
            edges[*place] = side / 2;
            *place += 1;
        }
        Edges { location, centers, normals: Vec::new(), edges, starts }
    }

    /// The edges of a centre, with the normals that a part needs.
    fn sides(&self, mesh: &Mesh, center: usize, part: Part) -> Vec<Side> {
        let side = |edge: &u32| {
            let [first, second] = self.centers[*edge as usize];
            let (other, sign) = if first as usize == center { (second, 1.0) } else { (first, -1.0) };
            let toward = |place: [f64; 3]| mesh.direction_toward(self.location, center, place);
            let normal = match self.normals.get(*edge as usize) {
                _ if part == Part::Mean => None,
                Some(pole) => pole.is_finite().then(|| toward((*pole).into())),
                None if other == NONE => None,
                None => {
                    let other = mesh.direction(self.location, other as usize);
                    Some(toward(other).map(|component| sign * component))
                }
            };
            Side { edge: *edge as usize, normal }
        };
        self.edges[self.starts[center]..self.starts[center + 1]].iter().map(side).collect()
    }

    /// The values of a part at centres from those at edges; NaN where these do not determine it.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if there are more or fewer edges than in the table.
    pub(crate) fn at_centers(&self, mesh: &Mesh, values: &ShapedValues, fill: f64, part: Part) -> Result<ShapedValues> {
        let (found, count) = (values.shape.columns, self.centers.len());
        if found != count {
            let context = format!("{found} edges, expected {count} as in the table of the mesh");
            return Err(Error::new(ErrorKind::Field, context));
        }
        Ok(values.made(self.starts.len() - 1, |center| {
            let sides = self.sides(mesh, center, part);
            move |layer| {
                let there = sides.iter().map(|side| (side.normal, values.value(side.edge, layer, fill)));
                part.of(there.filter(|(_, value)| !value.is_nan()))
            }
        }))
    }
}

impl Part {
    /// The value at a centre from those of its edges, with their normals.
    fn of(self, sides: impl Iterator<Item = (Option<[f64; 2]>, f64)>) -> f64 {
        if self == Part::Mean {
            let (count, sum) = sides.fold((0.0, 0.0), |(count, sum), (_, value)| (count + 1.0, sum + value));
            return sum / count;
        }
        // The normal equations of the least squares.
        let (mut of, mut with) = ([0.0; 3], [0.0; 2]);
        for ([east, north], value) in sides.filter_map(|(normal, value)| Some((normal?, value))) {
            of = [of[0] + east * east, of[1] + east * north, of[2] + north * north];
            with = [with[0] + east * value, with[1] + north * value];
        }
        let determinant = of[0] * of[2] - of[1] * of[1];
        let numerator = match self {
            Part::Zonal => with[0] * of[2] - with[1] * of[1],
            _ => with[1] * of[0] - with[0] * of[1],
        };
        if determinant > MIN_DETERMINANT { numerator / determinant } else { f64::NAN }
    }
}

/// Minimum determinant of the normal equations: the square of the sine of the angle between two normals that differ.
const MIN_DETERMINANT: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::IcosahedralMesh;

    #[test]
    fn edges_of_cells_take_two_tables_of_the_mesh() {
        let mesh = IcosahedralMesh::new(3).unwrap();
        let cells_of = |corner: i32| &mesh.corner_cell[3 * corner as usize..3 * corner as usize + 3];
        let beside = mesh.edge_corner.as_chunks().0.iter().map(|[one, other]| {
            let mut shared = cells_of(*one).iter().filter(|cell| cells_of(*other).contains(cell));
            [shared.next(), shared.next()].map(|cell| *cell.unwrap() as u32)
        });
        let edges = Edges::new(Location::Center, beside.collect(), mesh.cells());
        let of = |center: usize| &edges.edges[edges.starts[center]..edges.starts[center + 1]];
        for center in 0..mesh.cells() {
            assert!(of(center).iter().all(|edge| edges.centers[*edge as usize].contains(&(center as u32))));
        }
        assert_eq!((0..mesh.cells()).filter(|center| of(*center).len() == 5).count(), 12);
        let bytes = size_of_val(&edges.centers[..]) + size_of_val(&edges.edges[..]) + size_of_val(&edges.starts[..]);
        assert!(bytes <= 60 * mesh.cells(), "{bytes} bytes of {} cells", mesh.cells());
    }
}
