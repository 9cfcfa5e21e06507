//! Grids with fields, synthetic or from files.

use glam::DVec3;
use icoray::{Field, Grid, Layers, Renderer, Result, Scene};
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

impl Dataset {
    /// Generates or reads grid and field and hands them to `work`; `None` if the file is not in `data`. Where it is
    /// `quick`, synthetic grids have 642 cells and 8 layers.
    pub fn with<R>(
        self,
        quick: bool,
        data: &Path,
        renderer: &Renderer,
        work: impl FnOnce(&PreparedDataset) -> Result<R>,
    ) -> Result<Option<R>> {
        const SHELL: [f64; 2] = [1.0, 1.15];
        let (level, layers, shell, f): (_, _, _, fn(DVec3) -> f64) = match self {
            Dataset::Radial => (5, 61, [radial::INNER, radial::OUTER], |p| p.length()),
            Dataset::MultiScaleLow => (5, 61, SHELL, multi_scale),
            Dataset::MultiScaleHigh => (8, 99, SHELL, multi_scale),
            Dataset::Stiff => (4, 20, SHELL, multi_scale),
            Dataset::Vorticity => return with_file(data, "vorticity", renderer, work),
            Dataset::Theta => return with_file(data, "theta", renderer, work),
        };
        let (level, layers) = if quick { (3, 8) } else { (level, layers) };
        let sphere = Sphere::new(level, layers, shell, f)?;
        let grid = renderer.run(|| sphere.grid())?;
        work(&PreparedDataset { grid: &grid, layers: &sphere.layers, field: &sphere.field()? }).map(Some)
    }
}

fn with_file<R>(
    data: &Path,
    name: &str,
    renderer: &Renderer,
    work: impl FnOnce(&PreparedDataset) -> Result<R>,
) -> Result<Option<R>> {
    let path = data.join(MPAS_FILE);
    if !path.exists() {
        return Ok(None);
    }
    let file = icoray_netcdf::open(path)?;
    let (layers, field) = (file.layers(name)?, file.read_field(name, MPAS_TIME)?);
    let grid = renderer.run(|| file.mesh().grid())?;
    work(&PreparedDataset { grid: &grid, layers: &layers, field: &field.field()? }).map(Some)
}

/// The directory of data files: `given`, else that of `ICORAY_TEST_DATA`, else `../shared/data`.
pub(crate) fn data_directory(given: Option<&Path>) -> PathBuf {
    let named = || std::env::var_os("ICORAY_TEST_DATA").map(PathBuf::from);
    given.map(Path::to_owned).or_else(named).unwrap_or_else(|| PathBuf::from("../shared/data"))
}

/// A checked grid with its layers and its field.
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
        let radius = self.layers.for_field(self.field.shape().layers)?.shell(scene.exaggeration)?;
        Ok(radius[radius.len() - 1] - radius[0])
    }
}
