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
    to.par_chunks_mut(BLOCK * layers).enumerate().for_each(|(block, to)| {
        let first = block * BLOCK;
        if shape.layer_stride == 1 {
            for (column, to) in to.chunks_exact_mut(layers).enumerate() {
                let start = elements.at(elements.base(first + column), 0);
                to.copy_from_slice(&from[start..start + layers]);
            }
            return;
        }
        for layer in 0..layers {
            for column in 0..to.len() / layers {
                to[column * layers + layer] = from[elements.at(elements.base(first + column), layer)];
            }
        }
    });
}
