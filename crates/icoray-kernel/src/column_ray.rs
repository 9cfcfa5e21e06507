//! A ray that is driven from column to column.

use crate::column::Flow;
use crate::counts::Counts;
use crate::piece::Radiance;
use crate::signature::BoundarySignature;
use crate::walk::Column;
use icoray_grid::real::Real;

/// A ray in the mesh.
pub(crate) trait ColumnRay {
    type Real: Real;

    /// Bits of the visible blocks of gaps over a triangle.
    fn blocks(&self, triangle: u32) -> u32;

    /// Passes a column over a triangle with data.
    fn column(&mut self, column: &Column, triangle: u32, blocks: u32) -> Flow;

    /// Passes a column over a void triangle: only the core, a sphere there, can be met.
    fn void_column(&mut self, column: &Column) -> Flow;

    fn counts(&mut self) -> &mut Counts;

    /// Light and surfaces since the ray's start, or since it was restarted.
    fn met(&self) -> (&Radiance<Self::Real>, BoundarySignature);

    /// Starts a new fragment without light. The transmittance at which the ray ends counts from its start.
    fn restart(&mut self);
}
