//! MPAS-Ocean's interfaces from the thicknesses of its layers, where no depths are given that all columns share.
//!
//! Columns end at the sea floor, so that an interface's mean height over those that have it need not lie below the one above
//! it. Mean thicknesses, each over the columns that have the layer, add up to interfaces that do. A column's own interfaces are
//! its thicknesses, added up.

use super::columns::Spread;
use super::native::{changes, record};
use crate::floor::Floor;
use crate::reals::OwnedReals;
use crate::source::{Kind, Source, Variable};
use crate::sources::Sources;
use crate::times::is_time;
use icoray::{ErrorKind, Result, Shape};
use std::ops::Range;

/// Variables of thicknesses, in metres; those at rest are the same at all times.
pub(super) const NAMES: [&str; 3] = ["restingThickness", "layerThickness", "timeMonthly_avg_layerThickness"];

/// The same, those of the time that is drawn first.
pub(super) const NAMES_NOW: [&str; 3] =
    ["layerThickness", "timeMonthly_avg_layerThickness", "restingThickness"];

/// Height of the sea surface, metres.
const SURFACES: [&str; 2] = ["ssh", "timeMonthly_avg_ssh"];

/// Whether a variable lies over cells and layers, at times or without.
pub(super) fn fits(variable: &Variable) -> bool {
    let names: Vec<&str> = variable.dimensions.iter().map(|d| d.name.as_str()).collect();
    let over = match names.as_slice() {
        [time, rest @ ..] if is_time(time) => rest,
        all => all,
    };
    over == ["nCells", "nVertLevels"] && matches!(variable.kind, Kind::F32 | Kind::F64)
}

/// The thicknesses of the time that is drawn, or at rest.
pub(super) fn of_now(sources: &Sources) -> Option<(&Source, &Variable)> {
    NAMES_NOW.iter().filter_map(|name| sources.find(name)).find(|(_, variable)| fits(variable))
}

/// Where interfaces are added up from, in words.
pub(super) fn start(sources: &Sources) -> String {
    if sources.find("bottomDepth").is_some() {
        return "from the sea floor (bottomDepth)".into();
    }
    let surface = SURFACES.iter().find(|name| sources.find(name).is_some());
    surface.map_or("down from the sphere".into(), |name| format!("down from the sea surface ({name})"))
}

/// Whether each time has another place from where interfaces are added up.
pub(super) fn start_changes(sources: &Sources) -> bool {
    let surface = || SURFACES.iter().find_map(|name| sources.find(name));
    sources.find("bottomDepth").is_none()
        && surface().is_some_and(|(source, variable)| changes(sources, source, variable))
}

/// The interfaces of each column, from the sea surface down.
#[derive(Debug)]
pub(super) struct Columns {
    pub heights: OwnedReals,
    pub shape: Shape,
}

/// Where a column's interfaces are added up from.
enum Start {
    Floor(Vec<f64>),
    Surface(Vec<f64>),
}

impl Columns {
    /// Adds up the thicknesses of record `time`.
    pub fn read(
        sources: &Sources,
        (source, variable): (&Source, &Variable),
        floor: Option<&Floor>,
        time: usize,
    ) -> Result<Self> {
        let [.., cells, layers] = variable.dimensions.as_slice() else {
            let context = format!("variable {variable}, expected two dimensions");
            return Err(source.error(ErrorKind::Layers, context));
        };
        let (cells, layers) = (cells.len, layers.len);
        let block = at(sources, (source, variable), &[cells, layers], time)?;
        let start = match of_cells(sources, "bottomDepth", cells)? {
            Some(depth) => Start::Floor(depth),
            None => Start::Surface(surface(sources, cells, time)?),
        };
        let mut heights = match &block {
            OwnedReals::F32(_) => OwnedReals::F32(Vec::with_capacity(cells * (layers + 1))),
            OwnedReals::F64(_) => OwnedReals::F64(Vec::with_capacity(cells * (layers + 1))),
        };
        let mut column = vec![0.0; layers + 1];
        for cell in 0..cells {
            let thickness = |layer: usize| block.as_reals().get(cell * layers + layer);
            let water = match floor {
                Some(floor) => floor.water(cell, layers),
                // Without a sea floor a column ends where its layers have no thickness.
                None => 0..(0..layers).take_while(|layer| thickness(*layer) > 0.0).count(),
            };
            if let Some(layer) = water.clone().find(|l| !(thickness(*l).is_finite() && thickness(*l) >= 0.0))
            {
                let context = format!(
                    "{} of cell {}, layer {layer}: {}, expected a thickness in metres that is not negative",
                    variable.name,
                    cell + 1,
                    thickness(layer)
                );
                return Err(source.error(ErrorKind::Layers, context));
            }
            add_up(&mut column, water, &start, cell, thickness);
            column.iter().for_each(|height| heights.push(*height));
        }
        Ok(Columns { heights, shape: Shape::level_fastest(cells, layers + 1) })
    }
}

/// The interfaces of one column; NaN where it has no water.
fn add_up(
    column: &mut [f64],
    water: Range<usize>,
    start: &Start,
    cell: usize,
    thickness: impl Fn(usize) -> f64,
) {
    if water.is_empty() {
        column.fill(f64::NAN);
        return;
    }
    match start {
        Start::Floor(depth) => {
            column[water.end] = -depth[cell];
            water.clone().rev().for_each(|layer| column[layer] = column[layer + 1] + thickness(layer));
        }
        Start::Surface(height) => {
            column[water.start] = height[cell];
            water.clone().for_each(|layer| column[layer + 1] = column[layer] - thickness(layer));
        }
    }
    let [top, bottom] = [water.start, water.end].map(|interface| column[interface]);
    column[..water.start].fill(top);
    column[water.end..].fill(bottom);
}

/// Height of the sea surface in each column: the sphere's where no file tells.
fn surface(sources: &Sources, cells: usize, time: usize) -> Result<Vec<f64>> {
    let Some((source, variable)) = SURFACES.iter().find_map(|name| sources.find(name)) else {
        return Ok(vec![0.0; cells]);
    };
    let names: Vec<&str> = variable.dimensions.iter().map(|d| d.name.as_str()).collect();
    let fits = match names.as_slice() {
        [first, rest @ ..] if is_time(first) => rest == ["nCells"],
        all => all == ["nCells"],
    };
    if !fits || variable.dimensions.last().is_none_or(|dimension| dimension.len != cells) {
        let context =
            format!("variable {variable}, expected a height of each of {cells} nCells, at times or not");
        return Err(source.error(ErrorKind::Layers, context));
    }
    let heights = at(sources, (source, variable), &[cells], time)?;
    Ok((0..cells).map(|cell| heights.as_reals().get(cell)).collect())
}

/// One record of a variable over `count` entries, which may have times before them.
fn at(
    sources: &Sources,
    (source, variable): (&Source, &Variable),
    count: &[usize],
    time: usize,
) -> Result<OwnedReals> {
    let (mut start, mut count) = (vec![0; count.len()], count.to_vec());
    if variable.dimensions.len() > count.len() {
        start.insert(0, record(sources, source, variable, time)?);
        count.insert(0, 1);
    }
    source.reals(variable, &start, &count)
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
