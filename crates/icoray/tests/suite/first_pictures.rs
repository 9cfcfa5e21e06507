//! Measurements of first pictures of all kinds of fields: the share of the field and of the ground behind it, hues
//! against the colour bar, and contrast with dark ground.

use crate::common::over_columns;
use crate::culled::{Culled, Mark, Style, directions, is_near};
use glam::DVec3;
use icoray::{Coloring, Field, Frame, Grid, IcosahedralMesh, Layers, Level, Location, Renderer, Scene, suggest};
use icoray_test_support::Random;
use std::f64::consts::TAU;

const HEIGHT_M: [f64; 8] = [0.0, 1e3, 2e3, 4e3, 6e3, 9e3, 13e3, 20e3];
const LAYERS: usize = HEIGHT_M.len();
const EARTH_M: f64 = 6.371e6;
const SIZE: (u32, u32) = (100, 80);
/// The middle of the region, degrees, and its size, of the globe's.
const MIDDLE: [f64; 2] = [10.0, 50.0];
const SCALE: f64 = 0.07;

/// What a field is at a place: longitude and latitude, radians, height, 0 to 1, and a number of its own.
#[derive(Clone, Copy)]
struct Place {
    lon: f64,
    lat: f64,
    height: f64,
    number: usize,
}

impl Place {
    /// A bump about 0.5 E 0.4 N.
    fn bump(&self, width: f64) -> f64 {
        (-((self.lon - 0.5).powi(2) + (self.lat - 0.4).powi(2)) / width.powi(2)).exp()
    }

    fn noise(&self) -> f64 {
        Random::at(self.number).unit()
    }

    fn normal(&self) -> f64 {
        let mut random = Random::at(self.number);
        (-2.0 * random.unit().max(1e-9).ln()).sqrt() * (TAU * random.unit()).cos()
    }
}

