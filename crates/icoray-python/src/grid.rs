//! Grids over tables of Python.

use crate::array::{IndexArray, RealArray};
use crate::error::{argument, raised};
use icoray::{
    Connectivity, Error, ErrorKind, GridTables, IcosahedralMesh, Indices, LonLat, OwnedTables, Renderer, circumcenter,
};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;

/// A checked geodesic grid over borrowed tables.
///
/// Tables are named as in the C interface. Index tables hold int32 or int64 numbers that count from `index_base`; rows
/// may be in any order and orientation. C-contiguous tables are borrowed, others copied (`bytes_copied`). Borrowed tables
/// must not be changed while the grid lives. Each corner with its three cells is a triangle of the dual mesh, over
/// which values are interpolated. The mesh may have holes or cover a part of the sphere: a missing cell in
/// `corner_cell`, edge in `corner_edge` or corner in `edge_corner` and `cell_corner` is index_base - 1, -1, or one past
/// the last number.
///
/// Parameters
/// ----------
/// lon_center_rad, lat_center_rad : array_like, shape (cells,)
///     Positions of the cell centres, radians (MPAS lonCell, latCell; ICON vlon, vlat).
/// lon_corner_rad, lat_corner_rad : array_like, shape (corners,)
///     Positions of the corners, radians (MPAS lonVertex, latVertex; ICON clon, clat).
/// cell_corner : array_like, shape (cells, row)
///     Corners of each cell (MPAS verticesOnCell).
/// corner_cell : array_like, shape (corners, 3)
///     Cells at each corner (MPAS cellsOnVertex; ICON vertex_of_cell.T).
/// corner_edge : array_like, shape (corners, 3)
///     Edges at each corner (MPAS edgesOnVertex; ICON edge_of_cell.T).
/// edge_corner : array_like, shape (edges, 2)
///     Corners of each edge (MPAS verticesOnEdge; ICON adjacent_cell_of_edge.T).
/// cell_corner_count : array_like, shape (cells,), optional
///     Number of valid entries in each row of cell_corner (MPAS nEdgesOnCell). Without it a cell with fewer corners
///     repeats one of them.
/// index_base : {0, 1}
///     Number of the first cell, corner and edge.
///
/// Raises
/// ------
/// GridError
///     Names the table, row and value that is wrong, and what was expected.
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Grid {
    /// Dropped before the tables that it borrows.
    pub inner: Arc<icoray::Grid<'static>>,
    /// Bytes of tables that could not be borrowed and were copied.
    #[pyo3(get)]
    bytes_copied: u64,
    /// Number of the first cell, corner and edge in the tables.
    #[pyo3(get)]
    index_base: i32,
    /// Longitudes of the cell centres, radians, shape (cells,).
    #[pyo3(get)]
    lon_center_rad: Py<PyAny>,
    /// Latitudes of the cell centres, radians, shape (cells,).
    #[pyo3(get)]
    lat_center_rad: Py<PyAny>,
    /// Longitudes of the corners, radians, shape (corners,).
    #[pyo3(get)]
    lon_corner_rad: Py<PyAny>,
    /// Latitudes of the corners, radians, shape (corners,).
    #[pyo3(get)]
    lat_corner_rad: Py<PyAny>,
    /// Corners of each cell, shape (cells, row).
    #[pyo3(get)]
    cell_corner: Py<PyAny>,
    /// Number of valid entries in each row of cell_corner, shape (cells,); None if all count.
    #[pyo3(get)]
    cell_corner_count: Option<Py<PyAny>>,
    /// Cells at each corner, shape (corners, 3).
    #[pyo3(get)]
    corner_cell: Py<PyAny>,
    /// Edges at each corner, shape (corners, 3).
    #[pyo3(get)]
    corner_edge: Py<PyAny>,
    /// Corners of each edge, shape (edges, 2).
    #[pyo3(get)]
    edge_corner: Py<PyAny>,
}

/// The arrays of a grid.
struct GridArrays {
    center: [RealArray; 2],
    corner: [RealArray; 2],
    cell_corner: IndexArray,
    cell_corner_count: Option<IndexArray>,
    corner_cell: IndexArray,
    corner_edge: IndexArray,
    edge_corner: IndexArray,
    index_base: i32,
}

