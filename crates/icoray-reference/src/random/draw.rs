//! Random meshes, fields and scenes: a seed's scene is always the same.

use crate::culled::{Culled, Mark, Style, holes};
use crate::oracle::Data;
use crate::shading::direction;
use glam::{DQuat, DVec3};
use icoray::{Error, ErrorKind, Field, Fields, Grid, IcosahedralMesh, Layers, Location, Result, Scene, Shape};
use icoray_test_support::Random;
use std::fmt::Write as _;

/// The kinds of scenes; the last one combines all.
pub const KINDS: [&str; 9] = [
    "one volume",
    "log scale",
    "several volumes",
    "by another field",
    "isosurfaces",
    "surfaces",
    "cuts",
    "native heights",
    "mixed",
];

/// Pixels of a picture; odd, so that one ray goes through its middle.
const SIZE: [u32; 2] = [25, 19];

/// A mesh, layers, two fields, and a scene of them.
pub struct RandomScene {
    /// The seed that draws it.
    pub seed: u64,
    /// One of [`KINDS`].
    pub kind: &'static str,
    /// The scene as TOML.
    pub text: String,
    /// The parsed scene.
    pub scene: Scene,
    mesh: Culled,
    pub(super) layers: Layers,
    /// Heights of each column's layers, metres, level-fastest.
    heights: Vec<f64>,
    pub(super) fields: Vec<(&'static str, Vec<f64>)>,
    /// The fields rounded to single precision, where the model has that.
    single: Option<Vec<Vec<f32>>>,
    /// Mesh and fields in words.
    pub recipe: String,
}

impl RandomScene {
    /// Draws the scene of a seed, which is always the same.
    ///
    /// # Errors
    /// As [`Scene::parse`] and [`Layers::from_heights`], where an invalid scene is drawn.
    pub fn new(seed: u64) -> Result<Self> {
        let mut random = Random::new(seed);
        let random = &mut random;
        let (mesh, mut recipe) = mesh(random)?;
        let grid = mesh.grid();
        let layers = 2 + random.below(6);
        let top = 10f64.powf(uniform(random, -4.0, -0.5));
        let mut up: Vec<f64> = (0..layers).map(|l| (l as f64 + uniform(random, 0.0, 0.7)) / layers as f64).collect();
        (up[0], up[layers - 1]) = (0.0, 1.0);
        let steep = uniform(random, 0.0, 0.6);
        let columns = (0..grid.cells()).flat_map(|cell| {
            let mountain = steep * (3.0 * grid.direction(cell as u32).x + 1.0).sin().abs();
            up.iter().map(move |up| top * (mountain * (1.0 - up) + up)).collect::<Vec<f64>>()
        });
        let heights: Vec<f64> = columns.collect();
        let is_single = random.below(2) == 0;
        let log = random.below(KINDS.len()) == 1;
        let kind = if log { KINDS[1] } else { KINDS[[0, 2, 3, 4, 5, 6, 7, 8][random.below(8)]] };
        let mut fields = Vec::new();
        for name in ["f", "g"] {
            let (style, values) = values(random, &grid, layers, is_single, log);
            let _ = write!(recipe, "; {name} {style}, {}", if is_single { "f32" } else { "f64" });
            fields.push((name, values));
        }
        let radii: Vec<f64> = up.iter().map(|up| top * up).collect();
        let mut writer = Writer { random, fields: &fields, top, layers, text: String::new() };
        writer.scene(kind, &grid);
        let text = writer.text;
        let mut scene =
            Scene::parse(&text).map_err(|e| Error::new(ErrorKind::Scene, format!("seed {seed}: {e}\n{text}")))?;
        scene.name_first_field("f");
        let rounded = |(_, values): &(&str, Vec<f64>)| values.iter().map(|value| *value as f32).collect();
        let single = is_single.then(|| fields.iter().map(rounded).collect());
        drop(grid);
        let layers = Layers::from_heights(&radii, 1.0)?;
        Ok(RandomScene { seed, kind, text, scene, mesh, layers, heights, fields, single, recipe })
    }

    pub(super) fn grid(&self) -> Grid<'_> {
        self.mesh.grid()
    }

    /// The data of the oracle.
    pub(super) fn data<'d>(&'d self, grid: &'d Grid<'d>) -> Data<'d> {
        Data { grid, layers: &self.layers, heights: &self.heights, fields: &self.fields }
    }

    /// The fields in the model's precision.
    pub(super) fn model_fields(&self) -> Result<Fields<'_>> {
        let shape = Shape::level_fastest(self.heights.len() / self.layers.count(), self.layers.count());
        let field = |k: usize| match &self.single {
            Some(single) => Field::new(single[k].as_slice().into(), shape, Location::Center, None),
            None => Field::new(self.fields[k].1.as_slice().into(), shape, Location::Center, None),
        };
        let heights = Field::new(self.heights.as_slice().into(), shape, Location::Center, None)?;
        Ok(Fields::new([("f", field(0)?), ("g", field(1)?)]).with_heights(heights))
    }
}

