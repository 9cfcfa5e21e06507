//! How the three sides of a triangle sit against its three vertices, in one byte.
//!
//! Real files promise neither that column k of `corner_edge` lies opposite column k of `corner_cell` nor that rows wind
//! alike. Both facts are found once when the grid is checked and kept here, instead of sorting or copying the tables.

/// Two bits per vertex: the `corner_edge` column of the side opposite it; bit 6: the row winds clockwise from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Seats(u8);

impl Seats {
    const CLOCKWISE: u8 = 1 << 6;

    /// `side[k]` is the `corner_edge` column of the side opposite vertex `k`.
    pub fn new(side: [usize; 3], clockwise: bool) -> Self {
        let columns = (side[0] | side[1] << 2 | side[2] << 4) as u8;
        Seats(columns | if clockwise { Self::CLOCKWISE } else { 0 })
    }

    /// The `corner_edge` column of the side opposite vertex `k`.
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
    fn holds_every_permutation_and_winding() {
        for side in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            for clockwise in [false, true] {
                let seats = Seats::new(side, clockwise);
                assert_eq!([0, 1, 2].map(|k| seats.side_opposite(k)), side);
                assert_eq!(seats.is_clockwise(), clockwise);
            }
        }
    }
}
