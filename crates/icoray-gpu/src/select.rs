//! What of a field the rays of a picture can read: the columns that they may pass, and the layers between which something is to
//! be seen. Never less, so that no bit of the picture changes, and found in far less time than uploading the rest would take.

use crate::gpu::Gpu;
use crate::scene::Picture;
use crate::store::Lent;
use glam::DVec3;
use icoray::Grid;
use icoray::device::{Job, Reason, Rect, Span};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Some cells of a grid.
#[derive(Debug)]
pub(crate) struct Cells {
    /// No other cells' of the process.
    pub number: u64,
    /// In rising order.
    pub list: Vec<u32>,
    /// Binding 10: for each cell of the grid its place in the list. `None` where all cells are in it.
    pub places: Option<Lent>,
}

impl Cells {
    fn all(columns: usize) -> Self {
        Self::new((0..columns as u32).collect(), None)
    }

    fn new(list: Vec<u32>, places: Option<Lent>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Cells { number: NEXT.fetch_add(1, Ordering::Relaxed), list, places }
    }

    /// Bytes of them on the device.
    pub fn bytes(&self) -> u64 {
        self.places.as_ref().map_or(0, |places| places.size())
    }
}

/// What sees cells. A whole picture's is remembered, with its cells.
#[derive(Debug, Clone, PartialEq)]
struct View {
    eye: DVec3,
    /// Inward normals of the four planes through the eye between which all rays pass.
    sides: [DVec3; 4],
    /// Radii of the lowest and the highest layer.
    shell: [f64; 2],
    has_core: bool,
    /// Whether gradients are computed of the columns around.
    is_lit: bool,
}

impl View {
    /// That of the rays of some pixels, from the first to before the last in each direction.
    fn of(job: &Job, [across, down]: [Range<u32>; 2]) -> Self {
        let (scene, radius) = (job.scene(), job.radius());
        let ([forward, right, up], half_height) = scene.camera.frame();
        let [eye, forward, right, up] = [scene.camera.eye(), forward, right, up].map(DVec3::from_array);
        let pixel = 2.0 * half_height / f64::from(scene.height);
        let place = |pixels: u32, side: u32| pixel * (f64::from(pixels) - 0.5 * f64::from(side));
        let [left, right_end] = [across.start, across.end].map(|x| place(x, scene.width));
        let [top, bottom] = [down.start, down.end].map(|y| -place(y, scene.height));
        let sides =
            [right - left * forward, right_end * forward - right, top * forward - up, up - bottom * forward];
        View {
            eye,
            sides: sides.map(DVec3::normalize),
            shell: [radius[0], radius[radius.len() - 1]],
            has_core: scene.core.is_some(),
            is_lit: job.shading().is_some(),
        }
    }

    /// The cells of triangles that rays can pass between the lowest and the highest layer, before an opaque core ends them.
    fn cells(&self, grid: &Grid, reach: &Reach) -> Vec<u32> {
        let [inner, outer] = self.shell;
        let distance = self.eye.length();
        let towards = self.eye.normalize_or_zero();
        // Facets of the lowest layer lie below its sphere, but not farther than this. What is seen beyond the core's limb lies
        // no farther round than where a ray that touches the core there leaves the shell.
        let core = inner * reach.most.min(FRAC_PI_2).cos();
        let farthest = (core / distance).min(1.0).acos() + (core / outer).acos();
        let least = if self.has_core { farthest.cos() } else { -1.0 };
        let is_seen = |cell: &u32| {
            // A place in a triangle is within the cell's reach of the cell.
            let (direction, reach) = (grid.direction(*cell), f64::from(reach.of[*cell as usize]));
            let ends = [core, outer].map(|radius| radius * direction - self.eye);
            let is_inside = |side: &DVec3| ends.iter().any(|end| side.dot(*end) >= -outer * reach);
            direction.dot(towards) >= least - reach && self.sides.iter().all(is_inside)
        };
        let cells = 0..grid.cells() as u32;
        if !self.is_lit {
            return cells.into_par_iter().filter(is_seen).collect();
        }
        let is_seen: Vec<bool> = cells.clone().into_par_iter().map(|cell| is_seen(&cell)).collect();
        let mut is_read = is_seen.clone();
        for triangle in (0..grid.triangles() as u32).filter(|triangle| grid.is_triangle(*triangle)) {
            let around = grid.triangle(triangle).map(|cell| cell as usize);
            if around.iter().any(|cell| is_seen[*cell]) {
                around.iter().for_each(|cell| is_read[*cell] = true);
            }
        }
        cells.filter(|cell| is_read[*cell as usize]).collect()
    }
}

/// Of each cell the longest side of its triangles, as an angle or more.
#[derive(Debug)]
pub(crate) struct Reach {
    of: Vec<f32>,
    most: f64,
}

impl Reach {
    pub fn new(grid: &Grid) -> Self {
        let mut of = vec![0.0f32; grid.cells()];
        for triangle in (0..grid.triangles() as u32).filter(|triangle| grid.is_triangle(*triangle)) {
            let cells = grid.triangle(triangle);
            let [a, b, c] = cells.map(|cell| grid.direction(cell));
            let chord = (a - b).length().max((b - c).length()).max((c - a).length());
            // With more than rounding can be wrong by.
            let angle = 1.001 * 2.0 * (0.5 * chord).min(1.0).asin() + 1e-6;
            cells.iter().for_each(|cell| of[*cell as usize] = of[*cell as usize].max(angle as f32));
        }
        let most = of.iter().copied().fold(0.0, f32::max);
        Reach { of, most: f64::from(most) }
    }
}

