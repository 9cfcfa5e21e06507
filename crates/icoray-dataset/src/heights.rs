//! The heights of a field's layers.

mod axis;
mod columns;
pub(crate) mod native;
mod sigma;
mod thickness;

use crate::field::FieldInfo;
use crate::mesh::{Mesh, MeshLayout};
use crate::source::{SourceVariable, Variable};
use crate::sources::{EARTH_M, IN_ANOTHER_FILE, Sources};
use crate::standard_atmosphere;
use icoray::{Error, ErrorKind, Layers, Location, Result};

/// ICON's variables of heights over columns: of interfaces, then of full levels.
const ICON_COLUMNS: [&str; 7] = ["z_ifc", "zghalf", "HHL", "z_mc", "zg", "zfull", "geometric_height"];

/// Pressures over columns, in pascals unless units specify others.
const PRESSURE_COLUMNS: [&str; 3] = ["pfull", "pres", "pressure"];

/// Depths of MPAS-Atmosphere's soil over columns.
const SOIL_DEPTHS: &str = "zs";

/// Name of the source of heights if no variable gives them.
const SPHERE: &str = "sphere";

/// Advice for missing heights.
const WITHOUT_HEIGHTS: &str = "`heights` says at what heights the first and the last layer lie; a scene that shows layers \
                               as surfaces alone needs none";

/// Name of the source of heights if the user gives them.
const GIVEN: &str = "heights";

/// Thickness of the shell of a 2D field, in radii of the sphere.
const SHELL: f64 = 1e-3;

/// The heights of a field's layers.
///
/// A 2D field lies on the sphere: on the inner layer of a shell of a thousandth of the radius.
///
/// In MPAS these are the interfaces, one more than `nVertLevels`, on which fields over `nVertLevelsP1` lie; fields over
/// `nVertLevels` lie midway between them ([`Layers::for_field`]). In ICON they are the field's own layers, or
/// interfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerHeights {
    /// The variable of the heights; `sphere` for a 2D field.
    pub variable: String,
    /// Whether they are those of the standard atmosphere for the variable's pressures.
    pub is_of_pressure: bool,
    /// Whether the variable only counts layers: these are evenly spaced, at arbitrary heights.
    pub is_counted: bool,
    /// Height of each above the sphere in metres, negative below it: the mean over all columns if it differs.
    pub height_m: Vec<f64>,
    /// Largest deviation of a column's layer from the mean, in metres: 0 without terrain. `None` if the file gives one
    /// height for all columns and no deviation.
    pub deviation_m: Option<f64>,
    /// The layers as radii.
    pub layers: Layers,
}

/// Mean heights of layers or interfaces, and the largest deviation of columns from them, if known.
struct MeanHeights {
    height_m: Vec<f64>,
    deviation_m: Option<f64>,
}

/// Heights of a variable, before they become radii.
struct ReadHeights<'a> {
    found: SourceVariable<'a>,
    is_of_pressure: bool,
    is_counted: bool,
    means: MeanHeights,
}

impl<'a> ReadHeights<'a> {
    /// Heights in metres, from a variable that is not of pressures.
    fn new(found: SourceVariable<'a>, means: MeanHeights) -> Self {
        ReadHeights { found, is_of_pressure: false, is_counted: false, means }
    }
}

