//! Heights that all columns share: a coordinate in metres or pascals, according to the CF conventions 1.11, §4.3, or
//! pressures of hybrid levels (appendix D there).

use super::{MeanHeights, ReadHeights};
use crate::source::{SourceVariable, Variable};
use crate::sources::Sources;
use crate::standard_atmosphere;
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

/// Heights of a coordinate; `None` if it counts levels or has another unit.
pub(super) fn heights(found: SourceVariable, layers: usize) -> Result<Option<ReadHeights>> {
    let Some(unit) = Unit::of(found)?.filter(|_| is_over(found.variable, layers)) else { return Ok(None) };
    let values: Vec<f64> = found.all_numbers()?.into_iter().map(|value| unit.scale * value).collect();
    let is_depth = !unit.is_of_pressure && is_downward(found)? && values.iter().all(|value| *value >= 0.0);
    let height_m = match is_depth {
        _ if unit.is_of_pressure => of_pressures(found, values)?,
        true => values.into_iter().map(|depth| -depth).collect(),
        false => values,
    };
    let heights = ReadHeights::new(found, MeanHeights { height_m, deviation_m: Some(0.0) });
    Ok(Some(ReadHeights { is_of_pressure: unit.is_of_pressure, ..heights }))
}

/// Whether a variable has a number for each layer.
fn is_over(variable: &Variable, layers: usize) -> bool {
    variable.kind.is_number() && matches!(variable.after_time(), [only] if only.len == layers)
}

fn of_pressures(found: SourceVariable, values: Vec<f64>) -> Result<Vec<f64>> {
    if let Some(layer) = values.iter().position(|pa| !(pa.is_finite() && *pa > 0.0)) {
        let (name, pa) = (found.name(), values[layer]);
        let context = format!("{name} of layer {layer} is {pa} Pa, expected a positive pressure");
        return Err(found.error(ErrorKind::Layers, context));
    }
    Ok(values.into_iter().map(standard_atmosphere::height_m).collect())
}

/// Heights of hybrid levels over the mean pressure at the surface at the first time; `None` if no file has coefficients
/// of as many levels.
pub(super) fn hybrid(sources: &Sources, layers: usize) -> Result<Option<ReadHeights<'_>>> {
    let over = |name| sources.find(name).filter(|found| is_over(found.variable, layers));
    let Some((found, b)) = HYBRID.iter().find_map(|[a, b]| over(a).zip(over(b))) else { return Ok(None) };
    let [a, b] = [found.all_numbers()?, b.all_numbers()?];
    let is_in_pascals = found.text("units")?.is_some_and(|units| units == "Pa") || a.iter().any(|a| a.abs() > 10.0);
    let is_number = |p0: &SourceVariable| p0.variable.kind.is_number() && p0.variable.dimensions.is_empty();
    let reference_pa = match sources.find("P0").filter(is_number) {
        _ if is_in_pascals => 1.0,
        Some(p0) => p0.all_numbers()?[0],
        None => REFERENCE_PA,
    };
    let surface_pa = match SURFACE_PRESSURES.iter().find_map(|name| sources.find(name)) {
        Some(pressure) if pressure.variable.kind.is_number() => mean_at_first(pressure, &sources.options.missing)?,
        _ => None,
    };
    let surface_pa = surface_pa.unwrap_or(STANDARD_PA);
    let values = a.iter().zip(&b).map(|(a, b)| a * reference_pa + b * surface_pa).collect();
    let means = MeanHeights { height_m: of_pressures(found, values)?, deviation_m: None };
    Ok(Some(ReadHeights { is_of_pressure: true, ..ReadHeights::new(found, means) }))
}

/// The mean of a variable over its columns at its first time.
fn mean_at_first(found: SourceVariable, missing: &[f64]) -> Result<Option<f64>> {
    // Without a record yet there is no mean.
    let Ok((start, count)) = found.first_record() else { return Ok(None) };
    let values = found.decoded(&start, &count, missing)?;
    let finite: Vec<f64> = values.all().filter(|value| value.is_finite()).collect();
    Ok((!finite.is_empty()).then(|| finite.iter().sum::<f64>() / finite.len() as f64))
}

/// Whether a coordinate counts levels, and if so whether layers rise: the first level is the uppermost unless
/// `positive` is `up`.
pub(super) fn counted(found: SourceVariable, layers: usize) -> Result<Option<bool>> {
    let units = found.text("units")?.unwrap_or_default();
    if !is_over(found.variable, layers) || !COUNTED.contains(&units.as_str()) {
        return Ok(None);
    }
    let values = found.all_numbers()?;
    let step = values[1] - values[0];
    let is_counted = step.abs() == 1.0 && values.windows(2).all(|pair| pair[1] - pair[0] == step);
    let is_upward = found.text("positive")?.is_some_and(|positive| positive.eq_ignore_ascii_case("up"));
    Ok(is_counted.then_some(is_upward == (step > 0.0)))
}

/// A unit of length or pressure.
pub(super) struct Unit {
    is_of_pressure: bool,
    /// Its value in metres or pascals.
    pub scale: f64,
}

impl Unit {
    /// The unit of a variable; depths without one are in metres.
    pub fn of(found: SourceVariable) -> Result<Option<Self>> {
        if let Some(units) = found.text("units")? {
            return Ok(Unit::named(&units));
        }
        let is_depth = found.text("long_name")?.is_some_and(|text| text.to_ascii_lowercase().contains("depth"));
        Ok((is_depth || is_named_depth(found)?).then_some(Unit { is_of_pressure: false, scale: 1.0 }))
    }

    fn named(units: &str) -> Option<Self> {
        let (is_of_pressure, scale) = match units.trim().to_ascii_lowercase().as_str() {
            "m" | "meter" | "meters" | "metre" | "metres" => (false, 1.0),
            "km" | "kilometer" | "kilometers" | "kilometre" | "kilometres" => (false, 1e3),
            "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => (false, 1e-2),
            "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => (false, 1e-3),
            "pa" | "pascal" | "pascals" => (true, 1.0),
            "hpa" | "hectopascal" | "hectopascals" | "mb" | "mbar" | "millibar" | "millibars" => (true, 1e2),
            "kpa" => (true, 1e3),
            _ => return None,
        };
        Some(Unit { is_of_pressure, scale })
    }
}

/// Whether the coordinate is a depth.
fn is_downward(found: SourceVariable) -> Result<bool> {
    match found.text("positive")? {
        Some(positive) => Ok(positive.eq_ignore_ascii_case("down")),
        None => is_named_depth(found),
    }
}

fn is_named_depth(found: SourceVariable) -> Result<bool> {
    let name = found.name();
    let is_depth = found.text("standard_name")?.is_some_and(|name| name == "depth");
    Ok(is_depth || name.starts_with("depth") || NZ.contains(&name))
}
