//! Grids on the device: directions of cells, and cells and neighbours of triangles, uploaded once.

use crate::context::Context;
use crate::culling::Culling;
use crate::layout::{gradient, halves};
use icoray::Grid;
use icoray::device::FallbackReason;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

#[derive(Debug)]
pub(crate) struct DeviceMesh {
    /// A triangle that exists.
    pub start: u32,
    /// Bindings 1 to 3.
    pub buffers: [wgpu::Buffer; 3],
    pub culling: Culling,
    cell_triangles: OnceLock<CellTriangles>,
}

/// The triangles with data around each cell.
#[derive(Debug)]
pub(crate) struct CellTriangles {
    /// Entries per cell.
    pub row: u32,
    /// One row per cell, filled up with [`gradient::NONE`].
    pub buffer: wgpu::Buffer,
}

/// The grids whose tables are on a device; an entry ends with its grid.
#[derive(Debug, Default)]
pub(crate) struct MeshCache(Mutex<Vec<(Weak<()>, Arc<DeviceMesh>)>>);

impl MeshCache {
    fn alive(&self) -> MutexGuard<'_, Vec<(Weak<()>, Arc<DeviceMesh>)>> {
        let mut cached = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        cached.retain(|(life, _)| life.strong_count() > 0);
        cached
    }

    /// The tables of `grid`, and the number of bytes uploaded: 0 if they were cached.
    pub fn get(&self, ctx: &Context, grid: &Grid) -> Result<(Arc<DeviceMesh>, u64), FallbackReason> {
        let life = grid.lifetime_token();
        let found = self.alive().iter().find(|(known, _)| known.ptr_eq(&life)).cloned();
        if let Some((_, mesh)) = found {
            return Ok((mesh, 0));
        }
        let mesh = Arc::new(DeviceMesh::upload(ctx, grid)?);
        let bytes = mesh.buffers.iter().map(wgpu::Buffer::size).sum();
        self.alive().push((life, Arc::clone(&mesh)));
        Ok((mesh, bytes))
    }
}

impl DeviceMesh {
    fn upload(ctx: &Context, grid: &Grid) -> Result<Self, FallbackReason> {
        let split = |direction: &[f64; 3]| {
            let [x, y, z] = direction.map(halves);
            [x[0], y[0], z[0], x[1], y[1], z[1]]
        };
        let directions: Vec<[f32; 6]> = grid.directions().iter().map(split).collect();
        let all = (grid.triangles() + grid.void_triangles()) as u32;
        let cells: Vec<[u32; 3]> = (0..all).into_par_iter().map(|triangle| grid.triangle(triangle)).collect();
        let across = |triangle: u32| [0, 1, 2].map(|k| grid.across(triangle, k));
        let beyond: Vec<[u32; 3]> = (0..all).into_par_iter().map(across).collect();
        let buffers = [
            ctx.storage("directions of cells", &directions)?,
            ctx.storage("cells of triangles", &cells)?,
            ctx.storage("neighbours of triangles", &beyond)?,
        ];
        Ok(DeviceMesh {
            start: grid.nearest_valid_triangle(0),
            buffers,
            culling: Culling::default(),
            cell_triangles: OnceLock::new(),
        })
    }

    /// The triangles around each cell of `grid`, and the number of bytes uploaded: 0 if they were on the device.
    pub fn cell_triangles(&self, ctx: &Context, grid: &Grid) -> Result<(&CellTriangles, u64), FallbackReason> {
        if let Some(known) = self.cell_triangles.get() {
            return Ok((known, 0));
        }
        let cells = grid.cells() as u32;
        let row = (0..cells).into_par_iter().map(|cell| grid.triangles_around(cell).count()).max().unwrap_or(0).max(1);
        let mut rows = vec![gradient::NONE; grid.cells() * row];
        rows.par_chunks_exact_mut(row).zip(0..cells).for_each(|(places, cell)| {
            places.iter_mut().zip(grid.triangles_around(cell)).for_each(|(place, triangle)| *place = triangle);
        });
        let buffer = ctx.storage("triangles around cells", &rows)?;
        let bytes = buffer.size();
        // The thread of another picture may have set it meanwhile.
        Ok((self.cell_triangles.get_or_init(|| CellTriangles { row: row as u32, buffer }), bytes))
    }
}
