//! Copies fields at one time, so that the model can compute on while the frame is drawn.
//!
//! Only this module copies a model's data; the reports contain the bytes and seconds of that.

use crate::fields::{FieldLayout, Fields};
use crate::render::Renderer;
use icoray_grid::shape::ElementIndexer;
use icoray_grid::{Field, OwnedReals, Reals, Shape};
use rayon::prelude::*;
use std::mem::take;

/// Owned copies of fields, and of the heights of their columns if there are any: level-fastest, each in its own
/// precision and with its fill value and location.
///
/// The next copies reuse their memory, so that a series of frames of the same fields allocates once.
#[derive(Debug, Clone, Default)]
pub(super) struct Snapshot {
    /// The copies by name, in the order of the fields.
    copies: Vec<(String, Copied)>,
    heights: Option<Copied>,
}

impl Snapshot {
    /// Replaces the copies by those of `fields`, made on the renderer's threads. Memory is allocated only if a field is
    /// larger than any before it at its place in the list, or has another precision.
    pub fn take(&mut self, fields: &Fields, renderer: &Renderer) {
        let Snapshot { copies, heights } = take(self);
        let mut memory = copies.into_iter().map(|(_, copied)| copied.values);
        renderer.run(|| {
            let copied = fields.iter().map(|(name, field)| (name.to_owned(), Copied::of(field, memory.next())));
            self.copies = copied.collect();
            self.heights = fields.heights().map(|field| Copied::of(field, heights.map(|copied| copied.values)));
        });
    }

    pub fn fields(&self) -> Fields<'_> {
        let fields = Fields::new(self.copies.iter().map(|(name, copied)| (name.as_str(), copied.field())));
        fields.with_heights(self.heights.as_ref().map(Copied::field))
    }

    pub fn bytes(&self) -> u64 {
        self.all().map(|copied| copied.values.bytes() as u64).sum()
    }

    fn all(&self) -> impl Iterator<Item = &Copied> {
        self.copies.iter().map(|(_, copied)| copied).chain(&self.heights)
    }
}

#[derive(Debug, Clone)]
struct Copied {
    values: OwnedReals,
    at: FieldLayout,
    fill: Option<f64>,
}

impl Copied {
    fn of(field: &Field, memory: Option<OwnedReals>) -> Self {
        let (shape, elements) = (field.shape(), field.elements());
        let mut values = OwnedReals::buffer(field.samples(), memory);
        match (field.samples(), &mut values) {
            (Reals::F32(from), OwnedReals::F32(to)) => copy(from, to, shape, elements),
            (Reals::F64(from), OwnedReals::F64(to)) => copy(from, to, shape, elements),
            _ => unreachable!("a buffer has the precision of the field"),
        }
        Copied { values, at: FieldLayout::of(field), fill: field.fill() }
    }

    fn field(&self) -> Field<'_> {
        self.at.field(self.values.as_reals(), self.fill)
    }
}

/// Columns that are copied together: enough for whole cache lines of a layer in a cell-fastest array, few enough to
/// stay in the first-level cache.
const BLOCK: usize = 64;

