//! Rounds numbers to those that a person would write.

/// The nearest of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten. `value` is positive.
pub(super) fn round(value: f64) -> f64 {
    const STEPS: [f64; 11] = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    let exponent = value.log10().floor() as i32;
    let mantissa = value / 10f64.powi(exponent);
    let off = |step: &&f64| (step.ln() - mantissa.ln()).abs();
    let nearest = STEPS.iter().min_by(|a, b| off(a).total_cmp(&off(b))).copied().unwrap_or(1.0);
    scaled(nearest * 10.0, exponent - 1)
}

/// `value` to a multiple of the power of ten that is at most `step`.
pub(super) fn to_step(value: f64, step: f64) -> f64 {
    let exponent = step.log10().floor() as i32;
    scaled((value / 10f64.powi(exponent)).round(), exponent)
}

/// `whole` times a power of ten, rounded once: the value of the decimal number.
fn scaled(whole: f64, exponent: i32) -> f64 {
    if exponent < 0 { whole / 10f64.powi(-exponent) } else { whole * 10f64.powi(exponent) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_grid::numbers::text;

    #[test]
    fn numbers_are_short() {
        for (value, expected) in [(14.16, 15.0), (1.03, 1.0), (9.6, 10.0), (0.0342, 0.03), (731.0, 800.0)] {
            assert_eq!(round(value), expected, "{value}");
        }
        for (value, step, expected) in [
            (283.4567, 0.5, "283.5"),
            (-6.9871e-5, 3e-7, "-6.99e-5"),
            (101_325.4, 30.0, "101330"),
            (0.04, 1.0, "0"),
            (2.4e9, 1e8, "2.4e9"),
        ] {
            assert_eq!(text(to_step(value, step)), expected);
        }
    }
}
