//! The order of a triangle's three sides relative to its three vertices, in one byte.
//!
//! Real files guarantee neither that column k of `corner_edge` lies opposite column k of `corner_cell` nor that rows
//! wind alike. Both are determined once when the grid is checked and stored here, instead of sorting or copying the
//! tables.

use bytemuck::{Pod, Zeroable};

/// Two bits per vertex: the `corner_edge` column of the side opposite it, or 3 if no triangle of the table lies beyond;
/// bit 6: the row winds clockwise from outside; bit 7: a cell of the row is missing, it is no triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct TriangleOrientation(u8);

impl TriangleOrientation {
    const CLOCKWISE: u8 = 1 << 6;
    const ABSENT: u8 = 1 << 7;
    /// Replaces a column: a side of the mesh's rim.
    pub const RIM: usize = 3;

    /// `side[k]` is the `corner_edge` column of the side opposite vertex `k`, or [`Self::RIM`].
    pub fn new(side: [usize; 3], clockwise: bool) -> Self {
        let columns = (side[0] | side[1] << 2 | side[2] << 4) as u8;
        TriangleOrientation(columns | if clockwise { Self::CLOCKWISE } else { 0 })
    }

    /// The orientation of a row that names a missing cell.
    pub fn absent() -> Self {
        TriangleOrientation(Self::ABSENT)
    }

    /// Whether the row's three cells all exist.
    #[inline]
    pub fn is_triangle(self) -> bool {
        self.0 & Self::ABSENT == 0
    }

    /// Whether the side opposite vertex `k` is on the rim.
    #[inline]
    pub fn is_rim(self, k: usize) -> bool {
        self.side_opposite(k) == Self::RIM
    }

    /// The `corner_edge` column of the side opposite vertex `k`, or [`Self::RIM`].
    #[inline]
    pub fn side_opposite(self, k: usize) -> usize {
        (self.0 >> (2 * k) & 3) as usize
    }

    /// Whether the row runs clockwise seen from outside.
    #[inline]
    pub fn is_clockwise(self) -> bool {
        self.0 & Self::CLOCKWISE != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_every_permutation_winding_and_rim_and_absence() {
        const RIM: usize = TriangleOrientation::RIM;
        for side in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0], [RIM, 1, RIM], [2, RIM, 0]] {
            for clockwise in [false, true] {
                let orientation = TriangleOrientation::new(side, clockwise);
                assert_eq!([0, 1, 2].map(|k| orientation.side_opposite(k)), side);
                assert_eq!([0, 1, 2].map(|k| orientation.is_rim(k)), side.map(|column| column == RIM));
                assert!(orientation.is_clockwise() == clockwise && orientation.is_triangle());
            }
        }
        assert!(!TriangleOrientation::absent().is_triangle());
    }
}
