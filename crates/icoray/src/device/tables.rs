//! A grid's tables and a transfer function's spans, as plain numbers.

use crate::grid::Grid;
use crate::kernel::walk;
use glam::DVec3;

/// What a grid has beside the model's own tables ([`Grid::tables`]).
#[derive(Debug)]
pub struct Tables<'g> {
    /// Unit vectors of cells, and of synthetic points behind them.
    pub directions: &'g [[f64; 3]],
    /// A byte per row of `corner_cell`: two bits per vertex with the `corner_edge` column of the side opposite it, or 3 on the
    /// rim of a hole; bit 6 where the row winds clockwise; bit 7 where it is no triangle.
    pub seats: Vec<u8>,
    /// Void triangles: three vertices, and the triangles beyond the sides opposite them.
    pub void: Vec<[u32; 6]>,
    /// Sides on the rims of holes: triangle, vertex opposite, void triangle beyond. Sorted.
    pub rim: Vec<[u32; 3]>,
    /// A triangle that is there.
    pub start: u32,
}

impl<'g> Tables<'g> {
    /// Those of `grid`.
    pub fn of(grid: &'g Grid) -> Self {
        let (void, rim) = grid.closure_numbers();
        let seats = grid.seats().iter().map(|seats| seats.bits()).collect();
        Tables { directions: grid.directions(), seats, void, rim, start: grid.standing(0) }
    }
}

/// The triangle that holds the direction `target`, found from the triangle `from`; the nearer, the faster.
pub fn locate(grid: &Grid, from: u32, target: [f64; 3]) -> u32 {
    walk::locate(grid, from, DVec3::from_array(target))
}

/// Between two knots of the transfer function extinction and colour are linear in the normalised value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Values of the span, `low <= high`; infinite at the outer ends.
    pub low: f32,
    /// See `low`.
    pub high: f32,
    /// The value that slopes are measured from.
    pub anchor: f32,
    /// Per planet radius, at the anchor.
    pub extinction: f32,
    /// Its slope in the value.
    pub extinction_slope: f32,
    /// Linear RGB at the anchor.
    pub color: [f32; 3],
    /// Its slopes in the value.
    pub color_slope: [f32; 3],
    /// The largest of the slopes' sizes.
    pub steepest: f32,
    /// The largest channel at the span's ends.
    pub brightest: f32,
    /// Extinction is zero throughout.
    pub is_clear: bool,
}

/// What a ray may spend: `share` is the error of the colour per absorbed light, `rest` the transmittance at which a ray ends,
/// `brightest` the most that a channel can hold behind that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowed {
    /// See above.
    pub share: f32,
    /// See above.
    pub rest: f32,
    /// See above.
    pub brightest: f32,
}
