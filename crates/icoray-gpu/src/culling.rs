//! View-frustum culling: the cells whose columns the rays of a picture can read. The set is conservative, so that the
//! picture does not depend on it, and finding it is much faster than uploading the other columns.

use crate::context::Context;
use crate::pool::PooledBuffer;
use glam::DVec3;
use icoray::Grid;
use icoray::device::{FallbackReason, Job, Rect};
use icoray_grid::visible_cells::VisibleCells;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::BufferUsages;

/// Size of a field in bytes above which its cells are culled.
const LARGE: usize = 4 << 20;
/// Number of views of a grid whose cells are cached.
const CACHED_VIEWS: usize = 8;

#[derive(Debug)]
pub(crate) struct CellSet {
    /// Unique in the process.
    pub id: u64,
    /// The cells in rising order.
    pub list: Vec<u32>,
    /// Binding 10: for each cell of the grid its index in `list`. `None` if the set has all cells.
    pub places: Option<PooledBuffer>,
}

impl CellSet {
    fn all(cells: usize) -> Self {
        Self::new((0..cells as u32).collect(), None)
    }

    fn new(list: Vec<u32>, places: Option<PooledBuffer>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        CellSet { id: NEXT.fetch_add(1, Ordering::Relaxed), list, places }
    }

    /// Bytes of `places`.
    pub fn bytes(&self) -> u64 {
        self.places.as_ref().map_or(0, |places| places.size())
    }
}

/// The volume that the rays of a picture or of some of its tiles pass, and the other conditions for the cells that they
/// read.
#[derive(Debug, Clone, PartialEq)]
struct ViewFrustum {
    eye: DVec3,
    /// Inward normals of the four planes through the eye that enclose all rays.
    sides: [DVec3; 4],
    /// Radii of the lowest and the highest layer.
    shell: [f64; 2],
    has_core: bool,
    /// Whether gradients are computed, which read the columns around.
    is_lit: bool,
}

impl ViewFrustum {
    /// The frustum of a half-open range of pixel columns and one of pixel rows.
    fn new(job: &Job, [across, down]: [Range<u32>; 2]) -> Self {
        let scene = job.scene();
        let ([forward, right, up], half_height) = scene.camera.frame();
        let [eye, forward, right, up] = [scene.camera.eye(), forward, right, up].map(DVec3::from_array);
        let pixel = 2.0 * half_height / f64::from(scene.height);
        let place = |pixels: u32, side: u32| pixel * (f64::from(pixels) - 0.5 * f64::from(side));
        let [left, right_end] = [across.start, across.end].map(|x| place(x, scene.width));
        let [top, bottom] = [down.start, down.end].map(|y| -place(y, scene.height));
        let sides = [right - left * forward, right_end * forward - right, top * forward - up, up - bottom * forward];
        ViewFrustum {
            eye,
            sides: sides.map(DVec3::normalize),
            shell: job.extent(),
            has_core: scene.core.is_some(),
            is_lit: job.shading().is_some(),
        }
    }

    /// The cells of triangles that rays can pass between the lowest and the highest layer, up to an opaque core.
    fn cells(&self, grid: &Grid) -> Vec<u32> {
        let seen = VisibleCells::new(grid, self.eye, self.sides, self.shell, self.has_core);
        let is_visible = |cell: &u32| seen.contains(grid.direction(*cell));
        let cells = 0..grid.cells() as u32;
        if !self.is_lit {
            return cells.into_par_iter().filter(is_visible).collect();
        }
        let is_visible: Vec<bool> = cells.clone().into_par_iter().map(|cell| is_visible(&cell)).collect();
        let mut is_read = is_visible.clone();
        for triangle in (0..grid.triangles() as u32).filter(|triangle| grid.is_triangle(*triangle)) {
            let around = grid.triangle(triangle).map(|cell| cell as usize);
            if around.iter().any(|cell| is_visible[*cell]) {
                around.iter().for_each(|cell| is_read[*cell] = true);
            }
        }
        cells.filter(|cell| is_read[*cell as usize]).collect()
    }
}

/// Culls the cells of a grid, and caches the sets of the last views; the key `None` is the set of all cells.
#[derive(Debug, Default)]
pub(crate) struct Culling(Mutex<Vec<(Option<ViewFrustum>, Arc<CellSet>)>>);

impl Culling {
    fn cached(&self) -> MutexGuard<'_, Vec<(Option<ViewFrustum>, Arc<CellSet>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The cells whose columns the rays of a picture can read with any of its tiles, and the number of bytes uploaded
    /// for them. A small field that `fits_a_page` is not culled.
    pub fn of_picture(
        &self,
        ctx: &Context,
        job: &Job,
        fits_a_page: bool,
    ) -> Result<(Arc<CellSet>, u64), FallbackReason> {
        let (columns, layers, _) = job.order();
        let is_large = columns * layers * size_of::<f32>() > LARGE || !fits_a_page;
        let view = is_large.then(|| ViewFrustum::new(job, [0..job.scene().width, 0..job.scene().height]));
        if let Some((_, cells)) = self.cached().iter().find(|(other, _)| *other == view) {
            return Ok((Arc::clone(cells), 0));
        }
        let cells = Arc::new(match &view {
            Some(view) => Self::of_view(ctx, job, view)?,
            None => CellSet::all(columns),
        });
        let mut cached = self.cached();
        if cached.len() >= CACHED_VIEWS {
            cached.remove(0);
        }
        cached.push((view, Arc::clone(&cells)));
        Ok((Arc::clone(&cells), cells.bytes()))
    }

    /// The cells whose columns the rays of `tiles` can read.
    pub fn of_tiles(ctx: &Context, job: &Job, tiles: &[(usize, Rect)]) -> Result<CellSet, FallbackReason> {
        let (scene, step) = (job.scene(), job.quality().pixel_step);
        let end = |first: u32, count: u32, side: u32| ((first + count - 1) * step).min(side - 1) + 1;
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for (_, Rect { left, top, width, height }) in tiles {
            low = [low[0].min(*left * step), low[1].min(*top * step)];
            high = [high[0].max(end(*left, *width, scene.width)), high[1].max(end(*top, *height, scene.height))];
        }
        let [across, down] = [0, 1].map(|k| low[k].min(high[k] - 1)..high[k]);
        Self::of_view(ctx, job, &ViewFrustum::new(job, [across, down]))
    }

    fn of_view(ctx: &Context, job: &Job, view: &ViewFrustum) -> Result<CellSet, FallbackReason> {
        let grid = job.grid();
        let list = view.cells(grid);
        // If most cells are visible, saving the lookup in `places` is worth more than the memory.
        if 8 * list.len() >= 7 * grid.cells() {
            return Ok(CellSet::all(grid.cells()));
        }
        let mut places = vec![0u32; grid.cells()];
        for (place, cell) in (0..).zip(&list) {
            places[*cell as usize] = place;
        }
        Ok(CellSet::new(list, Some(ctx.pooled_data("places of columns", &places, BufferUsages::STORAGE)?)))
    }
}
