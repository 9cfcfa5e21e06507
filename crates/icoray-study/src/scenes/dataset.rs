//! Grids with fields, synthetic or from files.

use icoray::{CenterField, Field, Grid, Layers, Location, Renderer, Result, Scene};
use icoray_dataset::OwnedField;
use icoray_reference::job::Job;
use icoray_reference::radial;
use icoray_reference::sphere::{Sphere, multi_scale};
use std::path::{Path, PathBuf};

/// The file that the real fields are read from, and the record of day 9.
const MPAS_FILE: &str = "mpas_jw_10242.nc";
const MPAS_TIME: usize = 2;

/// A grid with layers and a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dataset {
    /// The distance to the centre on the paper's low-resolution grid, 10,242 cells and 61 layers.
    Radial,
    /// Relative vorticity of the baroclinic wave, from an MPAS file.
    Vorticity,
    /// Potential temperature of the baroclinic wave, from an MPAS file.
    Theta,
    /// The multi-scale field on the paper's low-resolution grid.
    MultiScaleLow,
    /// The multi-scale field on the paper's high-resolution grid, 655,362 cells and 99 layers.
    MultiScaleHigh,
    /// The multi-scale field on 2,562 cells and 20 layers.
    Stiff,
}

/// A dataset in memory.
#[derive(Debug)]
pub enum LoadedDataset {
    Synthetic(Sphere),
    File { file: Box<icoray_dataset::Dataset>, layers: Layers, field: OwnedField },
}

impl Dataset {
    /// Generates or reads grid and field; `None` if the file is not in `data`. Where it is `quick`, synthetic grids have 642
    /// cells and 8 layers.
    pub fn load(self, quick: bool, data: &Path) -> Result<Option<LoadedDataset>> {
        let synthetic = |level, layers, ends, f: fn(glam::DVec3) -> f64| {
            let (level, layers) = if quick { (3, 8) } else { (level, layers) };
            Sphere::new(level, layers, ends, f).map(|sphere| Some(LoadedDataset::Synthetic(sphere)))
        };
        match self {
            Dataset::Radial => synthetic(5, 61, [radial::INNER, radial::OUTER], |p| p.length()),
            Dataset::MultiScaleLow => synthetic(5, 61, [1.0, 1.15], multi_scale),
            Dataset::MultiScaleHigh => synthetic(8, 99, [1.0, 1.15], multi_scale),
            Dataset::Stiff => synthetic(4, 20, [1.0, 1.15], multi_scale),
            Dataset::Vorticity => read(data, "vorticity"),
            Dataset::Theta => read(data, "theta"),
        }
    }
}

fn read(data: &Path, name: &str) -> Result<Option<LoadedDataset>> {
    let path = data.join(MPAS_FILE);
    if !path.exists() {
        return Ok(None);
    }
    let file = icoray_netcdf::open(path)?;
    let layers = file.layers(name)?;
    let field = file.read_field(name, MPAS_TIME)?;
    Ok(Some(LoadedDataset::File { file: Box::new(file), layers, field }))
}

/// The directory of data files: `given`, or what `ICORAY_TEST_DATA` names, or `../shared/data`.
pub(crate) fn data_directory(given: Option<&Path>) -> PathBuf {
    let named = || std::env::var_os("ICORAY_TEST_DATA").map(PathBuf::from);
    given.map(Path::to_owned).or_else(named).unwrap_or_else(|| PathBuf::from("../shared/data"))
}

impl LoadedDataset {
    /// Checks the grid, averages a field at corners to cells, and hands both to `work`.
    pub fn with<R>(&self, renderer: &Renderer, work: impl FnOnce(&PreparedDataset) -> Result<R>) -> Result<R> {
        let (grid, layers, field) = match self {
            LoadedDataset::Synthetic(sphere) => (renderer.run(|| sphere.grid())?, &sphere.layers, sphere.field()?),
            LoadedDataset::File { file, layers, field } => {
                (renderer.run(|| file.mesh().grid())?, layers, field.field()?)
            }
        };
        let center = match field.location() {
            Location::Center => None,
            Location::Corner => Some(renderer.run(|| CenterField::average(&grid, &field))?),
        };
        let field = center.as_ref().map_or(field, CenterField::field);
        work(&PreparedDataset { grid: &grid, layers, field: &field })
    }
}

/// A checked grid with its layers and its field at cells.
#[derive(Debug, Clone, Copy)]
pub struct PreparedDataset<'a> {
    grid: &'a Grid<'a>,
    layers: &'a Layers,
    field: &'a Field<'a>,
}

impl PreparedDataset<'_> {
    /// The job of rendering `scene` here.
    pub fn job<'s>(&'s self, scene: &'s Scene) -> Job<'s> {
        Job { scene, grid: self.grid, layers: self.layers, field: self.field }
    }

    /// Thickness of the shell that `scene` makes of the layers, planet radii.
    pub fn thickness(&self, scene: &Scene) -> Result<f64> {
        let radius = self.layers.shell(scene.exaggeration)?;
        Ok(radius[radius.len() - 1] - radius[0])
    }
}
