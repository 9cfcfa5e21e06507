//! Radii of layers over each cell.

use icoray_grid::array::MapInline;
use icoray_grid::heights::Heights;

/// The radii of layers, in planet radii, counted from the innermost.
#[derive(Debug, Clone)]
pub enum Levels<'f> {
    /// Concentric layers: 1 / radius of each.
    Concentric(Vec<f64>),
    /// Layers at different heights in each column.
    Native(Heights<'f>),
}

impl Levels<'_> {
    /// Concentric layers of these radii, in planet radii.
    #[inline]
    pub fn concentric(radius: &[f64]) -> Self {
        Levels::Concentric(radius.iter().map(|r| 1.0 / r).collect())
    }

    /// Number of layers.
    #[inline]
    pub fn count(&self) -> usize {
        match self {
            Levels::Concentric(inverse) => inverse.len(),
            Levels::Native(heights) => heights.layers(),
        }
    }

    /// 1 / radius of a layer over three cells.
    #[inline]
    pub fn inverse(&self, cells: [u32; 3], layer: usize) -> [f64; 3] {
        match self {
            Levels::Concentric(inverse) => [inverse[layer]; 3],
            Levels::Native(heights) => heights.radii(cells, layer).map_inline(|radius| 1.0 / radius),
        }
    }
}
