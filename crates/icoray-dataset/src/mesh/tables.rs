//! The tables of a mesh, owned.

use super::polygons::Polygons;
use crate::source::{Kind, Source, SourceVariable};
use crate::sources::IN_ANOTHER_FILE;
use icoray::{Connectivity, Error, ErrorKind, Grid, GridTables, Location, LonLat, OwnedReals, Result};
use std::path::{Path, PathBuf};

/// How a file's tables lay a mesh out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshLayout {
    /// Hexagons with MPAS's tables; fields at cells or corners.
    Mpas,
    /// Triangles, as ICON and FESOM2 have them, and UGRID: the corners of the hexagons around their points. Fields at
    /// corners or, in ICON rarely, at cells.
    Triangles,
    /// Polygons: with their bounds over one dimension, according to the CF conventions 1.11, §7.1, as written by
    /// DYNAMICO, with fields at cells; or UGRID's, with fields at faces or nodes; or columns without tables, with
    /// fields at these.
    Polygons,
}

impl MeshLayout {
    /// The name of the format whose files usually have this layout.
    fn format(self) -> &'static str {
        match self {
            MeshLayout::Mpas => "MPAS",
            MeshLayout::Triangles => "ICON",
            MeshLayout::Polygons => "polygons",
        }
    }
}

/// The format of a mesh that was made from points alone.
pub(super) const POINTS: &str = "points";

/// Meaning of cells and corners for a file of triangles.
const OF_TRIANGLES: &str = "corners are the triangles of the file, cells its points";

/// The tables of a mesh that icoray needs, owned.
///
/// For MPAS, the tables as the file stores them, numbered from 1; missing ones are derived from the others if these
/// determine them. For ICON, `corner_cell` is `vertex_of_cell`, or is rebuilt from the triangles' bounds if the file
/// has no tables, and all others are derived from it, numbered from 0. For polygons with bounds, coincident points are
/// one corner, and all tables are derived from the polygons' corners, numbered from 0. UGRID's faces are such polygons,
/// or triangles like ICON's. If more than three polygons meet, the polygon of their middles is cut into triangles,
/// which are the corners ([`Mesh::corners_in_file`]). For columns without tables the corners are Delaunay triangles.
#[derive(Debug)]
pub struct Mesh {
    pub(super) path: PathBuf,
    pub(super) layout: MeshLayout,
    pub(super) center: Positions,
    pub(super) corner: Positions,
    pub(super) corner_cell: Vec<i32>,
    pub(super) connectivity: Connectivity,
    /// The file's corners; `None` if the mesh's corners are the file's.
    pub(super) file_corners: Option<FileCorners>,
    /// The name of the file's format; [`POINTS`] if the corners are Delaunay triangles of points.
    pub(super) format: &'static str,
}

/// The corners of a file, some of which are several corners of the mesh: triangles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FileCorners {
    /// Their number.
    pub count: usize,
    /// The row in the file of each of the mesh's corners.
    pub row: Vec<u32>,
}

/// Longitudes and latitudes in radians.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Positions {
    pub(super) lon: OwnedReals,
    pub(super) lat: OwnedReals,
}

impl Positions {
    /// The positions in some rows.
    pub(super) fn of_rows(&self, rows: &[u32]) -> Self {
        let of =
            |angle: &OwnedReals| OwnedReals::F64(rows.iter().map(|row| angle.as_reals().get(*row as usize)).collect());
        Positions { lon: of(&self.lon), lat: of(&self.lat) }
    }

    /// Longitude and latitude of a row.
    pub(super) fn at(&self, row: usize) -> [f64; 2] {
        [self.lon.as_reals().get(row), self.lat.as_reals().get(row)]
    }

    /// The unit vector of a row's position.
    pub(super) fn direction(&self, row: i32) -> [f64; 3] {
        let [lon, lat] = self.at(row as usize);
        [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()]
    }

    pub(super) fn borrowed(&self) -> LonLat<'_> {
        LonLat { lon_rad: self.lon.as_reals(), lat_rad: self.lat.as_reals() }
    }
}