#[pymethods]
impl Grid {
    #[new]
    #[pyo3(signature = (*, lon_center_rad, lat_center_rad, lon_corner_rad, lat_corner_rad, cell_corner, corner_cell,
                        corner_edge, edge_corner, cell_corner_count = None, index_base = 0))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn new(
        py: Python,
        lon_center_rad: &Bound<PyAny>,
        lat_center_rad: &Bound<PyAny>,
        lon_corner_rad: &Bound<PyAny>,
        lat_corner_rad: &Bound<PyAny>,
        cell_corner: &Bound<PyAny>,
        corner_cell: &Bound<PyAny>,
        corner_edge: &Bound<PyAny>,
        edge_corner: &Bound<PyAny>,
        cell_corner_count: Option<&Bound<PyAny>>,
        index_base: i32,
    ) -> PyResult<Self> {
        let center = positions(lon_center_rad, lat_center_rad, "center", 0)?;
        let corner = positions(lon_corner_rad, lat_corner_rad, "corner", 0)?;
        let [cells, corners] = [&center, &corner].map(|[lon, _]| lon.dimensions[0].extent);
        let count = cell_corner_count.map(|count| IndexArray::new(count, &[cells], "cell_corner_count"));
        GridArrays {
            center,
            corner,
            cell_corner: IndexArray::new(cell_corner, &[cells, 0], "cell_corner")?,
            cell_corner_count: count.transpose()?,
            corner_cell: IndexArray::new(corner_cell, &[corners, 3], "corner_cell")?,
            corner_edge: IndexArray::new(corner_edge, &[corners, 3], "corner_edge")?,
            edge_corner: IndexArray::new(edge_corner, &[0, 2], "edge_corner")?,
            index_base,
        }
        .grid(py)
    }

    /// A grid of triangles: the tables of edges and of each cell's corners are derived.
    ///
    /// Parameters
    /// ----------
    /// lon_center_rad, lat_center_rad : array_like, shape (cells,)
    ///     Positions of the cell centres, the triangles' vertices, radians.
    /// corner_cell : array_like, shape (corners, 3)
    ///     The three cells of each triangle, counted from `index_base`. A side without a triangle beyond is the rim of
    ///     a hole.
    /// lon_corner_rad, lat_corner_rad : array_like, shape (corners,), optional
    ///     Positions of the corners, radians; the triangles' circumcentres by default.
    /// index_base : {0, 1}
    ///     Number of the first cell.
    #[staticmethod]
    #[pyo3(signature = (lon_center_rad, lat_center_rad, corner_cell, *, lon_corner_rad = None, lat_corner_rad = None,
                        index_base = 0))]
    fn from_triangles(
        py: Python,
        lon_center_rad: &Bound<PyAny>,
        lat_center_rad: &Bound<PyAny>,
        corner_cell: &Bound<PyAny>,
        lon_corner_rad: Option<&Bound<PyAny>>,
        lat_corner_rad: Option<&Bound<PyAny>>,
        index_base: i32,
    ) -> PyResult<Self> {
        if !(0..=1).contains(&index_base) {
            return Err(argument(format!("index_base: {index_base}, expected 0 or 1")));
        }
        let center = positions(lon_center_rad, lat_center_rad, "center", 0)?;
        let cells = center[0].dimensions[0].extent;
        let triangles = IndexArray::new(corner_cell, &[0, 3], "corner_cell")?;
        let corners = triangles.shape[0];
        // Derived tables count from 0.
        // SAFETY: read at once, with Python's lock held.
        let from_zero = numbers_from_zero(unsafe { triangles.indices(py) }, index_base)?;
        let derived = py.detach(|| Connectivity::new(&from_zero, cells));
        let note = |error: Error| if index_base == 0 { error } else { error.after("counted from 0") };
        let derived = derived.map_err(|error| raised(note(error)))?;
        let corner = match (lon_corner_rad, lat_corner_rad) {
            (Some(lon), Some(lat)) => positions(lon, lat, "corner", corners)?,
            (None, None) => {
                // SAFETY: as above.
                let [lon, lat] = center.each_ref().map(|angle| unsafe { angle.reals() }.0);
                circumcentres([lon, lat], &from_zero).map(|angle| made_reals(py, angle))
            }
            _ => return Err(argument("lon_corner_rad without lat_corner_rad, expected both or none".into())),
        };
        let is_as_is = index_base == 0 && !triangles.is_wide;
        let corner_cell = if is_as_is { triangles } else { made_indices(py, from_zero, 3) };
        Self::connected(py, center, corner, corner_cell, derived)
    }

    /// A grid of points alone, for columns without tables: the cells are the points, the corners their Delaunay triangles.
    ///
    /// The points may cover the sphere or regions: a triangle whose circumcircle is more than 5 times as large as others at
    /// its points lies outside. Of points less than 3e-7 rad (2 m on the Earth) apart, as at the poles of a lat-lon grid,
    /// one is a vertex of triangles, and the values at the others are not shown. A 2D array of places is to be flattened.
    ///
    /// Parameters
    /// ----------
    /// lon_center_rad, lat_center_rad : array_like, shape (cells,)
    ///     Positions of the points, radians, in any order.
    ///
    /// Raises
    /// ------
    /// GridError
    ///     Names a point that is not finite or looks like degrees; also where the points span no area.
    #[staticmethod]
    fn from_points(py: Python, lon_center_rad: &Bound<PyAny>, lat_center_rad: &Bound<PyAny>) -> PyResult<Self> {
        let center = positions(lon_center_rad, lat_center_rad, "center", 0)?;
        // SAFETY: the arrays live until the call ends, and are not to be changed while the grid lives.
        let points = unsafe { lon_lat(&center) };
        let made = py.detach(|| with_threads(|| OwnedTables::of_points(points))).map_err(raised)?;
        let OwnedTables { corner, corner_cell, connectivity, .. } = made;
        let corner = corner.map(|angle| made_reals(py, angle));
        Self::connected(py, center, corner, made_indices(py, corner_cell, 3), connectivity)
    }

    /// The icosahedral grid: an icosahedron whose triangles are bisected `level` times.
    ///
    /// Parameters
    /// ----------
    /// level : int
    ///     0 to 12; the grid has 10 * 4**level + 2 cells.
    #[staticmethod]
    #[pyo3(signature = (level))]
    fn icosahedral(py: Python, level: i64) -> PyResult<Self> {
        let found = u32::try_from(level).ok().filter(|level| *level <= icoray::MAX_LEVEL);
        let level = found.ok_or_else(|| argument(format!("level: {level}, expected 0 to {}", icoray::MAX_LEVEL)))?;
        let mesh = py.detach(|| with_threads(|| IcosahedralMesh::new(level))).map_err(raised)?;
        let real = |angle| made_reals(py, angle);
        GridArrays {
            center: [real(mesh.lon_center_rad), real(mesh.lat_center_rad)],
            corner: [real(mesh.lon_corner_rad), real(mesh.lat_corner_rad)],
            cell_corner: made_indices(py, mesh.cell_corner, 6),
            cell_corner_count: None,
            corner_cell: made_indices(py, mesh.corner_cell, 3),
            corner_edge: made_indices(py, mesh.corner_edge, 3),
            edge_corner: made_indices(py, mesh.edge_corner, 2),
            index_base: 0,
        }
        .grid(py)
    }

    /// Number of cells.
    #[getter]
    fn cells(&self) -> usize {
        self.inner.cells()
    }

    /// Number of corners.
    #[getter]
    fn corners(&self) -> usize {
        self.inner.tables().corners()
    }

    /// Number of edges.
    #[getter]
    fn edges(&self) -> usize {
        self.inner.tables().edges()
    }

    fn __repr__(&self) -> String {
        format!("<icoray.Grid: {} cells, {} corners, {} edges>", self.cells(), self.corners(), self.edges())
    }
}

