//! A grid on the device: its tables as they are, in 32 bits, uploaded once.

use crate::gpu::{Gpu, Reason};
use crate::layout::halves;
use icoray::device::Tables;
use icoray::{Grid, Indices};
use std::borrow::Cow;

/// A grid whose tables are on a device.
#[derive(Debug)]
pub struct Mesh<'g> {
    pub(crate) grid: &'g Grid<'g>,
    pub(crate) start: u32,
    pub(crate) rim_sides: u32,
    /// Bindings 1 to 7.
    pub(crate) buffers: [wgpu::Buffer; 7],
}

impl Gpu {
    /// Uploads the tables of `grid`.
    ///
    /// # Errors
    /// A [`Reason`] where the device has no room for them.
    pub fn mesh<'g>(&self, grid: &'g Grid<'g>) -> Result<Mesh<'g>, Reason> {
        let tables = Tables::of(grid);
        let split = |direction: &[f64; 3]| {
            let [x, y, z] = direction.map(halves);
            [x[0], y[0], z[0], x[1], y[1], z[1]]
        };
        let directions: Vec<[f32; 6]> = tables.directions.iter().map(split).collect();
        let mut seats = tables.seats;
        seats.resize(seats.len().next_multiple_of(4), 0);
        let given = grid.tables();
        let buffers = [
            self.upload("directions of cells", &directions)?,
            self.upload("table corner_cell", &narrow(&given.corner_cell))?,
            self.upload("table corner_edge", &narrow(&given.corner_edge))?,
            self.upload("table edge_corner", &narrow(&given.edge_corner))?,
            self.upload("seats of triangles", &seats)?,
            self.upload("void triangles", &tables.void)?,
            self.upload("sides of rims", &tables.rim)?,
        ];
        Ok(Mesh { grid, start: tables.start, rim_sides: tables.rim.len() as u32, buffers })
    }
}

/// The table in 32 bits. The grid's check found numbers that mean something within them; a mark of what is missing is never
/// followed, so that it may become any.
fn narrow<'t>(table: &Indices<'t>) -> Cow<'t, [i32]> {
    match table {
        Indices::I32(rows) => Cow::Borrowed(rows),
        Indices::I64(rows) => rows.iter().map(|&n| n as i32).collect(),
    }
}
