//! Vertex gradients in f64: the mean of the interpolant's gradient over the incident frusta (§3.5 of the paper).

use glam::DVec3;
use icoray::Grid;
use rayon::prelude::*;

/// The values of a field at their places, and which frusta count.
pub(crate) struct GradientInput<'a, R, V> {
    pub grid: &'a Grid<'a>,
    pub layers: usize,
    /// Radius of a layer at a cell, planet radii, layer 0 innermost.
    pub radius: R,
    /// Value at a cell and layer; NaN where it is missing.
    pub value: V,
    /// Whether a frustum counts where the neighbours' values are known on the vertex's own layer and the vertex's on
    /// the next, as on native heights; else all six must be.
    pub partial: bool,
}

impl<R: Fn(u32, usize) -> f64 + Sync, V: Fn(u32, usize) -> f64 + Sync> GradientInput<'_, R, V> {
    /// Gradients at all vertices, per planet radius, level-fastest; zero where no frustum counts.
    pub fn gradients(&self) -> Vec<DVec3> {
        let mut gradients = vec![DVec3::ZERO; self.grid.cells() * self.layers];
        gradients.par_chunks_exact_mut(self.layers).enumerate().for_each(|(cell, row)| self.column(cell as u32, row));
        gradients
    }

    /// At vertex A the gradient has the slope to the next layer along A and the differences to the neighbours along
    /// `R·B - R·A` and `R·C - R·A`, each R a vertex's own: with the dual basis of the three, `s eA + (gB - gA) eB +
    /// (gC - gA) eC`.
    fn column(&self, cell: u32, row: &mut [DVec3]) {
        let mut count = vec![0u32; row.len()];
        let a = self.grid.direction(cell);
        for triangle in self.grid.triangles_around(cell) {
            let cells = self.grid.triangle(triangle);
            let k = cells.iter().position(|&c| c == cell).expect("a cell is at its own corners");
            let cells = [0, 1, 2].map(|i| cells[(k + i) % 3]);
            let values = |layer| cells.map(|cell| (self.value)(cell, layer));
            let mut low = values(0);
            for gap in 0..row.len() - 1 {
                let high = values(gap + 1);
                let slope = (high[0] - low[0]) / ((self.radius)(cell, gap + 1) - (self.radius)(cell, gap));
                let all_known = !low.iter().chain(&high).any(|v| v.is_nan());
                for (layer, at) in [(gap, &low), (gap + 1, &high)] {
                    let [own, b, c] = cells.map(|cell| (self.radius)(cell, layer) * self.grid.direction(cell));
                    let [b, c] = [b - own, c - own];
                    let volume = a.dot(b.cross(c));
                    let across = (at[1] - at[0]) * c.cross(a) + (at[2] - at[0]) * a.cross(b);
                    let gradient = (slope * b.cross(c) + across) / volume;
                    if gradient.is_finite() && (all_known || self.partial) {
                        row[layer] += gradient;
                        count[layer] += 1;
                    }
                }
                low = high;
            }
        }
        for (gradient, count) in row.iter_mut().zip(count) {
            *gradient /= f64::from(count.max(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::Sphere;

    /// A field that is linear in space is so in each frustum, on layers of any heights.
    #[test]
    fn the_gradient_of_a_linear_field_is_its_slope() {
        const LAYERS: usize = 4;
        let slope = DVec3::new(0.3, -0.7, 0.2);
        let sphere = Sphere::new(2, LAYERS, [1.0, 1.3], |p| p.length()).unwrap();
        let (grid, heights) = (sphere.grid().unwrap(), sphere.terrain());
        for native in [false, true] {
            let radius = |cell: u32, layer: usize| match native {
                true => 1.0 + heights[cell as usize * LAYERS + layer],
                false => sphere.layers.radius_m()[layer],
            };
            let value = |cell, layer| slope.dot(radius(cell, layer) * grid.direction(cell));
            let input = GradientInput { grid: &grid, layers: LAYERS, radius, value, partial: native };
            assert!(input.gradients().iter().all(|gradient| gradient.distance(slope) < 1e-13), "{native}");
        }
    }
}