impl LayerHeights {
    /// Finds and reads the heights of a field's layers; `None` if no file gives them.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh, info: &FieldInfo, sphere_radius_m: f64) -> Result<Option<Self>> {
        if info.is_2d() {
            return Self::of_shell(2, true, sphere_radius_m).map(Some);
        }
        if let Some(ends) = sources.options.heights_m {
            let means = MeanHeights { height_m: evenly_spaced(info.layers, ends), deviation_m: Some(0.0) };
            return Self::plain(GIVEN, means, sphere_radius_m).map(Some);
        }
        let of_mpas = if is_over_mpas_levels(mesh, info) { of_mpas(sources, mesh)? } else { None };
        let found = match of_mpas {
            Some(found) => Some(found),
            None => of_others(sources, mesh, info, sphere_radius_m)?,
        };
        let Some(ReadHeights { found, is_of_pressure, is_counted, means }) = found else { return Ok(None) };
        let (name, height_m) = (found.name(), &means.height_m);
        // For a mesh on the unit sphere whose heights are in metres, from a mesh file and a file of heights.
        let is_in_metres = sphere_radius_m == 1.0 && height_m.iter().any(|height| height.abs() >= 1.0);
        let sphere_radius_m = if is_in_metres { EARTH_M } else { sphere_radius_m };
        if let Some(i) = height_m.iter().position(|h| !h.is_finite() || h.abs() >= sphere_radius_m) {
            return Err(found.error(
                ErrorKind::Layers,
                format_args!(
                    "{name}: layer {i} lies at {} m, but sphere_radius is {sphere_radius_m}; expected a radius in metres, \
                     such as an init or history file gives, or as `radius`",
                    height_m[i]
                ),
            ));
        }
        let plain = Self::plain(name, means, sphere_radius_m);
        let plain = plain.map_err(|e| e.within(found.source.path().display()))?;
        Ok(Some(LayerHeights { is_of_pressure, is_counted, ..plain }))
    }

    /// Heights in metres with a name.
    fn plain(name: &str, means: MeanHeights, sphere_radius_m: f64) -> Result<Self> {
        let MeanHeights { height_m, deviation_m } = means;
        let layers = Layers::from_heights(&height_m, sphere_radius_m).map_err(|e| e.within(name))?;
        let variable = name.to_owned();
        Ok(LayerHeights { variable, is_of_pressure: false, is_counted: false, height_m, deviation_m, layers })
    }

    /// The layers of a thin shell: that of a 2D field, or one in which some layers are shown as surfaces whose heights
    /// no file gives. The first is the innermost over the levels of MPAS-Atmosphere, and the outermost in others, as in
    /// these models.
    pub(crate) fn of_layers(sources: &Sources, mesh: &Mesh, info: &FieldInfo, sphere_radius_m: f64) -> Result<Self> {
        let is_rising = is_over_mpas_levels(mesh, info) && sources.find("maxLevelCell").is_none();
        Self::of_shell(info.layers, is_rising, sphere_radius_m)
    }

    fn of_shell(count: usize, is_rising: bool, sphere_radius_m: f64) -> Result<Self> {
        Self::plain(SPHERE, MeanHeights::of_shell(count, is_rising, sphere_radius_m), sphere_radius_m)
    }

    /// Whether no file gives the heights.
    pub(crate) fn are_of_shell(&self) -> bool {
        self.variable == SPHERE
    }

    /// The error with the heights that were searched for a field's layers and not found.
    pub(crate) fn missing(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Error {
        let context = format!(
            "no heights for the {} layers of {}: looked for {}; {IN_ANOTHER_FILE}; {WITHOUT_HEIGHTS}",
            info.layers,
            info.name,
            looked_for(mesh, info)
        );
        sources.error(ErrorKind::Layers, context)
    }
}

/// Variables with heights of a field's layers.
fn looked_for(mesh: &Mesh, info: &FieldInfo) -> String {
    if is_over_mpas_levels(mesh, info) {
        let thicknesses = thickness::NAMES_NOW.join(", ");
        return format!(
            "zgrid(nCells, nVertLevelsP1), refBottomDepth(nVertLevels), and {thicknesses}(nCells, nVertLevels), at times or \
             not"
        );
    }
    format!(
        "a coordinate {dimension}({dimension}) in metres or pascals, hyam and hybm, and {}, {} over {} or {} layers and {} \
         cells",
        ICON_COLUMNS.join(", "),
        PRESSURE_COLUMNS.join(", "),
        info.layers,
        info.layers + 1,
        height_columns(mesh).0,
        dimension = info.layer_dimension,
    )
}

/// Heights of `count` layers between the given first and last one.
fn evenly_spaced(count: usize, [first, last]: [f64; 2]) -> Vec<f64> {
    (0..count).map(|layer| first + (last - first) * (layer as f64 / (count - 1) as f64)).collect()
}

impl MeanHeights {
    /// Heights of the layers of a thin shell.
    fn of_shell(count: usize, is_rising: bool, sphere_radius_m: f64) -> Self {
        let top = SHELL * sphere_radius_m;
        let ends = if is_rising { [0.0, top] } else { [top, 0.0] };
        MeanHeights { height_m: evenly_spaced(count, ends), deviation_m: None }
    }
}

/// Whether a field's layers are the levels of MPAS's models, or interfaces between them.
fn is_over_mpas_levels(mesh: &Mesh, info: &FieldInfo) -> bool {
    mesh.layout() == MeshLayout::Mpas && info.layer_dimension.starts_with("nVertLevels")
}

/// Interfaces of MPAS-Atmosphere, or of MPAS-Ocean: from the depths that all columns share, or else from thicknesses.
fn of_mpas<'a>(sources: &'a Sources, mesh: &Mesh) -> Result<Option<ReadHeights<'a>>> {
    if let Some(found) = sources.find("zgrid") {
        expect(found, &["nCells", "nVertLevelsP1"])?;
        if let Some(info) = FieldInfo::of(found, mesh, &sources.options)? {
            let means = columns::mean(found, &info, &sources.options.missing, |height| height)?;
            return Ok(Some(ReadHeights::new(found, means)));
        }
    }
    if let Some(found) = sources.find("refBottomDepth") {
        expect(found, &["nVertLevels"])?;
        let bottom = found.all_numbers()?;
        let height_m = std::iter::once(0.0).chain(bottom.iter().map(|depth| -depth)).collect();
        return Ok(Some(ReadHeights::new(found, MeanHeights { height_m, deviation_m: None })));
    }
    let Some(found) = thickness::of_any_time(sources) else { return Ok(None) };
    Ok(Some(ReadHeights::new(found, thickness::interfaces(sources, found)?)))
}

