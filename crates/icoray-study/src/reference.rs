//! An independent renderer for tests, slow and simple, in f64.
//!
//! It shares only its inputs with the renderer. A point is located by solving for its barycentric coordinates in a
//! triangle's three directions; the value is the paper's §3.3 to the letter (two barycentric interpolations, then one
//! along the radius); rays are integrated by tiny midpoint steps; vertex gradients are differences of the interpolant
//! in each incident frustum.

use crate::shading;
use glam::{DMat3, DVec3};
use icoray::{Field, Grid, Scene};

/// A scene over a grid and a field at cell centres, to be evaluated anywhere.
#[derive(Debug)]
pub struct Reference<'a> {
    grid: &'a Grid<'a>,
    scene: &'a Scene,
    radius: Vec<f64>,
    values: Vec<f64>,
    inverse: Vec<DMat3>,
    gradients: Vec<DVec3>,
}

/// A frustum with barycentric coordinates on its triangle and the fraction of the way to its upper layer.
#[derive(Debug, Clone, Copy)]
struct FrustumPoint {
    triangle: u32,
    layer: usize,
    weight: DVec3,
    lambda: f64,
}

impl<'a> Reference<'a> {
    /// `radius` are the layers' radii in planet radii, rising, exaggeration applied; layer 0 of `field` is the lowest.
    pub fn new(grid: &'a Grid<'a>, radius: &[f64], field: &Field, scene: &'a Scene) -> Self {
        let layers = radius.len();
        let values =
            (0..grid.cells()).flat_map(|c| (0..layers).map(move |l| (c, l))).map(|(c, l)| field.value(c, l)).collect();
        let basis = |t: u32| {
            let [a, b, c] = grid.triangle(t).map(|cell| grid.direction(cell));
            DMat3::from_cols(a, b, c).inverse()
        };
        let inverse = (0..grid.triangles() as u32).map(basis).collect();
        let mut reference = Reference { grid, scene, radius: radius.to_vec(), values, inverse, gradients: Vec::new() };
        if scene.lighting.is_some() {
            reference.gradients = reference.vertex_gradients();
        }
        reference
    }

    /// The coordinates of `p` in the triangle's three directions.
    fn coordinates(&self, triangle: u32, p: DVec3) -> DVec3 {
        self.inverse[triangle as usize] * p
    }

    fn value_of(&self, cell: u32, layer: usize) -> f64 {
        self.values[cell as usize * self.radius.len() + layer]
    }

    /// The triangle whose cone contains `p`; `hint` and its neighbours are tried first.
    fn triangle_at(&self, p: DVec3, hint: u32) -> u32 {
        let min = |t: u32| self.coordinates(t, p).min_element();
        if min(hint) >= 0.0 {
            return hint;
        }
        let near = (0..3).map(|k| self.grid.across(hint, k)).find(|&t| min(t) >= 0.0);
        near.unwrap_or_else(|| {
            let all = 0..self.grid.triangles() as u32;
            all.max_by(|&a, &b| min(a).total_cmp(&min(b))).expect("a grid has triangles")
        })
    }

    /// The frustum that contains `p`; `None` below the lowest and above the highest layer.
    fn locate(&self, p: DVec3, hint: &mut u32) -> Option<FrustumPoint> {
        let triangle = self.triangle_at(p, *hint);
        *hint = triangle;
        let coordinates = self.coordinates(triangle, p);
        let rho = coordinates.element_sum();
        let above = self.radius.partition_point(|&r| r <= rho);
        let layer = above.checked_sub(1).filter(|l| l + 1 < self.radius.len())?;
        let lambda = (rho - self.radius[layer]) / (self.radius[layer + 1] - self.radius[layer]);
        Some(FrustumPoint { triangle, layer, weight: coordinates / rho, lambda })
    }

    fn interpolate(&self, point: &FrustumPoint) -> f64 {
        let cells = self.grid.triangle(point.triangle);
        let on = |layer| {
            let values = DVec3::from_array(cells.map(|c| self.value_of(c, layer)));
            values.dot(point.weight)
        };
        let (low, high) = (on(point.layer), on(point.layer + 1));
        low + point.lambda * (high - low)
    }

    /// The interpolant of one frustum, extrapolated beyond its faces.
    fn continued(&self, triangle: u32, layer: usize, p: DVec3) -> f64 {
        let coordinates = self.coordinates(triangle, p);
        let rho = coordinates.element_sum();
        let lambda = (rho - self.radius[layer]) / (self.radius[layer + 1] - self.radius[layer]);
        self.interpolate(&FrustumPoint { triangle, layer, weight: coordinates / rho, lambda })
    }