/// Cells of the last views of a grid, and all its cells.
#[derive(Debug, Default)]
pub(crate) struct Views(Mutex<Vec<(Option<View>, Arc<Cells>)>>);

/// Views that are remembered.
const VIEWS: usize = 8;

impl Views {
    fn find(&self, view: &Option<View>) -> Option<Arc<Cells>> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.iter().find(|(other, _)| other == view).map(|(_, cells)| Arc::clone(cells))
    }

    fn put(&self, view: Option<View>, cells: &Arc<Cells>) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= VIEWS {
            known.remove(0);
        }
        known.push((view, Arc::clone(cells)));
    }
}

/// Bytes of a field from which on it pays to look for what rays read.
const LARGE: usize = 4 << 20;

impl Gpu {
    /// The cells whose columns the rays of a picture can read, whatever its tiles; and how many bytes were uploaded for that.
    pub(crate) fn cells(&self, picture: &Picture) -> Result<(Arc<Cells>, u64), Reason> {
        let Picture { job, mesh, .. } = picture;
        let (columns, layers, _) = job.order();
        let is_large = columns * layers * size_of::<f32>() > LARGE || !self.fits_a_page(job);
        let view = is_large.then(|| View::of(job, [0..job.scene().width, 0..job.scene().height]));
        if let Some(cells) = mesh.views.find(&view) {
            return Ok((cells, 0));
        }
        let cells = match &view {
            Some(view) => self.cells_in(picture, view)?,
            None => Cells::all(columns),
        };
        let (bytes, cells) = (cells.bytes(), Arc::new(cells));
        mesh.views.put(view, &cells);
        Ok((cells, bytes))
    }

    /// The cells whose columns the rays of `tiles` can read.
    pub(crate) fn cells_of(&self, picture: &Picture, tiles: &[(usize, Rect)]) -> Result<Cells, Reason> {
        let (scene, step) = (picture.job.scene(), picture.job.quality().pixel_step);
        let end = |first: u32, count: u32, side: u32| ((first + count - 1) * step).min(side - 1) + 1;
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for (_, Rect { left, top, width, height }) in tiles {
            low = [low[0].min(*left * step), low[1].min(*top * step)];
            high =
                [high[0].max(end(*left, *width, scene.width)), high[1].max(end(*top, *height, scene.height))];
        }
        let [across, down] = [0, 1].map(|k| low[k].min(high[k] - 1)..high[k]);
        self.cells_in(picture, &View::of(picture.job, [across, down]))
    }

    fn cells_in(&self, picture: &Picture, view: &View) -> Result<Cells, Reason> {
        let grid = picture.job.grid();
        let list = view.cells(grid, &picture.mesh.reach);
        // Where there is no great difference, a read less per column is worth more.
        if 8 * list.len() >= 7 * grid.cells() {
            return Ok(Cells::all(grid.cells()));
        }
        let mut places = vec![0u32; grid.cells()];
        for (place, cell) in (0..).zip(&list) {
            places[*cell as usize] = place;
        }
        Ok(Cells::new(list, Some(self.lend_with("places of columns", &places)?)))
    }
}

/// The layers between which something is to be seen over `columns`: without the lowest and highest ones that lie, with the
/// next one, within one clear span. What is read in their place lies there too, so that no bit of the picture changes.
pub(crate) fn seen_layers(job: &Job, columns: &[u32]) -> Range<usize> {
    let layers = job.radius().len();
    let below = clear_layers(job, columns, |k| k);
    if below == layers {
        // Nothing is seen anywhere.
        return 0..1;
    }
    let above = clear_layers(job, columns, |k| layers - 1 - k);
    // Gradients take one more.
    let kept = if job.shading().is_some() { 2 } else { 1 };
    below.max(kept) - kept..layers - above.max(kept) + kept
}

/// How many layers, one after the other by `layer`, have all values in the clear span of the first.
fn clear_layers(job: &Job, columns: &[u32], layer: impl Fn(usize) -> usize + Sync) -> usize {
    /// Columns that are read in one go.
    const RUN: usize = 1024;
    let value = |column: u32, k: usize| {
        let mut value = [0.0];
        job.values(&[column], layer(k)..layer(k) + 1, 0, &mut value);
        value[0]
    };
    let Some(first) = columns.first().map(|column| value(*column, 0)) else { return 0 };
    let spans = job.spans();
    let Some(span) = spans.iter().find(|span| span.is_clear && is_deep(span, first)) else { return 0 };
    let clear = AtomicUsize::new(job.radius().len());
    let look = |columns: &[u32]| {
        let mut values = [0.0; RUN];
        let values = &mut values[..columns.len()];
        for k in 0..clear.load(Ordering::Relaxed) {
            job.values(columns, layer(k)..layer(k) + 1, 0, values);
            if !values.iter().all(|value| is_deep(span, *value)) {
                clear.fetch_min(k, Ordering::Relaxed);
            }
            if clear.load(Ordering::Relaxed) <= k {
                break;
            }
        }
    };
    // Some from all over the globe first: most fields have no such layer, which is soon known.
    let some: Vec<u32> = columns.iter().step_by((columns.len() / RUN).max(1)).copied().take(RUN).collect();
    look(&some);
    columns.par_chunks(RUN).for_each(look);
    clear.into_inner()
}

/// Whether a value lies in a span and farther from its ends than rounding reaches in any mean of such values.
fn is_deep(span: &Span, value: f32) -> bool {
    const FARTHEST: f32 = 100.0;
    const MARGIN: f32 = 1e-3;
    value.abs() <= FARTHEST && value - MARGIN >= span.low && value + MARGIN <= span.high
}
