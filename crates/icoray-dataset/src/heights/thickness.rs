//! MPAS-Ocean's interfaces from layer thicknesses, for files without common depths.
//!
//! Columns end at the sea floor, so mean heights of interfaces over the columns that have them need not be monotone.
//! Sums of mean thicknesses, each over the columns that have the layer, are. The interfaces of a column are sums of its
//! thicknesses.

use super::MeanHeights;
use super::columns::HeightStatistics;
use crate::sea::Floor;
use crate::source::{SourceVariable, Variable};
use crate::sources::Sources;
use crate::values::ShapedValues;
use icoray::{ErrorKind, OwnedReals, Reals, Result, Shape};
use std::ops::Range;

/// Variables of thicknesses in metres, time-dependent ones first.
pub(super) const NAMES_NOW: [&str; 3] = ["layerThickness", "timeMonthly_avg_layerThickness", "restingThickness"];

/// Height of the sea surface, metres.
const SURFACES: [&str; 2] = ["ssh", "timeMonthly_avg_ssh"];

/// The first of these variables that lies over cells and layers, with or without times.
fn find<'a>(sources: &'a Sources, names: [&str; 3]) -> Option<SourceVariable<'a>> {
    let fits = |v: &Variable| v.kind.is_real() && v.lies_at_times_over(&["nCells", "nVertLevels"]);
    names.iter().find_map(|name| sources.find(name).filter(|found| fits(found.variable)))
}

/// The time-dependent thicknesses, or the resting ones.
pub(super) fn of_now(sources: &Sources) -> Option<SourceVariable<'_>> {
    find(sources, NAMES_NOW)
}

/// The resting thicknesses, or the time-dependent ones.
pub(super) fn of_any_time(sources: &Sources) -> Option<SourceVariable<'_>> {
    let [now, monthly, resting] = NAMES_NOW;
    find(sources, [resting, now, monthly])
}

/// Numbers of cells and layers of a variable that [`find`] has found.
fn cells_and_layers(variable: &Variable) -> [usize; 2] {
    [0, 1].map(|i| variable.after_time()[i].len)
}

/// Describes where the summation of interfaces starts.
pub(super) fn start(sources: &Sources) -> String {
    if sources.find("bottomDepth").is_some() {
        return "from the sea floor (bottomDepth)".into();
    }
    let surface = SURFACES.iter().find(|name| sources.find(name).is_some());
    surface.map_or("down from the sphere".into(), |name| format!("down from the sea surface ({name})"))
}

/// Whether the start of the summation changes with time.
pub(super) fn start_changes(sources: &Sources) -> bool {
    sources.find("bottomDepth").is_none() && changes(sources, &SURFACES)
}

/// Whether the first variable that is there changes with time.
pub(super) fn changes(sources: &Sources, names: &[&str]) -> bool {
    let found = names.iter().find_map(|name| sources.find(name));
    found.is_some_and(|found| sources.changes(found))
}

/// The interfaces of each column, from the sea surface down.
#[derive(Debug)]
pub(super) struct Columns {
    pub heights: OwnedReals,
    pub shape: Shape,
}

/// Start of the summation in each column.
enum Start {
    Floor(Vec<f64>),
    Surface(Vec<f64>),
}

impl Columns {
    /// Sums the thicknesses of record `time`.
    pub fn read(sources: &Sources, found: SourceVariable, floor: Option<&Floor>, time: usize) -> Result<Self> {
        let [cells, layers] = cells_and_layers(found.variable);
        let block = at(sources, found, &[cells, layers], time)?;
        let start = match of_cells(sources, "bottomDepth", cells)? {
            Some(depth) => Start::Floor(depth),
            None => Start::Surface(surface(sources, &SURFACES, cells, time)?),
        };
        let mut heights = match block.as_reals() {
            Reals::F32(_) => OwnedReals::F32(Vec::with_capacity(cells * (layers + 1))),
            Reals::F64(_) => OwnedReals::F64(Vec::with_capacity(cells * (layers + 1))),
        };
        let mut column = vec![0.0; layers + 1];
        for cell in 0..cells {
            let thickness = |layer: usize| block.as_reals().get(cell * layers + layer);
            let water = match floor {
                Some(floor) => floor.water(cell, layers),
                // Without a sea floor a column ends at its first layer without thickness.
                None => 0..(0..layers).take_while(|layer| thickness(*layer) > 0.0).count(),
            };
            if let Some(layer) = water.clone().find(|l| !(thickness(*l).is_finite() && thickness(*l) >= 0.0)) {
                let context = format!(
                    "{} of cell {}, layer {layer}: {}, expected a thickness in metres that is not negative",
                    found.name(),
                    cell + 1,
                    thickness(layer)
                );
                return Err(found.error(ErrorKind::Layers, context));
            }
            add_up(&mut column, water, &start, cell, thickness);
            match &mut heights {
                OwnedReals::F32(heights) => heights.extend(column.iter().map(|height| *height as f32)),
                OwnedReals::F64(heights) => heights.extend(&column),
            }
        }
        Ok(Columns { heights, shape: Shape::level_fastest(cells, layers + 1) })
    }
}

