//! A copy of a field as it is now, so that the model can compute on while the frame is drawn.
//!
//! It is the one place where icoray copies a model's data, and the reports say how many bytes and seconds that takes.

use crate::error::Result;
use crate::field::{Field, Location};
use crate::grid::Reals;
use crate::render::Renderer;
use crate::shape::{Elements, Shape};
use rayon::prelude::*;

/// An owned copy of a field's values, level-fastest, in the field's own precision and with its fill value and location.
///
/// Its memory is used again by the next copy, so that a run of frames of one field allocates once.
#[derive(Debug, Clone)]
pub struct Snapshot {
    values: Values,
    columns: usize,
    layers: usize,
    location: Location,
    fill: Option<f64>,
}

#[derive(Debug, Clone)]
enum Values {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl Snapshot {
    /// A snapshot of no field yet, which takes no memory.
    pub fn empty() -> Self {
        Snapshot {
            values: Values::F32(Vec::new()),
            columns: 0,
            layers: 0,
            location: Location::Center,
            fill: None,
        }
    }

    /// A copy of `field`, made on the renderer's threads.
    pub fn of(field: &Field, renderer: &Renderer) -> Self {
        let mut snapshot = Self::empty();
        snapshot.take(field, renderer);
        snapshot
    }

    /// Copies `field` in place of what was copied before, on the renderer's threads. Memory is allocated only where the
    /// field is larger than any before it or of another precision.
    pub fn take(&mut self, field: &Field, renderer: &Renderer) {
        let (shape, elements) = (*field.shape(), *field.elements());
        (self.columns, self.layers) = (shape.columns, shape.layers);
        (self.location, self.fill) = (field.location(), field.fill());
        renderer.run(|| match (field.samples(), &mut self.values) {
            (Reals::F32(from), Values::F32(to)) => copy(from, to, &shape, &elements),
            (Reals::F64(from), Values::F64(to)) => copy(from, to, &shape, &elements),
            (Reals::F32(from), values) => {
                // The other precision's memory goes before this one's comes.
                *values = Values::F32(Vec::new());
                let Values::F32(to) = values else { unreachable!("just set") };
                copy(from, to, &shape, &elements);
            }
            (Reals::F64(from), values) => {
                *values = Values::F64(Vec::new());
                let Values::F64(to) = values else { unreachable!("just set") };
                copy(from, to, &shape, &elements);
            }
        });
    }

    /// The copied field.
    ///
    /// # Errors
    /// [`ErrorKind::Field`](crate::ErrorKind::Field) when nothing was copied yet.
    pub fn field(&self) -> Result<Field<'_>> {
        let samples = match &self.values {
            Values::F32(v) => v.as_slice().into(),
            Values::F64(v) => v.as_slice().into(),
        };
        Field::new(samples, Shape::level_fastest(self.columns, self.layers), self.location, self.fill)
    }

    /// Bytes that were copied.
    pub fn bytes(&self) -> u64 {
        let bytes = match &self.values {
            Values::F32(v) => size_of_val(v.as_slice()),
            Values::F64(v) => size_of_val(v.as_slice()),
        };
        bytes as u64
    }
}

/// Columns that are copied together: enough for whole cache lines of a layer in a cell-fastest array, few enough to stay
/// in the first cache.
const BLOCK: usize = 64;

/// Copies what `shape` says of `from` to `to`, level-fastest.
fn copy<S: Copy + Default + Send + Sync>(from: &[S], to: &mut Vec<S>, shape: &Shape, elements: &Elements) {
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
        let mut used = Snapshot::empty();
        for shape in shapes() {
            for (samples, bytes) in [(Reals::from(wide.as_slice()), 8), (Reals::from(single.as_slice()), 4)] {
                let field = Field::new(samples, shape, Location::Corner, Some(50.0)).unwrap();
                used.take(&field, &renderer);
                for snapshot in [&used, &Snapshot::of(&field, &renderer)] {
                    let copy = snapshot.field().unwrap();
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
        let place = |snapshot: &Snapshot| match &snapshot.values {
            Values::F32(v) => (v.as_ptr(), v.capacity()),
            Values::F64(_) => panic!("the precision changed"),
        };
        let mut snapshot = Snapshot::of(&of(Shape::level_fastest(COLUMNS, LAYERS)), &renderer);
        let before = place(&snapshot);
        for shape in shapes().into_iter().chain([Shape::level_fastest(9, 2)]) {
            snapshot.take(&of(shape), &renderer);
            assert_eq!(place(&snapshot), before);
        }
        assert_eq!(snapshot.bytes(), 9 * 2 * 4);
    }

    #[test]
    fn nothing_copied_is_no_field() {
        let error = Snapshot::empty().field().unwrap_err();
        assert_eq!((error.kind(), Snapshot::empty().bytes()), (crate::ErrorKind::Field, 0));
    }
}
