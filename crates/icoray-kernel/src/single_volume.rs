//! The part of a frame that all rays through a single volume share.

use crate::budget::Budget;
use crate::column::{Shell, Values};
use crate::ground::Core;
use crate::shade::Shading;
use crate::transfer::Spans;
use fearless_simd::Level;
use icoray_grid::Grid;
use icoray_grid::gradient::Gradients;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::real::Real;
use icoray_grid::samples::AnySamples;
use icoray_scene::Method;

/// The kernel for one field: all data that the rays of a frame share.
///
/// Rays interpolate `N` values: the field's value (`N = 1`), or value and gradient (`N = 4`) with lighting.
pub struct SingleVolumeTracer<'f, T> {
    /// Tables and directions of the grid.
    pub grid: &'f Grid<'f>,
    /// Radii of the layers, in planet radii.
    pub shell: &'f Shell<T>,
    /// The transfer function.
    pub spans: &'f Spans<T>,
    /// The field, normalised to the range of `spans`.
    pub samples: AnySamples<'f>,
    /// [`Spans::needs_sizes`] of the field.
    pub needs_sizes: bool,
    /// Visible blocks of gaps.
    pub visible: &'f OccupancyMask,
    /// Radius of the visible space, in planet radii.
    pub outer: f64,
    /// Gradients at the vertices, level-fastest; not read without lighting.
    pub gradients: &'f Gradients,
    /// The rule of integration.
    pub method: Method,
    /// Division of the tolerance along a ray.
    pub budget: Budget,
    /// Lighting; `None` shows the transfer function's own colours.
    pub shading: Option<Shading>,
    /// When set, pieces are not cut where the gradient turns.
    pub is_coarse: bool,
    /// The machine's vector instructions, if rays are traced in packets.
    pub level: Option<Level>,
    /// Whether frusta are integrated; false to measure only the walk and the interpolation.
    pub integrates: bool,
    /// The opaque core; `None` lets rays through the hollow core.
    pub core: Option<Core<'f>>,
}

impl<T: Real> SingleVolumeTracer<'_, T> {
    /// Allowed error of the colour per absorbed light.
    #[inline]
    pub(crate) fn color_tolerance(&self) -> f64 {
        self.budget.color_tolerance_in::<T>(self.shading.as_ref())
    }

    /// Value, and gradient where `N` is 4, at a vertex whose value is known.
    #[inline(always)]
    pub(crate) fn vertex<const N: usize>(&self, cell: u32, value: T, layer: usize) -> Values<T, N> {
        let mut values = [T::zero(); N];
        values[0] = value;
        if N == 4 {
            let gradient = self.gradients.at(cell as usize * self.shell.layers() + layer);
            for k in 0..3 {
                values[1 + k] = T::of(f64::from(gradient[k]));
            }
        }
        values
    }
}
