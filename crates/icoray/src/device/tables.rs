//! Triangles by direction, and a transfer function's spans as plain numbers.

use glam::DVec3;
use icoray_grid::Grid;
use icoray_kernel::walk;

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
