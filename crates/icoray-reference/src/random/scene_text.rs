//! The text of random scenes.

use crate::oracle::NamedField;
use glam::DVec3;
use icoray::Grid;
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

/// The text of a scene that is written.
pub(super) struct SceneText<'w> {
    pub random: &'w mut Random,
    pub fields: &'w [NamedField<'static>],
    /// The finite values of each field.
    pub sorted: Vec<Vec<f64>>,
    /// Height of the highest layer.
    pub top: f64,
    pub layers: usize,
    pub text: String,
}

impl SceneText<'_> {
    fn color(&mut self) -> String {
        let [r, g, b] = [0; 3].map(|_| self.random.below(256));
        format!("\"rgb({r} {g} {b})\"")
    }

    fn field(&mut self) -> usize {
        self.random.below(2)
    }

    /// A value about the field's, from the sorted ones, or near the one that it is everywhere.
    fn value(&mut self, field: usize) -> f64 {
        let sorted = &self.sorted[field];
        let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
        if high - low <= 1e-5 * high.abs() {
            return self.random.between(0.5, 1.5) * low;
        }
        let i = self.random.below(sorted.len() - 1);
        self.random.between(sorted[i], sorted[i + 1])
    }

    fn two_values(&mut self, field: usize) -> [f64; 2] {
        let [a, b] = [0; 2].map(|_| self.value(field));
        let [low, high] = [a.min(b), a.max(b)];
        if low < high { [low, high] } else { [low, low + low.abs().max(1e-3)] }
    }

    /// An extinction per planet radius: optical depths of the shell from 1e-3 to 1e6, usually transparent ones.
    fn extinction(&mut self, shell: f64) -> f64 {
        let depth =
            if self.random.chance(0.1) { self.random.between(2.0, 6.0) } else { self.random.between(-3.0, 1.5) };
        if self.random.chance(0.35) { 0.0 } else { (10f64.powf(depth) / shell).min(1e12) }
    }

    /// Knots of a transfer function as an inline table.
    fn knots(&mut self, field: usize, shell: f64) -> String {
        let count = [1, 2, 3, 5, 12, 40][self.random.below(6)];
        let mut values: Vec<f64> = (0..count).map(|_| self.value(field)).collect();
        values.sort_by(f64::total_cmp);
        for i in 1..count {
            if self.random.chance(0.15) && (i < 2 || values[i - 2] < values[i - 1]) {
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
        let length = shell * 10f64.powf(self.random.between(-1.0, 1.0));
        let opacity = ["[[0, 0], [1, 0.9]]", "[[0, 0.8], [0.3, 0], [0.6, 0], [1, 0.99]]"][self.random.below(2)];
        format!(
            "{{ map = \"plasma\", {scale}, opacity = {opacity}, opacity_in = \"range\", unit_length = {length:e} }}"
        )
    }

    /// Writes a scene of this kind.
    pub fn scene(&mut self, kind: &str, grid: &Grid) {
        let exaggeration = [1.0, (0.3 / self.top).min(30.0)][self.random.below(2)];
        let shell = exaggeration * self.top;
        let tolerance = 10f64.powf(self.random.between(-7.0, -2.0));
        let precision = ["f32", "f64"][self.random.below(2)];
        let [core, background] = [0; 2].map(|_| {
            let color = self.color();
            if self.random.chance(0.4) { "\"transparent\"".to_owned() } else { color }
        });
        let _ = write!(
            self.text,
            "antialias = false\nbackend = \"cpu\"\nbackground = {background}\ncore = {core}\ntolerance = {tolerance:.2e}\n\
             precision = \"{precision}\"\nexaggeration = {exaggeration:e}\nimage = {{ width = {}, height = {} }}\n",
            SIZE[0], SIZE[1]
        );
        let mixed = kind == "mixed";
        if kind == "native heights" || mixed && self.random.chance(0.4) {
            self.text += "heights = \"native\"\n";
        }
        self.camera(grid, shell);
        self.light();
        let has_volume = !["isosurfaces", "surfaces"].contains(&kind) || self.random.chance(0.7);
        let count = if kind == "several volumes" || mixed { 2 + self.random.below(2) } else { usize::from(has_volume) };
        for _ in 0..count {
            self.volume(kind, shell);
        }
        let native = kind == "native heights";
        if kind == "isosurfaces" || mixed || native && self.random.chance(0.3) {
            self.isosurfaces();
        }
        if kind == "surfaces" || mixed && self.random.chance(0.6) || native && self.random.chance(0.3) {
            self.surface();
        }
        if kind == "cuts" || mixed && self.random.chance(0.5) {
            self.clip();
        }
    }

    fn camera(&mut self, grid: &Grid, shell: f64) {
        let direction = |random: &mut Random| DVec3::from_array(random.direction());
        let d = direction(self.random);
        let vertex = grid.direction(self.random.below(grid.cells()) as u32);
        let aside = d.cross(direction(self.random)).normalize();
        let inside = 1.0 + shell * self.random.between(0.0, 1.0);
        let (eye, target) = match self.random.below(6) {
            0 | 1 => (d * self.random.between(1.6, 4.0), DVec3::ZERO),
            2 => (d * inside, aside * self.random.between(0.3, 1.3)),
            3 => (d * self.random.between(1.5, 3.0), aside * inside),
            4 => (vertex * self.random.between(1.5, 3.0), DVec3::ZERO),
            _ => (d * self.random.between(1.4, 2.0), vertex * inside),
        };
        let (up, fov) = (direction(self.random), self.random.between(5.0, 100.0));
        let list = |v: DVec3| format!("[{:e}, {:e}, {:e}]", v.x, v.y, v.z);
        let [eye, target, up] = [eye, target, up].map(list);
        let _ = writeln!(self.text, "camera = {{ eye = {eye}, target = {target}, up = {up}, fov = {fov:e} }}");
    }

    fn light(&mut self) {
        let [ambient, diffuse, specular] = [0; 3].map(|_| self.random.between(0.0, 1.0));
        let kind = match self.random.below(4) {
            0 => "kind = \"headlight\"".to_owned(),
            1 => format!(
                "kind = \"sun\", lon = {:e}, lat = {:e}",
                self.random.between(0.0, 360.0),
                self.random.between(-90.0, 90.0)
            ),
            _ => return,
        };
        let shininess = 10f64.powf(self.random.between(0.0, 2.0));
        let _ = writeln!(
            self.text,
            "light = {{ {kind}, ambient = {ambient:e}, diffuse = {diffuse:e}, specular = {specular:e}, shininess = {shininess:e} }}"
        );
    }

    fn volume(&mut self, kind: &str, shell: f64) {
        let field = self.field();
        let transfer = if kind == "log scale" { self.log(field, shell) } else { self.knots(field, shell) };
        let by_other = kind == "by another field" || kind == "mixed" && self.random.chance(0.3);
        let colors = self.colors(field);
        let transfer = if by_other { colors } else { transfer };
        let _ = write!(self.text, "[[volumes]]\nfield = \"{}\"\ntransfer = {transfer}\n", self.fields[field].name);
        if by_other {
            let other = self.field();
            let mut values: Vec<f64> = (0..4).map(|_| self.value(other)).collect();
            values.sort_by(f64::total_cmp);
            let pairs = values.iter().map(|value| (*value, [0.0, 0.3, 0.95][self.random.below(3)]));
            let pairs: Vec<String> = pairs.map(|(value, opacity)| format!("[{value:e}, {opacity}]")).collect();
            let _ = writeln!(
                self.text,
                "opacity = {{ field = \"{}\", values = [{}], unit_length = {shell:e} }}",
                self.fields[other].name,
                pairs.join(", ")
            );
        }
    }

    fn paint(&mut self, key: &str) -> String {
        let field = self.field();
        let map = format!("{key} = \"{}\"\ntransfer = {}", self.fields[field].name, self.colors(field));
        let color = self.color();
        if self.random.chance(0.5) { format!("color = {color}") } else { map }
    }

    fn opacity(&mut self) -> f64 {
        if self.random.chance(0.3) { 1.0 } else { self.random.between(0.05, 0.95) }
    }

    fn isosurfaces(&mut self) {
        for _ in 0..1 + self.random.below(3) {
            let field = self.field();
            let (value, paint, opacity) = (self.value(field), self.paint("color_by"), self.opacity());
            let _ = write!(
                self.text,
                "[[isosurfaces]]\nfield = \"{}\"\nvalue = {value:e}\nopacity = {opacity:e}\n{paint}\n",
                self.fields[field].name
            );
        }
    }

    fn surface(&mut self) {
        let place = match self.random.below(3) {
            0 => format!("height_m = {:e}", self.random.between(0.05, 0.95) * self.top),
            _ => format!("layer = {}", self.random.below(self.layers)),
        };
        let (paint, opacity) = (self.paint("field"), self.opacity());
        let _ = write!(self.text, "[[surfaces]]\n{place}\nopacity = {opacity:e}\n{paint}\n");
    }

    fn clip(&mut self) {
        for _ in 0..1 + self.random.below(2) {
            let cut = ["inside", "outside"][usize::from(self.random.chance(0.3))];
            let [lon, lat] = [self.random.between(-180.0, 180.0), self.random.between(-90.0, 60.0)];
            let [east, north] = [lon + self.random.between(20.0, 170.0), lat + self.random.between(5.0, 90.0)];
            let bottom = self.random.below(self.layers);
            let layers = [bottom, bottom + self.random.below(self.layers - bottom)];
            let height = self.random.between(0.0, 0.5) * self.top;
            let heights = [height, height + self.random.between(0.1, 0.5) * self.top];
            let distance = self.random.between(-0.5, 1.0);
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
