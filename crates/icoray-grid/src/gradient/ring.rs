//! A cell's neighbours in order, and their weights in the mean gradient.
//!
//! With the neighbours n(i) in order around cell a, triangle i is (a, n(i), n(i + 1)). Of its dual basis the parts along
//! the layer are `-(a × n(i + 1))/v(i)` and `(a × n(i))/v(i)`, where `v(i) = (a × n(i))·n(i + 1)`. A neighbour's weight
//! is the mean of its parts in both of its triangles. The radial part follows from them: the dual basis of a, b - a and
//! c - a has `a = eA + (a·(b - a)) eB + (a·(c - a)) eC`, hence `eA = a - Σ a·(n - a) e(n)`.

use crate::array::MapInline;
use crate::grid::Grid;
use glam::DVec3;

/// Maximum number of neighbours of a cell for the stencil.
pub(super) const MAX_NEIGHBORS: usize = 8;

/// A cell's neighbours, with the weights of their differences to the cell at radius 1, x, y and z, and those of the
/// radial slope. Neighbours from `count` on are the cell itself, with weight 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct RingWeights {
    pub count: usize,
    pub neighbours: [u32; MAX_NEIGHBORS],
    pub along: [[f32; 3]; MAX_NEIGHBORS],
    pub radial: [f32; 3],
}

impl RingWeights {
    /// The weights of `cell`, all times `scale`; `None` if its triangles do not form a closed ring of at most
    /// [`MAX_NEIGHBORS`].
    #[inline(always)]
    pub fn of(grid: &Grid, cell: u32, scale: f64) -> Option<Self> {
        let mut neighbours = [cell; MAX_NEIGHBORS];
        let count = grid.ring(cell, &mut neighbours)?;
        let a = grid.direction(cell);
        // One before the first, and one behind the last.
        let mut to = [DVec3::ZERO; MAX_NEIGHBORS + 2];
        for i in 0..count {
            to[i + 1] = grid.direction(neighbours[i]) - a;
        }
        to[0] = to[count];
        to[count + 1] = to[1];
        let across = to.map_inline(|to| a.cross(to));
        let share = scale / count as f64;
        let mut inverse = [0.0; MAX_NEIGHBORS + 1];
        for i in 0..=count {
            inverse[i] = share / across[i].dot(to[i + 1]);
        }
        let mut along = [[0.0; 3]; MAX_NEIGHBORS];
        let mut radial = scale * a;
        for i in 0..count {
            let weight = across[i] * inverse[i] - across[i + 2] * inverse[i + 1];
            radial -= a.dot(to[i + 1]) * weight;
            along[i] = weight.as_vec3().to_array();
        }
        Some(RingWeights { count, neighbours, along, radial: radial.as_vec3().to_array() })
    }
}
