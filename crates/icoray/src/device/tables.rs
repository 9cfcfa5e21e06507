//! A grid's tables and a transfer function's spans, as plain numbers.

use glam::DVec3;
use icoray_grid::Grid;
use icoray_kernel::walk;

/// Tables of a grid that icoray derives, beside the model's own ([`Grid::tables`]).
#[derive(Debug)]
pub struct Tables<'g> {
    /// Unit vectors of cells, and of synthetic points behind them.
    pub directions: &'g [[f64; 3]],
    /// A byte per row of `corner_cell`: two bits per vertex with the `corner_edge` column of the side opposite it, or 3
    /// on the rim of a hole; bit 6 if the row winds clockwise; bit 7 if it is no triangle.
    pub orientations: Vec<u8>,
    /// Void triangles: three vertices, and the triangles beyond the sides opposite them.
    pub void: Vec<[u32; 6]>,
    /// Sides on the rims of holes: triangle, vertex opposite, void triangle beyond. Sorted.
    pub rim: Vec<[u32; 3]>,
    /// A row that is a triangle.
    pub start: u32,
}

impl<'g> Tables<'g> {
    /// The tables of `grid`.
    pub fn of(grid: &'g Grid) -> Self {
        let (void, rim) = grid.hole_filling_tables();
        let orientations = grid.orientations().iter().map(|orientation| orientation.bits()).collect();
        Tables { directions: grid.directions(), orientations, void, rim, start: grid.nearest_valid_triangle(0) }
    }
}

/// The triangle that contains the direction `target`, searched from the triangle `from`: the nearer, the faster.
pub fn locate(grid: &Grid, from: u32, target: [f64; 3]) -> u32 {
    walk::locate(grid, from, DVec3::from_array(target))
}

/// A span between two knots of the transfer function, in which extinction and colour are linear in the normalised
/// value.
pub type Span = icoray_kernel::transfer::Span<f32>;

/// A step of the transfer function: a jump, or a change within the reach of rounding.
pub type Step = icoray_kernel::transfer::Step<f32>;

/// Division of the tolerance along a ray, as [`Budget`](icoray_kernel::Budget).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetTable {
    /// Allowed error of the colour per absorbed light.
    pub color_tolerance: f32,
    /// Transmittance at which a ray ends.
    pub min_transmittance: f32,
    /// Largest linear value that a channel can have behind a ray's end.
    pub brightest: f32,
}
