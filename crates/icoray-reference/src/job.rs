//! The input of oracle and methods, and the data that both derive from it: the shell, the traversal, and the values at
//! a frustum's six vertices.

use crate::ray::Ray;
use icoray::{ComputedField, Field, Frame, Frustum, Grid, Layers, Location, Plan, Renderer, Result, Scene, Traversal};
use rayon::prelude::*;

/// A scene over a grid and field, ready for any method.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The mesh.
    pub grid: &'a Grid<'a>,
    /// The layers' radii.
    pub layers: &'a Layers,
    /// The values.
    pub field: &'a Field<'a>,
}

impl Job<'_> {
    /// The renderer's frame.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render(&self, renderer: &Renderer) -> Result<Frame> {
        renderer.render(self.scene, self.grid, self.layers, self.field)
    }
}

/// A checked [`Job`] with rising layers and its field at cell centres.
pub(crate) struct PreparedJob<'a> {
    pub scene: &'a Scene,
    pub grid: &'a Grid<'a>,
    /// Radii of the field's layers, planet radii, rising, exaggeration applied.
    pub radius: Vec<f64>,
    pub traversal: Traversal<'a>,
    input: Field<'a>,
    averaged: Option<ComputedField>,
    falling: bool,
}

impl<'a> PreparedJob<'a> {
    pub fn new(job: &Job<'a>) -> Result<Self> {
        Plan::new(job.scene, job.grid, job.layers, job.field)?;
        let layers = job.layers.for_field(job.field.shape().layers)?;
        let radius = layers.shell(job.scene.exaggeration)?;
        let from_corners = job.field.location() == Location::Corner;
        let averaged = from_corners.then(|| ComputedField::average(job.grid, job.field)).transpose()?;
        Ok(PreparedJob {
            scene: job.scene,
            grid: job.grid,
            traversal: Traversal::new(job.grid, &radius)?,
            radius,
            input: *job.field,
            averaged,
            falling: layers.is_falling(),
        })
    }

    /// Thickness of the shell, planet radii.
    pub fn thickness(&self) -> f64 {
        self.radius[self.radius.len() - 1] - self.radius[0]
    }

    /// The field at cell centres.
    pub fn field(&self) -> Field<'_> {
        self.averaged.as_ref().map_or(self.input, ComputedField::field)
    }

    /// Value at a cell, `layer` counted from the innermost; NaN where it is missing.
    #[inline]
    pub fn value(&self, field: &Field, cell: u32, layer: usize) -> f64 {
        let row = if self.falling { self.radius.len() - 1 - layer } else { layer };
        field.value(cell as usize, row)
    }

    /// All values, level-fastest, each column from the innermost layer on.
    pub fn values(&self) -> Vec<f64> {
        let (field, layers) = (self.field(), self.radius.len());
        let places = (0..self.grid.cells() as u32).flat_map(|cell| (0..layers).map(move |layer| (cell, layer)));
        places.map(|(cell, layer)| self.value(&field, cell, layer)).collect()
    }

    /// Values at the frustum's cells, on its lower and its upper layer; `None` when one is missing.
    #[inline]
    pub fn vertices(&self, frustum: &Frustum) -> Option<[[f64; 3]; 2]> {
        let field = self.field();
        let on = |layer| frustum.cells.map(|cell| self.value(&field, cell, layer));
        let values = [on(frustum.layer), on(frustum.layer + 1)];
        (!values.iter().flatten().any(|v| v.is_nan())).then_some(values)
    }

    /// Calls `pixel` with the ray of each pixel and a traversal hint, rows in parallel on the renderer's threads;
    /// results are in the order of pixels.
    pub fn pixels<P: Send>(&self, renderer: &Renderer, pixel: impl Fn(&Ray, &mut u32) -> P + Sync) -> Vec<P> {
        let Scene { width, height, .. } = *self.scene;
        let row = |y: u32| {
            let mut hint = 0;
            (y * width..(y + 1) * width).map(|i| pixel(&Ray::of_pixel(self.scene, i), &mut hint)).collect::<Vec<_>>()
        };
        let rows: Vec<Vec<P>> = renderer.run(|| (0..height).into_par_iter().with_max_len(1).map(row).collect());
        rows.into_iter().flatten().collect()
    }
}
