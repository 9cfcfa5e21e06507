//! A topology of the host as a grid of the context, kept as long as topology and coordinates stay.

use crate::blueprint::Geometry;
use crate::columns::Columns;
use crate::context::{Context, error};
use crate::order::Layout;
use crate::peers::Peers;
use crate::surface::{OwnedRows, Piece, Placement, Surface, direction_of, directions};
use glam::DVec3;
use icoray::{Error, Grid, GridTables, Result, Shape};
use icoray_context::bindings::PartInput;
use icoray_context::types::{ICORAY_CENTER, ICORAY_CORNER, ICORAY_F32, ICORAY_F64, icoray_array};
use icoray_dataset::Mesh;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ffi::CString;
use std::sync::Arc;
use xxhash_rust::xxh3::Xxh3;

/// A grid that the context has, or two where values at points need one of their own, with what fields on it need.
pub struct HostGrid {
    fingerprint: Fingerprint,
    pub points: HostColumns,
    pub elements: HostColumns,
    /// Unit vectors of the columns of points.
    directions: Vec<[f64; 3]>,
    /// The columns of points around each column of elements, where there are two grids.
    polygons: Vec<Vec<u32>>,
    /// Heights of points and, where there are two grids, those midway between for elements, column by column, if the
    /// scene may need them; read by the context.
    heights: Option<[Vec<f64>; 2]>,
}

/// Columns of points or of elements as those of a grid of the context.
pub struct HostColumns {
    /// Where the host's values are.
    pub layout: Layout,
    /// The name of grid and layers.
    grid: CString,
    is_at_corners: bool,
    /// Rows of this rank's columns in the grid; at points none if it owns none.
    rows: OwnedRows,
}

/// The tables of the grids that the context has, which it reads until it has another one of that name.
#[derive(Default)]
pub struct HostMeshes([Option<Box<Mesh>>; 2]);

/// Inputs of a grid.
pub struct Setting<'a> {
    /// The name of the grid and its layers.
    pub name: &'a str,
    pub planet_radius: Option<f64>,
    pub context: &'a Context,
    pub peers: &'a mut Peers,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Fingerprint {
    topology: u128,
    coordinates: u128,
}

/// The change of a rank's mesh since the last call.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum Change {
    None,
    /// Points have moved up or down.
    Radii,
    All,
}

/// Sums over own columns, of which all ranks make the layers' radii.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Radii {
    sum: Vec<f64>,
    columns: usize,
}

/// How far columns move, radians, before they are others: hosts have places in 32 bits.
const SAME: f64 = 1e-6;
/// Thickness of the shell above a single layer of points, in its radii: a context has two layers or more.
const THICKNESS: f64 = 1e-3;

impl HostGrid {
    /// Brings the context's grid up to date with what the host has now: its geometry, or `None` on a rank without any.
    /// Collective; all fail where one does.
    pub fn update(
        grid: Option<Self>,
        geometry: Result<Option<Geometry>>,
        tables: &mut HostMeshes,
        setting: &mut Setting,
    ) -> Result<Self> {
        let seen = Error::of_panics(|| {
            let geometry = geometry?;
            let fingerprint = geometry.as_ref().map(fingerprint).unwrap_or_default();
            let change = grid.as_ref().map_or(Change::All, |grid| grid.change(fingerprint, geometry.as_ref()));
            Ok((geometry, fingerprint, change))
        });
        let (change, seen) = match seen {
            Ok((geometry, fingerprint, change)) => (Ok(change), Some((geometry, fingerprint))),
            Err(error) => (Err(error), None),
        };
        let change = setting.peers.share_all(change)?.into_iter().max().unwrap_or(Change::All);
        let (geometry, fingerprint) = seen.unwrap_or_default();
        let mut grid = match grid {
            Some(grid) if change != Change::All => grid,
            _ => Self::made(geometry.as_ref(), fingerprint, tables, setting)?,
        };
        grid.fingerprint = fingerprint;
        if change > Change::None {
            grid.set_radii(geometry.as_ref(), setting)?;
        }
        Ok(grid)
    }

    fn change(&self, now: Fingerprint, geometry: Option<&Geometry>) -> Change {
        if now == self.fingerprint {
            return Change::None;
        }
        let is_same = |geometry: &Geometry| {
            let layout = &self.points.layout;
            now.topology == self.fingerprint.topology
                && geometry.points[0].len() == layout.elements
                && self.directions.iter().enumerate().all(|(column, known)| {
                    let points: Vec<u32> = (0..layout.layers).map(|level| layout.at(column, level)).collect();
                    let place = |point| geometry.point(point);
                    let is_rising = points.windows(2).all(|pair| place(pair[0]).length() <= place(pair[1]).length());
                    let direction = direction_of(&points, place);
                    is_rising
                        && direction.is_ok_and(|found| (found - DVec3::from_array(*known)).abs().max_element() < SAME)
                })
        };
        if geometry.is_some_and(is_same) { Change::Radii } else { Change::All }
    }

