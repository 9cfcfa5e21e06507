//! Cost of a frame on a device: bytes that its rays read and write, and operations in f32.
//!
//! Counted by hand in `shaders/kernel`, along the usual path of rays, and multiplied by the numbers of columns and
//! frusta. All reads count, including those that caches serve. Data that all rays share (layers, transfer function) do
//! not count.

use icoray::FrameReport;

/// Orientation, neighbour, cells of the next triangle, its new vertex' direction; values of three cells at the ray's
/// first layer.
const COLUMN_BYTES: u64 = 4 + 4 + 12 + 24 + 12;
/// Values of three cells at the next layer.
const FRUSTUM_BYTES: u64 = 12;
/// Gradients of three vertices, wherever values are read.
const GRADIENT_BYTES: u64 = 36;
/// Output of a pixel's ray.
const PIXEL_BYTES: u64 = 44;

/// In double-float, where a sum is 20 operations, a product 24 and a quotient 110: the new vertex seen from the ray's
/// plane 336, the side crossed 258, whether the ray ends 68, distance 134, height 246; in f32 the first chord 45.
const COLUMN_FLOPS: u64 = 336 + 258 + 68 + 134 + 246 + 45;
/// The next layer, chord and segment 45; its span 9; knots, error bounds and rounding 33; terms of the integral 40;
/// absorption, bound and integral of a thin piece 81; light over light 16. Clear frusta end after 54.
const FRUSTUM_FLOPS: u64 = 45 + 9 + 33 + 40 + 81 + 16;

/// Bytes and operations of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cost {
    pub bytes: f64,
    /// Of unlit rays: operations of lighting are not counted.
    pub flops: f64,
}

impl Cost {
    pub fn of(report: &FrameReport, pixels: u64, is_lit: bool) -> Self {
        let counts = &report.counts;
        let gradients = if is_lit { GRADIENT_BYTES } else { 0 };
        let bytes = counts.columns * (COLUMN_BYTES + gradients)
            + counts.frusta * (FRUSTUM_BYTES + gradients)
            + pixels * PIXEL_BYTES;
        let flops = counts.columns * COLUMN_FLOPS + counts.frusta * FRUSTUM_FLOPS;
        Cost { bytes: bytes as f64, flops: flops as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::Counts;

    #[test]
    fn rays_pay_for_columns_frusta_and_light() {
        let of = |columns, frusta, pixels, is_lit| {
            let counts = Counts { columns, frusta, ..Counts::default() };
            Cost::of(&FrameReport { counts, ..FrameReport::default() }, pixels, is_lit)
        };
        assert_eq!(of(1, 0, 0, false), Cost { bytes: 56.0, flops: 1087.0 });
        assert_eq!(of(0, 1, 0, false), Cost { bytes: 12.0, flops: 224.0 });
        assert_eq!(of(0, 1, 0, true), Cost { bytes: 48.0, flops: 224.0 });
        assert_eq!(of(2, 3, 5, false).bytes, 112.0 + 36.0 + 220.0);
    }
}
