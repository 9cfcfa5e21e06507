//! Numbers in texts and messages.

/// The shortest decimal text that parses to this number, with an exponent below 1e-3 and from 1e7 on.
pub fn text(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".into()
    } else if (1e-3..1e7).contains(&size) || !value.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// A list of numbers in brackets, each as [`text`].
pub fn list(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| text(*value)).collect();
    format!("[{}]", texts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_short_and_read_as_the_number() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (283.5, "283.5"),
            (1e300, "1e300"),
            (-1e-300, "-1e-300"),
            (6_371_229.0, "6371229"),
            (f64::MAX, "1.7976931348623157e308"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(text(value), expected);
            assert!(value.is_nan() || text(value).parse::<f64>() == Ok(value), "{value}");
        }
        assert_eq!(list(&[1.0, -1e20]), "[1, -1e20]");
    }
}
