//! Labels in pictures, checked by their pixels.

use super::*;
use crate::frame::{Certainty, ErrorSummary, Frame, Legend};
use icoray_grid::Description;
use icoray_scene::Scene;
use icoray_scene::name::Stamp;

mod several;

/// A square planet's picture: the planet is of radius 1, seen from `distance`.
fn scene(width: u32, height: u32, distance: f64, more: &str) -> Scene {
    let text = format!(
        "field = \"theta\"\nexaggeration = 50\nbackground = \"black\"\n[image]\nwidth = {width}\nheight = {height}\n\
         [camera]\nlon = 0\nlat = 0\ndistance = {distance}\nfov = 40\n\
         [transfer]\nmap = \"viridis\"\nrange = [0, 10]\nopacity = [[0, 0.5], [10, 0.5]]\n[labels]\n{more}"
    );
    Scene::parse(&text).unwrap()
}

/// A field's name with its description.
fn described(name: &str, long: &str, units: &str) -> (String, Description) {
    (name.to_owned(), Description { long_name: Some(long.into()), units: Some(units.into()) })
}

fn frame(scene: &Scene) -> Frame {
    let like = crate::frame::tests::frame();
    let pixels = vec![[0.0, 0.0, 0.0, 1.0]; (scene.width * scene.height) as usize];
    let mut frame = Frame {
        width: scene.width,
        height: scene.height,
        error: vec![0.0; pixels.len()],
        pixels,
        field: scene.field().to_owned(),
        descriptions: [described(scene.field(), "temperature", "K")].into(),
        legend: Legend::of(scene, &[1.0]),
        stamp: Stamp { step: 7, time_s: 3600.0, date: None },
        ..like
    };
    frame.report.error = ErrorSummary { max: 1.2e-3, certainty: Certainty::Estimate, ..frame.report.error };
    frame
}

/// The frame's picture on black with its labels.
fn drawn(scene: &Scene) -> Canvas {
    labelled(&frame(scene))
}

fn labelled(frame: &Frame) -> Canvas {
    labelled_on(0, frame)
}

/// The labels of a frame on a grey.
fn labelled_on(grey: u8, frame: &Frame) -> Canvas {
    let rgba = frame.pixels.iter().flat_map(|_| [grey, grey, grey, 255]).collect();
    let mut canvas = Canvas { width: frame.width, height: frame.height, rgba };
    if let Some(legend) = &frame.legend {
        draw(&mut canvas, frame, legend);
    }
    canvas
}

fn pixel(canvas: &Canvas, x: i64, y: i64) -> [u8; 3] {
    let at = 4 * (y * i64::from(canvas.width) + x) as usize;
    [canvas.rgba[at], canvas.rgba[at + 1], canvas.rgba[at + 2]]
}

/// Pixels within a rectangle of parts of the picture for which `is` holds.
fn count(canvas: &Canvas, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2], is: impl Fn([u8; 3]) -> bool) -> usize {
    let span = |a: f64, b: f64, size: u32| (a * f64::from(size)) as i64..(b * f64::from(size)) as i64;
    let rows = span(y0, y1, canvas.height);
    rows.flat_map(|y| span(x0, x1, canvas.width).map(move |x| (x, y)))
        .filter(|(x, y)| is(pixel(canvas, *x, *y)))
        .count()
}

const INK: [u8; 3] = [243; 3];

fn is_ink(pixel: [u8; 3]) -> bool {
    pixel == INK
}

fn is_colored([r, g, b]: [u8; 3]) -> bool {
    r.abs_diff(g).max(g.abs_diff(b)) > 40
}

/// Runs of `true`: where each begins and ends.
fn spans(is: impl Iterator<Item = bool>) -> Vec<[i64; 2]> {
    let at: Vec<i64> = (0..).zip(is).filter_map(|(at, is)| is.then_some(at)).collect();
    at.chunk_by(|one, next| one + 1 == *next).map(|run| [run[0], run[run.len() - 1]]).collect()
}

/// The bar's outline in a lying bar: its first and last column, and the rows of its upper and lower line.
fn outline(canvas: &Canvas) -> [i64; 4] {
    let [width, height] = [canvas.width, canvas.height].map(i64::from);
    let of_row = |y: i64| (0..width).filter(|x| is_ink(pixel(canvas, *x, y))).collect::<Vec<_>>();
    let lines: Vec<i64> = (0..height).filter(|y| of_row(*y).len() as i64 > width / 2).collect();
    let ends = of_row(lines[0]);
    [ends[0], ends[ends.len() - 1], lines[0], lines[lines.len() - 1]]
}

