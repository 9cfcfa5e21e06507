//! Bytes that rays read of tables and field.
//!
//! Counted by hand in the kernel and multiplied by the columns and frusta that rays met. Every read counts, from wherever
//! it is served: what caches give again is no traffic of the memory, so that the memory itself does less. What all rays
//! share (layers, transfer function) does not count, nor does what is done before the first ray.

use icoray::Counts;

/// Of the next triangle: seats, an entry of `corner_edge`, rows of `edge_corner` and `corner_cell`, its new vertex' direction.
const COLUMN: u64 = 1 + 4 + 8 + 12 + 24;
/// What can be seen over a triangle, where there is something to leap over.
const BLOCKS: u64 = 4;
/// Values of three cells on one layer, of 4 bytes.
const VALUES: u64 = 12;
/// Gradients of three vertices, wherever values are read.
const GRADIENTS: u64 = 36;

/// Bytes that rays read which met so much and leapt over the rest, if there was any.
pub(super) fn bytes(counts: &Counts, leaps: bool, is_lit: bool) -> u64 {
    let column = COLUMN + if leaps { BLOCKS } else { 0 };
    let layer = VALUES + if is_lit { GRADIENTS } else { 0 };
    // A frustum reads the layer ahead, the first one of a column that behind it too; columns that were leapt have none.
    let layers = counts.frusta + counts.frusta.min(counts.columns);
    counts.columns * column + layers * layer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_frusta_leaps_and_light_are_paid_for() {
        let of = |columns, frusta, leaps, is_lit| {
            bytes(&Counts { columns, frusta, ..Counts::default() }, leaps, is_lit)
        };
        assert_eq!(of(3, 0, false, false), 3 * 49);
        assert_eq!(of(3, 0, true, false), 3 * 53);
        assert_eq!(of(3, 5, false, false), 3 * 49 + 8 * 12);
        assert_eq!(of(3, 2, false, true), 3 * 49 + 4 * 48);
    }
}
