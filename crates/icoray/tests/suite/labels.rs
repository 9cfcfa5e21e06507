//! Labels and colour ranges from the scene to the files.

use crate::common::{Model, even_heights, scene};
use icoray::output::{Existing, NameTemplate, Output, Stamp, write_frame, write_picture_with};
use icoray::{Description, Frame, Renderer, Scene};
use std::path::Path;

const LAYERS: usize = 5;
const SIZE: u32 = 200;

fn shown(transfer: &str, rest: &str) -> Scene {
    let keys = format!("exaggeration = 60\nbackground = \"#102030\"\nimage = {{ width = {SIZE}, height = {SIZE} }}");
    scene("lon = 20\nlat = 40\ndistance = 4", transfer, &format!("{keys}\n{rest}"))
}

const FIXED: &str = "map = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.2], [0, 0], [1, 0.8]]";

/// The frame of a sphere whose values go from -`most` to `most`.
fn frame(renderer: &Renderer, scene: &Scene, most: f64) -> Frame {
    let value = |i: usize, count: usize| most * (2.0 * (i * 7919 % count) as f64 / (count - 1) as f64 - 1.0);
    let heights = even_heights(LAYERS, 16e3 / 6.371e6);
    let data = Model::new(4, &heights, |cell, _, layer| [value(cell * LAYERS + layer, 2562 * LAYERS)]);
    let mut frame = data.draw_by(renderer, scene);
    let description = Description { long_name: Some("a field".into()), units: Some("m s-1".into()) };
    frame.descriptions.insert(scene.field().to_owned(), description);
    frame.stamp = Stamp { step: 3, time_s: 60.0, date: None };
    frame
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
    let (folder, renderer) = (tempfile::tempdir().unwrap(), Renderer::new(2).unwrap());
    let [plain, off] = ["", "|[labels]\non = false"].map(|rest| frame(&renderer, &shown(FIXED, rest), 1.0));
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
    let (folder, renderer) = (tempfile::tempdir().unwrap(), Renderer::new(2).unwrap());
    let frames =
        ["", "|[labels]", "|[labels]\nplace = \"below\""].map(|rest| frame(&renderer, &shown(FIXED, rest), 1.0));
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
    let (folder, renderer) = (tempfile::tempdir().unwrap(), Renderer::new(2).unwrap());
    let follows = "map = \"vik\"\ncenter = 0\nrange = { union = [0, 100], hysteresis = 0.5 }\n\
                   opacity = [[0, 0.8], [0.5, 0], [1, 0.8]]";
    let union = shown(follows, "");
    let output = Output::from(NameTemplate::new("{step}.png").unwrap());
    for (step, most, expected) in [(0, 2.0, 2.0), (1, 3.0, 2.0), (2, 1.0, 2.0), (3, 10.0, 12.0)] {
        let mut drawn = frame(&renderer, &union, most);
        assert_eq!(drawn.report.colors[0].range, [-expected, expected], "step {step}");
        // The picture is that of a scene with this range.
        let fixed = follows.replace("{ union = [0, 100], hysteresis = 0.5 }", &format!("[-{expected}, {expected}]"));
        let like = frame(&renderer, &shown(&fixed, "|opacity_in = \"range\""), most);
        assert_eq!(drawn.pixels, like.pixels, "step {step}");
        let stamp = Stamp { step, ..Stamp::default() };
        let path = write_frame(folder.path(), &output, &stamp, &mut drawn, Existing::Overwrite).unwrap();
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
