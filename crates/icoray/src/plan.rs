//! The plan of a scene: the data of a grid, layers and a field that it needs. Only this module decides which are left
//! out.

use crate::cells_per_pixel::cells_per_pixel;
use crate::derive;
use glam::DVec3;
use icoray_grid::visible_cells::VisibleCells;
use icoray_grid::{ColumnCount, Error, ErrorKind, Field, Grid, Layers, Location, Reals, Result};
use icoray_kernel::beyond_gathers;
use icoray_kernel::shade::Shading;
use icoray_output::{CellsPerPixel, Sharing};
use icoray_scene::{LightSource, Method, Precision, Scene, Scheme};

mod blocks;
pub(crate) mod budget;
mod left_out;
pub(crate) use left_out::CELL_CORNER;
mod levels;
mod memory;
mod savings;
pub(crate) use blocks::{Blocks, FieldColumns, FieldTest, MAX_CLEAR, OccupancyTest, SeenBlocks, clear_values};
pub use memory::FrameMemory;
pub(crate) use memory::lit_fields;
pub use savings::Savings;

/// The data that a scene needs.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Radii of the field's layers in planet radii, rising, exaggeration applied.
    pub(crate) radius: Vec<f64>,
    /// Whether the field's first layer is the outermost.
    pub(crate) falling: bool,
    /// Lighting, for which gradients are computed.
    pub(crate) shading: Option<Shading>,
    /// Whether the field has to be averaged from corners to centres.
    pub(crate) from_corners: bool,
    average_bytes: u64,
    derived_bytes: u64,
    left_out: Vec<String>,
}

