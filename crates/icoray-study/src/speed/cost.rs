//! Bytes that rays read of tables and field.
//!
//! Counted by hand in the kernel and multiplied by the numbers of columns and frusta. All reads count, including those
//! that caches serve. Data that all rays share (layers, transfer function) and the preparation of frames do not count.

use icoray::Counts;

/// Of the next triangle: its number, its row of `corner_cell`, its new vertex' direction.
const COLUMN: u64 = 4 + 12 + 24;
/// Occupancy over a triangle, where there is empty space to skip.
const BLOCKS: u64 = 4;
/// Values of three cells on one layer, of 4 bytes.
const VALUES: u64 = 12;
/// Gradients of three vertices, wherever values are read.
const GRADIENTS: u64 = 36;

/// Bytes that rays read; `empty_space` if they skip it.
pub(super) fn bytes(counts: &Counts, empty_space: bool, is_lit: bool) -> u64 {
    let column = COLUMN + if empty_space { BLOCKS } else { 0 };
    let layer = VALUES + if is_lit { GRADIENTS } else { 0 };
    // A frustum reads the layer behind it and the one ahead.
    let layers = 2 * counts.frusta;
    counts.columns * column + layers * layer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_frusta_blocks_and_light_are_paid_for() {
        let of = |columns, frusta, empty_space, is_lit| {
            bytes(&Counts { columns, frusta, ..Counts::default() }, empty_space, is_lit)
        };
        assert_eq!(of(3, 0, false, false), 3 * 40);
        assert_eq!(of(3, 0, true, false), 3 * 44);
        assert_eq!(of(3, 5, false, false), 3 * 40 + 10 * 12);
        assert_eq!(of(3, 2, false, true), 3 * 40 + 4 * 48);
    }
}