    /// A grid of the columns of all ranks. Collective.
    fn made(
        geometry: Option<&Geometry>,
        fingerprint: Fingerprint,
        tables: &mut HostMeshes,
        Setting { name, context, peers, .. }: &mut Setting,
    ) -> Result<Self> {
        let found = Error::of_panics(|| match geometry {
            Some(geometry) => found(geometry).map_err(|e| e.within(*name)),
            None => Ok((Columns::default(), Piece::default())),
        });
        let (columns, piece) = match found {
            Ok((columns, piece)) => (Some(columns), Ok(piece)),
            Err(error) => (None, Err(error)),
        };
        let mut pieces = peers.share_all(piece)?;
        let columns = columns.unwrap_or_default();
        let [levels, layers] = common_sizes(&pieces)?;
        let rank = peers.rank();
        let Surface { meshes, points, elements } = peers.agree(|| Surface::of(&pieces, rank, name))?;
        let Piece { directions, mut polygons, .. } = pieces.swap_remove(rank);
        drop(pieces);
        if meshes.len() == 1 {
            polygons.clear();
        }
        for (number, mesh) in meshes.into_iter().enumerate() {
            let grid = name_of(number, name);
            peers.share_all(tables.set(number, mesh, &grid, context))?;
            if peers.size() > 1 {
                let none = OwnedRows::default();
                let rows = |is_at_corners| {
                    let mut placements = [&points, &elements].into_iter();
                    let found = placements.find(|at| at.mesh == number && at.is_at_corners == is_at_corners);
                    found.map_or(&none, |at| &at.rows)
                };
                let (cells, corners) = (rows(false), rows(true));
                let part = PartInput { grid: &grid, cells: cells.as_cells(), corners: corners.as_corners() };
                context.set_part(Some(part)).map_err(error)?;
            }
        }
        let [of_points, of_elements] =
            geometry.map_or([0, 0], |geometry| [geometry.points[0].len(), geometry.elements.len()]);
        Ok(HostGrid {
            fingerprint,
            points: HostColumns::new(points, name, Layout::of(columns.points, levels, of_points)),
            elements: HostColumns::new(elements, name, Layout::of(columns.elements, layers, of_elements)),
            directions,
            polygons,
            heights: None,
        })
    }

    /// Sets the layers' radii and finds the heights of points. Collective.
    fn set_radii(&mut self, geometry: Option<&Geometry>, setting: &mut Setting) -> Result<()> {
        let Setting { planet_radius, context, peers, .. } = setting;
        let levels = self.points.layout.layers;
        let at = |column: usize, level: usize| {
            geometry.map_or(0.0, |geometry| geometry.point(self.points.layout.at(column, level)).length())
        };
        let is_owned = &self.points.rows.is_owned;
        let own: Vec<usize> = (0..is_owned.len()).filter(|&column| is_owned[column] != 0).collect();
        let all = peers.share_all(Error::of_panics(|| Ok(Radii::of(&own, levels, at))))?;
        let columns: usize = all.iter().map(|radii| radii.columns).sum();
        let mean = |level: usize| all.iter().map(|radii| radii.sum[level]).sum::<f64>() / columns as f64;
        let mut radii: Vec<f64> = (0..levels).map(mean).collect();
        let planet_radius = planet_radius.unwrap_or(radii[0]);
        let set = Error::of_panics(|| {
            let needs_heights = levels > 1 && context.may_need_heights();
            let heights = needs_heights.then(|| self.heights_above(planet_radius, at));
            if levels == 1 {
                radii.push(radii[0] * (1.0 + THICKNESS));
            }
            for grid in BTreeSet::from([&self.points.grid, &self.elements.grid]) {
                context.set_layers(&grid.to_string_lossy(), &radii, planet_radius).map_err(error)?;
            }
            Ok(heights)
        });
        self.heights = peers.agree(|| set)?;
        Ok(())
    }

    /// Heights of points and, where there are two grids, at elements: the means of the points around.
    fn heights_above(&self, planet_radius: f64, radius: impl Fn(usize, usize) -> f64) -> [Vec<f64>; 2] {
        let levels = self.points.layout.layers;
        let height = |i: usize| radius(i / levels, i % levels) - planet_radius;
        let at_elements = |polygon: &Vec<u32>| {
            let mean = |level: usize| {
                let sum: f64 = polygon.iter().map(|column| radius(*column as usize, level)).sum();
                sum / polygon.len() as f64 - planet_radius
            };
            (0..levels).map(mean).collect::<Vec<_>>()
        };
        let at_points = (0..self.points.rows.row.len() * levels).map(height).collect();
        [at_points, self.polygons.iter().flat_map(at_elements).collect()]
    }