#[test]
fn ticks_stand_at_their_values_at_every_size() {
    for (width, height) in [(512, 512), (1024, 768), (3840, 2160)] {
        let canvas = drawn(&scene(width, height, 8.0, "place = \"bottom\""));
        let [left, right, top, bottom] = outline(&canvas);
        let line = (f64::from(width.min(height)) / 36.0 * 0.07).round().max(1.0) as i64;
        let length = right - left + 1 - 2 * line;
        assert_eq!(length, (0.6 * f64::from(width)) as i64);
        // Only ticks cross this row.
        let below = spans((0..i64::from(width)).map(|x| is_ink(pixel(&canvas, x, bottom + 2))));
        let ticks: Vec<i64> = below.iter().map(|[from, to]| (from + to + 1) / 2).collect();
        // 0, 2, ..., 10 of 0 to 10.
        let expected: Vec<i64> = (0..=5).map(|i| left + line + (i * length / 5).min(length - 1)).collect();
        assert_eq!(ticks.len(), expected.len(), "{width}: {ticks:?}");
        for (found, expected) in ticks.iter().zip(&expected) {
            assert!((found - expected).abs() <= line, "{width}: {ticks:?}, {expected:?}");
        }
        // Em by em the same: breadth of the bar, and that labels are there below.
        let em = f64::from(width.min(height)) / 36.0;
        assert!(((bottom - top + 1 - 2 * line) as f64 - 1.2 * em).abs() < 1.0);
        assert!(count(&canvas, [0.15, 0.85], [0.9, 1.0], is_ink) as f64 > em * em);
    }
}

#[test]
fn the_bars_colours_are_the_transfer_functions() {
    let canvas = drawn(&scene(512, 512, 8.0, "place = \"bottom\""));
    let [left, right, top, bottom] = outline(&canvas);
    let map = scene(512, 512, 8.0, "").volumes[0].transfer.clone();
    let length = right - left - 1;
    for at in [0, 17, length / 2, length - 1] {
        let (color, _) = map.at(10.0 * (at as f64 + 0.5) / length as f64);
        let expected = color.map(|c| srgb_byte(c as f32));
        assert_eq!(pixel(&canvas, left + 1 + at, top + 1), expected);
        // Beside the ticks it is half as opaque, over grey.
        let beside = pixel(&canvas, left + 1 + at, bottom - 1);
        assert!(beside != expected && (0..3).all(|k| beside[k] > 40), "{beside:?}");
    }
}

#[test]
fn arrows_stand_at_the_ends_that_have_values_beyond_them() {
    let scene = scene(512, 512, 8.0, "place = \"bottom\"");
    for (values, beyond) in [([0.0, 10.0], [false; 2]), ([-1.0, 10.0], [true, false]), ([2.0, 11.0], [false, true])] {
        let mut frame = frame(&scene);
        frame.report.value_ranges = vec![("theta".into(), values)];
        let canvas = labelled(&frame);
        let [left, right, top, bottom] = outline(&canvas);
        for (x, end, has_arrow) in [(left - 2, 0.0, beyond[0]), (right + 2, 10.0, beyond[1])] {
            let color = scene.volumes[0].transfer.at(end).0.map(|c| srgb_byte(c as f32));
            assert_eq!(pixel(&canvas, x, (top + bottom) / 2) == color, has_arrow, "{values:?}");
        }
    }
}

#[test]
fn labels_are_at_the_place_that_the_scene_names() {
    let colored = |canvas: &Canvas, x, y| count(canvas, x, y, is_colored);
    for (place, x, y) in
        [("right", [0.8, 1.0], [0.15, 0.85]), ("left", [0.0, 0.15], [0.15, 0.85]), ("bottom", [0.15, 0.85], [0.8, 1.0])]
    {
        let canvas = drawn(&scene(512, 512, 8.0, &format!("place = \"{place}\"")));
        let all = colored(&canvas, [0.0, 1.0], [0.0, 1.0]);
        assert!(all > 3000 && colored(&canvas, x, y) == all, "{place}");
        assert!(count(&canvas, [0.0, 0.4], [0.0, 0.08], is_ink) > 50, "{place}: no title");
    }
}

