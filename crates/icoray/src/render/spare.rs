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
    /// Heights of layers where columns have their own, and planet radii per metre of height.
    pub heights: Option<(Source, f64)>,
}

/// What a field on other layers than its own depends on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MovedKey {
    pub source: Source,
    /// Radii of the field's layers.
    pub own: Vec<f64>,
    /// Radii of those to which it was brought.
    pub wanted: Vec<f64>,
}

/// What the normals of a layer depend on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NormalKey {
    /// Heights of layers, and planet radii per metre of height.
    pub heights: (Source, f64),
    /// The layer, of how many that the field has.
    pub layer: [usize; 2],
}

/// Things of one kind, and what each was made of. As many as frames had of them at once; the one that was taken back first
/// comes first.
#[derive(Debug)]
struct Shelf<K, V>(Vec<(K, V)>);

impl<K, V> Default for Shelf<K, V> {
    fn default() -> Self {
        Shelf(Vec::new())
    }
}

impl<K: PartialEq, V> Shelf<K, V> {
    /// Takes what was made of `key`, or else the first for its memory, and whether it is what is sought. Where a frame asks for
    /// several in the same order as the last, that is what was in the place of the one that is new.
    fn take(&mut self, key: &K) -> (bool, Option<V>) {
        let found = self.0.iter().position(|(known, _)| known == key);
        let is_there = !self.0.is_empty();
        (found.is_some(), is_there.then(|| self.0.remove(found.unwrap_or(0)).1))
    }

    fn keep(&mut self, key: K, value: V) {
        self.0.push((key, value));
    }
}

/// Least and greatest value, and how many are missing.
pub(super) type Range = (Option<[f64; 2]>, u64);

#[derive(Debug, Default)]
struct Kept {
    range: Shelf<Source, Range>,
    average: Shelf<Source, CenterField>,
    moved: Shelf<MovedKey, CenterField>,
    visible: Shelf<SightKey, Visible>,
    gradients: Shelf<LightKey, Gradients>,
    normals: Shelf<NormalKey, Vec<[f32; 3]>>,
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
        Spare { kept: Mutex::default(), reuses: true }
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
        let (is_it, known) = self.kept().range.take(source);
        let range = known.filter(|_| is_it && self.reuses).unwrap_or_else(find);
        self.kept().range.keep(source.clone(), range);
        range
    }

    /// A field at corners, averaged to the centres.
    pub fn average(&self, source: &Source, grid: &Grid, field: &Field) -> Result<CenterField> {
        let (is_it, known) = self.kept().average.take(source);
        match known {
            Some(known) if is_it && self.reuses => Ok(known),
            memory => CenterField::average_in(grid, field, memory),
        }
    }

    /// Takes an average back.
    pub fn keep_average(&self, source: Source, average: CenterField) {
        self.kept().average.keep(source, average);
    }

    /// A field on other layers than its own, by `make` in the memory that it is given, unless it is known.
    pub fn moved(
        &self,
        key: &MovedKey,
        make: impl FnOnce(Option<CenterField>) -> CenterField,
    ) -> CenterField {
        let (is_it, known) = self.kept().moved.take(key);
        match known {
            Some(known) if is_it && self.reuses => known,
            memory => make(memory),
        }
    }

    /// Takes it back.
    pub fn keep_moved(&self, key: MovedKey, moved: CenterField) {
        self.kept().moved.keep(key, moved);
    }

    /// What can be seen, by `find` in the memory that it is given, unless it is known.
    pub fn visible(&self, key: &SightKey, find: impl FnOnce(Visible) -> Visible) -> Visible {
        let (is_it, known) = self.kept().visible.take(key);
        let known = known.unwrap_or_default();
        if is_it && self.reuses { known } else { find(known) }
    }

    /// Takes it back.
    pub fn keep_visible(&self, key: SightKey, visible: Visible) {
        self.kept().visible.keep(key, visible);
    }

    /// Gradients, by `compute` in the memory that it is given, unless they are known.
    pub fn gradients(&self, key: &LightKey, compute: impl FnOnce(Gradients) -> Gradients) -> Gradients {
        let (is_it, known) = self.kept().gradients.take(key);
        let known = known.unwrap_or_else(Gradients::none);
        if is_it && self.reuses { known } else { compute(known) }
    }

    /// Normals of a layer, by `compute` in the memory that it is given, unless they are known.
    pub fn normals(
        &self,
        key: &NormalKey,
        compute: impl FnOnce(Vec<[f32; 3]>) -> Vec<[f32; 3]>,
    ) -> Vec<[f32; 3]> {
        let (is_it, known) = self.kept().normals.take(key);
        let known = known.unwrap_or_default();
        if is_it && self.reuses { known } else { compute(known) }
    }

    /// Takes them back.
    pub fn keep_normals(&self, key: NormalKey, normals: Vec<[f32; 3]>) {
        self.kept().normals.keep(key, normals);
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