    fn vertex_gradients(&self) -> Vec<DVec3> {
        const H: f64 = 1e-5;
        let layers = self.radius.len();
        let mut sums = vec![(DVec3::ZERO, 0.0); self.values.len()];
        for t in 0..self.grid.triangles() as u32 {
            for (cell, layer) in self.grid.triangle(t).into_iter().flat_map(|c| (0..layers).map(move |l| (c, l))) {
                let at = self.grid.direction(cell) * self.radius[layer];
                for gap in [layer.checked_sub(1), (layer + 1 < layers).then_some(layer)].into_iter().flatten() {
                    let slope = |axis: DVec3| {
                        let ahead = self.continued(t, gap, at + axis * H);
                        (ahead - self.continued(t, gap, at - axis * H)) / (2.0 * H)
                    };
                    let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
                    if !gradient.is_nan() {
                        let sum = &mut sums[cell as usize * layers + layer];
                        *sum = (sum.0 + gradient, sum.1 + 1.0);
                    }
                }
            }
        }
        sums.into_iter().map(|(sum, count): (DVec3, f64)| sum / count.max(1.0)).collect()
    }

    /// The vertex gradients, interpolated like the value.
    fn gradient(&self, point: &FrustumPoint) -> DVec3 {
        let cells = self.grid.triangle(point.triangle);
        let on = |layer: usize| {
            let at = cells.map(|c| self.gradients[c as usize * self.radius.len() + layer]);
            at[0] * point.weight.x + at[1] * point.weight.y + at[2] * point.weight.z
        };
        on(point.layer).lerp(on(point.layer + 1), point.lambda)
    }

    /// Light along a ray, premultiplied RGB and opacity, before the background, in `steps` midpoint steps over the
    /// part inside the sphere around the outermost layer. Steps that cross the shell's surface are cut there.
    pub fn trace(&self, eye: DVec3, dir: DVec3, steps: usize) -> [f64; 4] {
        let outer = self.radius[self.radius.len() - 1];
        let along = eye.dot(dir);
        let half = outer * outer - (eye - along * dir).length_squared();
        if half <= 0.0 || -along + half.sqrt() <= 0.0 {
            return [0.0; 4];
        }
        let (start, end) = ((-along - half.sqrt()).max(0.0), -along + half.sqrt());
        let (mut color, mut transmittance) = (DVec3::ZERO, 1.0);
        let mut hint = 0;
        let mut t = start;
        let mut here = self.region(eye + t * dir, &mut hint);
        for i in 1..=steps {
            let goal = start + (end - start) * i as f64 / steps as f64;
            while t < goal {
                let mut to = goal;
                let mut there = self.region(eye + to * dir, &mut hint);
                if there != here {
                    // Bisect to where the region changes.
                    let (mut low, mut high) = (t, goal);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if self.region(eye + middle * dir, &mut hint) == here {
                            low = middle;
                        } else {
                            high = middle;
                        }
                    }
                    to = high;
                    there = self.region(eye + to * dir, &mut hint);
                }
                if here == Region::Core
                    && let Some(core) = self.scene.core
                {
                    color += transmittance
                        * shading::ground(self.scene, DVec3::from_array(core), (eye + t * dir).normalize(), dir);
                    return [color.x, color.y, color.z, 1.0];
                }
                self.step(eye + 0.5 * (t + to) * dir, to - t, dir, &mut hint, &mut color, &mut transmittance);
                (t, here) = (to, there);
            }
        }
        [color.x, color.y, color.z, 1.0 - transmittance]
    }

    fn step(&self, p: DVec3, length: f64, dir: DVec3, hint: &mut u32, color: &mut DVec3, transmittance: &mut f64) {
        let Some(point) = self.locate(p, hint) else { return };
        let value = self.interpolate(&point);
        if value.is_nan() {
            return;
        }
        let (own, extinction) =
            shading::transfer(self.scene, self.radius[self.radius.len() - 1] - self.radius[0], value);
        let alpha = -(-extinction * length).exp_m1();
        let own = match self.scene.lighting {
            Some(_) => shading::lit(self.scene, own, self.gradient(&point).normalize_or_zero(), dir),
            None => own,
        };
        *color += *transmittance * alpha * own;
        *transmittance *= 1.0 - alpha;
    }

    fn region(&self, p: DVec3, hint: &mut u32) -> Region {
        let triangle = self.triangle_at(p, *hint);
        *hint = triangle;
        let rho = self.coordinates(triangle, p).element_sum();
        if rho < self.radius[0] {
            return Region::Core;
        }
        if rho >= self.radius[self.radius.len() - 1] { Region::Outside } else { Region::Shell }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Region {
    Core,
    Shell,
    Outside,
}