#[test]
fn labels_below_leave_the_picture_as_it_is() {
    let scene = scene(400, 300, 2.0, "place = \"below\"");
    let canvas = drawn(&scene);
    assert!(canvas.height > 340 && canvas.height < 420, "{}", canvas.height);
    assert_eq!(canvas.rgba.len(), 4 * 400 * canvas.height as usize);
    let own = &canvas.rgba[..4 * 400 * 300];
    assert!(own.chunks_exact(4).all(|pixel| pixel == [0, 0, 0, 255]));
    let [left, right, top, _] = outline(&canvas);
    assert!(top > 300 && left > 0 && right < 399);
}

/// The position of a bar that chooses its own place, as its coloured pixels' least and largest column and row.
fn found(canvas: &Canvas) -> [f64; 4] {
    let [width, height] = [canvas.width, canvas.height].map(i64::from);
    let points: Vec<(i64, i64)> = (0..width * height).map(|at| (at % width, at / width)).collect();
    let colored: Vec<_> = points.into_iter().filter(|(x, y)| is_colored(pixel(canvas, *x, *y))).collect();
    let xs = || colored.iter().map(|p| p.0 as f64 / width as f64);
    let ys = || colored.iter().map(|p| p.1 as f64 / height as f64);
    [xs().fold(1.0, f64::min), xs().fold(0.0, f64::max), ys().fold(1.0, f64::min), ys().fold(0.0, f64::max)]
}

#[test]
fn a_bar_by_itself_stays_off_the_planet_where_there_is_room() {
    let full_height = 1.0 / (20f64.to_radians()).sin();
    // Wide: beside the planet. Narrow: below it. Square and filled: in a corner.
    let [left, _, top, bottom] = found(&drawn(&scene(800, 400, full_height, "")));
    assert!(left > 0.8 && top < 0.25 && bottom > 0.7);
    let [left, right, top, _] = found(&drawn(&scene(300, 600, 2.0 * full_height, "")));
    assert!(top > 0.85 && left < 0.3 && right > 0.7);
    let [left, _, top, _] = found(&drawn(&scene(512, 512, full_height, "")));
    assert!(left > 0.55 && top > 0.5, "{left} {top}");
}

#[test]
fn labels_over_the_planet_have_a_panel_behind_them() {
    let canvas = labelled_on(255, &frame(&scene(300, 300, 1.5, "place = \"right\"")));
    // 80 % of black over white, in bytes.
    let panel = count(&canvas, [0.0, 1.0], [0.0, 1.0], |pixel| pixel == [51; 3]);
    assert!(panel > 4000, "{panel}");
}

#[test]
fn labels_that_only_come_near_the_planet_have_no_panel() {
    let picture = |distance: f64| {
        // Only the upper line reaches the planet's columns.
        let title = "title = \"a long line of words\\nshort\"";
        let frame = frame(&scene(300, 300, distance, &format!("bar = false\nscale = false\n{title}")));
        (labelled_on(255, &frame), frame.legend.unwrap().outer)
    };
    // The planet grows towards the title until a panel is there.
    let distances = (0..200).map(|i| 6.0 - 0.02 * f64::from(i));
    let mut panels = distances.map(|distance| (distance, picture(distance)));
    let is_panel = |pixel: [u8; 3]| pixel == [51; 3];
    let (distance, (canvas, outer)) =
        panels.find(|(_, (canvas, _))| count(canvas, [0.0, 1.0], [0.0, 1.0], is_panel) > 0).unwrap();
    // The corner of the line's text that is nearest the planet.
    let corner = (0..300 * 300).map(|at| [at % 300, at / 300]).filter(|[x, y]| is_panel(pixel(&canvas, *x, *y)));
    let [x, y] = corner.fold([0, 0], |[x, y], [right, bottom]| [x.max(right), y.max(bottom)]);
    assert!(y < 25, "a panel of {y} rows behind one line");
    let away = (153.0 - x as f64).hypot(150.0 - y as f64) / 150.0 * 20f64.to_radians().tan();
    assert!(away.atan() < (outer / distance).asin(), "{distance}: a panel without the planet behind the text");
}

