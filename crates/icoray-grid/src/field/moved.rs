//! Interpolates fields to other layers: from interfaces to the layers midway between them, or vice versa.

use super::Field;
use crate::reals::{OwnedReals, resized};
use crate::sample::Sample;
use rayon::prelude::*;
use std::ops::Range;

/// A layer between two others, or one of them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Between {
    layers: [usize; 2],
    weight: f64,
}

/// Interpolates `field`, whose layers lie at the radii `own`, linearly to the radii `wanted`; beyond the outer layers it
/// takes the value of the nearest one. A value is missing if one of the two around it is. Both lists are in one unit,
/// and both rise or both fall. Level-fastest over these columns, in the precision of the field and in `memory` if that
/// has the same.
pub fn moved(
    field: &Field,
    [own, wanted]: [&[f64]; 2],
    columns: Range<usize>,
    memory: Option<OwnedReals>,
) -> OwnedReals {
    let between: Vec<Between> = wanted.iter().map(|radius| bracket(own, *radius)).collect();
    match OwnedReals::buffer(field.samples(), memory) {
        OwnedReals::F32(memory) => OwnedReals::F32(filled(field, &between, columns, memory)),
        OwnedReals::F64(memory) => OwnedReals::F64(filled(field, &between, columns, memory)),
    }
}

fn bracket(own: &[f64], radius: f64) -> Between {
    let rises = own[own.len() - 1] > own[0];
    let before = own.partition_point(|r| if rises { *r <= radius } else { *r >= radius });
    let low = before.clamp(1, own.len() - 1) - 1;
    let weight = ((radius - own[low]) / (own[low + 1] - own[low])).clamp(0.0, 1.0);
    Between { layers: [low, low + 1], weight }
}

fn filled<S: Sample>(field: &Field, between: &[Between], columns: Range<usize>, memory: Vec<S>) -> Vec<S> {
    let mut values = resized(memory, columns.len() * between.len());
    let rows = values.par_chunks_exact_mut(between.len()).with_min_len(256).enumerate();
    rows.for_each(|(row, values)| {
        let column = columns.start + row;
        for (value, Between { layers, weight }) in values.iter_mut().zip(between) {
            let [low, high] = layers.map(|layer| field.value(column, layer));
            *value = S::of(match *weight {
                0.0 => low,
                1.0 => high,
                weight => low + weight * (high - low),
            });
        }
    });
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{ComputedField, Location};
    use crate::shape::Shape;

    fn moved_whole(field: &Field, own: &[f64], wanted: &[f64]) -> ComputedField {
        ComputedField::new(moved(field, [own, wanted], 0..field.shape().columns, None), Location::Center, wanted.len())
    }

    #[test]
    fn interfaces_and_the_layers_between_them_are_brought_to_each_other() {
        let values = [0.0f64, 2.0, 6.0, 10.0, f64::NAN, 30.0];
        let field = Field::level_fastest(&values[..], 3, Location::Center).unwrap();
        let between = moved_whole(&field, &[1.0, 2.0, 4.0], &[1.5, 3.0]);
        let of = |column| [0, 1].map(|layer| between.field().value(column, layer));
        assert_eq!(of(0), [1.0, 4.0]);
        assert!(of(1).iter().all(|value| value.is_nan()));
        let out = moved_whole(&between.field(), &[1.5, 3.0], &[1.0, 2.0, 4.0]);
        assert_eq!([0, 1, 2].map(|layer| out.field().value(0, layer)), [1.0, 2.0, 4.0]);
    }

    #[test]
    fn falling_layers_are_as_good() {
        let field =
            Field::new([6.0f32, 2.0, 0.0].as_slice().into(), Shape::level_fastest(1, 3), Location::Center, None)
                .unwrap();
        let between = moved_whole(&field, &[4.0, 2.0, 1.0], &[3.0, 1.5]);
        assert_eq!([0, 1].map(|layer| between.field().value(0, layer)), [4.0, 1.0]);
    }
}