/// The interfaces of one column; NaN if it has no water.
fn add_up(column: &mut [f64], water: Range<usize>, start: &Start, cell: usize, thickness: impl Fn(usize) -> f64) {
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

/// Height of the sea surface in each column, from the first of some variables: the sphere's if no file has any.
pub(super) fn surface(sources: &Sources, names: &[&str], cells: usize, time: usize) -> Result<Vec<f64>> {
    let Some(found) = names.iter().find_map(|name| sources.find(name)) else { return Ok(vec![0.0; cells]) };
    if !matches!(found.variable.after_time(), [only] if only.len == cells) {
        let expected = format_args!("a height of each of {cells} cells, at times or not");
        return Err(found.unexpected(ErrorKind::Layers, expected));
    }
    Ok(at(sources, found, &[cells], time)?.all().collect())
}

/// One record of a variable over `count` entries, which may have times before them.
fn at(sources: &Sources, found: SourceVariable, count: &[usize], time: usize) -> Result<ShapedValues> {
    let (mut start, mut count) = (vec![0; count.len()], count.to_vec());
    if found.variable.dimensions.len() > count.len() {
        start.insert(0, sources.record(found, time)?);
        count.insert(0, 1);
    }
    found.decoded(&start, &count, &sources.options.missing)
}

/// The interfaces below the sphere's surface, and the largest deviation of columns from them, if there is
/// `bottomDepth`.
pub(super) fn interfaces(sources: &Sources, found: SourceVariable) -> Result<MeanHeights> {
    let [cells, layers] = cells_and_layers(found.variable);
    let [first, last] = ["minLevelCell", "maxLevelCell"].map(|name| of_cells(sources, name, cells));
    let (first, last) = (first?, last?);
    let depth = of_cells(sources, "bottomDepth", cells)?;
    let (start, count) = found.first_record()?;
    let block = found.decoded(&start, &count, &sources.options.missing)?;
    let thickness = |cell: usize, layer: usize| block.as_reals().get(cell * layers + layer);
    let water = |cell: usize| {
        let start = first.as_ref().map_or(0, |first| (first[cell].max(1.0) as usize - 1).min(layers));
        // Without a sea floor a column ends at its first layer without thickness.
        let end = match &last {
            Some(last) => (last[cell].max(0.0) as usize).min(layers),
            None => start + (start..layers).take_while(|&layer| thickness(cell, layer) > 0.0).count(),
        };
        start..end
    };
    let mut of_layers = vec![HeightStatistics::default(); layers];
    for cell in 0..cells {
        for layer in water(cell) {
            let here = thickness(cell, layer);
            if !(here.is_finite() && here > 0.0) {
                let (name, number) = (found.name(), cell + 1);
                let context =
                    format!("{name} of cell {number}, layer {layer}: {here}, expected a positive thickness in metres");
                return Err(found.error(ErrorKind::Layers, context));
            }
            of_layers[layer].add(here);
        }
    }
    // Layers that no column has lie below all visible ones; they only have to lie below each other.
    let thinnest =
        of_layers.iter().map(HeightStatistics::mean).filter(|mean| mean.is_finite()).fold(f64::INFINITY, f64::min);
    if thinnest == f64::INFINITY {
        return Err(found.error(ErrorKind::Layers, format_args!("variable {}: no cell has a layer", found.variable)));
    }
    let mut height_m = vec![0.0];
    for layer in &of_layers {
        let mean = layer.mean();
        height_m.push(height_m.last().unwrap_or(&0.0) - if mean.is_finite() { mean } else { thinnest });
    }
    let deviation_m = depth.map(|depth| {
        let mut interfaces = vec![HeightStatistics::default(); layers + 1];
        for (cell, depth) in depth.into_iter().enumerate() {
            let mut height = -depth;
            let water = water(cell);
            for interface in (water.start..=water.end).rev().filter(|_| !water.is_empty()) {
                interfaces[interface].add(height);
                height += if interface > water.start { thickness(cell, interface - 1) } else { 0.0 };
            }
        }
        interfaces.iter().zip(&height_m).map(|(i, height)| i.deviation_from(*height)).fold(0.0, f64::max)
    });
    Ok(MeanHeights { height_m, deviation_m })
}

/// A number for each cell; `None` if there is no such variable.
pub(super) fn of_cells(sources: &Sources, name: &str, cells: usize) -> Result<Option<Vec<f64>>> {
    let Some(found) = sources.find(name) else { return Ok(None) };
    let variable = found.variable;
    if !variable.kind.is_number() || !matches!(variable.after_time(), [only] if only.len == cells) {
        return Err(found.unexpected(ErrorKind::Layers, format_args!("{name} of numbers over the {cells} cells")));
    }
    let (start, count) = found.first_record()?;
    Ok(Some(found.decoded(&start, &count, &sources.options.missing)?.all().collect()))
}