#[test]
fn captions_of_upright_bars_end_below_the_title() {
    let name = "Zonal component of reconstructed horizontal velocity at cell centers";
    let canvas = drawn(&scene(720, 720, 8.0, &format!("place = \"right\"\nname = \"{name}\"")));
    assert_eq!(count(&canvas, [0.85, 1.0], [0.0, 0.07], is_ink), 0);
    assert!(count(&canvas, [0.85, 1.0], [0.1, 0.9], is_ink) > 500);
}

#[test]
fn text_is_dark_on_bright_and_bright_on_dark() {
    let grey = |level: f64| Some([level; 3]);
    for (back, ink) in [(grey(0.0), 243), (grey(0.05), 243), (grey(1.0), 25), (grey(0.5), 25), (None, 25)] {
        let scene = Scene { background: back, ..scene(512, 512, 8.0, "") };
        let canvas = drawn(&scene);
        assert!(count(&canvas, [0.0, 0.4], [0.0, 0.08], |pixel| pixel == [ink; 3]) > 20, "{back:?}");
    }
}

#[test]
fn each_label_can_be_left_out() {
    let inked = |more: &str| count(&drawn(&scene(512, 512, 8.0, more)), [0.0, 1.0], [0.0, 1.0], |p| p != [0; 3]);
    let all = inked("error = true");
    let without = ["title = \"\"", "bar = false", "scale = false"];
    assert!(without.iter().all(|key| inked(&format!("{key}\nerror = true")) < all) && inked("") < all);
    assert_eq!(inked(&without.join("\n")), 0);
    assert_eq!(inked("on = false"), 0);
    assert!(inked("size = 2") > 3 * all / 2);
}

#[test]
fn words_come_from_the_file_the_model_or_the_scene() {
    let said = |more: &str| {
        let scene = scene(64, 64, 3.0, more);
        let frame = frame(&scene);
        let legend = frame.legend.as_ref().unwrap();
        let bar = &bar::Bar::all(&legend.scene)[0];
        (words::title(&frame, legend), words::caption(&frame, legend, bar, 0), words::notes(&frame, legend))
    };
    let (title, caption, notes) = said("");
    assert_eq!(title, ["day 0 01:00"]);
    assert_eq!(caption, ["temperature (K)"]);
    assert_eq!(notes, ["vertical × 50"]);
    assert_eq!(said("error = true").2, ["vertical × 50", "error ≤ 1.2 × 10⁻³ (estimate)"]);
    let (title, caption, _) = said(
        "title = \"{field}: {name} ({units})\\n\\n{step:04}, {time}, × {exaggeration}\"\nname = \"speed\"\nunits = \"m s-1\"",
    );
    assert_eq!(title, ["theta: speed (m s⁻¹)", "0007, day 0 01:00, × 50"]);
    assert_eq!(caption, ["speed (m s⁻¹)"]);
    assert_eq!(said("title = \"{name} ({units})\"\nunits = \"\"").0, ["temperature"]);
    // No date is there.
    assert_eq!(said("title = \"$Y\"").0, ["day 0 01:00"]);
}

#[test]
fn an_error_above_the_tolerance_has_another_colour() {
    let is_orange = |[r, g, b]: [u8; 3]| r > 90 && g < r && b < 30;
    for place in ["right", "bottom", "left", "below"] {
        let scene = scene(300, 300, 3.0, &format!("place = \"{place}\"\nbar = false"));
        let mut frame = frame(&scene);
        let seen = |frame: &Frame| count(&labelled(frame), [0.0, 1.0], [0.0, 1.0], is_orange);
        assert_eq!(seen(&frame), 0, "{place}");
        frame.report.error.pixels_over_tolerance = 12;
        frame.report.quality.tolerance = 1e-3;
        // Of one in a thousand pixels at most.
        frame.report.error.p999 = 1e-3;
        assert_eq!(seen(&frame), 0, "{place}");
        frame.report.error.p999 = 1.1e-3;
        assert!(seen(&frame) > 50, "{place}");
        let scene = self::scene(300, 300, 3.0, &format!("place = \"{place}\"\nbar = false\nerror = false"));
        let silent = Frame { legend: Legend::of(&scene, &[1.0]), ..frame.clone() };
        assert_eq!(seen(&silent), 0, "{place}");
        let notes = words::notes(&frame, frame.legend.as_ref().unwrap());
        assert_eq!(notes.last().unwrap(), "error ≤ 1.2 × 10⁻³ (estimate), above 0.001 in 12 px");
    }
}