fn uniform(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

fn chance(random: &mut Random, of: f64) -> bool {
    random.unit() < of
}

/// An icosahedral mesh with jittered cells, turned at random, in one of four cases with holes; and its recipe.
fn mesh(random: &mut Random) -> Result<(Culled, String)> {
    let level = [1, 2, 2, 3][random.below(4)];
    let jitter = uniform(random, 0.0, 0.2) * 1.1 / f64::from(1 << level);
    let mut mesh = IcosahedralMesh::new(level)?;
    let turn = DQuat::from_axis_angle(DVec3::from_array(random.direction()), uniform(random, 0.0, 6.0));
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

/// A field and its style.
fn values(random: &mut Random, grid: &Grid, layers: usize, single: bool, decades: bool) -> (&'static str, Vec<f64>) {
    let styles = ["constant but for rounding", "smooth", "noise", "spikes", "decades"];
    let style = if decades { 4 } else { [0, 1, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4][random.below(12)] };
    let scale = 10f64.powf(uniform(random, -6.0, 4.0));
    let offset = scale * [0.0, 0.0, 1.0, 300.0][random.below(4)];
    let [a, b] = [0; 2].map(|_| uniform(random, 1.0, 6.0) * DVec3::from_array(random.direction()));
    let turn = uniform(random, -3.0, 3.0);
    let missing = if random.below(5) == 0 { uniform(random, 0.0, 0.1) } else { 0.0 };
    let mut values = Vec::new();
    for cell in 0..grid.cells() {
        let d = grid.direction(cell as u32);
        let column_missing = chance(random, 0.5 * missing);
        for layer in 0..layers {
            let up = layer as f64 / layers as f64;
            let wave = (a.dot(d) + turn * up).sin() * (b.dot(d) - turn * up).cos() + 0.3 * up;
            let noise = uniform(random, -1.0, 1.0);
            let value = match style {
                0 => offset.max(scale) * (1.0 + (3.0 * noise).round() * if single { 1.2e-7 } else { 2.3e-16 }),
                1 => offset + scale * wave,
                2 => offset + scale * noise,
                3 if chance(random, 0.05) => scale * 10f64.powf(uniform(random, 0.0, 6.0)),
                3 => scale * 0.01 * wave,
                _ => scale * 10f64.powf(-3.0 + 3.0 * wave),
            };
            let value = if single { f64::from(value as f32) } else { value };
            let is_missing = column_missing || chance(random, 0.2 * missing);
            values.push(if is_missing { f64::NAN } else { value });
        }
    }
    (styles[style], values)
}

/// Writes a scene.
struct Writer<'w> {
    random: &'w mut Random,
    fields: &'w [(&'static str, Vec<f64>)],
    /// Height of the highest layer.
    top: f64,
    layers: usize,
    text: String,
}

