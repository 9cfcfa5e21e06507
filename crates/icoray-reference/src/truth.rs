//! The exact integral of the interpolant along a ray, in double-double.

mod radiance;

use crate::columns::{Column, columns};
use crate::double_double::Dd;
use crate::gauss::Gauss;
use crate::layered_column::LayeredColumn;
use crate::ray::Ray;
use icoray::{Field, Grid, Scene};
use radiance::{FrustumInterpolant, NODES, Radiance, Transfer};

/// A scene over a grid and a field at cell centres whose first layer is the lowest.
#[derive(Debug, Clone)]
pub struct Truth<'a> {
    grid: &'a Grid<'a>,
    field: &'a Field<'a>,
    radius: &'a [f64],
    transfer: Transfer,
    core: Option<[f64; 3]>,
    rule: Gauss<NODES>,
    falling: bool,
    /// Added to every value, in units of the transfer function's range.
    shift: Dd,
}

/// A part of a ray between two layers, or below all of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    /// The lower layer; `None` in the core.
    pub layer: Option<usize>,
    /// Distances at which the ray enters and leaves.
    pub t: [Dd; 2],
    /// The column that it lies in.
    pub column: Column,
}

impl<'a> Truth<'a> {
    /// `radius` are the layers' radii in planet radii, rising; `falling` when the field's first layer is the highest.
    pub fn new(grid: &'a Grid<'a>, field: &'a Field<'a>, radius: &'a [f64], falling: bool, scene: &Scene) -> Self {
        let transfer = Transfer::new(scene, radius);
        let (core, rule, shift) = (scene.core, Gauss::rule(), Dd::ZERO);
        Truth { grid, field, radius, transfer, core, rule, falling, shift }
    }

    /// The same with every value moved by the part `by` of the transfer function's range.
    pub(crate) fn shifted(&self, by: f64) -> Self {
        Truth { shift: Dd::from(by), ..self.clone() }
    }

    /// All parts of a ray between layers and in the core, in order, until an opaque core ends it; or the distance at
    /// which the mesh has a gap.
    pub(crate) fn stretches(&self, ray: &Ray) -> Result<Vec<Stretch>, f64> {
        let outer = self.radius[self.radius.len() - 1];
        let mut path = Vec::new();
        for column in columns(self.grid, ray, outer, self.core.map(|_| self.radius[0]))? {
            if column.is_void {
                let core = self.core.and_then(|_| ray.inside(self.radius[0], column.t));
                if let Some(t) = core {
                    path.push(Stretch { layer: None, t, column });
                    return Ok(path);
                }
                continue;
            }
            for pair in self.layered(&column).crossings().windows(2).filter(|pair| pair[0].t < pair[1].t) {
                let t = [pair[0].t, pair[1].t];
                let above = self.layered(&column).layers_below((t[0] + t[1]) / 2.0);
                if above < self.radius.len() {
                    path.push(Stretch { layer: above.checked_sub(1), t, column });
                }
                if above == 0 && self.core.is_some() {
                    return Ok(path);
                }
            }
        }
        Ok(path)
    }

    fn layered<'c>(&self, column: &'c Column) -> LayeredColumn<'c, impl Fn(u32, usize) -> f64 + use<'c, 'a>> {
        let radius = self.radius;
        LayeredColumn { column, layers: radius.len(), radius: |_, layer| radius[layer] }
    }

    /// The values of a column's cells on a layer, counted from the lowest; `None` where one is missing.
    fn values(&self, cells: [u32; 3], layer: usize) -> Option<[Dd; 3]> {
        let row = if self.falling { self.radius.len() - 1 - layer } else { layer };
        let values = cells.map(|cell| self.field.value(cell as usize, row));
        values.iter().all(|v| v.is_finite()).then(|| values.map(|v| self.transfer.normalise(v) + self.shift))
    }

    /// The value along a stretch, `None` in a void.
    fn interpolant(&self, layer: usize, stretch: &Stretch) -> Option<FrustumInterpolant> {
        let [lower, upper] = [self.values(stretch.column.cells, layer)?, self.values(stretch.column.cells, layer + 1)?];
        let frustum = self.layered(&stretch.column).frustum(layer, stretch.t);
        let difference = |k: usize| if k < 3 { lower[k] - lower[0] } else { upper[k - 3] - lower[0] };
        let value = |weight: [Dd; 6]| (1..6).fold(lower[0], |sum, k| sum + weight[k] * difference(k));
        Some(FrustumInterpolant::new(frustum.weight.map(value), frustum.height))
    }

    /// Radiance along a ray: premultiplied linear RGB and opacity.
    ///
    /// # Errors
    /// The distance along the ray at which the mesh has a gap.
    pub fn trace(&self, ray: &Ray) -> Result<[f64; 4], f64> {
        Ok(self.light(&self.stretches(ray)?))
    }

    /// As [`Self::trace`], along known stretches.
    pub(crate) fn light(&self, path: &[Stretch]) -> [f64; 4] {
        let mut light = Radiance::none();
        for stretch in path {
            match (stretch.layer, self.core) {
                (Some(layer), _) => {
                    if let Some(interpolant) = self.interpolant(layer, stretch) {
                        light.pass(&self.rule, &self.transfer, &interpolant, stretch.t[1] - stretch.t[0]);
                    }
                }
                (None, Some(color)) => light.hit(color),
                (None, None) => {}
            }
            if light.is_opaque() {
                break;
            }
        }
        let [r, g, b] = light.color.map(Dd::to_f64);
        [r, g, b, (Dd::ONE - light.transmittance).to_f64()]
    }
}
