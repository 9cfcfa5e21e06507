//! MPAS-Ocean's interfaces from the thicknesses of its layers, where no depths are given that all columns share.
//!
//! Columns end at the sea floor, so that an interface's mean height over those that have it need not lie below the one above
//! it. Mean thicknesses, each over the columns that have the layer, add up to interfaces that do.

use super::columns::Spread;
use crate::source::{Kind, Source, Variable};
use crate::sources::Sources;
use crate::times::is_time;
use icoray::{ErrorKind, Result};

/// Variables of thicknesses, in metres; those at rest are the same at all times.
pub(super) const NAMES: [&str; 3] = ["restingThickness", "layerThickness", "timeMonthly_avg_layerThickness"];

/// Whether a variable lies over cells and layers, at times or without.
pub(super) fn fits(variable: &Variable) -> bool {
    let names: Vec<&str> = variable.dimensions.iter().map(|d| d.name.as_str()).collect();
    let over = match names.as_slice() {
        [time, rest @ ..] if is_time(time) => rest,
        all => all,
    };
    over == ["nCells", "nVertLevels"] && matches!(variable.kind, Kind::F32 | Kind::F64)
}

/// The interfaces below the sphere's surface, and how far those of columns lie off them, where `bottomDepth` tells.
pub(super) fn interfaces(
    sources: &Sources,
    source: &Source,
    variable: &Variable,
) -> Result<(Vec<f64>, Option<f64>)> {
    let [.., cells, layers] = variable.dimensions.as_slice() else {
        return Err(
            source.error(ErrorKind::Layers, format_args!("variable {variable}, expected two dimensions"))
        );
    };
    let (cells, layers) = (cells.len, layers.len);
    let last = of_cells(sources, "maxLevelCell", cells)?;
    let depth = of_cells(sources, "bottomDepth", cells)?;
    let is_of_times = variable.dimensions.len() == 3;
    let (mut start, mut count) = (vec![0, 0], vec![cells, layers]);
    if is_of_times {
        start.insert(0, 0);
        count.insert(0, 1);
    }
    let block = source.reals(variable, &start, &count)?;
    let thickness = |cell: usize, layer: usize| block.as_reals().get(cell * layers + layer);
    // Without a sea floor a column ends where its layers have no thickness.
    let wet = |cell: usize| match &last {
        Some(last) => (last[cell].max(0.0) as usize).min(layers),
        None => (0..layers).take_while(|&layer| thickness(cell, layer) > 0.0).count(),
    };
    let mut of_layers = vec![Spread::default(); layers];
    for cell in 0..cells {
        for (layer, spread) in of_layers.iter_mut().enumerate().take(wet(cell)) {
            let here = thickness(cell, layer);
            if !(here.is_finite() && here > 0.0) {
                let context = format!(
                    "{} of cell {}, layer {layer}: {here}, expected a positive thickness in metres",
                    variable.name,
                    cell + 1
                );
                return Err(source.error(ErrorKind::Layers, context));
            }
            spread.add(here);
        }
    }
    // Layers that no column has lie below all that is seen; they only have to lie below each other.
    let thinnest =
        of_layers.iter().map(Spread::mean).filter(|mean| mean.is_finite()).fold(f64::INFINITY, f64::min);
    if thinnest == f64::INFINITY {
        return Err(source.error(ErrorKind::Layers, format_args!("variable {variable}: no cell has a layer")));
    }
    let mut height_m = vec![0.0];
    for layer in &of_layers {
        let mean = layer.mean();
        height_m.push(height_m.last().unwrap_or(&0.0) - if mean.is_finite() { mean } else { thinnest });
    }
    let deviation_m = depth.map(|depth| {
        let mut interfaces = vec![Spread::default(); layers + 1];
        for (cell, depth) in depth.into_iter().enumerate() {
            let mut height = -depth;
            for interface in (0..=wet(cell)).rev().filter(|_| wet(cell) > 0) {
                interfaces[interface].add(height);
                height += if interface > 0 { thickness(cell, interface - 1) } else { 0.0 };
            }
        }
        interfaces.iter().zip(&height_m).map(|(i, height)| i.deviation_from(*height)).fold(0.0, f64::max)
    });
    Ok((height_m, deviation_m))
}

/// A number for each cell; `None` where there is no such variable.
fn of_cells(sources: &Sources, name: &str, cells: usize) -> Result<Option<Vec<f64>>> {
    let Some((source, variable)) = sources.find(name) else {
        return Ok(None);
    };
    let is_number = matches!(variable.kind, Kind::F32 | Kind::F64 | Kind::Integer);
    if !is_number || !matches!(&variable.dimensions[..], [only] if only.len == cells) {
        let context = format!("variable {variable}, expected {name}(nCells = {cells}) of numbers");
        return Err(source.error(ErrorKind::Layers, context));
    }
    source.all_numbers(variable).map(Some)
}
