//! Counts of rays, columns, frusta and fragments.

/// Counts of crossed columns and frusta, summed over the rays of a tile or a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays that hit the shell.
    pub rays: u64,
    /// Columns that they crossed; includes columns behind the end of a ray whose frusta are integrated in a batch.
    pub columns: u64,
    /// Frusta that they crossed and read, without skipped ones.
    pub frusta: u64,
    /// Those of `frusta` that are empty because a value is missing.
    pub void_frusta: u64,
    /// Frusta and pieces of frusta that packets passed to scalar code.
    pub scalar_pieces: u64,
    /// Fragments of which rays were composed, if ranks have parts of the grid.
    pub fragments: u64,
    /// Bytes of these fragments that ranks sent to each other.
    pub fragment_bytes: u64,
}

impl Counts {
    /// All counts, in the order of the members.
    #[inline]
    pub fn numbers(&self) -> [u64; 7] {
        let Counts { rays, columns, frusta, void_frusta, scalar_pieces, fragments, fragment_bytes } = *self;
        [rays, columns, frusta, void_frusta, scalar_pieces, fragments, fragment_bytes]
    }

    /// The counts with these [`Self::numbers`].
    #[inline]
    pub fn of_numbers(
        [rays, columns, frusta, void_frusta, scalar_pieces, fragments, fragment_bytes]: [u64; 7],
    ) -> Self {
        Counts { rays, columns, frusta, void_frusta, scalar_pieces, fragments, fragment_bytes }
    }
}

impl std::ops::AddAssign for Counts {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        let (mine, others) = (self.numbers(), other.numbers());
        *self = Counts::of_numbers(std::array::from_fn(|i| mine[i] + others[i]));
    }
}