impl Plan {
    /// Determines the data that `scene` needs, and checks that grid, layers and field fit each other and the scene.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when the field's shape does not fit the grid or the layers; [`ErrorKind::Scene`] when the
    /// exaggeration turns the shell inside out, the camera sits inside an opaque core, or the scene names a layer that
    /// is not there or a value that the kernels cannot hold.
    pub fn new(scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Result<Self> {
        let from_corners = field.location() == Location::Corner;
        let layers = Self::check(scene.field(), grid, layers, field)?;
        scene.check_values()?;
        levels::check(scene, field.shape().layers)?;
        let radius = layers.shell(scene.exaggeration)?;
        let eye = scene.camera.eye().iter().map(|x| x * x).sum::<f64>().sqrt();
        if scene.core.is_some() && eye < radius[0] {
            let message = format!(
                "the camera is {eye} planet radii from the centre, inside the opaque core of radius {}",
                radius[0]
            );
            return Err(Error::new(ErrorKind::Scene, message));
        }
        let shading = scene.lighting.map(|l| Shading {
            ambient: l.ambient,
            diffuse: l.diffuse,
            specular: l.specular,
            shininess: l.shininess,
            is_packed: false,
            towards_light: match l.source {
                LightSource::Headlight => None,
                LightSource::Sun { lon_deg, lat_deg } => {
                    Some(icoray_grid::grid::unit_vector(lon_deg.to_radians(), lat_deg.to_radians()))
                }
            },
        });
        let left_out = left_out::left_out(scene, grid, field.shape().layers, from_corners);
        let value_bytes = if matches!(field.samples(), Reals::F32(_)) { size_of::<f32>() } else { size_of::<f64>() };
        let averages = if from_corners { grid.cells() * radius.len() * value_bytes } else { 0 };
        let mut plan = Plan {
            radius,
            falling: layers.is_falling(),
            shading,
            from_corners,
            average_bytes: averages as u64,
            derived_bytes: derive::bytes(scene, field),
            left_out,
        };
        let beyond = Self::is_for_packets(scene).then(|| plan.beyond_gathers(scene, grid)).flatten();
        plan.left_out.extend(beyond.map(|table| format!("rays side by side: {table}")));
        Ok(plan)
    }

    /// Checks that field `name` fits grid and layers, and returns the layers on which it lies.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when its shape does not fit.
    pub(crate) fn check(name: &str, grid: &Grid, layers: &Layers, field: &Field) -> Result<Layers> {
        let shape = field.shape();
        let place = if field.location() == Location::Corner { "per corner" } else { "per cell" };
        let expected = ColumnCount::new(grid, field.location());
        if shape.columns != expected.columns {
            return Err(expected.error(shape.columns, place).within(format!("{name:?}")));
        }
        layers.for_field(shape.layers).map_err(|e| e.within(format!("{name:?}")))
    }

    /// Thickness of the shell, planet radii: the unit of a transfer function's lengths.
    pub(crate) fn thickness(&self) -> f64 {
        self.radius[self.radius.len() - 1] - self.radius[0]
    }

    /// The plan of the same scene with layers that are higher by this factor.
    pub(crate) fn lifted(&self, factor: f64) -> Self {
        Plan { radius: self.radius.iter().map(|radius| factor * radius).collect(), ..self.clone() }
    }

    /// Notes that fields or heights are averaged from corners.
    pub(crate) fn mark_corners_read(&mut self) {
        self.left_out.retain(|what| what != CELL_CORNER);
    }

    /// The parallel scheme for a picture of `scene`: the requested one, or one that fits the data. `has_parts` if each
    /// node has its part of the grid, else every rank has the whole.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] if tiles are requested and nodes have only parts.
    pub fn sharing(scene: &Scene, has_parts: bool) -> Result<Sharing> {
        let (scheme, why) = match (scene.ranks, has_parts) {
            (Scheme::Tiles, true) => {
                let message = "key ranks: \"tiles\", but each node has a part of the grid only, so no rank can draw a tile \
                               alone; expected \"auto\" or \"fragments\"";
                return Err(Error::new(ErrorKind::Scene, message));
            }
            (_, true) => (Scheme::Fragments, "each node has its part of the grid"),
            (Scheme::Fragments, false) => (Scheme::Fragments, "requested; every rank has the whole grid"),
            (Scheme::Auto | Scheme::Tiles, false) => (Scheme::Tiles, "every rank has the whole grid"),
        };
        Ok(Sharing::because(scheme, why))
    }

    /// Number of the grid's cells per pixel of the scene's picture.
    pub fn cells_per_pixel(&self, scene: &Scene, grid: &Grid) -> CellsPerPixel {
        cells_per_pixel(scene, grid, None, [self.radius[0], self.radius[self.radius.len() - 1]])
    }

    /// Bytes that a frame of the scene takes beside the model's arrays, on the CPU and with all savings.
    pub fn memory(&self, scene: &Scene, grid: &Grid) -> FrameMemory {
        self.memory_with(scene, grid, false, Savings::ALL, true)
    }

    /// The cells that rays of the picture can pass.
    pub(crate) fn visible_cells(&self, scene: &Scene, grid: &Grid) -> VisibleCells {
        let shell = [self.radius[0], self.radius[self.radius.len() - 1]];
        let sides = scene.camera.sides(scene.width, scene.height);
        VisibleCells::new(grid, DVec3::from_array(scene.camera.eye()), sides, shell, scene.core.is_some())
    }

    /// Whether rays walk side by side, where the machine and the grid permit it.
    fn is_for_packets(scene: &Scene) -> bool {
        scene.precision == Precision::F32 && scene.method == Method::Exact
    }

    /// The first table that is too long for packets of rays.
    fn beyond_gathers(&self, scene: &Scene, grid: &Grid) -> Option<String> {
        let values = grid.cells() * self.radius.len();
        let words = if self.allows_single_gradients(scene) { 1 } else { 3 };
        let gradients = if scene.lighting.is_some() { words * values } else { 0 };
        beyond_gathers(values, gradients)
    }

    /// Whether the scene's tolerance is far above the effect on light of gradients in single precision and of packed
    /// ones: packing turns normals by 1e-5.
    pub(crate) fn allows_single_gradients(&self, scene: &Scene) -> bool {
        const TURN: f64 = 1e-5;
        let off = self.shading.map_or(0.0, |s| TURN * (s.diffuse + s.specular * s.shininess.max(1.0).sqrt()));
        scene.precision == Precision::F32 && off <= 0.05 * scene.tolerance
    }

    /// Descriptions of the data that are not computed or read for this scene.
    pub fn left_out(&self) -> &[String] {
        &self.left_out
    }
}