/// Name, values, and whether they are on a surface.
type Case = (&'static str, fn(&Place) -> f64, bool);

const CASES: [Case; 20] = [
    ("constant", |_| 7.0, false),
    ("two values", |p| f64::from(p.lon > 0.2), false),
    ("one cell", |p| f64::from(p.bump(0.05) > 0.3 && (0.1..0.3).contains(&p.height)), false),
    ("sparse 1e-6", |p| if p.bump(0.2) > 0.5 && p.height < 0.3 { 1e-6 } else { 0.0 }, false),
    ("sparse 0.5", |p| (p.bump(1.5) - 0.4).max(0.0), false),
    ("a few spots", |p| if p.noise() > 0.995 { p.noise() } else { 0.0 }, false),
    (
        "8 decades",
        |p| 10f64.powf(-4.0 + 4.0 * p.bump(0.9) * (1.0 - p.height) + 0.9 * p.normal().clamp(-4.0, 4.0)),
        false,
    ),
    (
        "theta",
        |p| 300.0 - 40.0 * p.lat.sin().powi(2) + 80.0 * p.height + 4.0 * (3.0 * p.lon).sin() * p.lat.cos(),
        false,
    ),
    ("layers alone", |p| 300.0 + 80.0 * p.height, false),
    ("layers and a bubble", |p| 300.0 + 80.0 * p.height + 2.0 * p.bump(0.4) * (1.0 - p.height), false),
    ("skewed signs", |p| 5.0 * p.bump(0.7) - 1.5 * (2.0 * p.lon + 1.0).sin().max(0.0) * p.lat.cos(), false),
    ("wave", |p| 1e-5 * (6.0 * p.lon).sin() * (-3.0 * (p.lat - 0.7).powi(2)).exp(), false),
    ("jet", |p| 35.0 * (-((p.lat - 0.7) / 0.3).powi(2)).exp() * (p.height * 3.0).sin(), false),
    ("noise", |p| p.noise() - 0.5, false),
    ("half is missing", |p| if p.lon < 0.3 { f64::NAN } else { (2.0 * p.lon).sin() * p.lat.cos() }, false),
    ("humidity", |p| 0.02 * (p.bump(1.2) + 0.1) * (-6.0 * p.height).exp(), false),
    ("winds on a surface", |p| 10.0 * (3.0 * p.lon).sin() * p.lat.cos() + 1.0, true),
    ("rain on a surface", |p| 10f64.powf(-6.0 + 4.0 * p.bump(1.0) + 0.4 * p.normal()), true),
    ("mask on a surface", |p| f64::from(p.bump(1.0) > 0.5), true),
    ("integers", |p| (20.0 * p.bump(1.5)).floor(), false),
];

/// A scene with its grid's colours taken away from the ground, and what is seen of it.
struct Picture {
    text: String,
    scene: Scene,
    /// Linear light of the field alone, and the part that is seen of a white planet, of each pixel on the planet.
    light: Vec<([f64; 3], f64)>,
}

fn picture(grid: &Grid, values: &[f64], is_surface: bool, renderer: &Renderer) -> Picture {
    let field = Field::level_fastest(values, LAYERS, Location::Center).unwrap();
    let layers = Layers::from_heights(&HEIGHT_M, EARTH_M).unwrap();
    let surface = is_surface.then_some(Level::Layer(0));
    let options = suggest::Options { size: Some(SIZE), surface, ..Default::default() };
    let text = suggest::scene("q", grid, &layers, &field, &options).unwrap();
    let scene = Scene::parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let draw = |core: f64| -> Frame {
        let mut scene = Scene { core: Some([core; 3]), background: Some([0.0; 3]), lighting: None, ..scene.clone() };
        scene.scenery.lines.clear();
        scene.scenery.ground = Default::default();
        renderer.render(&scene, grid, &layers, icoray::Fields::new([("q", field)])).unwrap()
    };
    let (black, white) = (draw(0.0), draw(1.0));
    let eye = DVec3::from(scene.camera.eye());
    let direction = |i: u32| DVec3::from(scene.camera.direction(i % SIZE.0, i / SIZE.0, SIZE.0, SIZE.1));
    let is_planet = |i: &u32| (eye - eye.dot(direction(*i)) * direction(*i)).length() < 0.99;
    let pixel = |i: u32| {
        let [black, white] = [&black, &white].map(|frame| frame.pixels[i as usize].map(f64::from));
        ([black[0], black[1], black[2]], white[0] - black[0])
    };
    Picture { light: (0..SIZE.0 * SIZE.1).filter(is_planet).map(pixel).collect(), text, scene }
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Part of a colour that is no grey, and its hue, degrees.
fn hue(color: [f64; 3]) -> (f64, f64) {
    let [r, g, b] = color.map(|c| c.max(0.0).powf(1.0 / 2.2));
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let sixth = match high - low {
        0.0 => 0.0,
        span if high == r => (g - b) / span,
        span if high == g => 2.0 + (b - r) / span,
        span => 4.0 + (r - g) / span,
    };
    (if high > 0.0 { (high - low) / high } else { 0.0 }, (60.0 * sixth).rem_euclid(360.0))
}

/// How far a colour is from those of a bar, degrees; a grey one is as far as the bar's greyest colour has a hue.
fn off_the_bar(color: [f64; 3], bar: &[[f64; 3]]) -> f64 {
    let (part, angle) = hue(color);
    let off = |other: &[f64; 3]| {
        let (other_part, other_angle) = hue(*other);
        let apart = (angle - other_angle).rem_euclid(360.0);
        let grey = if part < 0.2 { 90.0 * (other_part - part - 0.2).max(0.0) } else { f64::INFINITY };
        apart.min(360.0 - apart).min(grey)
    };
    bar.iter().map(off).fold(f64::INFINITY, f64::min)
}

impl Picture {
    /// The rules that do not hold.
    fn faults(&self, values: &[f64]) -> Vec<String> {
        let is_volume = self.scene.scenery.surfaces.is_empty();
        let shown = self.light.iter().filter(|(light, seen)| luminance(*light) > 0.02 && *seen < 0.95);
        let shown: Vec<[f64; 3]> = shown.map(|(light, _)| *light).collect();
        let mut faults = Vec::new();
        let mut expect = |holds: bool, rule: &str| {
            if !holds {
                faults.push(format!("{rule}; {} of {} pixels", shown.len(), self.light.len()));
            }
        };
        expect(shown.len() >= 4, "the field is seen");
        let dense = self.light.iter().filter(|(_, seen)| *seen < 0.1).count();
        expect(!is_volume || dense < 4 * self.light.len() / 5, "the planet is seen too");
        let paintings = self.scene.paintings();
        let painting = paintings[paintings.len() - 1];
        let coloring: &Coloring = painting.coloring.unwrap();
        let [low, high] = coloring.fixed().unwrap();
        let [from, to] = [low, high].map(|end| coloring.scale().forward(end));
        let place = |i: usize| coloring.scale().backward(from + i as f64 / 64.0 * (to - from));
        let bar: Vec<([f64; 3], f64)> = (0..=64).map(|i| painting.transfer.at(place(i))).collect();
        let colors: Vec<[f64; 3]> = bar.iter().map(|(color, _)| *color).collect();
        let off = shown.iter().filter(|color| off_the_bar(**color, &colors) > 15.0).count();
        expect(20 * off <= shown.len(), &format!("{off} pixels have a hue that is not on the bar"));
        // The least and the largest value, where they are dense.
        let densest = bar.iter().map(|(_, extinction)| *extinction).fold(0.0, f64::max);
        let ground = self.scene.scenery.ground;
        let behind = [self.scene.core, self.scene.background, ground.land, ground.ocean].into_iter().flatten();
        let brightest = behind.map(luminance).fold(0.0, f64::max);
        let [least, most] =
            [f64::min, f64::max].map(|end| values.iter().copied().fold(values[0], end).clamp(low, high));
        for (color, extinction) in [least, most].map(|end| painting.transfer.at(end)) {
            let contrast = (luminance(color) + 0.05) / (brightest + 0.05);
            expect(
                is_volume && extinction < 0.5 * densest || contrast > 3.0,
                &format!("an extreme has contrast {contrast}"),
            );
        }
        let anomaly = self.text.contains("[[derive]]");
        let seen: Vec<f64> =
            values.iter().copied().filter(|v| !is_volume || painting.transfer.at(*v).1 > 0.0).collect();
        let inside = seen.iter().filter(|value| (low..=high).contains(value)).count();
        expect(anomaly || 10 * inside >= 8 * seen.len(), "values are on the bar");
        faults
    }

    /// The part of the picture that the planet fills, and that the field does, with its middle in parts of the picture's
    /// width and height from the picture's own middle.
    fn filled(&self) -> (f64, f64, [f64; 2]) {
        let all = f64::from(SIZE.0 * SIZE.1);
        let shown = (0..).zip(&self.light).filter(|(_, (_, seen))| *seen < 0.1).map(|(i, _)| i);
        let places: Vec<[u32; 2]> = shown.map(|i| [i % SIZE.0, i / SIZE.0]).collect();
        let middle =
            [0, 1].map(|k| places.iter().map(|place| f64::from(place[k]) + 0.5).sum::<f64>() / places.len() as f64);
        let off = [middle[0] / f64::from(SIZE.0) - 0.5, middle[1] / f64::from(SIZE.1) - 0.5];
        (self.light.len() as f64 / all, places.len() as f64 / all, off)
    }
}

/// The cells of an icosahedral mesh that stay.
fn mesh(level: u32, stays: impl Fn(DVec3) -> bool) -> Culled {
    let mesh = IcosahedralMesh::new(level).unwrap();
    let stays: Vec<bool> = directions(&mesh.lon_center_rad, &mesh.lat_center_rad).into_iter().map(stays).collect();
    Culled::new(&mesh, &stays, Style::Corners, Mark::BeforeFirst, 1)
}

fn region() -> Culled {
    mesh(6, |p| is_near(p, MIDDLE[0], MIDDLE[1], 170.0 * SCALE))
}

#[test]
fn a_globe_or_a_region_fills_the_picture() {
    let renderer = Renderer::new(2).unwrap();
    let filled = |culled: &Culled| {
        let values: Vec<f64> = (0..culled.cells.len() * LAYERS).map(|i| (i as f64).sin()).collect();
        picture(&culled.grid(), &values, true, &renderer).filled()
    };
    let (planet, ..) = filled(&mesh(3, |_| true));
    // In a picture that is wider than high, and with the exaggerated shell around it.
    assert!(planet > 0.47, "{planet}");
    // The lowest layer of a round one, which is farther than the top of the shell that fills the picture; and of one that
    // is higher than wide.
    let narrow = mesh(6, |p| is_near(p, -60.0, -20.0, 12.0) && is_near(p, -60.0, p.z.asin().to_degrees(), 4.0));
    for (culled, least) in [(region(), 0.35), (narrow, 0.15)] {
        let (_, shown, [x, y]) = filled(&culled);
        assert!(shown > least && x.abs() < 0.1 && y.abs() < 0.1, "{shown} about {x} {y}");
    }
}

#[test]
fn every_field_has_a_picture_whose_colours_are_read_off_the_bar() {
    let renderer = Renderer::new(2).unwrap();
    let mut faults = Vec::new();
    let globe = mesh(4, |_| true);
    let ocean = mesh(4, |p| !is_near(p, -20.0, -10.0, 20.0) && !is_near(p, 90.0, 30.0, 30.0));
    for (mesh, culled, is_region) in [("globe", globe, false), ("ocean", ocean, false), ("region", region(), true)] {
        let grid = culled.grid();
        let [lon, lat, ..] = &culled.lon_lat;
        for (name, value, is_surface) in CASES {
            let place = |cell: usize, layer: usize| {
                let to_globe =
                    |rad: f64, k: usize| if is_region { (rad - MIDDLE[k].to_radians()) / SCALE } else { rad };
                let lon = (lon[cell] + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
                let height = HEIGHT_M[layer] / HEIGHT_M[LAYERS - 1];
                Place { lon: to_globe(lon, 0), lat: to_globe(lat[cell], 1), height, number: cell * LAYERS + layer }
            };
            let values = over_columns(grid.cells(), LAYERS, |cell, layer| value(&place(cell, layer)));
            let drawn = picture(&grid, &values, is_surface, &renderer);
            let shown: Vec<f64> = match is_surface {
                true => values.iter().copied().step_by(LAYERS).collect(),
                false => values.iter().copied().filter(|value| !value.is_nan()).collect(),
            };
            let found = drawn.faults(&shown);
            if !found.is_empty() {
                faults.push(format!("{name}, {mesh}: {found:#?}\n{}", drawn.text));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
