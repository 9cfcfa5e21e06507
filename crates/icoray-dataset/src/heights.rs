//! The heights on which a field's layers lie.

mod axis;
mod columns;
pub(crate) mod native;
mod thickness;

use crate::field::FieldInfo;
use crate::mesh::{Convention, Mesh};
use crate::source::{Source, Variable};
use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{Error, ErrorKind, Layers, Result};

/// ICON's variables of heights over columns: of interfaces, then of full levels.
const ICON_COLUMNS: [&str; 7] = ["z_ifc", "zghalf", "HHL", "z_mc", "zg", "zfull", "geometric_height"];

/// Name of what heights are of where no variable gives them.
const SPHERE: &str = "sphere";

/// Thickness of the shell of a 2D field, in radii of the sphere.
const SHELL: f64 = 1e-3;

/// Where a field's layers lie.
///
/// A 2D field lies on the sphere: on the inner layer of a shell of a thousandth of the radius.
///
/// In MPAS these are the interfaces, one more than `nVertLevels`, where fields over `nVertLevelsP1` lie; fields over
/// `nVertLevels` lie midway between them ([`Layers::for_field`]). In ICON they are the field's own layers, or
/// interfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerHeights {
    /// The variable that the heights are from; `sphere` of a 2D field.
    pub variable: String,
    /// Whether they are those of the standard atmosphere for pressures that the variable gives.
    pub is_of_pressure: bool,
    /// Height of each above the sphere in metres, negative below it: the mean over all columns where it differs.
    pub height_m: Vec<f64>,
    /// How far a column's layer lies off the mean at most, in metres: 0 without terrain. `None` where the file gives
    /// one height for all columns and does not tell.
    pub deviation_m: Option<f64>,
    /// The same as radii.
    pub layers: Layers,
}

/// Heights of a variable, before they become radii.
struct ReadHeights<'a> {
    source: &'a dyn Source,
    variable: &'a Variable,
    is_of_pressure: bool,
    height_m: Vec<f64>,
    deviation_m: Option<f64>,
}

impl<'a> ReadHeights<'a> {
    /// Heights in metres, of a variable that gives no pressures.
    fn new((source, variable): (&'a dyn Source, &'a Variable), (height_m, deviation_m): columns::Means) -> Self {
        ReadHeights { source, variable, is_of_pressure: false, height_m, deviation_m }
    }
}

impl LayerHeights {
    /// Finds and reads the heights of a field's layers; `None` where no file gives them.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh, info: &FieldInfo, sphere_radius_m: f64) -> Result<Option<Self>> {
        if info.is_2d() {
            return Self::of_shell(2, true, sphere_radius_m).map(Some);
        }
        let found = match mesh.convention() {
            Convention::Mpas => of_mpas(sources)?,
            Convention::Icon | Convention::Cf => of_icon(sources, mesh, info)?,
        };
        let Some(found) = found else { return Ok(None) };
        let (source, name, height_m) = (found.source, &found.variable.name, found.height_m);
        if let Some(i) = height_m.iter().position(|h| !h.is_finite() || h.abs() >= sphere_radius_m) {
            return Err(source.error(
                ErrorKind::Layers,
                format_args!(
                    "{name}: layer {i} lies at {} m, but sphere_radius is {sphere_radius_m}; expected a radius in metres, \
                     such as an init or history file gives (a mesh on the unit sphere has 1)",
                    height_m[i]
                ),
            ));
        }
        let layers = Layers::from_heights(&height_m, sphere_radius_m)
            .map_err(|e| e.within(name).within(source.path().display()))?;
        let (variable, is_of_pressure, deviation_m) = (name.clone(), found.is_of_pressure, found.deviation_m);
        Ok(Some(LayerHeights { variable, is_of_pressure, height_m, deviation_m, layers }))
    }

    /// The layers of a thin shell: that of a 2D field, or one in which some layers are shown as surfaces whose heights
    /// no file gives. The first is the innermost in files of MPAS-Atmosphere, and the outermost in others, as there.
    pub(crate) fn of_layers(sources: &Sources, mesh: &Mesh, info: &FieldInfo, sphere_radius_m: f64) -> Result<Self> {
        let is_rising = mesh.convention() == Convention::Mpas && sources.find("maxLevelCell").is_none();
        Self::of_shell(info.layers, is_rising, sphere_radius_m)
    }

    fn of_shell(count: usize, is_rising: bool, sphere_radius_m: f64) -> Result<Self> {
        let part = |layer: usize| layer as f64 / (count - 1) as f64;
        let height = |layer: usize| SHELL * sphere_radius_m * if is_rising { part(layer) } else { 1.0 - part(layer) };
        let height_m: Vec<f64> = (0..count).map(height).collect();
        let layers = Layers::from_heights(&height_m, sphere_radius_m)?;
        let variable = SPHERE.into();
        Ok(LayerHeights { variable, is_of_pressure: false, height_m, deviation_m: None, layers })
    }

    /// Whether no file gives the heights.
    pub(crate) fn are_of_shell(&self) -> bool {
        self.variable == SPHERE
    }

    /// Which heights of a field's layers were looked for and not found.
    pub(crate) fn missing(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Error {
        if mesh.convention() == Convention::Mpas {
            return sources.error(
                ErrorKind::Layers,
                format_args!(
                    "no layer heights: looked for zgrid(nCells, nVertLevelsP1), refBottomDepth(nVertLevels), \
                     restingThickness(nCells, nVertLevels) and layerThickness(Time, nCells, nVertLevels); \
                     {IN_ANOTHER_FILE}; a scene that shows layers as surfaces alone needs none"
                ),
            );
        }
        sources.error(
            ErrorKind::Layers,
            format_args!(
                "no heights for the {} layers of {}: looked for a coordinate {dimension}({dimension}) in metres or \
                 pascals, and for {} over {} or {} layers and {} cells; {IN_ANOTHER_FILE}; a scene that \
                 shows layers as surfaces alone needs none",
                info.layers,
                info.name,
                ICON_COLUMNS.join(", "),
                info.layers,
                info.layers + 1,
                columns_of(mesh),
                dimension = info.layer_dimension,
            ),
        )
    }
}

