//! A topology of the host as a grid of the context, kept as long as topology and coordinates stay.

use crate::blueprint::Geometry;
use crate::columns::Columns;
use crate::context::{ColumnValues, Context};
use crate::order::Layout;
use crate::peers::Peers;
use crate::strides::Strides;
use crate::surface::{OwnedRows, Piece, Surface, direction_of, directions};
use glam::DVec3;
use icoray::{Error, Grid, GridTables, Result};
use icoray_dataset::Mesh;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use xxhash_rust::xxh3::Xxh3;

/// A grid that the context has, with what fields on it need.
pub struct HostGrid {
    fingerprint: Fingerprint,
    /// Where the host's points and elements are.
    pub points: Layout,
    pub elements: Layout,
    /// Unit vectors of the columns of points.
    directions: Vec<[f64; 3]>,
    nodes: OwnedRows,
    /// This rank's columns at points and at elements; 0 at points if it owns none.
    pub columns: [usize; 2],
    /// Whether elements are triangles, so that fields at points are at cells' centres.
    pub has_triangles: bool,
    /// Heights of points, column by column, if the scene may need them; read by the context.
    heights: Option<Vec<f64>>,
}

/// The tables of a grid that the context has, which it reads until it has another one of that name.
#[derive(Default)]
pub struct HostMesh(Option<Box<Mesh>>);

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

impl HostGrid {
    /// Brings the context's grid up to date with what the host has now: its geometry, or `None` on a rank without any.
    /// Collective.
    ///
    /// # Errors
    /// The failure of any rank, the same on all.
    pub fn update(
        grid: Option<Self>,
        geometry: Result<Option<Geometry>>,
        tables: &mut HostMesh,
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
            now.topology == self.fingerprint.topology
                && geometry.points[0].len() == self.points.elements
                && self.directions.iter().enumerate().all(|(column, known)| {
                    let points: Vec<u32> = (0..self.points.layers).map(|level| self.points.at(column, level)).collect();
                    let direction = direction_of(&points, |point| geometry.point(point));
                    direction.is_ok_and(|direction| (direction - DVec3::from_array(*known)).abs().max_element() < SAME)
                })
        };
        if geometry.is_some_and(is_same) { Change::Radii } else { Change::All }
    }

    /// A grid of the columns of all ranks. Collective.
    fn made(
        geometry: Option<&Geometry>,
        fingerprint: Fingerprint,
        tables: &mut HostMesh,
        Setting { name, context, peers, .. }: &mut Setting,
    ) -> Result<Self> {
        let found = Error::of_panics(|| match geometry {
            Some(geometry) => found(geometry),
            None => Ok((Columns::default(), Piece::default())),
        });
        let (columns, piece) = match found {
            Ok((columns, piece)) => (Some(columns), Ok(piece)),
            Err(error) => (None, Err(error)),
        };
        let directions = piece.as_ref().map_or_else(|_| Vec::new(), |piece| piece.directions.clone());
        let pieces = peers.share_all(piece)?;
        let columns = columns.unwrap_or_default();
        let levels = pieces.iter().map(|piece| piece.levels).max().unwrap_or(0);
        if let Some(other) = pieces.iter().find(|piece| piece.levels != 0 && piece.levels != levels) {
            return Err(Error::grid(format!(
                "columns of {} and of {levels} points, expected as many on all ranks",
                other.levels
            )));
        }
        if levels == 0 {
            return Err(Error::grid("no elements on any rank"));
        }
        let rank = peers.rank();
        let Surface { mesh, nodes, faces, has_triangles } = peers.agree(|| Surface::of(&pieces, rank, name))?;
        drop(pieces);
        peers.share_all(tables.set(mesh, name, context))?;
        if peers.size() > 1 {
            let (cells, corners) = if has_triangles { (&nodes, &faces) } else { (&faces, &nodes) };
            context.set_part(name, cells, corners)?;
        }
        let [points, elements] =
            geometry.map_or([0, 0], |geometry| [geometry.points[0].len(), geometry.elements.len()]);
        let own = [nodes.row.len(), faces.row.len()];
        Ok(HostGrid {
            fingerprint,
            points: Layout::of(columns.points, levels, points),
            elements: Layout::of(columns.elements, levels - 1, elements),
            directions,
            columns: own,
            has_triangles,
            nodes,
            heights: None,
        })
    }

    /// Sets the layers' radii and finds the heights of points. Collective.
    fn set_radii(&mut self, geometry: Option<&Geometry>, setting: &mut Setting) -> Result<()> {
        let Setting { name, planet_radius, context, peers } = setting;
        let levels = self.points.layers;
        let at = |column: usize, level: usize| {
            geometry.map_or(0.0, |geometry| geometry.point(self.points.at(column, level)).length())
        };
        let own: Vec<usize> = (0..self.columns[0]).filter(|&column| self.nodes.is_owned[column] != 0).collect();
        let all = peers.share_all(Error::of_panics(|| Ok(Radii::of(&own, levels, at))))?;
        let columns: usize = all.iter().map(|radii| radii.columns).sum();
        let mean = |level: usize| all.iter().map(|radii| radii.sum[level]).sum::<f64>() / columns as f64;
        let radii: Vec<f64> = (0..levels).map(mean).collect();
        let planet_radius = planet_radius.unwrap_or(radii[0]);
        let set = Error::of_panics(|| {
            let height = |i: usize| at(i / levels, i % levels) - planet_radius;
            let heights = context.may_need_heights().then(|| (0..self.columns[0] * levels).map(height).collect());
            context.set_layers(name, &radii, planet_radius)?;
            Ok(heights)
        });
        self.heights = peers.agree(|| set)?;
        Ok(())
    }

    /// The heights of layers, if the scene may need them.
    pub fn heights<'a>(&self, grid: &'a str) -> Option<ColumnValues<'a>> {
        let heights = self.heights.as_ref()?;
        Some(ColumnValues {
            data: heights.as_ptr().cast(),
            is_f64: true,
            is_at_corners: !self.has_triangles,
            columns: self.columns[0],
            layers: self.points.layers,
            strides: Strides::by_column(self.points.layers),
            grid,
        })
    }
}

impl HostMesh {
    /// Whether the context has a grid of this name.
    pub fn are_set(&self) -> bool {
        self.0.is_some()
    }

    /// Gives the context a grid of these tables.
    fn set(&mut self, mesh: Mesh, name: &str, context: &Context) -> Result<()> {
        let mesh = Box::new(mesh);
        // SAFETY: the tables lie on the heap, and stay until the context has another grid of this name or is closed.
        let tables = unsafe { std::mem::transmute::<GridTables<'_>, GridTables<'static>>(mesh.tables()) };
        context.set_grid(name, Arc::new(Grid::new(tables)?))?;
        self.0 = Some(mesh);
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
    let piece = Piece { levels: columns.levels, directions, polygons };
    Ok((columns, piece))
}

fn fingerprint(geometry: &Geometry) -> Fingerprint {
    let (mut topology, mut coordinates) = (Xxh3::new(), Xxh3::new());
    geometry.elements.hash(&mut topology);
    geometry.points.iter().for_each(|axis| axis.hash(&mut coordinates));
    Fingerprint { topology: topology.digest128(), coordinates: coordinates.digest128() }
}
