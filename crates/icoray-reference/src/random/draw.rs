//! Random meshes, fields and scenes: a seed's scene is always the same.

use super::scene_text::{KINDS, SceneText};
use crate::culled::{Culled, Mark, Style, holes};
use crate::oracle::{Data, NamedField};
use crate::shading::direction;
use glam::{DQuat, DVec3};
use icoray::{
    Error, ErrorKind, Field, Fields, Grid, IcosahedralMesh, Layers, Location, OwnedReals, Precision, Result, Scene,
    Shape,
};
use icoray_test_support::Random;
use std::fmt::Write as _;

/// A mesh, layers, two fields, and a scene of them.
pub struct RandomScene {
    /// The seed that draws it.
    pub seed: u64,
    /// One of [`KINDS`](super::KINDS).
    pub kind: &'static str,
    /// The scene as TOML.
    pub text: String,
    /// The parsed scene.
    pub scene: Scene,
    mesh: Culled,
    /// The layers.
    pub layers: Layers,
    /// Heights of each column's layers, metres, level-fastest.
    heights: Vec<f64>,
    pub(super) fields: Vec<NamedField<'static>>,
    /// The same in the model's precision.
    given: Vec<OwnedReals>,
    /// Mesh and fields in words.
    pub recipe: String,
}

impl RandomScene {
    /// Draws the scene of a seed, which is always the same.
    ///
    /// # Errors
    /// As [`Scene::parse`] and [`Layers::from_heights`], where an invalid scene is drawn.
    pub fn new(seed: u64) -> Result<Self> {
        Self::draw(seed, [1, 2, 2, 3], &KINDS)
    }

    /// Draws a scene of one volume without light in f32, on a mesh that has levels of detail.
    ///
    /// # Errors
    /// As [`RandomScene::new`].
    pub fn with_levels(seed: u64) -> Result<Self> {
        let mut drawn = Self::draw(seed, [4, 5, 5, 5], &KINDS[..2])?;
        (drawn.scene.lighting, drawn.scene.precision) = (None, Precision::F32);
        Ok(drawn)
    }

    /// Draws a scene of one of these kinds on a mesh of one of these bisections.
    fn draw(seed: u64, bisections: [u32; 4], kinds: &[&'static str]) -> Result<Self> {
        let mut random = Random::new(seed);
        let random = &mut random;
        let (mesh, mut recipe) = mesh(random, bisections)?;
        let grid = mesh.grid();
        let layers = 2 + random.below(6);
        let top = 10f64.powf(random.between(-4.0, -0.5));
        let mut up: Vec<f64> = (0..layers).map(|l| (l as f64 + random.between(0.0, 0.7)) / layers as f64).collect();
        (up[0], up[layers - 1]) = (0.0, 1.0);
        let steep = random.between(0.0, 0.6);
        let columns = (0..grid.cells()).flat_map(|cell| {
            let mountain = steep * (3.0 * grid.direction(cell as u32).x + 1.0).sin().abs();
            up.iter().map(move |up| top * (mountain * (1.0 - up) + up)).collect::<Vec<f64>>()
        });
        let heights: Vec<f64> = columns.collect();
        let is_single = random.below(2) == 0;
        let log = random.below(kinds.len()) == 1;
        let kind = if log { KINDS[1] } else { kinds[[0, 2, 3, 4, 5, 6, 7, 8][random.below(kinds.len() - 1)]] };
        let mut fields = Vec::new();
        for name in ["f", "g"] {
            let style = if log { STYLES.len() - 1 } else { [0, 1, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4][random.below(12)] };
            let values = values(random, &grid, layers, is_single, style);
            let _ = write!(recipe, "; {name} {}, {}", STYLES[style], if is_single { "f32" } else { "f64" });
            fields.push(NamedField { name, values });
        }
        let radii: Vec<f64> = up.iter().map(|up| top * up).collect();
        let sorted = fields.iter().map(|field| {
            let mut sorted: Vec<f64> = field.values.iter().copied().filter(|value| value.is_finite()).collect();
            sorted.sort_by(f64::total_cmp);
            sorted
        });
        let sorted = sorted.collect();
        let mut writer = SceneText { random, fields: &fields, sorted, top, layers, text: String::new() };
        writer.scene(kind, &grid);
        let text = writer.text;
        let mut scene =
            Scene::parse(&text).map_err(|e| Error::new(ErrorKind::Scene, format!("seed {seed}: {e}\n{text}")))?;
        scene.name_first_field("f");
        let given = fields.iter().map(|NamedField { values, .. }| match is_single {
            true => OwnedReals::F32(values.iter().map(|value| *value as f32).collect()),
            false => OwnedReals::F64(values.clone()),
        });
        let given = given.collect();
        drop(grid);
        let layers = Layers::from_heights(&radii, 1.0)?;
        Ok(RandomScene { seed, kind, text, scene, mesh, layers, heights, fields, given, recipe })
    }

    /// The grid of the mesh.
    pub fn grid(&self) -> Grid<'_> {
        self.mesh.grid()
    }

