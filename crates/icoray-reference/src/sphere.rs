//! Synthetic grids with fields, for studies and tests.

use crate::job::Job;
use crate::shading::direction;
use glam::DVec3;
use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Result, Scene, memory};
use rayon::prelude::*;

/// A mesh, layers and a level-fastest f32 field on them.
#[derive(Debug)]
pub struct Sphere {
    /// The mesh's tables.
    pub mesh: IcosahedralMesh,
    /// Layers in planet radii.
    pub layers: Layers,
    /// Values, level-fastest.
    pub values: Vec<f32>,
}

impl Sphere {
    /// An icosahedral mesh of `level` bisections with `layers` equally spaced radii from `inner` to `outer`, and the
    /// field `f` of position.
    ///
    /// # Errors
    /// As [`IcosahedralMesh::new`] and [`Layers::new`].
    pub fn new(level: u32, layers: usize, [inner, outer]: [f64; 2], f: impl Fn(DVec3) -> f64 + Sync) -> Result<Self> {
        let mesh = IcosahedralMesh::new(level)?;
        let radius = |l: usize| inner + (outer - inner) * l as f64 / (layers - 1) as f64;
        let layers = Layers::new((0..layers).map(radius).collect(), 1.0)?;
        let radii = layers.radius_m();
        let mut values: Vec<f32> = memory::zeros("the values of a field", mesh.cells() * radii.len())?;
        values.par_chunks_exact_mut(radii.len()).enumerate().for_each(|(cell, column)| {
            let direction = direction(mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]);
            for (value, r) in column.iter_mut().zip(radii) {
                *value = f(direction * *r) as f32;
            }
        });
        Ok(Sphere { mesh, layers, values })
    }

    /// The checked grid.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn grid(&self) -> Result<Grid<'_>> {
        Grid::new(self.mesh.tables())
    }

    /// The field.
    ///
    /// # Errors
    /// As [`Field::new`].
    pub fn field(&self) -> Result<Field<'_>> {
        Field::level_fastest(&self.values, self.layers.count(), Location::Center)
    }

    /// Heights of layers that follow mountains and get even upwards, level-fastest.
    pub fn terrain(&self) -> Vec<f64> {
        let planet = self.layers.planet_radius_m();
        let heights: Vec<f64> = self.layers.radius_m().iter().map(|radius| radius - planet).collect();
        let top = heights[heights.len() - 1];
        let columns = (0..self.mesh.cells()).into_par_iter().flat_map_iter(|cell| {
            let d = direction(self.mesh.lon_center_rad[cell], self.mesh.lat_center_rad[cell]);
            let wave = (9.0 * d.x + 2.0 * d.z).sin() * (7.0 * d.y - 3.0 * d.x).cos() * (8.0 * d.z).cos();
            let mountain = 0.4 * top * wave * wave;
            heights.iter().map(move |height| mountain + height * (1.0 - mountain / top))
        });
        columns.collect()
    }

    /// Hands the job of rendering `scene` to `work`.
    ///
    /// # Errors
    /// As [`Self::grid`] and [`Self::field`], and those of `work`.
    pub fn with_job<R>(&self, scene: &Scene, work: impl FnOnce(&Job) -> Result<R>) -> Result<R> {
        let (grid, field) = (self.grid()?, self.field()?);
        work(&Job { scene, grid: &grid, layers: &self.layers, field: &field })
    }
}

/// Wave numbers and weights of [`multi_scale`].
const WAVES: [(f64, f64); 4] = [(3.0, 0.5), (7.0, 0.25), (17.0, 0.15), (41.0, 0.1)];

/// A field with structure from the planet's size down to a few degrees, in [-1, 1], like vorticity.
pub fn multi_scale(p: DVec3) -> f64 {
    let r = p.length();
    let d = p / r;
    let mut sum = 0.0;
    for (k, weight) in WAVES {
        let phase = 20.0 * (r - 1.0);
        sum += weight * (k * d.x + phase).sin() * (k * d.y - 0.7 * phase).cos() * (k * d.z + 0.3 * k).sin();
    }
    (2.0 * sum).clamp(-1.0, 1.0)
}