/// Interfaces of MPAS-Atmosphere, or of MPAS-Ocean: from the depths that all columns share, or else from thicknesses.
fn of_mpas(sources: &Sources) -> Result<Option<ReadHeights<'_>>> {
    if let Some((source, variable)) = sources.find("zgrid") {
        expect(source, variable, &["nCells", "nVertLevelsP1"])?;
        return Ok(Some(ReadHeights::new((source, variable), columns::mean(source, variable, true)?)));
    }
    if let Some((source, variable)) = sources.find("refBottomDepth") {
        expect(source, variable, &["nVertLevels"])?;
        let bottom = source.all_numbers(variable)?;
        let height_m = std::iter::once(0.0).chain(bottom.iter().map(|depth| -depth)).collect();
        return Ok(Some(ReadHeights::new((source, variable), (height_m, None))));
    }
    let Some(found) = thickness::of_any_time(sources) else { return Ok(None) };
    Ok(Some(ReadHeights::new(found, thickness::interfaces(sources, found)?)))
}

/// Heights of ICON's layers: of a coordinate in metres or pascals, or of a variable with the heights of columns.
fn of_icon<'a>(sources: &'a Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Option<ReadHeights<'a>>> {
    if let Some(found) = of_axis(sources, info)? {
        return Ok(Some(found));
    }
    let Some((source, variable)) = icon_columns(sources, mesh, info) else { return Ok(None) };
    Ok(Some(ReadHeights::new((source, variable), columns::mean(source, variable, false)?)))
}

/// Heights of the coordinate of a field's layers, which all columns share; `None` where no file has one.
fn of_axis<'a>(sources: &'a Sources, info: &FieldInfo) -> Result<Option<ReadHeights<'a>>> {
    for source in sources.all() {
        let Some(variable) = source.variable(&info.layer_dimension) else { continue };
        if let Some((height_m, is_of_pressure)) = axis::heights(source, variable, info.layers)? {
            let deviation_m = Some(0.0);
            return Ok(Some(ReadHeights { source, variable, is_of_pressure, height_m, deviation_m }));
        }
    }
    Ok(None)
}

/// Number of columns with heights: ICON's triangles, other models' cells.
fn columns_of(mesh: &Mesh) -> usize {
    if mesh.convention() == Convention::Icon { mesh.corners() } else { mesh.cells() }
}

/// The variable with the heights of a field's layers over ICON's columns, or of its interfaces.
fn icon_columns<'a>(sources: &'a Sources, mesh: &Mesh, info: &FieldInfo) -> Option<(&'a dyn Source, &'a Variable)> {
    let fits = |variable: &Variable| {
        let [.., layers, cells] = variable.dimensions.as_slice() else { return false };
        let is_theirs = layers.len == info.layers || layers.len == info.layers + 1;
        variable.kind.is_real() && is_theirs && cells.len == columns_of(mesh)
    };
    ICON_COLUMNS.iter().filter_map(|name| sources.find(name)).find(|(_, variable)| fits(variable))
}

fn expect(source: &dyn Source, variable: &Variable, dimensions: &[&str]) -> Result<()> {
    if variable.lies_at_times_over(dimensions) && variable.kind.is_real() {
        return Ok(());
    }
    Err(source.error(
        ErrorKind::Layers,
        format_args!("variable {variable}, expected {}({}) of float or double", variable.name, dimensions.join(", ")),
    ))
}