impl Writer<'_> {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        uniform(self.random, low, high)
    }

    fn chance(&mut self, of: f64) -> bool {
        chance(self.random, of)
    }

    fn color(&mut self) -> String {
        let [r, g, b] = [0; 3].map(|_| self.random.below(256));
        format!("\"rgb({r} {g} {b})\"")
    }

    fn field(&mut self) -> usize {
        self.random.below(2)
    }

    /// A value about the field's, from the sorted ones, or near the one that it is everywhere.
    fn value(&mut self, field: usize) -> f64 {
        let mut sorted: Vec<f64> = self.fields[field].1.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
        if high - low <= 1e-5 * high.abs() {
            return self.uniform(0.5, 1.5) * low;
        }
        let i = self.random.below(sorted.len() - 1);
        self.uniform(sorted[i], sorted[i + 1])
    }

    fn two_values(&mut self, field: usize) -> [f64; 2] {
        let [a, b] = [0; 2].map(|_| self.value(field));
        let [low, high] = [a.min(b), a.max(b)];
        if low < high { [low, high] } else { [low, low + low.abs().max(1e-3)] }
    }

    /// An extinction per planet radius: optical depths of the shell from 1e-3 to 1e6, most of them seen through.
    fn extinction(&mut self, shell: f64) -> f64 {
        let depth = if self.chance(0.1) { self.uniform(2.0, 6.0) } else { self.uniform(-3.0, 1.5) };
        if self.chance(0.35) { 0.0 } else { (10f64.powf(depth) / shell).min(1e12) }
    }

    /// Knots of a transfer function as an inline table.
    fn knots(&mut self, field: usize, shell: f64) -> String {
        let count = [1, 2, 3, 5, 12, 40][self.random.below(6)];
        let mut values: Vec<f64> = (0..count).map(|_| self.value(field)).collect();
        values.sort_by(f64::total_cmp);
        for i in 1..count {
            if self.chance(0.15) && (i < 2 || values[i - 2] < values[i - 1]) {
                values[i] = values[i - 1];
            }
        }
        values.sort_by(f64::total_cmp);
        let knot = |value: f64| {
            let (color, extinction) = (self.color(), self.extinction(shell));
            format!("{{ value = {value:e}, color = {color}, extinction = {extinction:e} }}")
        };
        let knots: Vec<String> = values.into_iter().map(knot).collect();
        format!("{{ unit_length = 1, knots = [{}] }}", knots.join(", "))
    }

    /// A colour map over a range, of colours alone.
    fn colors(&mut self, field: usize) -> String {
        let [low, high] = self.two_values(field);
        format!("{{ map = \"viridis\", range = [{low:e}, {high:e}] }}")
    }

    fn log(&mut self, field: usize, shell: f64) -> String {
        let [low, high] = self.two_values(field);
        let (low, high) = (low.max(1e-280), high.max(1e-279));
        let scale = match self.random.below(2) {
            0 => format!("scale = \"log\", range = [{low:e}, {high:e}]"),
            _ => format!("scale = \"symlog\", threshold = {:e}, range = [{:e}, {high:e}]", low, -high),
        };
        let length = shell * 10f64.powf(self.uniform(-1.0, 1.0));
        let opacity = ["[[0, 0], [1, 0.9]]", "[[0, 0.8], [0.3, 0], [0.6, 0], [1, 0.99]]"][self.random.below(2)];
        format!(
            "{{ map = \"plasma\", {scale}, opacity = {opacity}, opacity_in = \"range\", unit_length = {length:e} }}"
        )
    }

    fn scene(&mut self, kind: &str, grid: &Grid) {
        let exaggeration = [1.0, (0.3 / self.top).min(30.0)][self.random.below(2)];
        let shell = exaggeration * self.top;
        let tolerance = 10f64.powf(self.uniform(-7.0, -2.0));
        let precision = ["f32", "f64"][self.random.below(2)];
        let [core, background] = [0; 2].map(|_| {
            let color = self.color();
            if self.chance(0.4) { "\"transparent\"".to_owned() } else { color }
        });
        let _ = write!(
            self.text,
            "antialias = false\nbackend = \"cpu\"\nbackground = {background}\ncore = {core}\ntolerance = {tolerance:.2e}\n\
             precision = \"{precision}\"\nexaggeration = {exaggeration:e}\nimage = {{ width = {}, height = {} }}\n",
            SIZE[0], SIZE[1]
        );
        let mixed = kind == "mixed";
        if kind == "native heights" || mixed && self.chance(0.4) {
            self.text += "heights = \"native\"\n";
        }
        self.camera(grid, shell);
        self.light();
        let has_volume = !["isosurfaces", "surfaces"].contains(&kind) || self.chance(0.7);
        let count = if kind == "several volumes" || mixed { 2 + self.random.below(2) } else { usize::from(has_volume) };
        for _ in 0..count {
            self.volume(kind, shell);
        }
        let native = kind == "native heights";
        if kind == "isosurfaces" || mixed || native && self.chance(0.3) {
            self.isosurfaces();
        }
        if kind == "surfaces" || mixed && self.chance(0.6) || native && self.chance(0.3) {
            self.surface();
        }
        if kind == "cuts" || mixed && self.chance(0.5) {
            self.clip();
        }
    }

    fn camera(&mut self, grid: &Grid, shell: f64) {
        let direction = |random: &mut Random| DVec3::from_array(random.direction());
        let d = direction(self.random);
        let vertex = grid.direction(self.random.below(grid.cells()) as u32);
        let aside = d.cross(direction(self.random)).normalize();
        let inside = 1.0 + shell * self.uniform(0.0, 1.0);
        let (eye, target) = match self.random.below(6) {
            0 | 1 => (d * self.uniform(1.6, 4.0), DVec3::ZERO),
            2 => (d * inside, aside * self.uniform(0.3, 1.3)),
            3 => (d * self.uniform(1.5, 3.0), aside * inside),
            4 => (vertex * self.uniform(1.5, 3.0), DVec3::ZERO),
            _ => (d * self.uniform(1.4, 2.0), vertex * inside),
        };
        let (up, fov) = (direction(self.random), self.uniform(5.0, 100.0));
        let list = |v: DVec3| format!("[{:e}, {:e}, {:e}]", v.x, v.y, v.z);
        let [eye, target, up] = [eye, target, up].map(list);
        let _ = writeln!(self.text, "camera = {{ eye = {eye}, target = {target}, up = {up}, fov = {fov:e} }}");
    }

    fn light(&mut self) {
        let [ambient, diffuse, specular] = [0; 3].map(|_| self.uniform(0.0, 1.0));
        let kind = match self.random.below(4) {
            0 => "kind = \"headlight\"".to_owned(),
            1 => format!("kind = \"sun\", lon = {:e}, lat = {:e}", self.uniform(0.0, 360.0), self.uniform(-90.0, 90.0)),
            _ => return,
        };
        let shininess = 10f64.powf(self.uniform(0.0, 2.0));
        let _ = writeln!(
            self.text,
            "light = {{ {kind}, ambient = {ambient:e}, diffuse = {diffuse:e}, specular = {specular:e}, shininess = {shininess:e} }}"
        );
    }

    fn volume(&mut self, kind: &str, shell: f64) {
        let field = self.field();
        let transfer = if kind == "log scale" { self.log(field, shell) } else { self.knots(field, shell) };
        let by_other = kind == "by another field" || kind == "mixed" && self.chance(0.3);
        let colors = self.colors(field);
        let transfer = if by_other { colors } else { transfer };
        let _ = write!(self.text, "[[volumes]]\nfield = \"{}\"\ntransfer = {transfer}\n", self.fields[field].0);
        if by_other {
            let other = self.field();
            let mut values: Vec<f64> = (0..4).map(|_| self.value(other)).collect();
            values.sort_by(f64::total_cmp);
            let pairs = values.iter().map(|value| (*value, [0.0, 0.3, 0.95][self.random.below(3)]));
            let pairs: Vec<String> = pairs.map(|(value, opacity)| format!("[{value:e}, {opacity}]")).collect();
            let _ = writeln!(
                self.text,
                "opacity = {{ field = \"{}\", values = [{}], unit_length = {shell:e} }}",
                self.fields[other].0,
                pairs.join(", ")
            );
        }
    }

    fn paint(&mut self, key: &str) -> String {
        let field = self.field();
        let map = format!("{key} = \"{}\"\ntransfer = {}", self.fields[field].0, self.colors(field));
        let color = self.color();
        if self.chance(0.5) { format!("color = {color}") } else { map }
    }

    fn opacity(&mut self) -> f64 {
        if self.chance(0.3) { 1.0 } else { self.uniform(0.05, 0.95) }
    }

    fn isosurfaces(&mut self) {
        for _ in 0..1 + self.random.below(3) {
            let field = self.field();
            let (value, paint, opacity) = (self.value(field), self.paint("color_by"), self.opacity());
            let _ = write!(
                self.text,
                "[[isosurfaces]]\nfield = \"{}\"\nvalue = {value:e}\nopacity = {opacity:e}\n{paint}\n",
                self.fields[field].0
            );
        }
    }

    fn surface(&mut self) {
        let place = match self.random.below(3) {
            0 => format!("height_m = {:e}", self.uniform(0.05, 0.95) * self.top),
            _ => format!("layer = {}", self.random.below(self.layers)),
        };
        let (paint, opacity) = (self.paint("field"), self.opacity());
        let _ = write!(self.text, "[[surfaces]]\n{place}\nopacity = {opacity:e}\n{paint}\n");
    }

    fn clip(&mut self) {
        for _ in 0..1 + self.random.below(2) {
            let cut = ["inside", "outside"][usize::from(self.chance(0.3))];
            let [lon, lat] = [self.uniform(-180.0, 180.0), self.uniform(-90.0, 60.0)];
            let [east, north] = [lon + self.uniform(20.0, 170.0), lat + self.uniform(5.0, 90.0)];
            let bottom = self.random.below(self.layers);
            let layers = [bottom, bottom + self.random.below(self.layers - bottom)];
            let height = self.uniform(0.0, 0.5) * self.top;
            let heights = [height, height + self.uniform(0.1, 0.5) * self.top];
            let distance = self.uniform(-0.5, 1.0);
            let what = match self.random.below(4) {
                0 => format!("lon = [{lon:e}, {east:e}]\nlat = [{lat:e}, {:e}]", north.min(90.0)),
                1 => format!("layers = {layers:?}\nlat = [{lat:e}, {:e}]", north.min(90.0)),
                2 => format!("height_m = [{:e}, {:e}]", heights[0], heights[1]),
                _ => format!("half_space = {{ towards = [{lon:e}, {lat:e}], distance = {distance:e} }}"),
            };
            let _ = write!(self.text, "[[clip]]\ncut = \"{cut}\"\n{what}\n");
        }
    }
}