    pub(super) fn data<'d>(&'d self, grid: &'d Grid<'d>) -> Data<'d> {
        Data { grid, layers: &self.layers, heights: &self.heights, fields: &self.fields }
    }

    /// The fields in the model's precision.
    ///
    /// # Errors
    /// As [`Field::new`].
    pub fn model_fields(&self) -> Result<Fields<'_>> {
        let shape = Shape::level_fastest(self.heights.len() / self.layers.count(), self.layers.count());
        let field = |values| Field::new(values, shape, Location::Center, None);
        let [f, g] = [0, 1].map(|k: usize| field(self.given[k].as_reals()));
        Ok(Fields::new([("f", f?), ("g", g?)]).with_heights(field((&self.heights).into())?))
    }
}

/// An icosahedral mesh with jittered cells, turned at random, in one of four cases with holes; and its recipe.
fn mesh(random: &mut Random, bisections: [u32; 4]) -> Result<(Culled, String)> {
    let level = bisections[random.below(4)];
    let jitter = random.between(0.0, 0.2) * 1.1 / f64::from(1 << level);
    let mut mesh = IcosahedralMesh::new(level)?;
    let turn = DQuat::from_axis_angle(DVec3::from_array(random.direction()), random.between(0.0, 6.0));
    let mut moved = |lon: &mut f64, lat: &mut f64, jitter: f64| {
        let at = direction(*lon, *lat) + jitter * DVec3::from_array(random.direction());
        let at = turn * at.normalize();
        (*lon, *lat) = (at.y.atan2(at.x), at.z.clamp(-1.0, 1.0).asin());
    };
    mesh.lon_center_rad.iter_mut().zip(&mut mesh.lat_center_rad).for_each(|(lon, lat)| moved(lon, lat, jitter));
    mesh.lon_corner_rad.iter_mut().zip(&mut mesh.lat_corner_rad).for_each(|(lon, lat)| moved(lon, lat, 0.0));
    let mut all = holes(&mesh);
    let (name, stays) = match random.below(4) {
        0 => all.swap_remove(random.below(all.len())),
        _ => ("no holes", vec![true; mesh.cells()]),
    };
    let style = [Style::Corners, Style::Triangles][random.below(2)];
    let stays = if stays.iter().filter(|s| **s).count() > 12 { stays } else { vec![true; mesh.cells()] };
    let recipe = format!("level {level}, jitter {jitter:.3}, {name}");
    Ok((Culled::new(&mesh, &stays, style, Mark::MinusOne, 0), recipe))
}

const STYLES: [&str; 5] = ["constant but for rounding", "smooth", "noise", "spikes", "decades"];

/// The values of a field in one of the [`STYLES`].
fn values(random: &mut Random, grid: &Grid, layers: usize, single: bool, style: usize) -> Vec<f64> {
    let scale = 10f64.powf(random.between(-6.0, 4.0));
    let offset = scale * [0.0, 0.0, 1.0, 300.0][random.below(4)];
    let [a, b] = [0; 2].map(|_| random.between(1.0, 6.0) * DVec3::from_array(random.direction()));
    let turn = random.between(-3.0, 3.0);
    let missing = if random.below(5) == 0 { random.between(0.0, 0.1) } else { 0.0 };
    let mut values = Vec::new();
    for cell in 0..grid.cells() {
        let d = grid.direction(cell as u32);
        let column_missing = random.chance(0.5 * missing);
        for layer in 0..layers {
            let up = layer as f64 / layers as f64;
            let wave = (a.dot(d) + turn * up).sin() * (b.dot(d) - turn * up).cos() + 0.3 * up;
            let noise = random.between(-1.0, 1.0);
            let value = match style {
                0 => offset.max(scale) * (1.0 + (3.0 * noise).round() * if single { 1.2e-7 } else { 2.3e-16 }),
                1 => offset + scale * wave,
                2 => offset + scale * noise,
                3 if random.chance(0.05) => scale * 10f64.powf(random.between(0.0, 6.0)),
                3 => scale * 0.01 * wave,
                _ => scale * 10f64.powf(-3.0 + 3.0 * wave),
            };
            let value = if single { f64::from(value as f32) } else { value };
            let is_missing = column_missing || random.chance(0.2 * missing);
            values.push(if is_missing { f64::NAN } else { value });
        }
    }
    values
}
