//! Heights that all columns share: a coordinate in metres or pascals, as the CF conventions 1.11, §4.3, have them.

use crate::source::{Source, Variable};
use crate::standard_atmosphere;
use icoray::{ErrorKind, Result};

/// Heights in metres of the coordinate `variable`, and whether it gives pressures; `None` where it counts levels or has
/// another unit.
pub(super) fn heights(source: &dyn Source, variable: &Variable, layers: usize) -> Result<Option<(Vec<f64>, bool)>> {
    let name = &variable.name;
    let is_axis = variable.kind.is_number() && matches!(&variable.dimensions[..], [only] if only.len == layers);
    let units = source.text_of(name, "units")?.unwrap_or_default();
    let Some((is_of_pressure, scale)) = unit(&units).filter(|_| is_axis) else {
        return Ok(None);
    };
    let values: Vec<f64> = source.numbers(variable)?.into_iter().map(|value| scale * value).collect();
    if is_of_pressure {
        if let Some(layer) = values.iter().position(|pa| !(pa.is_finite() && *pa > 0.0)) {
            let context = format!("{name} of layer {layer} is {} Pa, expected a positive pressure", values[layer]);
            return Err(source.error(ErrorKind::Layers, context));
        }
        return Ok(Some((values.into_iter().map(standard_atmosphere::height_m).collect(), true)));
    }
    let sign = if is_downward(source, name)? { -1.0 } else { 1.0 };
    Ok(Some((values.into_iter().map(|height| sign * height).collect(), false)))
}

/// Whether a unit is one of pressure, and how many pascals or metres it has.
fn unit(units: &str) -> Option<(bool, f64)> {
    Some(match units.trim().to_ascii_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => (false, 1.0),
        "km" | "kilometer" | "kilometers" | "kilometre" | "kilometres" => (false, 1e3),
        "pa" | "pascal" | "pascals" => (true, 1.0),
        "hpa" | "hectopascal" | "hectopascals" | "mb" | "mbar" | "millibar" | "millibars" => (true, 1e2),
        "kpa" => (true, 1e3),
        _ => return None,
    })
}

/// Whether the coordinate is a depth.
fn is_downward(source: &dyn Source, name: &str) -> Result<bool> {
    let positive = source.text_of(name, "positive")?;
    let standard_name = source.text_of(name, "standard_name")?;
    Ok(positive.map_or_else(
        || standard_name.is_some_and(|name| name == "depth") || name.starts_with("depth"),
        |positive| positive.eq_ignore_ascii_case("down"),
    ))
}
