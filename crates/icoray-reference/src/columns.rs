//! The columns that a ray passes in double-double, by intersection with the cone of every triangle.
//!
//! There is no traversal: all triangles are tested in f64 with a margin, and candidates are solved in double-double.
//! The parts found must cover the ray without a gap.
//!
//! Along a ray through layers of any heights, with the coordinates α of a point in the unit vectors of a triangle's
//! cells, the facet of a layer with the radii R is `ψ = Σ α/R = 1`, and the value between two facets, linear along the
//! radius, is `((1 - ψ') Σ αg/R + (ψ - 1) Σ αg'/R') / (ψ - ψ')`: a sum of the six vertices' values with weights that
//! add up to 1.

use crate::double_double::Dd;
use crate::ray::Ray;
use glam::DVec3;
use icoray::{Frustum, Grid};

/// A part of a ray in the cone of one triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    pub cells: [u32; 3],
    /// Whether the triangle fills a hole of the mesh.
    pub is_void: bool,
    /// Distances at which the ray enters and leaves.
    pub t: [Dd; 2],
    /// The ray's point is the sum of `start[k] + t·speed[k]` times the cells' unit vectors.
    start: [Dd; 3],
    speed: [Dd; 3],
}

impl Column {
    /// The part of a column that is a frustum of the traversal, of some length.
    pub fn around(frustum: &Frustum) -> Self {
        let (t, [from, to]) = (frustum.t.map(Dd::from), frustum.alpha.map(|alpha| alpha.map(Dd::from)));
        let speed = [0, 1, 2].map(|k| (to[k] - from[k]) / (t[1] - t[0]));
        let start = [0, 1, 2].map(|k| from[k] - t[0] * speed[k]);
        Column { cells: frustum.cells, is_void: false, t, start, speed }
    }

    /// Coordinates of the ray's point at `t` in the three unit vectors.
    pub fn coordinates(&self, t: Dd) -> [Dd; 3] {
        [0, 1, 2].map(|k| self.start[k] + t * self.speed[k])
    }

    /// The height at `t`: on the facet of a layer it is the layer's radius.
    pub fn height(&self, t: Dd) -> Dd {
        let [a, b, c] = self.coordinates(t);
        a + b + c
    }

    /// Where the height is `radius`, `None` where the ray keeps its height.
    pub fn reaches(&self, radius: f64) -> Option<Dd> {
        let [a, b, c] = self.start;
        let speed = self.speed[0] + self.speed[1] + self.speed[2];
        (speed != Dd::ZERO).then(|| (Dd::from(radius) - (a + b + c)) / speed)
    }
}

type Vector = [Dd; 3];

fn cross(a: DVec3, b: DVec3) -> Vector {
    let minor = |x: f64, y: f64, z: f64, w: f64| Dd::product(x, w) - Dd::product(y, z);
    [minor(a.y, a.z, b.y, b.z), minor(a.z, a.x, b.z, b.x), minor(a.x, a.y, b.x, b.y)]
}

fn dot(a: DVec3, b: &Vector) -> Dd {
    Dd::from(a.x) * b[0] + Dd::from(a.y) * b[1] + Dd::from(a.z) * b[2]
}

/// Whether the ray may meet the triangle's cone within `range`: conservative, in f64.
fn roughly(ray: &Ray, [a, b, c]: [DVec3; 3], range: [f64; 2]) -> bool {
    let [mut low, mut high] = range;
    let sides = [b.cross(c), c.cross(a), a.cross(b)];
    let turn = a.dot(sides[0]).signum();
    for side in sides {
        let margin = 1e-12 * (1.0 + ray.eye.length()) * side.length();
        let (start, speed) = (turn * ray.eye.dot(side) + margin, turn * ray.dir.dot(side));
        if speed > 0.0 {
            low = low.max(-start / speed);
        } else if speed < 0.0 {
            high = high.min(-start / speed);
        } else if start < 0.0 {
            return false;
        }
    }
    low <= high
}

/// The part of the ray in the triangle's cone, in double-double.
fn column(ray: &Ray, cells: [u32; 3], [a, b, c]: [DVec3; 3], range: [f64; 2]) -> Option<Column> {
    let sides = [cross(b, c), cross(c, a), cross(a, b)];
    let volume = dot(a, &sides[0]);
    let start = [0, 1, 2].map(|k| dot(ray.eye, &sides[k]) / volume);
    let speed = [0, 1, 2].map(|k| dot(ray.dir, &sides[k]) / volume);
    let [mut low, mut high] = range.map(Dd::from);
    for (s, v) in start.into_iter().zip(speed) {
        if v > Dd::ZERO {
            low = low.max(-s / v);
        } else if v < Dd::ZERO {
            high = high.min(-s / v);
        } else if s < Dd::ZERO {
            return None;
        }
    }
    (low < high).then_some(Column { cells, is_void: false, t: [low, high], start, speed })
}

/// The part of the ray inside the sphere of radius `outer`, with a margin; `inner` ends it inside an opaque core.
fn range(ray: &Ray, outer: f64, inner: Option<f64>) -> Option<[f64; 2]> {
    let along = -ray.eye.dot(ray.dir);
    let closest = (ray.eye + along * ray.dir).length();
    let margin = 1e-9 * (1.0 + ray.eye.length());
    let half = ((outer + margin) * (outer + margin) - closest * closest).max(0.0).sqrt();
    // Facets lie inside their sphere, by less than a half on any mesh that is used here.
    let floor = 0.5 * inner.unwrap_or(0.0);
    let end =
        if closest < floor && along > 0.0 { along - (floor * floor - closest * closest).sqrt() } else { along + half };
    let start = (along - half).max(0.0);
    (half > 0.0 && start < end).then_some([start, end])
}