impl Mesh {
    /// A mesh of triangles of cells, numbered from 0, with the positions of cells and of these corners.
    pub(super) fn of_triangles(
        path: &Path,
        layout: MeshLayout,
        places: [Positions; 2],
        corner_cell: Vec<i32>,
    ) -> Result<Self> {
        let connectivity = Connectivity::new(&corner_cell, places[0].lon.as_reals().len())?;
        Ok(Self::of_tables(path, layout, places, corner_cell, connectivity))
    }

    /// A mesh of polygons, with the positions of cells and of the polygons' corners. If a corner joins more than 3
    /// cells, the polygon of their middles is cut into triangles, which are the mesh's corners.
    pub(super) fn of_polygons(path: &Path, [center, corner]: [Positions; 2], polygons: Polygons) -> Result<Self> {
        let (layout, count) = (MeshLayout::Polygons, corner.lon.as_reals().len());
        if polygons.joins_more_than_3(count) {
            let (corner_cell, row) = polygons.triangles(count, |cell| center.direction(cell))?;
            let places = [center, corner.of_rows(&row)];
            let file_corners = Some(FileCorners { count, row });
            return Ok(Mesh { file_corners, ..Self::of_triangles(path, layout, places, corner_cell)? });
        }
        let corner_cell = polygons.corner_cells(count)?;
        Ok(Self::of_tables(path, layout, [center, corner], corner_cell, polygons.connectivity(count)?))
    }

    /// A mesh from all its tables.
    pub(super) fn of_tables(
        path: &Path,
        layout: MeshLayout,
        [center, corner]: [Positions; 2],
        corner_cell: Vec<i32>,
        connectivity: Connectivity,
    ) -> Self {
        Mesh {
            path: path.to_owned(),
            layout,
            center,
            corner,
            corner_cell,
            connectivity,
            file_corners: None,
            format: layout.format(),
        }
    }

