//! Heights that all columns share: a coordinate in metres or pascals, according to the CF conventions 1.11, §4.3, or
//! pressures of hybrid levels (appendix D there).

use super::ReadHeights;
use crate::source::{Source, Variable};
use crate::sources::Sources;
use crate::standard_atmosphere;
use crate::stored::decoded;
use icoray::{ErrorKind, Result};

/// Coefficients of hybrid levels, `a` and `b` in `a + b ps` or `a P0 + b ps`.
const HYBRID: [[&str; 2]; 3] = [["hyam", "hybm"], ["hyai", "hybi"], ["ap", "b"]];
/// Pressures at the surface, and the default one.
const SURFACE_PRESSURES: [&str; 5] = ["PS", "ps", "aps", "sp", "surface_pressure"];
const STANDARD_PA: f64 = 101_325.0;
/// `P0` if no file has it.
const REFERENCE_PA: f64 = 1e5;
/// FESOM's depths of interfaces and of layers.
const NZ: [&str; 2] = ["nz", "nz1"];
/// Units of coordinates that count levels.
const COUNTED: [&str; 4] = ["", "1", "level", "levels"];

/// Heights in metres of the coordinate `variable`, and whether it is of pressures; `None` if it counts levels or has
/// another unit.
pub(super) fn heights(source: &dyn Source, variable: &Variable, layers: usize) -> Result<Option<(Vec<f64>, bool)>> {
    let name = &variable.name;
    let Some((is_of_pressure, scale)) = unit_of(source, name)?.filter(|_| is_over(variable, layers)) else {
        return Ok(None);
    };
    let values: Vec<f64> = source.all_numbers(variable)?.into_iter().map(|value| scale * value).collect();
    if is_of_pressure {
        return of_pressures(source, name, values).map(|heights| Some((heights, true)));
    }
    let is_depth = is_downward(source, name)? && values.iter().all(|value| *value >= 0.0);
    let sign = if is_depth { -1.0 } else { 1.0 };
    Ok(Some((values.into_iter().map(|height| sign * height).collect(), false)))
}

/// Whether a variable has a number for each layer.
fn is_over(variable: &Variable, layers: usize) -> bool {
    variable.kind.is_number() && matches!(variable.after_time(), [only] if only.len == layers)
}

fn of_pressures(source: &dyn Source, name: &str, values: Vec<f64>) -> Result<Vec<f64>> {
    if let Some(layer) = values.iter().position(|pa| !(pa.is_finite() && *pa > 0.0)) {
        let context = format!("{name} of layer {layer} is {} Pa, expected a positive pressure", values[layer]);
        return Err(source.error(ErrorKind::Layers, context));
    }
    Ok(values.into_iter().map(standard_atmosphere::height_m).collect())
}

/// Heights of hybrid levels over the mean pressure at the surface at the first time; `None` if no file has coefficients
/// of as many levels.
pub(super) fn hybrid(sources: &Sources, layers: usize) -> Result<Option<ReadHeights<'_>>> {
    let over = |name| sources.find(name).filter(|(_, variable)| is_over(variable, layers));
    let Some((a, b)) = HYBRID.iter().find_map(|[a, b]| over(a).zip(over(b))) else { return Ok(None) };
    let (source, variable) = a;
    let [a, b] = [source.all_numbers(variable)?, b.0.all_numbers(b.1)?];
    let is_in_pascals =
        source.text_of(&variable.name, "units")?.is_some_and(|units| units == "Pa") || a.iter().any(|a| a.abs() > 10.0);
    let reference_pa = match sources.find("P0").filter(|(_, p0)| p0.kind.is_number() && p0.dimensions.is_empty()) {
        _ if is_in_pascals => 1.0,
        Some((source, p0)) => source.all_numbers(p0)?[0],
        None => REFERENCE_PA,
    };
    let surface_pa = match SURFACE_PRESSURES.iter().find_map(|name| sources.find(name)) {
        Some((source, pressure)) if pressure.kind.is_number() => {
            mean_at_first(source, pressure, &sources.options.missing)?
        }
        _ => None,
    };
    let surface_pa = surface_pa.unwrap_or(STANDARD_PA);
    let values = a.iter().zip(&b).map(|(a, b)| a * reference_pa + b * surface_pa).collect();
    let height_m = of_pressures(source, &variable.name, values)?;
    Ok(Some(ReadHeights { is_of_pressure: true, ..ReadHeights::new((source, variable), (height_m, None)) }))
}

/// The mean of a variable over its columns at its first time.
fn mean_at_first(source: &dyn Source, variable: &Variable, missing: &[f64]) -> Result<Option<f64>> {
    // Without a record yet there is no mean.
    let Ok((start, count)) = source.first_record(variable) else { return Ok(None) };
    let values = decoded(source, variable, (&start, &count), missing)?;
    let finite: Vec<f64> = values.all().filter(|value| value.is_finite()).collect();
    Ok((!finite.is_empty()).then(|| finite.iter().sum::<f64>() / finite.len() as f64))
}

/// Whether a coordinate counts levels, and if so whether layers rise: the first level is the uppermost unless
/// `positive` is `up`.
pub(super) fn counted(source: &dyn Source, variable: &Variable, layers: usize) -> Result<Option<bool>> {
    let name = &variable.name;
    let units = source.text_of(name, "units")?.unwrap_or_default();
    if !is_over(variable, layers) || !COUNTED.contains(&units.as_str()) {
        return Ok(None);
    }
    let values = source.all_numbers(variable)?;
    let step = values[1] - values[0];
    let is_counted = step.abs() == 1.0 && values.windows(2).all(|pair| pair[1] - pair[0] == step);
    let is_upward = source.text_of(name, "positive")?.is_some_and(|positive| positive.eq_ignore_ascii_case("up"));
    Ok(is_counted.then_some(is_upward == (step > 0.0)))
}

/// Whether the unit of a variable is one of pressure, and its value in pascals or metres. Depths without a unit are in
/// metres.
pub(super) fn unit_of(source: &dyn Source, name: &str) -> Result<Option<(bool, f64)>> {
    if let Some(units) = source.text_of(name, "units")? {
        return Ok(unit(&units));
    }
    let is_depth = source.text_of(name, "long_name")?.is_some_and(|text| text.to_ascii_lowercase().contains("depth"));
    Ok((is_depth || is_named_depth(source, name)?).then_some((false, 1.0)))
}

/// Whether a unit is one of pressure, and its value in pascals or metres.
fn unit(units: &str) -> Option<(bool, f64)> {
    Some(match units.trim().to_ascii_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => (false, 1.0),
        "km" | "kilometer" | "kilometers" | "kilometre" | "kilometres" => (false, 1e3),
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => (false, 1e-2),
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => (false, 1e-3),
        "pa" | "pascal" | "pascals" => (true, 1.0),
        "hpa" | "hectopascal" | "hectopascals" | "mb" | "mbar" | "millibar" | "millibars" => (true, 1e2),
        "kpa" => (true, 1e3),
        _ => return None,
    })
}

/// Whether the coordinate is a depth.
fn is_downward(source: &dyn Source, name: &str) -> Result<bool> {
    match source.text_of(name, "positive")? {
        Some(positive) => Ok(positive.eq_ignore_ascii_case("down")),
        None => is_named_depth(source, name),
    }
}

fn is_named_depth(source: &dyn Source, name: &str) -> Result<bool> {
    let standard_name = source.text_of(name, "standard_name")?;
    Ok(standard_name.is_some_and(|name| name == "depth") || name.starts_with("depth") || NZ.contains(&name))
}