/// The ray's columns in order, without gap or overlap.
///
/// `inner` is the radius of an opaque core, at which a ray ends.
///
/// # Errors
/// Where along the ray a gap begins: then the mesh does not cover the sphere, or this reference is wrong.
pub(crate) fn columns(grid: &Grid, ray: &Ray, outer: f64, inner: Option<f64>) -> Result<Vec<Column>, f64> {
    let Some([start, end]) = range(ray, outer, inner) else { return Ok(Vec::new()) };
    let candidate = |triangle: u32| {
        let cells = grid.triangle(triangle);
        let corners = cells.map(|cell| grid.direction(cell));
        let near = roughly(ray, corners, [start, end]);
        if !near {
            return None;
        }
        Some(Column { is_void: grid.is_void(triangle), ..column(ray, cells, corners, [start, end])? })
    };
    let all = 0..(grid.triangles() + grid.void_triangles()) as u32;
    let all = all.filter(|&t| grid.is_triangle(t) || grid.is_void(t));
    let mut found: Vec<Column> = all.filter_map(candidate).collect();
    found.sort_by(|a, b| a.t[0].to_f64().total_cmp(&b.t[0].to_f64()));
    let tolerance = Dd::from(1e-24 * (1.0 + end.abs()));
    let (mut at, end, mut next, mut path) = (Dd::from(start), Dd::from(end), 0, Vec::new());
    while at < end - tolerance {
        // Of all columns with this place, the one that leads farthest: several meet on a side or a vertex.
        let mut best: Option<Column> = None;
        while next < found.len() && found[next].t[0].to_f64() <= at.to_f64() {
            next += 1;
        }
        for column in &found[..next] {
            let has_place = column.t[0] <= at + tolerance && column.t[1] > at;
            if has_place && best.is_none_or(|b| column.t[1] > b.t[1]) {
                best = Some(*column);
            }
        }
        let Some(mut column) = best else { return Err(at.to_f64()) };
        let leaves = column.t[1];
        column.t[0] = at;
        path.push(column);
        at = leaves;
    }
    Ok(path)
}

/// A triangle's column along a ray, and the radii of its layers.
pub(crate) struct LayeredColumn<'c, R> {
    pub column: &'c Column,
    pub layers: usize,
    pub radius: R,
}

/// A place where a ray crosses a layer, or an end of its column.
pub(crate) struct Crossing {
    pub t: Dd,
    pub layer: Option<usize>,
}

/// A part of a ray between two layers.
pub(crate) struct FrustumWeights {
    /// Weights of the lower and upper vertices at the start, in the middle and at the end.
    pub weight: [[Dd; 6]; 3],
    /// `ψ - ψ'` at the start and at the end, which is proportional to the height.
    pub height: [Dd; 2],
}

impl<R: Fn(u32, usize) -> f64> LayeredColumn<'_, R> {
    /// The terms of ψ at `t`.
    fn terms(&self, layer: usize, t: Dd) -> [Dd; 3] {
        let alpha = self.column.coordinates(t);
        [0, 1, 2].map(|k| alpha[k] / Dd::from((self.radius)(self.column.cells[k], layer)))
    }

    fn psi(&self, layer: usize, t: Dd) -> Dd {
        let [a, b, c] = self.terms(layer, t);
        a + b + c
    }

    /// The number of layers at or below the point at `t`.
    pub fn layers_below(&self, t: Dd) -> usize {
        (0..self.layers).take_while(|layer| self.psi(*layer, t) >= Dd::ONE).count()
    }

    /// The column's ends and the crossings between them, in order.
    pub fn crossings(&self) -> Vec<Crossing> {
        let [start, end] = self.column.t;
        let mut crossings = vec![Crossing { t: start, layer: None }, Crossing { t: end, layer: None }];
        for layer in 0..self.layers {
            let ends = [self.psi(layer, start), self.psi(layer, end)];
            if (ends[0] >= Dd::ONE) != (ends[1] >= Dd::ONE) {
                let t = start + (end - start) * ((Dd::ONE - ends[0]) / (ends[1] - ends[0]));
                crossings.push(Crossing { t: t.max(start).min(end), layer: Some(layer) });
            }
        }
        crossings[1..].sort_by(|a, b| a.t.partial_cmp(&b.t).expect("distances are numbers"));
        crossings
    }

    /// Where the ray meets the facet whose vertices all have this radius.
    pub fn meets(&self, radius: f64) -> Option<Dd> {
        let [start, end] = self.column.t;
        let t = self.column.reaches(radius)?;
        (start <= t && t < end).then_some(t)
    }

    /// Weights of the vertices of a layer's facet at `t`.
    pub fn on_layer(&self, layer: usize, t: Dd) -> [f64; 3] {
        let psi = self.psi(layer, t);
        self.terms(layer, t).map(|term| (term / psi).to_f64())
    }

    /// The part from `from` to `to`, above `layer`.
    pub fn frustum(&self, layer: usize, [from, to]: [Dd; 2]) -> FrustumWeights {
        let mut height = [Dd::ZERO; 3];
        let mut weight = [[Dd::ZERO; 6]; 3];
        for (i, t) in [from, (from + to) / 2.0, to].into_iter().enumerate() {
            let (low, high) = (self.terms(layer, t), self.terms(layer + 1, t));
            let [below, above] = [low, high].map(|[a, b, c]| a + b + c);
            height[i] = below - above;
            let [down, up] = [(Dd::ONE - above) / height[i], (below - Dd::ONE) / height[i]];
            weight[i] = [0, 1, 2, 3, 4, 5].map(|k| if k < 3 { down * low[k] } else { up * high[k - 3] });
        }
        FrustumWeights { weight, height: [height[0], height[2]] }
    }
}
