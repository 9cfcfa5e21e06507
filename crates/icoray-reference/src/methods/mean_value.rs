//! Mean value coordinates over a frustum's eight triangles (Ju, Schaefer and Warren 2005, doi:10.1145/1073204.1073229;
//! Floater, Kós and Reimers 2005, doi:10.1016/j.cagd.2005.06.004), which the paper compares with in §4.2.
//!
//! From the point, each triangle is projected onto the unit sphere around it; the mean vector of the spherical triangle
//! is `m = ½ Σ θ_i n_i` over its sides, with angle θ and unit normal n, and vertex i gets the weight `m·n_i/(d_i
//! u_i·n_i)` with the normal of the side opposite. In the plane of a triangle that is 0/0: inside, the value is
//! barycentric there; outside, the triangle is seen edge-on and adds nothing. The side faces' diagonals are those of
//! the tetrahedra.

use super::march::{Interpolant, along};
use super::transfer::Transfer;
use crate::job::PreparedJob;
use glam::DVec3;
use icoray::Frustum;

/// The sine of the angle at which a triangle counts as seen edge-on.
const FLAT: f64 = 1e-11;

pub(crate) struct MeanValue<'s, 'a>(pub &'s PreparedJob<'a>);

/// A frustum's vertices, lower layer first, cells in the order of their numbers; and its triangles, facing outwards.
pub(crate) struct Solid {
    vertex: [DVec3; 6],
    value: [f64; 6],
    faces: [[usize; 3]; 8],
    direction: [DVec3; 3],
}

impl Solid {
    fn new(prepared: &PreparedJob, values: &[[f64; 3]; 2], frustum: &Frustum) -> Self {
        let direction = frustum.cells.map(|cell| prepared.grid.direction(cell));
        let mut order = [0, 1, 2];
        order.sort_unstable_by_key(|&k| frustum.cells[k]);
        let on = |i: usize| (i / 3, order[i % 3]);
        let six = [0, 1, 2, 3, 4, 5];
        let vertex = six.map(|i| direction[on(i).1] * prepared.radius[frustum.layer + on(i).0]);
        let value = six.map(|i| values[on(i).0][on(i).1]);
        let mut faces = [[0, 1, 2], [3, 4, 5], [0, 1, 4], [0, 3, 4], [1, 2, 5], [1, 4, 5], [0, 2, 5], [0, 3, 5]];
        let centre = vertex.iter().sum::<DVec3>() / 6.0;
        for face in &mut faces {
            let [a, b, c] = face.map(|i| vertex[i]);
            if (b - a).cross(c - a).dot(a - centre) < 0.0 {
                face.swap(1, 2);
            }
        }
        Solid { vertex, value, faces, direction }
    }

    /// The value at a point inside or on the surface.
    fn value(&self, p: DVec3) -> f64 {
        let away = self.vertex.map(|v| v - p);
        let distance = away.map(DVec3::length);
        let size = distance.iter().fold(0.0f64, |m, d| m.max(*d));
        if let Some(i) = distance.iter().position(|d| *d <= 1e-12 * size) {
            return self.value[i];
        }
        let unit: [DVec3; 6] = std::array::from_fn(|i| away[i] / distance[i]);
        let (mut weights, mut sum) = (0.0, 0.0);
        for face in &self.faces {
            match weight(face.map(|i| unit[i]), face.map(|i| distance[i])) {
                Weight::Of(weight) => {
                    for (w, &i) in weight.into_iter().zip(face) {
                        weights += w;
                        sum += w * self.value[i];
                    }
                }
                Weight::None => {}
                Weight::All => return self.on_face(face, p),
            }
        }
        sum / weights
    }

    /// Barycentric on a face.
    fn on_face(&self, face: &[usize; 3], p: DVec3) -> f64 {
        let [a, b, c] = face.map(|i| self.vertex[i] - p);
        let normal = (b - a).cross(c - a);
        let part = [b.cross(c), c.cross(a), a.cross(b)].map(|n| n.dot(normal));
        let sum: f64 = face.iter().zip(part).map(|(&i, part)| part * self.value[i]).sum();
        sum / part.iter().sum::<f64>()
    }
}

/// Contribution of one triangle.
enum Weight {
    /// Weights of its vertices.
    Of([f64; 3]),
    /// Nothing: seen edge-on.
    None,
    /// The point lies in it: it alone counts.
    All,
}

/// Weights of a triangle with unit vectors to its vertices and their distances.
fn weight(unit: [DVec3; 3], distance: [f64; 3]) -> Weight {
    let [u, v, w] = unit;
    let cross = [v.cross(w), w.cross(u), u.cross(v)];
    let volume = u.dot(cross[0]);
    let angle = [v.dot(w), w.dot(u), u.dot(v)];
    let sine = cross.map(DVec3::length);
    let theta: [f64; 3] = std::array::from_fn(|i| sine[i].atan2(angle[i]));
    if volume.abs() <= FLAT {
        // Coplanar: around an inside point the angles make a full turn.
        let turn = theta.iter().sum::<f64>();
        return if turn > std::f64::consts::TAU - 1e-5 { Weight::All } else { Weight::None };
    }
    let normal: [DVec3; 3] = std::array::from_fn(|i| cross[i] / sine[i]);
    let mean = 0.5 * (normal[0] * theta[0] + normal[1] * theta[1] + normal[2] * theta[2]);
    Weight::Of(std::array::from_fn(|i| mean.dot(normal[i]) * sine[i] / (distance[i] * volume)))
}

impl Interpolant for MeanValue<'_, '_> {
    type Cell = Solid;

    fn cell(&self, transfer: &Transfer, frustum: &Frustum) -> Option<Solid> {
        let values = self.0.vertices(frustum)?.map(|on| on.map(|v| f64::from(transfer.normalised(v))));
        Some(Solid::new(self.0, &values, frustum))
    }

    #[inline]
    fn value(&self, solid: &Solid, frustum: &Frustum, t: f64) -> f32 {
        let alpha = along(frustum, t);
        let [a, b, c] = solid.direction;
        solid.value(a * alpha[0] + b * alpha[1] + c * alpha[2]) as f32
    }
}
