//! Computes derived values, a run of columns at a time: reads inputs of any layout into f64, processes them in loops
//! that the compiler vectorises, and writes the requested precision.

use super::zonal::Means;
use fearless_simd::{Level, dispatch};
use icoray_grid::sample::Sample;
use icoray_grid::{Field, OwnedReals, Reals};
use rayon::prelude::*;
use std::ops::Range;

/// Values of a run: several runs fit into the first-level cache.
const RUN: usize = 2048;

/// The operation on a run of values.
#[derive(Debug)]
pub(super) enum Operation<'o> {
    /// The length of the vector of all inputs.
    Magnitude,
    /// The weighted sum of the inputs.
    Sum(Vec<f64>),
    /// The input minus the mean of its latitude.
    FromMeans(&'o Means<'o>),
}

/// Fills `values` with the results of the operation on some columns of inputs at the same location.
pub(super) fn fill(values: OwnedReals, inputs: &[Field], operation: &Operation, columns: Range<usize>) -> OwnedReals {
    match values {
        OwnedReals::F32(memory) => OwnedReals::F32(filled(memory, inputs, operation, columns)),
        OwnedReals::F64(memory) => OwnedReals::F64(filled(memory, inputs, operation, columns)),
    }
}

fn filled<S: Sample + Default>(
    mut values: Vec<S>,
    inputs: &[Field],
    operation: &Operation,
    columns: Range<usize>,
) -> Vec<S> {
    let layers = inputs[0].shape().layers;
    values.reserve_exact((columns.len() * layers).saturating_sub(values.len()));
    values.resize(columns.len() * layers, S::default());
    let level = Level::new();
    let buffers = || vec![Vec::new(); inputs.len() + 1];
    let rows = (RUN / layers).max(1);
    values.par_chunks_mut(rows * layers).enumerate().for_each_init(buffers, |buffers, (n, to)| {
        let first = columns.start + n * rows;
        let columns = first..first + to.len() / layers;
        let (result, loaded) = buffers.split_first_mut().expect("one more than inputs");
        loaded.iter_mut().zip(inputs).for_each(|(run, input)| load(input, columns.clone(), run));
        result.clear();
        result.resize(to.len(), 0.0);
        match operation {
            Operation::Magnitude => dispatch!(level, _simd => magnitude(loaded, result)),
            Operation::Sum(factors) => dispatch!(level, _simd => sum(factors, loaded, result)),
            Operation::FromMeans(means) => {
                dispatch!(level, _simd => from_means(means, columns, &loaded[0], result));
            }
        }
        to.iter_mut().zip(result).for_each(|(to, value)| *to = S::near(*value));
    });
    values
}

/// Reads the values of some columns, level-fastest; NaN where one is missing.
pub(super) fn load(field: &Field, columns: Range<usize>, to: &mut Vec<f64>) {
    match field.samples() {
        Reals::F32(samples) => load_of(samples, field, columns, to),
        Reals::F64(samples) => load_of(samples, field, columns, to),
    }
}

fn load_of<S: Sample>(samples: &[S], field: &Field, columns: Range<usize>, to: &mut Vec<f64>) {
    let (elements, layers) = (field.elements(), field.shape().layers);
    let fill = field.fill().unwrap_or(f64::NAN);
    let read = |sample: S| {
        let value = sample.wide();
        if (value.abs() <= f64::MAX) & (value != fill) { value } else { f64::NAN }
    };
    to.clear();
    to.resize(columns.len() * layers, 0.0);
    if elements.layer_stride() == 1 {
        for (column, row) in columns.zip(to.chunks_exact_mut(layers)) {
            let start = elements.at(elements.base(column), 0);
            let samples = &samples[start..start + layers];
            row.iter_mut().zip(samples).for_each(|(value, sample)| *value = read(*sample));
        }
        return;
    }
    // Columns are mostly adjacent, and layers far apart.
    let bases: Vec<isize> = columns.map(|column| elements.base(column)).collect();
    for layer in 0..layers {
        for (value, base) in to[layer..].iter_mut().step_by(layers).zip(&bases) {
            *value = read(samples[elements.at(*base, layer)]);
        }
    }
}

/// Lengths of vectors; their squares may overflow or underflow f64.
#[inline(always)]
fn magnitude(inputs: &[Vec<f64>], to: &mut [f64]) {
    let power = |exponent: i64| f64::from_bits(((1023 + exponent) as u64) << 52);
    let (far, down, up) = (power(500), power(-600), power(600));
    let scale = |largest: f64| {
        let small = if largest < 1.0 / far { up } else { 1.0 };
        if largest > far { down } else { small }
    };
    // The scale is a power of 2, which rounds nothing: `to` has first the largest component, then the length.
    for input in inputs {
        to.iter_mut().zip(input).for_each(|(largest, value)| *largest = largest.max(value.abs()));
    }
    let mut squares = [0.0; 64];
    for (n, to) in to.chunks_mut(squares.len()).enumerate() {
        let squares = &mut squares[..to.len()];
        squares.fill(0.0);
        for input in inputs {
            let input = &input[n * 64..][..to.len()];
            for ((square, largest), value) in squares.iter_mut().zip(&*to).zip(input) {
                let scaled = value * scale(*largest);
                *square += scaled * scaled;
            }
        }
        for (to, square) in to.iter_mut().zip(squares) {
            *to = square.sqrt() / scale(*to);
        }
    }
}

#[inline(always)]
fn sum(factors: &[f64], inputs: &[Vec<f64>], to: &mut [f64]) {
    for (factor, input) in factors.iter().zip(inputs) {
        to.iter_mut().zip(input).for_each(|(sum, value)| *sum += factor * value);
    }
}

#[inline(always)]
fn from_means(means: &Means, columns: Range<usize>, from: &[f64], to: &mut [f64]) {
    let layers = to.len() / columns.len();
    let rows = to.chunks_exact_mut(layers).zip(from.chunks_exact(layers));
    columns.zip(rows).for_each(|(column, (to, row))| means.take_off(column, row, to));
}