    /// The tables, borrowed. [`GridTables`] lists their MPAS names.
    pub fn tables(&self) -> GridTables<'_> {
        GridTables {
            index_base: self.index_base(),
            center: self.center.borrowed(),
            corner: self.corner.borrowed(),
            cell_corner: self.connectivity.cell_corner.as_slice().into(),
            cell_corner_row: self.connectivity.cell_corner_row,
            cell_corner_count: Some(self.connectivity.cell_corner_count.as_slice().into()),
            corner_cell: self.corner_cell.as_slice().into(),
            corner_edge: self.connectivity.corner_edge.as_slice().into(),
            edge_corner: self.connectivity.edge_corner.as_slice().into(),
        }
    }

    /// The tables as a checked grid.
    ///
    /// # Errors
    /// As [`Grid::new`], with the file's name before the message.
    pub fn grid(&self) -> Result<Grid<'_>> {
        Grid::new(self.tables()).map_err(|e| e.within(self.path.display()))
    }

    /// How the file's tables lay the mesh out.
    pub fn layout(&self) -> MeshLayout {
        self.layout
    }

    /// Number of cells: MPAS's `nCells`, the points of ICON's triangles.
    pub fn cells(&self) -> usize {
        self.tables().cells()
    }

    /// Number of corners: MPAS's `nVertices`, ICON's triangles, the points of polygons.
    pub fn corners(&self) -> usize {
        self.tables().corners()
    }

    /// Number of corners in the file, over which its fields at corners lie: [`Mesh::corners`], or fewer if some of them
    /// are several triangles of the mesh.
    pub fn corners_in_file(&self) -> usize {
        self.file_corners.as_ref().map_or(self.corners(), |corners| corners.count)
    }

    /// The row in the file of each corner, if the mesh's corners are not the file's.
    pub(crate) fn corner_rows(&self) -> Option<&[u32]> {
        self.file_corners.as_ref().map(|corners| corners.row.as_slice())
    }

    /// A description of the tables with their sizes.
    pub fn in_words(&self) -> String {
        let [cells, corners, edges] = [self.cells(), self.corners(), self.edges()];
        let of_triangles = || (self.layout == MeshLayout::Triangles).then(|| OF_TRIANGLES.to_owned());
        let made = self.made_in_words().or_else(of_triangles).map_or_else(String::new, |made| format!("; {made}"));
        format!("{}: {cells} cells, {corners} corners, {edges} edges{made}", self.format())
    }

    /// A description of corners that are not the file's.
    pub fn made_in_words(&self) -> Option<String> {
        let cut = |file: &FileCorners| format!("corners are triangles, made of {} corners of the file", file.count);
        let of_points = "corners are the Delaunay triangles of the points";
        if self.format == POINTS { Some(of_points.to_owned()) } else { self.file_corners.as_ref().map(cut) }
    }

    /// The name of the file's format, or "points" if the mesh was made from points alone.
    pub fn format(&self) -> &'static str {
        self.format
    }

    /// Number of edges.
    pub fn edges(&self) -> usize {
        self.tables().edges()
    }

    /// The mesh of a file in a format of this name; one of MPAS stays that.
    pub(super) fn with_format(self, name: &'static str) -> Self {
        Mesh { format: if self.layout == MeshLayout::Mpas { self.format } else { name }, ..self }
    }

    /// Converts a mesh, whose tables are numbered from 0, to one of MPAS, whose are from 1.
    pub(super) fn into_mpas(mut self) -> Self {
        let Connectivity { corner_edge, edge_corner, cell_corner, .. } = &mut self.connectivity;
        let tables = [cell_corner, &mut self.corner_cell, corner_edge, edge_corner];
        tables.into_iter().flatten().for_each(|entry| *entry += 1);
        Mesh { layout: MeshLayout::Mpas, format: MeshLayout::Mpas.format(), ..self }
    }

    /// The number of the first cell, corner and edge.
    fn index_base(&self) -> i32 {
        i32::from(self.layout == MeshLayout::Mpas)
    }

    /// The file of the tables, as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether all tables are equal, in any file: data derived from one mesh are valid for the other.
    pub fn is_same(&self, other: &Mesh) -> bool {
        self.layout == other.layout
            && self.connectivity == other.connectivity
            && self.file_corners == other.file_corners
            && self.corner_cell == other.corner_cell
            && [&self.center, &self.corner] == [&other.center, &other.corner]
    }

    /// Positions of cells or corners.
    fn positions(&self, location: Location) -> &Positions {
        if location == Location::Center { &self.center } else { &self.corner }
    }

    /// The unit vector of the position of a cell or corner.
    pub(crate) fn direction(&self, location: Location, column: usize) -> [f64; 3] {
        self.positions(location).direction(column as i32)
    }

    /// Zonal and meridional component of the direction from a cell or corner to a place on the sphere, given as a
    /// vector of any length.
    pub(crate) fn direction_toward(&self, location: Location, from: usize, [x, y, z]: [f64; 3]) -> [f64; 2] {
        let [lon, lat] = self.positions(location).at(from);
        let [east, north] =
            [y * lon.cos() - x * lon.sin(), z * lat.cos() - (x * lon.cos() + y * lon.sin()) * lat.sin()];
        [east, north].map(|part| part / east.hypot(north))
    }

    /// The cells around a corner, counted from 0; `None` for a missing one.
    pub(crate) fn cells_at(&self, corner: usize) -> [Option<usize>; 3] {
        let number = |k| i64::from(self.corner_cell[3 * corner + k]) - i64::from(self.index_base());
        let cell = |k| usize::try_from(number(k)).ok();
        [0, 1, 2].map(|k| cell(k).filter(|&cell| cell < self.cells()))
    }
}

/// The variable of that name, with numbers of that kind over those dimensions.
pub(super) fn find<'a>(
    source: &'a dyn Source,
    name: &str,
    dimensions: &[&str],
    is_integer: bool,
) -> Result<SourceVariable<'a>> {
    let found = source.find(name).ok_or_else(|| missing(source, name))?;
    let kind = found.variable.kind;
    let has_kind = if is_integer { kind == Kind::Integer } else { kind.is_real() };
    if has_kind && found.variable.lies_at_times_over(dimensions) {
        return Ok(found);
    }
    let kind = if is_integer { "integer" } else { "float or double" };
    Err(found.unexpected(ErrorKind::Grid, format_args!("{name}({}) of {kind}", dimensions.join(", "))))
}

pub(super) fn missing(source: &dyn Source, name: &str) -> Error {
    source.error(
        ErrorKind::Grid,
        format_args!("variable {name} is missing: the file holds no whole mesh; {IN_ANOTHER_FILE}"),
    )
}
