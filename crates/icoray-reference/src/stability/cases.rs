//! The cases: meshes, layers, fields, transfer functions, cameras.

mod fields;
mod rays;
mod shells;
mod transfers;

use glam::DVec3;
use icoray::{Camera, Field, Grid, Knot, Layers, Location, OwnedReals, Result, Scene, Shape};

/// The groups in the order of the table.
pub const GROUPS: [&str; 8] = ["mesh", "shell", "Earth", "camera", "ray", "depth", "transfer", "field"];

/// Meshes that the suite needs, by number of bisections.
pub const LEVELS: [u32; 5] = [2, 3, 4, 5, 6];
/// The same for the fine meshes.
pub const LARGE_LEVELS: [u32; 3] = [7, 8, 9];

/// The cases on one mesh.
pub fn on(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let mut cases = shells::meshes(mesh)?;
    match mesh.level {
        3 => {
            cases.extend(shells::thickness(mesh)?);
            cases.extend(rays::cameras(mesh)?);
            cases.extend(rays::rays(mesh)?);
            cases.extend(transfers::depths(mesh)?);
            cases.extend(transfers::transfers(mesh)?);
            cases.extend(fields::fields(mesh)?);
            cases.extend(fields::missing(mesh)?);
        }
        4 => cases.extend(shells::earth(mesh)?),
        _ => {}
    }
    Ok(cases)
}

/// A picture to be drawn and checked ray by ray.
#[derive(Debug, Clone)]
pub struct Case {
    /// One of [`GROUPS`].
    pub group: &'static str,
    /// Description, unique in its group.
    pub name: String,
    /// Layers in planet radii.
    pub layers: Layers,
    /// Values, level-fastest, first layer first.
    pub values: OwnedReals,
    /// The value that marks a missing one.
    pub fill: Option<f64>,
    /// Camera, transfer function, core.
    pub scene: Scene,
}

/// A mesh to make cases on.
#[derive(Debug, Clone, Copy)]
pub struct CaseMesh<'g> {
    pub level: u32,
    pub grid: &'g Grid<'g>,
}

const RED: [f64; 3] = [0.9, 0.1, 0.05];
const BLUE: [f64; 3] = [0.1, 0.2, 1.0];
const PLAIN: &str = r##"
field = "f"
antialias = false
background = "transparent"
core = "#405060"
[camera]
lon = 20
lat = 35
distance = 3.5
fov = 40
[transfer]
knots = [ { value = -0.6, color = "#2040ff", opacity = 0.7 }, { value = -0.2, color = "#20c0ff", opacity = 0.1 },
          { value = 0.0, color = "white", opacity = 0 }, { value = 0.15, color = "yellow", opacity = 0 },
          { value = 0.3, color = "orange", opacity = 0.6 }, { value = 0.7, color = "red", opacity = 0.9 } ]
"##;

/// A field of some structure in [-1, 1]; `x` runs from 0 on the lowest layer to 1 on the highest.
fn wave(d: DVec3, x: f64) -> f64 {
    let slow = (3.0 * d.x + 4.0 * x).sin() * (2.0 * d.y - x).cos();
    let fast = (7.0 * d.z + 2.0 * x).sin() * (6.0 * d.x - 3.0 * x).cos();
    (0.7 * slow + 0.5 * fast).clamp(-1.0, 1.0)
}

impl CaseMesh<'_> {
    /// Six layers from radius 1 to 1.1 with a [`wave`], the whole globe seen from afar, an opaque core.
    fn case(&self, group: &'static str, name: impl Into<String>) -> Result<Case> {
        let mut case = Case {
            group,
            name: name.into(),
            layers: Layers::new(vec![1.0, 1.1], 1.0)?,
            values: OwnedReals::F32(Vec::new()),
            fill: None,
            scene: Scene::parse(PLAIN)?,
        };
        case.scene.width = 13;
        case.scene.height = 13;
        self.shell(&mut case, 6, 0.02)?;
        Ok(case)
    }

    /// Puts `count` layers, `thickness` apart, from radius 1 on, with the wave on them.
    fn shell(&self, case: &mut Case, count: usize, thickness: f64) -> Result<()> {
        case.layers = Layers::new((0..count).map(|l| 1.0 + thickness * l as f64).collect(), 1.0)?;
        self.field(case, wave);
        Ok(())
    }

    /// The values of `f` at each cell's direction and fraction of the shell, in f64.
    fn sampled(&self, case: &Case, f: impl Fn(DVec3, f64) -> f64) -> Vec<f64> {
        let count = case.layers.count();
        let fraction = |l: usize| l as f64 / (count - 1) as f64;
        let cells = 0..self.grid.cells() as u32;
        let value = |c: u32, l: usize| f(self.grid.direction(c), fraction(l));
        cells.flat_map(|c| (0..count).map(move |l| (c, l))).map(|(c, l)| value(c, l)).collect()
    }

    /// Gives the case the field `f` in single precision.
    fn field(&self, case: &mut Case, f: impl Fn(DVec3, f64) -> f64) {
        case.values = OwnedReals::F32(self.sampled(case, f).into_iter().map(|v| v as f32).collect());
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.grid.triangle(triangle).map(|cell| self.grid.direction(cell))
    }
}

impl Case {
    /// The field over `grid`.
    pub fn field(&self, grid: &Grid) -> Result<Field<'_>> {
        let shape = Shape::level_fastest(grid.cells(), self.layers.count());
        Field::new(self.values.as_reals(), shape, Location::Center, self.fill)
    }

    /// Looks from `eye` along `dir`; `fov` in degrees, `size` pixels wide and high.
    fn look(mut self, eye: DVec3, dir: DVec3, fov: f64, size: u32) -> Self {
        let up = dir.normalize().any_orthonormal_vector().to_array();
        let camera = Camera::look_at(eye.to_array(), (eye + dir).to_array(), up, fov);
        self.scene.camera = camera.expect("a case's camera looks somewhere");
        (self.scene.width, self.scene.height) = (size, size);
        self
    }

    /// Lets rays through the core.
    fn hollow(mut self) -> Self {
        self.scene.core = None;
        self
    }

    /// Sets the transfer function; extinction is per `unit` planet radii.
    fn transfer(mut self, unit: f64, knots: &[Knot]) -> Self {
        self.scene.volumes[0].transfer.knots = knots.to_vec();
        self.scene.volumes[0].transfer.unit_length = Some(unit);
        self
    }
}

const fn knot(value: f64, color: [f64; 3], extinction: f64) -> Knot {
    Knot { value, color, extinction }
}
