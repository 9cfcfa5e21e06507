//! The heights of an MPAS file's layer interfaces.

use crate::source::{Kind, Source, Variable};
use icoray::{ErrorKind, Layers, Reals, Result};

/// Variables that give the interfaces, in the order in which they are looked for.
const ZGRID: &str = "zgrid";
const REF_BOTTOM_DEPTH: &str = "refBottomDepth";

/// Values of `zgrid` that are in memory at one time.
const BLOCK: usize = 1 << 20;

/// The interfaces between layers: one more than `nVertLevels`, where fields over `nVertLevelsP1` lie; fields over
/// `nVertLevels` lie midway between them ([`Layers::for_field`]).
#[derive(Debug, Clone, PartialEq)]
pub struct LayerHeights {
    /// The variable that the heights are from: `zgrid` (atmosphere) or `refBottomDepth` (ocean).
    pub variable: &'static str,
    /// Height of each interface above the sphere in metres, negative below it: the mean over all cells.
    pub height_m: Vec<f64>,
    /// How far a column's interface lies off the mean at most, in metres: 0 without terrain.
    pub deviation_m: f64,
    /// The interfaces as radii.
    pub layers: Layers,
}

impl LayerHeights {
    /// Finds and reads the heights: in the first of `sources` that has one of the variables.
    pub(crate) fn read(sources: &[&Source], sphere_radius_m: f64) -> Result<Self> {
        let Some((source, variable, name)) = Self::find(sources) else {
            return Err(sources[0].error(
                ErrorKind::Layers,
                format_args!(
                    "no layer heights: looked for {ZGRID}(nCells, nVertLevelsP1) and {REF_BOTTOM_DEPTH}(nVertLevels)"
                ),
            ));
        };
        let (height_m, deviation_m) = match name {
            ZGRID => mean_heights(source, variable)?,
            _ => (depths(source, variable)?, 0.0),
        };
        if let Some(i) = height_m.iter().position(|h| !h.is_finite() || h.abs() >= sphere_radius_m) {
            return Err(source.error(
                ErrorKind::Layers,
                format_args!(
                    "{name}: interface {i} lies at {} m, but sphere_radius is {sphere_radius_m}; expected a radius in metres, \
                     such as an init or history file gives (a mesh on the unit sphere has 1)",
                    height_m[i]
                ),
            ));
        }
        let layers = Layers::from_heights(&height_m, sphere_radius_m)
            .map_err(|e| e.within(name).within(source.path().display()))?;
        Ok(LayerHeights { variable: name, height_m, deviation_m, layers })
    }

    /// Whether [`LayerHeights::read`] would find a variable.
    pub(crate) fn are_in(sources: &[&Source]) -> bool {
        Self::find(sources).is_some()
    }

    fn find<'a>(sources: &[&'a Source]) -> Option<(&'a Source, &'a Variable, &'static str)> {
        let found = |name| sources.iter().find_map(|s| s.variable(name).map(|v| (*s, v, name)));
        found(ZGRID).or_else(|| found(REF_BOTTOM_DEPTH))
    }
}

fn expect(source: &Source, variable: &Variable, dimensions: &[&str]) -> Result<()> {
    if variable.lies_over(dimensions) && matches!(variable.kind, Kind::F32 | Kind::F64) {
        return Ok(());
    }
    Err(source.error(
        ErrorKind::Layers,
        format_args!(
            "variable {variable}, expected {}({}) of float or double",
            variable.name,
            dimensions.join(", ")
        ),
    ))
}

/// Mean of `zgrid` over the cells at each interface, and the greatest distance from it.
fn mean_heights(source: &Source, variable: &Variable) -> Result<(Vec<f64>, f64)> {
    expect(source, variable, &["nCells", "nVertLevelsP1"])?;
    let (cells, interfaces) = (variable.dimensions[0].len, variable.dimensions[1].len);
    if cells == 0 || interfaces == 0 {
        return Err(source.error(ErrorKind::Layers, format_args!("variable {variable} is empty")));
    }
    let rows = (BLOCK / interfaces).max(1);
    let (mut sum, mut least, mut greatest) = (Vec::new(), Vec::new(), Vec::new());
    for first in (0..cells).step_by(rows) {
        let block = source.reals(variable, &[first, 0], &[rows.min(cells - first), interfaces])?;
        let heights = block.as_reals();
        // Only now is it known that a damaged header does not promise more interfaces than there can be.
        sum.resize(interfaces, 0.0);
        least.resize(interfaces, f64::INFINITY);
        greatest.resize(interfaces, f64::NEG_INFINITY);
        for i in 0..heights.len() {
            let (height, interface) = (heights.get(i), i % interfaces);
            if !height.is_finite() {
                let cell = first + i / interfaces + 1;
                let context = format!(
                    "{ZGRID} of cell {cell}, interface {interface}: {height}, expected a height in metres"
                );
                return Err(source.error(ErrorKind::Layers, context));
            }
            sum[interface] += height;
            least[interface] = height.min(least[interface]);
            greatest[interface] = height.max(greatest[interface]);
        }
    }
    // Equal heights keep their very value, without the sum's rounding.
    let mean_of = |i: usize| {
        if least[i] == greatest[i] { least[i] } else { sum[i] / cells as f64 }
    };
    let mean: Vec<f64> = (0..interfaces).map(mean_of).collect();
    let off = (0..interfaces).map(|i| (greatest[i] - mean[i]).max(mean[i] - least[i]));
    let deviation = off.fold(0.0, f64::max);
    Ok((mean, deviation))
}

/// Interfaces from `refBottomDepth`: the surface, then the bottom of each level, falling.
fn depths(source: &Source, variable: &Variable) -> Result<Vec<f64>> {
    expect(source, variable, &["nVertLevels"])?;
    let bottom = source.all_reals(variable)?;
    let bottom: Reals<'_> = bottom.as_reals();
    Ok(std::iter::once(0.0).chain((0..bottom.len()).map(|level| -bottom.get(level))).collect())
}