    /// Columns of points or of elements.
    pub fn columns_of(&self, is_at_elements: bool) -> &HostColumns {
        if is_at_elements { &self.elements } else { &self.points }
    }

    /// The heights of layers for values at points or at elements, if the scene may need them.
    pub fn heights(&self, is_at_elements: bool) -> Option<icoray_array> {
        let [at_points, at_elements] = self.heights.as_ref()?;
        let has_own = is_at_elements && self.elements.grid != self.points.grid;
        let (columns, heights) = if has_own { (&self.elements, at_elements) } else { (&self.points, at_points) };
        let layers = self.points.layout.layers;
        let shape = Shape::level_fastest(columns.layout.columns, layers);
        let values = columns.values(true, heights.as_ptr().cast(), &shape);
        Some(icoray_array { layers: layers as i64, ..values })
    }
}

impl HostColumns {
    /// The columns of a mesh of the grid `name`.
    fn new(Placement { mesh, is_at_corners, rows }: Placement, name: &str, layout: Layout) -> Self {
        HostColumns {
            layout,
            grid: CString::new(name_of(mesh, name).replace('\0', "?")).unwrap_or_default(),
            is_at_corners,
            rows,
        }
    }

    /// Values of these columns, which borrow the name of grid and layers, with the strides of `shape` from `first`.
    pub fn values(&self, is_f64: bool, first: *const u8, shape: &Shape) -> icoray_array {
        icoray_array {
            struct_size: size_of::<icoray_array>(),
            data: first.cast(),
            r#type: if is_f64 { ICORAY_F64 } else { ICORAY_F32 },
            location: if self.is_at_corners { ICORAY_CORNER } else { ICORAY_CENTER },
            columns: self.rows.row.len() as i64,
            layers: self.layout.layers as i64,
            column_stride: shape.column_stride as i64,
            layer_stride: shape.layer_stride as i64,
            block: shape.block as i64,
            block_stride: shape.block_stride as i64,
            grid_name: self.grid.as_ptr(),
            layers_name: self.grid.as_ptr(),
            ..Default::default()
        }
    }
}

fn name_of(mesh: usize, name: &str) -> String {
    if mesh == 0 { name.to_owned() } else { format!("{name} at points") }
}

/// Numbers of points and of elements in a column, the same on all ranks with elements.
fn common_sizes(pieces: &[Piece]) -> Result<[usize; 2]> {
    let mut sizes = pieces.iter().filter(|piece| piece.levels != 0).map(|piece| [piece.levels, piece.layers]);
    let first = sizes.next().ok_or_else(|| Error::grid("no elements on any rank"))?;
    match sizes.find(|size| *size != first) {
        None => Ok(first),
        Some([levels, layers]) => Err(Error::grid(format!(
            "columns of {levels} points and {layers} elements, and of {} and {}, expected as many on all ranks",
            first[0], first[1]
        ))),
    }
}

impl HostMeshes {
    /// Whether the context has a grid of this name.
    pub fn are_set(&self) -> bool {
        self.0[0].is_some()
    }

    /// Gives the context a grid of these tables, the first or second of a topology.
    fn set(&mut self, number: usize, mesh: Mesh, name: &str, context: &Context) -> Result<()> {
        let mesh = Box::new(mesh);
        // SAFETY: the tables lie on the heap, and stay until the context has another grid of this name or is closed.
        let tables = unsafe { std::mem::transmute::<GridTables<'_>, GridTables<'static>>(mesh.tables()) };
        context.set_grid(name, Arc::new(Grid::new(tables)?)).map_err(error)?;
        self.0[number] = Some(mesh);
        Ok(())
    }
}

impl Radii {
    fn of(columns: &[usize], levels: usize, at: impl Fn(usize, usize) -> f64) -> Self {
        let sum_of = |level| columns.iter().map(|column| at(*column, level)).sum();
        Radii { sum: (0..levels).map(sum_of).collect(), columns: columns.len() }
    }
}

fn found(geometry: &Geometry) -> Result<(Columns, Piece)> {
    let place = |point| geometry.point(point);
    let mut columns = Columns::find(&geometry.elements, place)?;
    let directions = directions(&columns, place)?;
    let polygons = std::mem::take(&mut columns.polygons);
    let piece = Piece { levels: columns.levels, layers: columns.layers, directions, polygons };
    Ok((columns, piece))
}

fn fingerprint(geometry: &Geometry) -> Fingerprint {
    let (mut topology, mut coordinates) = (Xxh3::new(), Xxh3::new());
    geometry.elements.hash(&mut topology);
    geometry.points.iter().for_each(|axis| axis.hash(&mut coordinates));
    Fingerprint { topology: topology.digest128(), coordinates: coordinates.digest128() }
}
