//! A grid on the device: its tables as they are, in 32 bits, uploaded once.

use crate::gpu::Gpu;
use crate::gradient::Corners;
use crate::layout::halves;
use crate::select::{Reach, Views};
use icoray::device::{Reason, Tables};
use icoray::{Grid, Indices};
use std::borrow::Cow;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

/// A grid's tables on a device.
#[derive(Debug)]
pub(crate) struct Mesh {
    pub start: u32,
    pub rim_sides: u32,
    /// Bindings 1 to 7.
    pub buffers: [wgpu::Buffer; 7],
    /// Of grids that a lit scene is drawn of.
    pub corners: OnceLock<Corners>,
    pub reach: Reach,
    pub views: Views,
}

/// The grids whose tables are on a device, as long as they live.
#[derive(Debug, Default)]
pub(crate) struct Meshes(Mutex<Vec<(Weak<()>, Arc<Mesh>)>>);

impl Meshes {
    fn known(&self) -> MutexGuard<'_, Vec<(Weak<()>, Arc<Mesh>)>> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|(life, _)| life.strong_count() > 0);
        known
    }
}

impl Gpu {
    /// The tables of `grid`, and how many bytes were uploaded for it: none where they are there.
    pub(crate) fn mesh(&self, grid: &Grid) -> Result<(Arc<Mesh>, u64), Reason> {
        let life = grid.life();
        let found = self.meshes.known().iter().find(|(known, _)| known.ptr_eq(&life)).cloned();
        if let Some((_, mesh)) = found {
            return Ok((mesh, 0));
        }
        let mesh = Arc::new(self.upload_mesh(grid)?);
        let bytes = mesh.buffers.iter().map(wgpu::Buffer::size).sum();
        self.meshes.known().push((life, Arc::clone(&mesh)));
        Ok((mesh, bytes))
    }

    fn upload_mesh(&self, grid: &Grid) -> Result<Mesh, Reason> {
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
        Ok(Mesh {
            start: tables.start,
            rim_sides: tables.rim.len() as u32,
            buffers,
            reach: Reach::new(grid),
            corners: OnceLock::new(),
            views: Views::default(),
        })
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
