//! Cache between frames: buffers as large as the grid, so that a series of frames allocates them once, and their
//! content if the next frame shows the same field.

use super::levels::LevelCache;
use crate::plan::FrameMemory;
use crate::ranges::RangeAndMissing;
use icoray_grid::gradient::PartialGradients;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::{ComputedField, Field, Grid};
use std::sync::{Mutex, PoisonError, Weak};

/// Identifies a field over a grid. Both are borrowed and cannot have changed, so values computed for an equal key are
/// valid.
#[derive(Debug, Clone)]
pub(super) struct SourceKey {
    field: u64,
    grid: Weak<()>,
}

impl SourceKey {
    pub fn new(grid: &Grid, field: &Field) -> Self {
        SourceKey { field: field.number(), grid: grid.lifetime_token() }
    }
}

impl PartialEq for SourceKey {
    fn eq(&self, other: &Self) -> bool {
        self.field == other.field && self.grid.ptr_eq(&other.grid)
    }
}

/// Key of visible blocks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OccupancyKey {
    /// The fields that are seen, with the bits of their clear values.
    pub fields: Vec<(SourceKey, Vec<[u64; 2]>)>,
    pub falling: bool,
    /// Whether macrocells were found too.
    pub leaps: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct GradientKey {
    pub source: SourceKey,
    pub falling: bool,
    /// Range to which values are normalised.
    pub range: [f64; 2],
    pub radius: Vec<f64>,
    pub packed: bool,
    /// Whether they are in single precision.
    pub single: bool,
    /// The visible blocks in which they are computed; all if there is none.
    pub occupancy: Option<OccupancyKey>,
    /// Heights of layers if columns have their own, and planet radii per metre of height.
    pub heights: Option<(SourceKey, f64)>,
}

/// Key of a field that was moved to other layers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MovedKey {
    pub source: SourceKey,
    /// Radii of the field's layers.
    pub own: Vec<f64>,
    /// Radii of the layers to which it was moved.
    pub wanted: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct NormalKey {
    /// Heights of layers, and planet radii per metre of height.
    pub heights: (SourceKey, f64),
    /// The layer, and the field's number of layers.
    pub layer: [usize; 2],
}

/// Cached values of one kind with their keys, the oldest first.
#[derive(Debug)]
pub(super) struct CacheSlots<K, V> {
    entries: Mutex<Vec<(K, V)>>,
    /// Whether contents are reused, not only allocations.
    reuses: bool,
}

impl<K, V> Default for CacheSlots<K, V> {
    fn default() -> Self {
        CacheSlots { entries: Mutex::default(), reuses: true }
    }
}

impl<K: PartialEq, V> CacheSlots<K, V> {
    /// Removes and returns the value for `key`. If there is none, the error is the oldest value, to reuse its
    /// allocation. When frames request several values in the same order, the oldest is the one that the new value
    /// replaces.
    pub fn take(&self, key: &K) -> Result<V, Option<V>> {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let found = entries.iter().position(|(known, _)| known == key);
        if entries.is_empty() {
            return Err(None);
        }
        let (_, value) = entries.remove(found.unwrap_or(0));
        if found.is_some() && self.reuses { Ok(value) } else { Err(Some(value)) }
    }

    /// The bytes of all values.
    pub fn bytes(&self, of: impl Fn(&V) -> usize) -> u64 {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.iter().map(|(_, value)| of(value) as u64).sum()
    }

    /// Stores a value for the next frame.
    pub fn store(&self, key: K, value: V) {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner).push((key, value));
    }
}

/// The cached values that no frame is using. Of concurrent frames all but one find it empty.
#[derive(Debug, Default)]
pub(super) struct FrameCache {
    ranges: CacheSlots<SourceKey, RangeAndMissing>,
    /// Fields at corners, averaged to the centres.
    pub averages: CacheSlots<SourceKey, ComputedField>,
    /// Fields on other layers than their own.
    pub moved: CacheSlots<MovedKey, ComputedField>,
    pub visible: CacheSlots<OccupancyKey, OccupancyMask<'static>>,
    /// Gradients of the cells that rays of the pictures so far could pass.
    pub gradients: CacheSlots<GradientKey, PartialGradients<'static>>,
    pub normals: CacheSlots<NormalKey, Vec<[f32; 3]>>,
    /// Coarser grids, with the last picture's values.
    pub levels: LevelCache,
}

