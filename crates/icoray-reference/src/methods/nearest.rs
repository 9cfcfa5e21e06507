//! Piecewise constant: each point has the value of the nearest cell centre, whose Voronoi cell it is in, on the nearest
//! layer. What the paper calls conventional piecewise-constant sampling (§3.3); of first order in the mesh.

use super::march::{Interpolant, along};
use super::transfer::Transfer;
use crate::job::PreparedJob;
use icoray::Frustum;

pub(crate) struct Nearest<'s, 'a>(pub &'s PreparedJob<'a>);

/// A frustum's values on both layers, products that give the nearest vertex, and the height midway.
pub(crate) struct Values {
    on: [[f32; 3]; 2],
    /// Products of the three directions: times α, the point's component along each direction.
    product: [[f64; 3]; 3],
    middle: f64,
}

impl Interpolant for Nearest<'_, '_> {
    type Cell = Values;

    fn cell(&self, transfer: &Transfer, frustum: &Frustum) -> Option<Values> {
        let on = self.0.vertices(frustum)?.map(|on| on.map(|v| transfer.normalised(v)));
        let at = frustum.cells.map(|cell| self.0.grid.direction(cell));
        let product = at.map(|v| at.map(|w| v.dot(w)));
        let middle = 0.5 * (self.0.radius[frustum.layer] + self.0.radius[frustum.layer + 1]);
        Some(Values { on, product, middle })
    }

    #[inline]
    fn value(&self, values: &Values, frustum: &Frustum, t: f64) -> f32 {
        let alpha = along(frustum, t);
        let near = values.product.map(|row| row[0] * alpha[0] + row[1] * alpha[1] + row[2] * alpha[2]);
        let cell = if near[0] >= near[1] && near[0] >= near[2] {
            0
        } else if near[1] >= near[2] {
            1
        } else {
            2
        };
        values.on[usize::from(alpha[0] + alpha[1] + alpha[2] >= values.middle)][cell]
    }
}
