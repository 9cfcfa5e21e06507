//! The transfer function: colour and extinction, piecewise linear in the field's value.

use std::array;

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
    /// The length that extinction refers to, in planet radii after exaggeration; `None` is the shell's own thickness,
    /// so that a ray straight down through the whole shell meets an optical depth equal to the extinction.
    pub unit_length: Option<f64>,
}

/// Optical depth at which a unit length absorbs the part `opacity` of the light.
pub(super) fn extinction_of(opacity: f64) -> f64 {
    -(-opacity).ln_1p()
}

impl TransferFunction {
    /// A transfer function that shows nothing.
    pub(super) fn clear() -> Self {
        let clear = Knot { value: 0.0, color: [0.0; 3], extinction: 0.0 };
        TransferFunction { knots: vec![clear], unit_length: None }
    }

    /// Linear RGB, not premultiplied, and extinction at a value.
    pub fn at(&self, value: f64) -> ([f64; 3], f64) {
        let above = self.knots.partition_point(|knot| knot.value <= value);
        let Some(low) = above.checked_sub(1).map(|i| &self.knots[i]) else {
            return (self.knots[0].color, self.knots[0].extinction);
        };
        let Some(high) = self.knots.get(above) else { return (low.color, low.extinction) };
        let w = (value - low.value) / (high.value - low.value);
        let mix = |a: f64, b: f64| a + w * (b - a);
        (array::from_fn(|k| mix(low.color[k], high.color[k])), mix(low.extinction, high.extinction))
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
    fn between_knots_all_is_straight_and_beyond_them_constant() {
        let knot = |value, red, extinction| Knot { value, color: [red, 0.0, 0.0], extinction };
        let knots = vec![knot(1.0, 0.0, 1.0), knot(3.0, 1.0, 0.0), knot(3.0, 0.5, 2.0)];
        let tf = TransferFunction { knots, unit_length: None };
        for (value, red, extinction) in
            [(-5.0, 0.0, 1.0), (1.0, 0.0, 1.0), (2.5, 0.75, 0.25), (3.0, 0.5, 2.0), (9.0, 0.5, 2.0)]
        {
            assert_eq!(tf.at(value), ([red, 0.0, 0.0], extinction), "{value}");
        }
    }

    #[test]
    fn opacity_is_absorption_over_one_unit() {
        for opacity in [0.0, 1e-9, 0.5, 0.999] {
            assert!((1.0 - (-extinction_of(opacity)).exp() - opacity).abs() < 1e-15);
        }
    }
}
