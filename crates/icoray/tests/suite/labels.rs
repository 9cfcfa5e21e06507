//! Labels and colour ranges from the scene to the files.

use crate::common::{at_centers, icosahedral};
use icoray::output::{Existing, NameTemplate, Output, Stamp, write_frame, write_picture_with};
use icoray::{Description, Frame, Grid, Layers, Renderer, Scene};
use std::path::Path;

const LAYERS: usize = 5;
const SIZE: u32 = 200;

fn scene(transfer: &str, rest: &str) -> Scene {
    let text = format!(
        "field = \"f\"\nexaggeration = 60\nbackground = \"#102030\"\n[image]\nwidth = {SIZE}\nheight = {SIZE}\n\
         [camera]\nlon = 20\nlat = 40\ndistance = 4\n[transfer]\n{transfer}\n{rest}\n"
    );
    Scene::parse(&text).unwrap_or_else(|e| panic!("{e}"))
}

const FIXED: &str = "map = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.2], [0, 0], [1, 0.8]]";

/// A sphere whose values go from -`most` to `most`.
struct Sphere {
    grid: Grid<'static>,
    layers: Layers,
    renderer: Renderer,
}

impl Sphere {
    fn new() -> Self {
        let heights: Vec<f64> = (0..LAYERS).map(|k| 4000.0 * k as f64).collect();
        Sphere {
            grid: icosahedral(4).1,
            layers: Layers::from_heights(&heights, 6.371e6).unwrap(),
            renderer: Renderer::new(2).unwrap(),
        }
    }

    fn frame(&self, scene: &Scene, most: f32) -> Frame {
        let count = self.grid.cells() * LAYERS;
        let values: Vec<f32> =
            (0..count).map(|i| most * (2.0 * (i * 7919 % count) as f32 / (count - 1) as f32 - 1.0)).collect();
        let field = at_centers(&values, LAYERS);
        let mut frame = self.renderer.render(scene, &self.grid, &self.layers, &field).unwrap();
        let description = Description { long_name: Some("a field".into()), units: Some("m s-1".into()) };
        frame.descriptions.insert(scene.field().to_owned(), description);
        frame.stamp = Stamp { step: 3, time_s: 60.0, date: None };
        frame
    }
}

fn written(frame: &Frame, path: &Path) -> image::DynamicImage {
    write_picture_with(path, frame, Existing::NeverModify).unwrap();
    image::open(path).unwrap()
}

/// IEC 61966-2-1, of premultiplied light.
fn encoded(pixel: [f32; 4]) -> [u8; 4] {
    let curve = |v: f64| if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    let [r, g, b, a] = pixel.map(f64::from);
    let byte = |v: f64| (curve((v / a).clamp(0.0, 1.0)) * 255.0).round() as u8;
    [byte(r), byte(g), byte(b), (a * 255.0).round() as u8]
}

#[test]
fn without_labels_pictures_are_the_pixels_and_nothing_else() {
    let (folder, sphere) = (tempfile::tempdir().unwrap(), Sphere::new());
    let [plain, off] = ["", "[labels]\non = false"].map(|rest| sphere.frame(&scene(FIXED, rest), 1.0));
    assert!(plain.legend.is_none() && plain == Frame { report: plain.report.clone(), ..off.clone() });
    let picture = written(&plain, &folder.path().join("plain.png")).into_rgba8();
    assert_eq!(picture.dimensions(), (SIZE, SIZE));
    for (found, pixel) in picture.pixels().zip(&plain.pixels) {
        let expected = encoded(*pixel);
        assert!((0..4).all(|k| found.0[k].abs_diff(expected[k]) <= 1), "{found:?}, {expected:?}");
    }
    assert_eq!(picture, written(&off, &folder.path().join("off.png")).into_rgba8());
}

#[test]
fn labels_are_in_the_png_alone() {
    let (folder, sphere) = (tempfile::tempdir().unwrap(), Sphere::new());
    let frames = ["", "[labels]", "[labels]\nplace = \"below\""].map(|rest| sphere.frame(&scene(FIXED, rest), 1.0));
    let [plain, labelled, below] = &frames;
    assert!(frames.iter().all(|frame| frame.pixels == plain.pixels && frame.error == plain.error));
    let read = |frame: &Frame, name: &str| written(frame, &folder.path().join(name));
    let exr = [read(plain, "a.exr"), read(labelled, "b.exr"), read(below, "c.exr")].map(|i| i.into_rgba32f());
    assert!(exr[0] == exr[1] && exr[0] == exr[2]);
    let [plain, labelled, below] =
        [read(plain, "a.png"), read(labelled, "b.png"), read(below, "c.png")].map(|i| i.into_rgba8());
    let changed = plain.pixels().zip(labelled.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 500 && changed < (SIZE * SIZE / 3) as usize, "{changed}");
    assert!(below.height() > SIZE && below.width() == SIZE);
    assert_eq!(below.as_raw()[..plain.as_raw().len()], plain.as_raw()[..]);
}

#[test]
fn ranges_that_follow_the_data_are_drawn_and_reported() {
    let (folder, sphere) = (tempfile::tempdir().unwrap(), Sphere::new());
    let follows = "map = \"vik\"\ncenter = 0\nrange = { union = [0, 100], hysteresis = 0.5 }\n\
                   opacity = [[0, 0.8], [0.5, 0], [1, 0.8]]";
    let union = scene(follows, "");
    let output = Output::from(NameTemplate::new("{step}.png").unwrap());
    for (step, most, expected) in [(0, 2.0, 2.0), (1, 3.0, 2.0), (2, 1.0, 2.0), (3, 10.0, 12.0)] {
        let mut frame = sphere.frame(&union, most);
        assert_eq!(frame.report.colors[0].range, [-expected, expected], "step {step}");
        // The picture is that of a scene with this range.
        let fixed = follows.replace("{ union = [0, 100], hysteresis = 0.5 }", &format!("[-{expected}, {expected}]"));
        let like = sphere.frame(&scene(&fixed, "opacity_in = \"range\""), most);
        assert_eq!(frame.pixels, like.pixels, "step {step}");
        let stamp = Stamp { step, ..Stamp::default() };
        let path = write_frame(folder.path(), &output, &stamp, &mut frame, Existing::Overwrite).unwrap();
        let bytes = std::fs::read(path).unwrap();
        let says = |words: &str| bytes.windows(words.len()).any(|at| at == words.as_bytes());
        for words in ["centred on 0, percentiles 0 to 100 of all frames", "m s-1", "a field"] {
            assert!(says(words), "{words}");
        }
        assert!(says(&format!("-{expected} to {expected}")));
    }
    let report = std::fs::read_to_string(folder.path().join("report.csv")).unwrap();
    assert_eq!(report.matches(",-2,2,\"f: vik, linear, centred on 0, percentiles").count(), 3, "{report}");
    assert_eq!(report.matches(",-12,12,\"f: vik,").count(), 1);
}
