//! Typesets units and powers of ten: `m s-1` as m s⁻¹.

/// Formulas whose digits are no exponents.
const SUBSTANCES: [&str; 8] = ["CO", "CH", "O", "N", "NO", "SO", "NH", "H"];

/// A whole number as an exponent.
pub(super) fn raised(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
    exponent.to_string().chars().map(digit).collect()
}

/// A power of ten.
pub(super) fn power_of_ten(exponent: i32) -> String {
    format!("10{}", raised(exponent))
}

/// Typeset units; `None` if there is no text, such as for `1`.
///
/// ```
/// # use icoray_output::printed_units;
/// assert_eq!(printed_units("m s-1").as_deref(), Some("m s⁻¹"));
/// ```
pub fn printed_units(units: &str) -> Option<String> {
    pretty(units, 0)
}

/// Units of values that are shown divided by 10 to the `exponent`; `None` if there is no text.
pub(super) fn pretty(units: &str, exponent: i32) -> Option<String> {
    let units = units.trim();
    let is_none = ["", "1", "-", "none", "unitless", "dimensionless", "nondimensional"];
    let is_none = is_none.iter().any(|none| none.eq_ignore_ascii_case(units));
    match (is_none, exponent) {
        (true, 0) => None,
        (true, _) => Some(power_of_ten(exponent)),
        (false, 0) => Some(spelled(units)),
        (false, _) => Some(format!("{} {}", power_of_ten(exponent), spelled(units))),
    }
}

fn spelled(units: &str) -> String {
    // A time since a date, or a sentence.
    if units.contains(" since ") {
        return units.to_owned();
    }
    // Two words for one unit, as MPAS-Ocean writes it.
    if let Some((degrees, "Celsius" | "celsius" | "C")) = units.split_once(' ')
        && ["degrees", "degree", "deg"].contains(&degrees)
    {
        return "°C".into();
    }
    let plain = units.replace("**", "^");
    let factors = plain.split([' ', '*', '·']).filter(|factor| !factor.is_empty());
    factors.map(factor).collect::<Vec<_>>().join(" ")
}

/// One factor, which may be a quotient or, between letters, a product with dots.
fn factor(text: &str) -> String {
    let is_product = text.contains('.') && !text.starts_with(|c: char| c.is_ascii_digit());
    let product = |text: &str| {
        if is_product { text.split('.').map(power).collect::<Vec<_>>().join(" ") } else { power(text) }
    };
    text.split('/').map(product).collect::<Vec<_>>().join("/")
}

/// A unit with its exponent, if it has one.
fn power(text: &str) -> String {
    let name = match text {
        "degC" | "degree_C" | "degree_Celsius" | "degrees_Celsius" | "Celsius" | "celsius" => "°C",
        "degrees_north" | "degree_north" => "°N",
        "degrees_east" | "degree_east" => "°E",
        "degree" | "degrees" | "deg" => "°",
        "percent" => "%",
        "um" | "micron" => "µm",
        other => other,
    };
    let digits = name.trim_end_matches('}');
    let base = digits.trim_end_matches(|c: char| c.is_ascii_digit());
    let base = base.strip_suffix(['-', '+']).unwrap_or(base);
    let exponent = digits[base.len()..].trim_start_matches('+').parse::<i32>();
    let marked = base.strip_suffix("^{").or_else(|| base.strip_suffix('^'));
    let unit = marked.unwrap_or(base);
    let is_unit = !unit.is_empty() && unit.chars().all(|c| c.is_alphabetic() || "°%_".contains(c));
    match exponent {
        Ok(exponent) if is_unit && (marked.is_some() || !SUBSTANCES.contains(&unit)) => match exponent {
            1 => unit.to_owned(),
            _ => format!("{unit}{}", raised(exponent)),
        },
        _ => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_raised() {
        for (plain, pretty) in [
            ("m s-1", "m s⁻¹"),
            ("m s^{-1}", "m s⁻¹"),
            ("kg m^-3", "kg m⁻³"),
            ("kg m**-2 s**-1", "kg m⁻² s⁻¹"),
            ("K m2 kg-1 s-1", "K m² kg⁻¹ s⁻¹"),
            ("kg.m-2", "kg m⁻²"),
            ("m2/s2", "m²/s²"),
            ("W/m^2", "W/m²"),
            ("kg kg^{-1}", "kg kg⁻¹"),
            ("m s+2", "m s²"),
            ("m1", "m"),
            ("K", "K"),
            ("degC", "°C"),
            ("degrees Celsius", "°C"),
            ("deg C", "°C"),
            ("degrees_north", "°N"),
            ("mol CO2 m-2", "mol CO2 m⁻²"),
            ("1e-5 s-1", "1e-5 s⁻¹"),
            ("0.5 hPa", "0.5 hPa"),
            ("days since 2000-01-01", "days since 2000-01-01"),
            ("%", "%"),
            ("H2O", "H2O"),
            ("m s-99999999999", "m s-99999999999"),
        ] {
            assert_eq!(super::pretty(plain, 0).unwrap(), pretty, "{plain}");
        }
    }

    #[test]
    fn a_power_of_ten_stands_before_the_units() {
        assert_eq!(pretty("s-1", -5).unwrap(), "10⁻⁵ s⁻¹");
        assert_eq!(pretty("1", 6).unwrap(), "10⁶");
        for none in ["", " 1 ", "unitless", "None", "-"] {
            assert_eq!(pretty(none, 0), None, "{none:?}");
        }
        assert_eq!(raised(-1_234_567_890), "⁻¹²³⁴⁵⁶⁷⁸⁹⁰");
    }
}
