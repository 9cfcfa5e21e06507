//! The paper's interpolant (§3.3), point by point: barycentric on the flat layers, linear in between along the radius.

use super::march::{Interpolant, along};
use super::transfer::Transfer;
use crate::job::PreparedJob;
use crate::oracle::GradientInput;
use glam::{DVec3, Vec3};
use icoray::Frustum;

/// Values, and gradients where the scene is lit, between the six vertices of a frustum.
pub(crate) struct Wedge<'s, 'a> {
    prepared: &'s PreparedJob<'a>,
    gradients: Vec<Vec3>,
}

/// A frustum's values: the first vertex's and the differences of the other two, on the lower and the upper layer.
pub(crate) struct Values {
    on: [[f32; 3]; 2],
    inner: f64,
    inverse_gap: f64,
}

impl<'s, 'a> Wedge<'s, 'a> {
    pub fn new(prepared: &'s PreparedJob<'a>) -> Self {
        let field = prepared.field();
        let input = GradientInput {
            grid: prepared.grid,
            layers: prepared.radius.len(),
            radius: |_, layer: usize| prepared.radius[layer],
            value: |cell, layer| prepared.value(&field, cell, layer),
            partial: false,
        };
        let gradients = prepared.scene.lighting.map_or(Vec::new(), |_| input.gradients());
        // Only directions count: relative to the largest, a gradient of 1e30 is an f32.
        let largest = gradients.iter().fold(0.0f64, |m, g| m.max(g.abs().max_element()));
        let narrow = |g: &DVec3| (*g / largest).as_vec3();
        Wedge { prepared, gradients: gradients.iter().map(narrow).collect() }
    }
}

/// Barycentric weights of the second and third vertex, and the fraction of the way to the upper layer.
fn place(values: &Values, frustum: &Frustum, t: f64) -> [f32; 3] {
    let [a, b, c] = along(frustum, t);
    let rho = a + b + c;
    [(b / rho) as f32, (c / rho) as f32, ((rho - values.inner) * values.inverse_gap) as f32]
}

impl Interpolant for Wedge<'_, '_> {
    type Cell = Values;

    fn cell(&self, transfer: &Transfer, frustum: &Frustum) -> Option<Values> {
        let narrow = |[a, b, c]: [f64; 3]| {
            let [a, b, c] = [a, b, c].map(|v| transfer.normalised(v));
            [a, b - a, c - a]
        };
        let on = self.prepared.vertices(frustum)?.map(narrow);
        let inner = self.prepared.radius[frustum.layer];
        Some(Values { on, inner, inverse_gap: 1.0 / (self.prepared.radius[frustum.layer + 1] - inner) })
    }

    #[inline]
    fn value(&self, values: &Values, frustum: &Frustum, t: f64) -> f32 {
        let [b, c, lambda] = place(values, frustum, t);
        let [low, high] = values.on.map(|v| v[0] + (b * v[1] + c * v[2]));
        low + lambda * (high - low)
    }

    fn gradient(&self, values: &Values, frustum: &Frustum, t: f64) -> Vec3 {
        let [b, c, lambda] = place(values, frustum, t);
        let layers = self.prepared.radius.len();
        let at = |k: usize, layer: usize| self.gradients[frustum.cells[k] as usize * layers + layer];
        let on = |layer| at(0, layer) * (1.0 - b - c) + at(1, layer) * b + at(2, layer) * c;
        on(frustum.layer).lerp(on(frustum.layer + 1), lambda)
    }
}
