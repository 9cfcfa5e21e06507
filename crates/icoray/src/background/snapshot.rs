//! Copies fields at one time, so that the model can compute on while the frame is drawn.
//!
//! Only this module copies a model's data; the reports contain the bytes and seconds of that.

use crate::fields::Fields;
use crate::render::Renderer;
use icoray_grid::shape::ElementIndexer;
use icoray_grid::{Field, Location, OwnedReals, Reals, Result, Shape};
use rayon::prelude::*;
use std::mem::replace;

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
        self.copies.resize_with(fields.iter().count(), Default::default);
        renderer.run(|| {
            for ((name, copied), (given, field)) in self.copies.iter_mut().zip(fields.iter()) {
                given.clone_into(name);
                copied.take(field);
            }
            match fields.heights() {
                Some(heights) => self.heights.get_or_insert_default().take(heights),
                None => self.heights = None,
            }
        });
    }

    /// The copied fields.
    ///
    /// # Errors
    /// None in practice: copies keep the shapes of their fields.
    pub fn fields(&self) -> Result<Fields<'_>> {
        let copies = self.copies.iter().map(|(name, copied)| Ok((name.as_str(), copied.field()?)));
        let fields = Fields::new(copies.collect::<Result<Vec<_>>>()?);
        Ok(match &self.heights {
            Some(heights) => fields.with_heights(heights.field()?),
            None => fields,
        })
    }

    /// Number of copied bytes.
    pub fn bytes(&self) -> u64 {
        self.all().map(Copied::bytes).sum()
    }

    fn all(&self) -> impl Iterator<Item = &Copied> {
        self.copies.iter().map(|(_, copied)| copied).chain(&self.heights)
    }
}

/// A copy of one field.
#[derive(Debug, Clone)]
struct Copied {
    values: OwnedReals,
    columns: usize,
    layers: usize,
    location: Location,
    fill: Option<f64>,
}

impl Default for Copied {
    fn default() -> Self {
        Copied { values: OwnedReals::F32(Vec::new()), columns: 0, layers: 0, location: Location::Center, fill: None }
    }
}

impl Copied {
    fn take(&mut self, field: &Field) {
        let (shape, elements) = (*field.shape(), *field.elements());
        (self.columns, self.layers) = (shape.columns, shape.layers);
        (self.location, self.fill) = (field.location(), field.fill());
        // The other precision's memory is freed before this one's is allocated.
        let memory = replace(&mut self.values, OwnedReals::F32(Vec::new()));
        self.values = OwnedReals::buffer(field.samples(), Some(memory));
        match (field.samples(), &mut self.values) {
            (Reals::F32(from), OwnedReals::F32(to)) => copy(from, to, &shape, &elements),
            (Reals::F64(from), OwnedReals::F64(to)) => copy(from, to, &shape, &elements),
            _ => unreachable!("a buffer has the precision of the field"),
        }
    }

    fn field(&self) -> Result<Field<'_>> {
        let shape = Shape::level_fastest(self.columns, self.layers);
        Field::new(self.values.as_reals(), shape, self.location, self.fill)
    }

    fn bytes(&self) -> u64 {
        self.values.bytes() as u64
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
                    let fields = snapshot.fields().unwrap();
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

    #[test]
    fn fields_keep_their_names_places_and_heights() {
        let renderer = Renderer::new(2).unwrap();
        let (wide, narrow) = ([1.0, 2.0, 3.0, f64::NAN], [5.0f32, 6.0, 7.0, 8.0, 9.0, 10.0]);
        let a = Field::new(wide[..].into(), Shape::level_fastest(2, 2), Location::Center, Some(3.0)).unwrap();
        let b = Field::new(narrow[..].into(), Shape::cell_fastest(3, 2), Location::Corner, None).unwrap();
        let mut snapshot = copied(&Fields::new([("b", b), ("a", a)]).with_heights(a), &renderer);
        assert_eq!(snapshot.bytes(), 2 * 4 * 8 + 6 * 4);
        let fields = snapshot.fields().unwrap();
        assert_eq!(fields.iter().map(|(name, _)| name).collect::<Vec<_>>(), ["b", "a"]);
        for (copy, field) in [("a", a), ("b", b)].map(|(name, field)| (fields.get(name).unwrap(), field)) {
            assert_eq!((copy.location(), copy.fill()), (field.location(), field.fill()));
            assert_eq!(copy.value(1, 0).to_bits(), field.value(1, 0).to_bits());
        }
        assert_eq!(fields.heights().map(|heights| heights.value(0, 1)), Some(2.0));
        assert_eq!(fields.get("c").unwrap_err().context(), "the scene shows field \"c\", and there is [\"b\", \"a\"]");
        snapshot.take(&Fields::new([("a", a)]), &renderer);
        assert!(snapshot.fields().unwrap().heights().is_none() && snapshot.bytes() == 4 * 8);
    }

    #[test]
    fn nothing_copied_is_no_field() {
        let empty = Snapshot::default();
        let error = empty.fields().unwrap().first("q").unwrap_err();
        assert_eq!((error.kind(), empty.bytes()), (icoray_grid::ErrorKind::Scene, 0));
        assert_eq!(error.context(), "the scene shows field \"q\", and there is []");
    }
}