impl Grid {
    /// A grid of tables that count from 0.
    fn connected(
        py: Python,
        center: [RealArray; 2],
        corner: [RealArray; 2],
        corner_cell: IndexArray,
        of: Connectivity,
    ) -> PyResult<Self> {
        let cells = of.cell_corner_count.len();
        let count = of.cell_corner_count.into_pyarray(py);
        GridArrays {
            center,
            corner,
            cell_corner: made_indices(py, of.cell_corner, of.cell_corner_row),
            cell_corner_count: Some(IndexArray::new(&read_only(count), &[cells], "cell_corner_count")?),
            corner_cell,
            corner_edge: made_indices(py, of.corner_edge, 3),
            edge_corner: made_indices(py, of.edge_corner, 2),
            index_base: 0,
        }
        .grid(py)
    }
}

impl GridArrays {
    /// Checks the tables.
    fn grid(self, py: Python) -> PyResult<Grid> {
        // SAFETY: the tables live as long as the grid, whose documentation asks that they do not change.
        let tables = unsafe {
            GridTables {
                index_base: self.index_base,
                center: lon_lat(&self.center),
                corner: lon_lat(&self.corner),
                cell_corner: self.cell_corner.indices(py),
                cell_corner_row: self.cell_corner.shape[1],
                cell_corner_count: self.cell_corner_count.as_ref().map(|count| count.indices(py)),
                corner_cell: self.corner_cell.indices(py),
                corner_edge: self.corner_edge.indices(py),
                edge_corner: self.edge_corner.indices(py),
            }
        };
        let inner = py.detach(|| with_threads(|| icoray::Grid::new(tables))).map_err(raised)?;
        let reals = self.center.iter().chain(&self.corner).map(|array| array.bytes_copied);
        let tables = [&self.cell_corner, &self.corner_cell, &self.corner_edge, &self.edge_corner];
        let tables = tables.into_iter().chain(&self.cell_corner_count).map(|table| table.bytes_copied);
        let [lon_center_rad, lat_center_rad] = self.center.each_ref().map(|array| array.owner(py).unbind());
        let [lon_corner_rad, lat_corner_rad] = self.corner.each_ref().map(|array| array.owner(py).unbind());
        let owner = |table: &IndexArray| table.owner(py).unbind();
        Ok(Grid {
            inner: Arc::new(inner),
            bytes_copied: reals.chain(tables).sum(),
            index_base: self.index_base,
            lon_center_rad,
            lat_center_rad,
            lon_corner_rad,
            lat_corner_rad,
            cell_corner: owner(&self.cell_corner),
            cell_corner_count: self.cell_corner_count.as_ref().map(owner),
            corner_cell: owner(&self.corner_cell),
            corner_edge: owner(&self.corner_edge),
            edge_corner: owner(&self.edge_corner),
        })
    }
}