/// Heights of other layers: of a coordinate in metres or pascals, of a variable with the heights, depths or pressures
/// of columns, of hybrid levels, or evenly spaced if a coordinate counts them.
fn of_others<'a>(
    sources: &'a Sources,
    mesh: &Mesh,
    info: &FieldInfo,
    sphere_radius_m: f64,
) -> Result<Option<ReadHeights<'a>>> {
    if let Some(found) = of_axis(sources, mesh, info)? {
        return Ok(Some(found));
    }
    if let Some(found) = sigma::of(sources, mesh, info) {
        return Ok(Some(ReadHeights::new(found, sigma::means(sources, found)?)));
    }
    let names = [&ICON_COLUMNS[..], &[SOIL_DEPTHS], &PRESSURE_COLUMNS].concat();
    if let Some(HeightColumns { found, info }) = HeightColumns::find(&names, sources, mesh, info)? {
        let name = found.name();
        let is_of_pressure = PRESSURE_COLUMNS.contains(&name);
        let scale = axis::Unit::of(found)?.map_or(1.0, |unit| unit.scale);
        let to_height = |value: f64| match name {
            SOIL_DEPTHS => -value,
            _ if is_of_pressure => standard_atmosphere::height_m(scale * value),
            _ => value,
        };
        let means = columns::mean(found, &info, &sources.options.missing, to_height)?;
        return Ok(Some(ReadHeights { is_of_pressure, ..ReadHeights::new(found, means) }));
    }
    if let Some(found) = axis::hybrid(sources, info.layers)? {
        return Ok(Some(found));
    }
    let Some(found) = sources.find(&info.layer_dimension) else { return Ok(None) };
    let is_rising = axis::counted(found, info.layers)?;
    Ok(is_rising.map(|is_rising| {
        let means = MeanHeights::of_shell(info.layers, is_rising, sphere_radius_m);
        ReadHeights { is_counted: true, ..ReadHeights::new(found, means) }
    }))
}

/// Heights of the coordinate of a field's layers, which all columns share; `None` if no file has one. In MPAS files it
/// may have another name than the dimension, such as `t_iso_levels(nIsoLevelsT)`, if it is of pressures.
fn of_axis<'a>(sources: &'a Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Option<ReadHeights<'a>>> {
    let is_mpas = mesh.layout() == MeshLayout::Mpas;
    let is_over = |v: &Variable| v.lies_at_times_over(&[&info.layer_dimension]);
    for source in sources.all() {
        let own = source.find(&info.layer_dimension);
        let others = source.each_variable().filter(|found| is_mpas && is_over(found.variable));
        for found in own.into_iter().chain(others) {
            let is_own = found.name() == info.layer_dimension;
            let heights = axis::heights(found, info.layers)?;
            if let Some(heights) = heights.filter(|heights| is_own || heights.is_of_pressure) {
                return Ok(Some(heights));
            }
        }
    }
    Ok(None)
}

/// Number and location of the columns with heights: ICON's triangles, other models' cells.
fn height_columns(mesh: &Mesh) -> (usize, Location) {
    match mesh.layout() {
        MeshLayout::Triangles => (mesh.corners_in_file(), Location::Corner),
        MeshLayout::Mpas | MeshLayout::Polygons => (mesh.cells(), Location::Center),
    }
}

/// A variable with heights of columns, and its description.
struct HeightColumns<'a> {
    found: SourceVariable<'a>,
    info: FieldInfo,
}

impl<'a> HeightColumns<'a> {
    /// The first variable of these names that lies over columns and a field's layers, or its interfaces.
    fn find(names: &[&str], sources: &'a Sources, mesh: &Mesh, of: &FieldInfo) -> Result<Option<Self>> {
        for found in names.iter().filter_map(|name| sources.find(name)) {
            let Some(info) = FieldInfo::of(found, mesh, &sources.options)? else { continue };
            let is_same = info.layer_dimension == of.layer_dimension;
            // Interfaces are a dimension of another name in ICON's files.
            let is_alike = mesh.layout() != MeshLayout::Mpas && (0..=1).any(|more| info.layers == of.layers + more);
            let is_over_columns = (info.columns, info.location) == height_columns(mesh);
            if found.variable.kind.is_real() && is_over_columns && (is_same || is_alike) {
                return Ok(Some(HeightColumns { found, info }));
            }
        }
        Ok(None)
    }
}

fn expect(found: SourceVariable, dimensions: &[&str]) -> Result<()> {
    if found.variable.lies_at_times_over(dimensions) && found.variable.kind.is_real() {
        return Ok(());
    }
    let expected = format_args!("{}({}) of float or double", found.name(), dimensions.join(", "));
    Err(found.unexpected(ErrorKind::Layers, expected))
}
