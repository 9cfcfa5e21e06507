//! What rays met.

/// What rays met, added up over a tile or a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays that met the shell.
    pub rays: u64,
    /// Columns that they walked over, some behind a ray's end where its frusta are integrated together.
    pub columns: u64,
    /// Frusta that they crossed and read: those that they leapt over are not counted.
    pub frusta: u64,
    /// Frusta among these that a missing value made void.
    pub void_frusta: u64,
    /// Fragments that rays were put together of, where ranks have parts of the grid.
    pub fragments: u64,
    /// Bytes of these that ranks sent to each other.
    pub fragment_bytes: u64,
}

impl Counts {
    /// All of them, in order.
    #[inline]
    pub(crate) fn numbers(&self) -> [u64; 6] {
        let Counts { rays, columns, frusta, void_frusta, fragments, fragment_bytes } = *self;
        [rays, columns, frusta, void_frusta, fragments, fragment_bytes]
    }

    /// What [`Self::numbers`] gave.
    #[inline]
    pub(crate) fn of_numbers(
        [rays, columns, frusta, void_frusta, fragments, fragment_bytes]: [u64; 6],
    ) -> Self {
        Counts { rays, columns, frusta, void_frusta, fragments, fragment_bytes }
    }
}

impl std::ops::AddAssign for Counts {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        let (mine, others) = (self.numbers(), other.numbers());
        *self = Counts::of_numbers(std::array::from_fn(|i| mine[i] + others[i]));
    }
}