/// Longitudes and latitudes of as many cells or corners, `count` of them or, if that is 0, any number.
fn positions(lon: &Bound<PyAny>, lat: &Bound<PyAny>, of: &str, count: usize) -> PyResult<[RealArray; 2]> {
    let lon = RealArray::packed(lon, &[count], &format!("lon_{of}_rad"))?;
    let lat = RealArray::packed(lat, &[lon.dimensions[0].extent], &format!("lat_{of}_rad"))?;
    Ok([lon, lat])
}

/// # Safety
/// As [`RealArray::reals`].
unsafe fn lon_lat([lon, lat]: &[RealArray; 2]) -> LonLat<'static> {
    // SAFETY: passed on.
    unsafe { LonLat { lon_rad: lon.reals().0, lat_rad: lat.reals().0 } }
}

/// Does work on threads of its own, which end with it: those of a library would not survive a fork.
fn with_threads<R: Send>(work: impl FnOnce() -> icoray::Result<R> + Send) -> icoray::Result<R> {
    Error::of_panics(|| Renderer::new(0)?.run(work))
}

/// A read-only array of ours.
fn read_only<T: numpy::Element, D: numpy::ndarray::Dimension>(array: Bound<numpy::PyArray<T, D>>) -> Bound<PyAny> {
    array.readwrite().make_nonwriteable();
    array.into_any()
}

fn made_reals(py: Python, values: Vec<f64>) -> RealArray {
    let array = read_only(PyArray1::from_vec(py, values));
    RealArray::new(&array, "angles").expect("an array of doubles")
}

fn made_indices(py: Python, table: Vec<i32>, row: usize) -> IndexArray {
    let rows = table.len() / row;
    let array = PyArray1::from_vec(py, table).reshape([rows, row]).expect("whole rows");
    IndexArray::new(&read_only(array), &[rows, row], "table").expect("a table of 32-bit numbers")
}

/// A table as Rust's 32-bit numbers from 0.
fn numbers_from_zero(table: Indices, index_base: i32) -> PyResult<Vec<i32>> {
    let narrow = |(at, number): (usize, i64)| {
        i32::try_from(number.saturating_sub(i64::from(index_base))).map_err(|_| {
            let (row, column) = (at / 3, at % 3);
            let message = format!("corner_cell[{row}][{column}]: {number}, expected a number of 32 bits");
            raised(Error::new(ErrorKind::Grid, message))
        })
    };
    table.iter().enumerate().map(narrow).collect()
}

/// Longitudes and latitudes of the centres of the triangles' circumscribed circles.
fn circumcentres(center: [icoray::Reals; 2], corner_cell: &[i32]) -> [Vec<f64>; 2] {
    let unit = |cell: i32| {
        let [(sin_lon, cos_lon), (sin_lat, cos_lat)] = center.map(|angle| angle.get(cell as usize).sin_cos());
        [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat]
    };
    let place = |triangle: &[i32]| {
        let [x, y, z] = circumcenter([triangle[0], triangle[1], triangle[2]].map(unit));
        (y.atan2(x), z.atan2(x.hypot(y)))
    };
    let (lon, lat) = corner_cell.chunks_exact(3).map(place).unzip();
    [lon, lat]
}
