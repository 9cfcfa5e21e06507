//! The transfer function: colour and extinction, piecewise linear in the field's value.

use super::color;
use crate::kernel::transfer::KernelKnot;

/// Steps that a named colour map is cut into. Linear light between them is within 1/255 of the map.
const MAP_STEPS: usize = 32;

/// A knot of the transfer function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Field value, in the field's units.
    pub value: f64,
    /// Linear RGB, 0 to 1, not premultiplied.
    pub color: [f64; 3],
    /// Optical depth per unit length.
    pub extinction: f64,
}

/// Colour and extinction between knots, constant beyond the first and the last.
///
/// Knots rise; two of them may share a value, which makes a step: a value exactly on it counts as above.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction {
    /// The knots, at least one.
    pub knots: Vec<Knot>,
    /// The length that extinction refers to, in planet radii after exaggeration; `None` is the shell's own thickness, so
    /// that a ray straight down through the whole shell meets an optical depth equal to the extinction.
    pub unit_length: Option<f64>,
}

/// Optical depth at which a unit length absorbs the part `opacity` of the light.
pub(super) fn extinction_of(opacity: f64) -> f64 {
    -(-opacity).ln_1p()
}

impl TransferFunction {
    /// A named colour map over `range`, with extinction knots of its own; `None` when there is no such map.
    ///
    /// Colour knots where nothing is to be seen are left out.
    pub(super) fn from_map(
        name: &str,
        reverse: bool,
        range: [f64; 2],
        extinction: &[(f64, f64)],
        unit_length: Option<f64>,
    ) -> Option<Self> {
        let mut colors = color::map(name, MAP_STEPS)?;
        if reverse {
            colors.reverse();
        }
        let stop = |i: usize| range[0] + (range[1] - range[0]) * i as f64 / MAP_STEPS as f64;
        let color_at = |value: f64| {
            let at =
                ((value - range[0]) / (range[1] - range[0]) * MAP_STEPS as f64).clamp(0.0, MAP_STEPS as f64);
            let i = (at as usize).min(MAP_STEPS - 1);
            let w = at - i as f64;
            std::array::from_fn(|k| colors[i][k] + w * (colors[i + 1][k] - colors[i][k]))
        };
        let knot = |value: f64, extinction: f64| Knot { value, color: color_at(value), extinction };
        let between = |low: f64, high: f64| (0..=MAP_STEPS).map(stop).filter(move |v| low < *v && *v < high);
        let (first, last) = (extinction[0], extinction[extinction.len() - 1]);
        let mut knots = Vec::new();
        if first.1 > 0.0 {
            knots.extend(between(f64::NEG_INFINITY, first.0).map(|v| knot(v, first.1)));
        }
        knots.push(knot(first.0, first.1));
        for pair in extinction.windows(2) {
            let ((low, from), (high, to)) = (pair[0], pair[1]);
            if from > 0.0 || to > 0.0 {
                knots.extend(
                    between(low, high).map(|v| knot(v, from + (to - from) * (v - low) / (high - low))),
                );
            }
            knots.push(knot(high, to));
        }
        if last.1 > 0.0 {
            knots.extend(between(last.0, f64::INFINITY).map(|v| knot(v, last.1)));
        }
        Some(TransferFunction { knots, unit_length })
    }

    /// The knots in the kernel's units, for a shell of the given thickness.
    pub(crate) fn kernel_knots(&self, thickness: f64) -> Vec<KernelKnot> {
        let unit = self.unit_length.unwrap_or(thickness);
        let knots = self.knots.iter();
        knots
            .map(|k| KernelKnot { value: k.value, color: k.color, extinction: k.extinction / unit })
            .collect()
    }

    /// First and last knot's value.
    pub fn range(&self) -> [f64; 2] {
        [self.knots[0].value, self.knots[self.knots.len() - 1].value]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_and_opacity_knots_are_merged_and_the_unseen_left_out() {
        let tf = TransferFunction::from_map(
            "viridis",
            false,
            [0.0, 32.0],
            &[(8.0, 0.0), (10.0, 1.0), (12.5, 0.0)],
            None,
        )
        .unwrap();
        let values: Vec<f64> = tf.knots.iter().map(|k| k.value).collect();
        assert_eq!(values, [8.0, 9.0, 10.0, 11.0, 12.0, 12.5]);
        assert_eq!(tf.knots[1].extinction, 0.5);
        assert_eq!(tf.knots[2].color, color::map("viridis", 32).unwrap()[10]);
    }

    #[test]
    fn opaque_ends_keep_the_map_beyond_the_opacity_knots() {
        let tf = TransferFunction::from_map("greys", true, [0.0, 32.0], &[(16.0, 1.0)], Some(2.0)).unwrap();
        assert_eq!(tf.knots.len(), 33);
        assert_eq!(tf.range(), [0.0, 32.0]);
        assert_eq!(tf.kernel_knots(9.0)[3].extinction, 0.5);
        // Reversed: the map's last colour stands at the range's low end.
        assert_eq!(tf.knots[0].color, color::map("greys", 32).unwrap()[32]);
    }

    #[test]
    fn opacity_is_absorption_over_one_unit() {
        for opacity in [0.0, 1e-9, 0.5, 0.999] {
            assert!((1.0 - (-extinction_of(opacity)).exp() - opacity).abs() < 1e-15);
        }
    }
}