/// Copies the elements of `from` in the layout `shape` to `to`, level-fastest.
fn copy<S: Copy + Default + Send + Sync>(from: &[S], to: &mut Vec<S>, shape: &Shape, elements: &ElementIndexer) {
    let layers = shape.layers;
    to.resize(shape.columns * layers, S::default());
    let is_level_fastest = shape.layer_stride.unsigned_abs() <= shape.column_stride.unsigned_abs();
    to.par_chunks_mut(BLOCK * layers).enumerate().for_each(|(block, to)| {
        let first = block * BLOCK;
        if shape.layer_stride == 1 {
            for (column, to) in to.chunks_exact_mut(layers).enumerate() {
                let start = elements.at(elements.base(first + column), 0);
                to.copy_from_slice(&from[start..start + layers]);
            }
        } else if is_level_fastest {
            for (column, to) in to.chunks_exact_mut(layers).enumerate() {
                let base = elements.base(first + column);
                to.iter_mut().enumerate().for_each(|(layer, to)| *to = from[elements.at(base, layer)]);
            }
        } else {
            for layer in 0..layers {
                let to = to[layer..].iter_mut().step_by(layers);
                to.enumerate().for_each(|(column, to)| {
                    *to = from[elements.at(elements.base(first + column), layer)];
                });
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_grid::Location;

    fn copied(fields: &Fields, renderer: &Renderer) -> Snapshot {
        let mut snapshot = Snapshot::default();
        snapshot.take(fields, renderer);
        snapshot
    }

    const COLUMNS: usize = 150;
    const LAYERS: usize = 3;
    /// Elements of the array that the shapes below are of.
    const LENGTH: usize = 800;

    /// 150 columns of 3 layers as models have them, and turned round.
    fn shapes() -> Vec<Shape> {
        let level = Shape::level_fastest(COLUMNS, LAYERS);
        let padded = Shape { column_stride: 5, offset: 2, ..level };
        let cell = Shape { layer_stride: 200, offset: 7, ..Shape::cell_fastest(COLUMNS, LAYERS) };
        let upside_down = Shape { layer_stride: -1, offset: LAYERS - 1, ..level };
        let backwards = Shape { column_stride: -5, offset: 5 * COLUMNS, ..padded };
        let both = Shape { column_stride: -1, layer_stride: -200, offset: 700, ..cell };
        vec![level, padded, cell, upside_down, backwards, both]
    }

    #[test]
    fn every_layout_is_copied_value_by_value() {
        let renderer = Renderer::new(2).unwrap();
        let wide: Vec<f64> = (0..LENGTH).map(|i| if i % 11 == 0 { f64::NAN } else { i as f64 }).collect();
        let single: Vec<f32> = wide.iter().map(|v| *v as f32).collect();
        let mut used = Snapshot::default();
        for shape in shapes() {
            for (samples, bytes) in [(Reals::from(wide.as_slice()), 8), (Reals::from(single.as_slice()), 4)] {
                let field = Field::new(samples, shape, Location::Corner, Some(50.0)).unwrap();
                let fields = Fields::new([("q", field)]);
                used.take(&fields, &renderer);
                for snapshot in [&used, &copied(&fields, &renderer)] {
                    let fields = snapshot.fields();
                    let copy = *fields.get("q").unwrap();
                    assert_eq!(*copy.shape(), Shape::level_fastest(COLUMNS, LAYERS));
                    assert_eq!((copy.location(), copy.fill()), (Location::Corner, Some(50.0)));
                    assert_eq!(snapshot.bytes(), (COLUMNS * LAYERS * bytes) as u64);
                    assert_eq!(copy.samples().len() * bytes, snapshot.bytes() as usize);
                    for (column, layer) in (0..COLUMNS).flat_map(|c| (0..LAYERS).map(move |l| (c, l))) {
                        let [one, other] = [field, copy].map(|f| f.value(column, layer));
                        assert_eq!(one.to_bits(), other.to_bits(), "({column}, {layer}) of {shape:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn memory_is_used_again() {
        let renderer = Renderer::new(1).unwrap();
        let values: Vec<f32> = (0..LENGTH).map(|i| i as f32).collect();
        let of = |shape| Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap();
        let place = |copied: &Copied| match &copied.values {
            OwnedReals::F32(v) => (v.as_ptr(), v.capacity()),
            OwnedReals::F64(_) => panic!("the precision changed"),
        };
        let places = |snapshot: &Snapshot| snapshot.all().map(place).collect::<Vec<_>>();
        let all = |shape| Fields::new([("a", of(shape)), ("b", of(shape))]).with_heights(of(shape));
        let mut snapshot = copied(&all(Shape::level_fastest(COLUMNS, LAYERS)), &renderer);
        let before = places(&snapshot);
        assert_eq!(before.len(), 3);
        for shape in shapes().into_iter().chain([Shape::level_fastest(9, 2)]) {
            snapshot.take(&all(shape), &renderer);
            assert_eq!(places(&snapshot), before);
        }
        assert_eq!(snapshot.bytes(), 3 * 9 * 2 * 4);
        // One field's memory stays, that of what is no longer asked for goes.
        snapshot.take(&Fields::new([("a", of(Shape::level_fastest(5, 2)))]), &renderer);
        assert_eq!((places(&snapshot).as_slice(), snapshot.bytes()), (&before[..1], 5 * 2 * 4));
    }
}
