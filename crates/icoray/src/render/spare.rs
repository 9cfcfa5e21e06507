//! What a frame leaves to the next one: memory as large as the grid, so that a run of frames allocates it once, and what it
//! holds, where the next frame is of the same field.

use crate::error::Result;
use crate::field::{CenterField, Field};
use crate::gradient::Gradients;
use crate::grid::Grid;
use crate::kernel::leap::Visible;
use std::sync::{Mutex, MutexGuard, PoisonError, Weak};

/// A field over a grid. Both are borrowed: what was made of one that equals this is right, as nobody could write to either in
/// between.
#[derive(Debug, Clone)]
pub(super) struct Source {
    field: u64,
    grid: Weak<()>,
}

impl Source {
    pub fn new(grid: &Grid, field: &Field) -> Self {
        Source { field: field.number(), grid: grid.life() }
    }
}

impl PartialEq for Source {
    fn eq(&self, other: &Self) -> bool {
        self.field == other.field && self.grid.ptr_eq(&other.grid)
    }
}

/// What the visible blocks depend on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SightKey {
    pub source: Source,
    pub falling: bool,
    /// The clear values' bits.
    pub clear: Vec<[u64; 2]>,
}

/// What gradients depend on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LightKey {
    pub source: Source,
    pub falling: bool,
    /// What values are normalised to.
    pub range: [f64; 2],
    pub radius: Vec<f64>,
    pub packed: bool,
    /// The blocks in which they were wanted; all where it is `None`.
    pub sight: Option<SightKey>,
}

/// Something, and what it was made of: else memory.
#[derive(Debug)]
struct Slot<K, V> {
    key: Option<K>,
    value: V,
}

impl<K: PartialEq, V> Slot<K, V> {
    /// Takes what is there, and whether it is what is made of `key`.
    fn take(&mut self, key: &K, nothing: V) -> (bool, V) {
        let is_it = self.key.take().is_some_and(|known| known == *key);
        (is_it, std::mem::replace(&mut self.value, nothing))
    }

    fn keep(&mut self, key: K, value: V) {
        *self = Slot { key: Some(key), value };
    }
}

/// Least and greatest value, and how many are missing.
pub(super) type Range = (Option<[f64; 2]>, u64);

#[derive(Debug)]
struct Kept {
    range: Slot<Source, Range>,
    average: Slot<Source, Option<CenterField>>,
    visible: Slot<SightKey, Visible>,
    gradients: Slot<LightKey, Gradients>,
}

/// What no frame is using. Of frames that are drawn at once all but one find nothing here.
#[derive(Debug)]
pub(super) struct Spare {
    kept: Mutex<Kept>,
    /// Whether more than memory is used again.
    reuses: bool,
}

impl Default for Spare {
    fn default() -> Self {
        let kept = Kept {
            range: Slot { key: None, value: (None, 0) },
            average: Slot { key: None, value: None },
            visible: Slot { key: None, value: Visible::default() },
            gradients: Slot { key: None, value: Gradients::none() },
        };
        Spare { kept: Mutex::new(kept), reuses: true }
    }
}

impl Spare {
    /// The same, where more than memory is used again, or not.
    pub fn with_reuse(self, reuses: bool) -> Self {
        Spare { reuses, ..self }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The range of the field, by `find` unless it is known.
    pub fn range(&self, source: &Source, find: impl FnOnce() -> Range) -> Range {
        let (is_it, known) = self.kept().range.take(source, (None, 0));
        let range = if is_it && self.reuses { known } else { find() };
        self.kept().range.keep(source.clone(), range);
        range
    }

    /// A field at corners, averaged to the centres.
    pub fn average(&self, source: &Source, grid: &Grid, field: &Field) -> Result<CenterField> {
        let (is_it, known) = self.kept().average.take(source, None);
        match known {
            Some(known) if is_it && self.reuses => Ok(known),
            memory => CenterField::average_in(grid, field, memory),
        }
    }

    /// Takes an average back.
    pub fn keep_average(&self, source: Source, average: CenterField) {
        self.kept().average.keep(source, Some(average));
    }

    /// What can be seen, by `find` in the memory that it is given, unless it is known.
    pub fn visible(&self, key: &SightKey, find: impl FnOnce(Visible) -> Visible) -> Visible {
        let (is_it, known) = self.kept().visible.take(key, Visible::default());
        if is_it && self.reuses { known } else { find(known) }
    }

    /// Takes it back.
    pub fn keep_visible(&self, key: SightKey, visible: Visible) {
        self.kept().visible.keep(key, visible);
    }

    /// Gradients, by `compute` in the memory that it is given, unless they are known.
    pub fn gradients(&self, key: &LightKey, compute: impl FnOnce(Gradients) -> Gradients) -> Gradients {
        let (is_it, known) = self.kept().gradients.take(key, Gradients::none());
        if is_it && self.reuses { known } else { compute(known) }
    }

    /// Takes them back.
    pub fn keep_gradients(&self, key: LightKey, gradients: Gradients) {
        self.kept().gradients.keep(key, gradients);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Location;
    use crate::grid::IcosahedralMesh;
    use crate::shape::Shape;

    /// Values are known again for copies of the field over the same grid, once they were taken back, and for nothing else.
    #[test]
    fn only_the_same_borrow_is_known() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let grids = [Grid::new(mesh.tables()).unwrap(), Grid::new(mesh.tables()).unwrap()];
        let values = vec![0.5f32; 2 * grids[0].cells()];
        let shape = Shape::level_fastest(grids[0].cells(), 2);
        let field = || Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap();
        let (one, other) = (field(), field());
        let copy = one;
        let spare = Spare::default();
        let finds = |spare: &Spare, grid: &Grid, field: &Field| {
            let mut finds = 0;
            spare.range(&Source::new(grid, field), || {
                finds += 1;
                field.range()
            });
            finds
        };
        assert_eq!(finds(&spare, &grids[0], &one), 1);
        assert_eq!(finds(&spare, &grids[0], &copy), 0);
        assert_eq!(finds(&spare, &grids[1], &one), 1, "another grid");
        assert_eq!(finds(&spare, &grids[1], &other), 1, "the array may have been written to");
        assert_eq!(finds(&spare, &grids[1], &other), 0);
        assert_eq!(finds(&spare.with_reuse(false), &grids[1], &other), 1);
    }

    #[test]
    fn memory_of_another_field_is_given_on() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        let values = vec![0.5f32; 2 * grid.cells()];
        let field = || {
            Field::new(
                values.as_slice().into(),
                Shape::level_fastest(grid.cells(), 2),
                Location::Center,
                None,
            )
            .unwrap()
        };
        let key = |clear: f64| SightKey {
            source: Source::new(&grid, &field()),
            falling: false,
            clear: vec![[clear.to_bits(); 2]],
        };
        let spare = Spare::default();
        let first = key(0.1);
        let found = spare.visible(&first, |memory| Visible { blocks: vec![7; 9], ..memory });
        let place = found.blocks.as_ptr();
        spare.keep_visible(first.clone(), found);
        let known = spare.visible(&first, |_| panic!("it is known"));
        spare.keep_visible(first, known);
        let found = spare.visible(&key(0.1), |memory| memory);
        assert_eq!((found.blocks.as_ptr(), found.blocks.len()), (place, 9));
    }
}
