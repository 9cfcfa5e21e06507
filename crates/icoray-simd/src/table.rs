//! Tables that vectors are gathered from.

/// A slice that vectors are gathered from: at least one element, and no more than an index of 31 bits reaches.
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
    /// Largest number of elements.
    pub const MAX: usize = 1 << 31;

    /// The table of these elements; `None` where there are none, or more than [`Self::MAX`].
    #[inline]
    pub fn new(elements: &'t [X]) -> Option<Self> {
        let last = elements.len().checked_sub(1)?;
        (last < Self::MAX).then_some(Table { elements, last: last as u32 })
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_elements() {
        assert!(Table::<f32>::new(&[]).is_none());
        assert_eq!(Table::new(&[1.0f32, 2.0]).unwrap().last(), 1);
        assert!(Table::new(&vec![(); Table::<()>::MAX]).is_some());
        assert!(Table::new(&vec![(); Table::<()>::MAX + 1]).is_none());
    }
}