impl FrameCache {
    /// Sets whether contents are reused, not only allocations.
    pub fn with_reuse(mut self, reuses: bool) -> Self {
        self.ranges.reuses = reuses;
        self.averages.reuses = reuses;
        self.moved.reuses = reuses;
        self.visible.reuses = reuses;
        self.gradients.reuses = reuses;
        self.normals.reuses = reuses;
        self
    }

    /// The memory of a frame that neither this cache nor the grid already has.
    pub fn missing(&self, all: FrameMemory) -> FrameMemory {
        FrameMemory {
            grid: 0,
            averages: 0,
            derived: 0,
            occupancy: all.occupancy.saturating_sub(self.visible.bytes(OccupancyMask::own_bytes)),
            gradients: all.gradients.saturating_sub(self.gradients.bytes(PartialGradients::own_bytes)),
            picture: all.picture,
        }
    }

    /// The range of the field; calls `find` if it is not cached.
    pub fn range(&self, source: &SourceKey, find: impl FnOnce() -> RangeAndMissing) -> RangeAndMissing {
        let range = self.ranges.take(source).unwrap_or_else(|_| find());
        self.ranges.store(source.clone(), range);
        range
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::{Model, at_centers, even_heights};
    use crate::render::Renderer;
    use icoray_grid::{IcosahedralMesh, Location};
    use icoray_scene::Scene;

    /// Values are found again for copies of the field over the same grid, once they were stored, and for no other.
    #[test]
    fn only_the_same_borrow_hits_the_cache() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let grids = [Grid::new(mesh.tables()).unwrap(), Grid::new(mesh.tables()).unwrap()];
        let values = vec![0.5f32; 2 * grids[0].cells()];
        let field = || Field::level_fastest(&values, 2, Location::Center).unwrap();
        let (one, other) = (field(), field());
        let copy = one;
        let cache = FrameCache::default();
        let finds = |cache: &FrameCache, grid: &Grid, field: &Field| {
            let mut finds = 0;
            cache.range(&SourceKey::new(grid, field), || {
                finds += 1;
                field.range()
            });
            finds
        };
        assert_eq!(finds(&cache, &grids[0], &one), 1);
        assert_eq!(finds(&cache, &grids[0], &copy), 0);
        assert_eq!(finds(&cache, &grids[1], &one), 1, "another grid");
        assert_eq!(finds(&cache, &grids[1], &other), 1, "the array may have been written to");
        assert_eq!(finds(&cache, &grids[1], &other), 0);
        assert_eq!(finds(&cache.with_reuse(false), &grids[1], &other), 1);
    }

    /// A close-up computes a few cells' gradients; the next view adds those that it needs besides, and the same view
    /// none.
    #[test]
    fn each_view_adds_the_gradients_that_it_needs() {
        let value = |cell: usize, layer: usize| ((3 * cell + layer) as f64 * 0.37).sin().abs();
        let heights = even_heights(3, 200e3 / 6.371e6);
        let model = Model::new(5, &heights, |cell, _, layer| [value(cell, layer)]);
        let (cells, field) = (model.grid.cells(), at_centers(&model.values[0], 3));
        let renderer = Renderer::new(1).unwrap();
        let computed = ["lon = 10, lat = 20", "lon = 10, lat = 20", "lon = 200, lat = -30"].map(|place| {
            let scene = Scene::parse(&format!(
                "field = 'f'
                 image = {{ width = 24, height = 24 }}
                 camera = {{ {place}, distance = 1.5, fov = 20 }}
                 light = {{ kind = 'headlight' }}
                 transfer = {{ range = [0, 1], opacity = [[0, 0.5], [1, 0.5]] }}"
            ));
            renderer.render(&scene.unwrap(), &model.grid, &model.layers, &field).unwrap();
            let entries = renderer.frame_cache.gradients.entries.lock().unwrap();
            entries.last().expect("the gradients of the last picture").1.computed_cells(cells)
        });
        let [first, again, both] = computed;
        assert!(first > 50 && first < cells / 10, "{first} of {cells}");
        assert_eq!(first, again);
        assert!(both > first + 50 && both < cells / 5, "{both} of {cells}");
    }
}
