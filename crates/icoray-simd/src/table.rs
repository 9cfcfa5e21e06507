//! Tables that vectors are gathered from.

/// A slice that vectors are gathered from: at least one element, and no more than [`Self::MAX`].
#[derive(Debug)]
pub struct Table<'t, X> {
    elements: &'t [X],
    /// The last element's index.
    last: u32,
}

// Not derived: that would ask for `X: Copy`.
impl<X> Clone for Table<'_, X> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<X> Copy for Table<'_, X> {}

impl<'t, X> Table<'t, X> {
    /// Largest number of elements: what an index of 32 bits reaches, and of vectors of 24 bytes one of 31 bits
    /// in units of 8 bytes.
    pub const MAX: usize = match size_of::<X>() {
        24 => (1 << 31) / 3,
        _ => 1 << 32,
    };

    /// The table of these elements; `None` where there are none, or more than [`Self::MAX`].
    #[inline]
    pub fn new(elements: &'t [X]) -> Option<Self> {
        let last = elements.len().checked_sub(1)?;
        (elements.len() <= Self::MAX).then_some(Table { elements, last: last as u32 })
    }

    /// All elements.
    #[inline(always)]
    pub fn elements(&self) -> &'t [X] {
        self.elements
    }

    /// The last element's index.
    #[inline(always)]
    pub fn last(&self) -> u32 {
        self.last
    }

    /// Starts to fetch the element with this index, or the last one, into the cache. Does nothing on machines other than
    /// x86-64.
    #[inline(always)]
    pub fn prefetch(&self, index: u32) {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let element = self.elements.as_ptr().wrapping_add(index.min(self.last) as usize);
            // SAFETY: x86-64 has the instruction, which reads nothing; the index is clamped to the table's last element.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(element.cast()) };
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = index;
    }
}

/// A table of at least two elements, from which neighbours are gathered.
#[derive(Debug, Clone, Copy)]
pub struct Pairs<'t, X>(Table<'t, X>);

impl<'t, X> Pairs<'t, X> {
    /// The table of these elements; `None` where there are fewer than two, or more than [`Table::MAX`].
    #[inline]
    pub fn new(elements: &'t [X]) -> Option<Self> {
        Table::new(elements).filter(|table| table.last > 0).map(Pairs)
    }

    /// As a table of single elements.
    #[inline(always)]
    pub fn table(&self) -> Table<'t, X> {
        self.0
    }

    /// The index of the last element but one.
    #[inline(always)]
    pub fn last(&self) -> u32 {
        self.0.last - 1
    }
}

/// Tables of f32 that are of one length.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'t, const N: usize> {
    rows: [&'t [f32]; N],
    last: u32,
}

impl<'t, const N: usize> Rows<'t, N> {
    /// These rows; `None` where they are empty, of different lengths, or of more than 2^31 elements.
    #[inline]
    pub fn new(rows: [&'t [f32]; N]) -> Option<Self> {
        let last = Table::new(rows.first()?)?.last();
        let is_fine = last < 1 << 31 && rows.iter().all(|row| row.len() == rows[0].len());
        is_fine.then_some(Rows { rows, last })
    }

    /// A row.
    #[inline(always)]
    pub fn row(&self, k: usize) -> &'t [f32] {
        self.rows[k]
    }

    /// The last index.
    #[inline(always)]
    pub fn last(&self) -> u32 {
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_of_one_length() {
        assert!(Rows::new([&[1.0, 2.0], &[3.0]]).is_none());
        assert!(Rows::new([&[], &[]]).is_none());
        assert_eq!(Rows::new([&[1.0, 2.0], &[3.0, 4.0]]).unwrap().last(), 1);
    }

    #[test]
    fn a_table_has_elements() {
        assert!(Table::<f32>::new(&[]).is_none());
        assert_eq!(Table::new(&[1.0f32, 2.0]).unwrap().last(), 1);
        assert!(Pairs::<f32>::new(&[]).is_none() && Pairs::new(&[1.0f32]).is_none());
        assert_eq!(Pairs::new(&[1.0f32, 2.0]).unwrap().last(), 0);
        assert!(Table::new(&[(); Table::<()>::MAX]).is_some());
        assert!(Table::new(&[(); Table::<()>::MAX + 1]).is_none());
        // The last vector is within an index of 31 bits.
        const { assert!((Table::<[f64; 3]>::MAX - 1) * 3 < 1 << 31) };
    }
}
