//! Savings do not change pictures: skipped space changes no bit, packets change less than the errors.

use crate::common::*;
use crate::culled::{Culled, Mark, Style, holes};
use icoray::{Frame, Grid, IcosahedralMesh, Layers, Location, OwnedReals, Renderer, Savings, Scene, Shape};
use itertools::iproduct;

const NONE: Savings = Savings { ends: true, ..Savings::NONE };
const LEAPS: Savings = Savings { empty_space: true, gradients: true, tiles: true, ..NONE };

const STEPS: &str = "knots = [ { value = -0.9, color = \"red\", extinction = 1e4 }, { value = -0.5, color = \"orange\", extinction = 1e4 }, \
     { value = -0.5, color = \"blue\", extinction = 0 }, { value = 0.2, color = \"blue\", extinction = 0 }, \
     { value = 0.2, color = \"white\", extinction = 9 }, { value = 0.9, color = \"white\", extinction = 0 } ]";

/// A field with waves, level-fastest or cell-fastest, some values missing.
struct Model {
    mesh: &'static IcosahedralMesh,
    grid: Grid<'static>,
    layers: Layers,
    values: Array,
}

impl Model {
    fn new(layers: usize, is_level_fastest: bool, misses: bool) -> Self {
        let (mesh, grid) = icosahedral(5);
        let shape = if is_level_fastest { Shape::level_fastest } else { Shape::cell_fastest }(mesh.cells(), layers);
        let values = Array::new(shape, false, Location::Center, Some(-9e33), |cell, layer| {
            let (lon, lat) = (mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]);
            let height = layer as f64 / layers as f64;
            let value = (5.0 * lon + 4.0 * height).sin() * (6.0 * lat - 3.0 * height).cos();
            let is_missing = misses && (cell * 31 + layer * 7) % 97 == 0;
            if is_missing { -9e33 } else { value }
        });
        let radii = (0..layers).map(|l| 1.0 + 0.15 * l as f64 / (layers - 1) as f64).collect();
        Model { mesh, grid, layers: Layers::new(radii, 1.0).unwrap(), values }
    }

    fn draw(&self, scene: &Scene, savings: Savings) -> Frame {
        let renderer = Renderer::new(2).unwrap().with_savings(savings);
        renderer.render(scene, &self.grid, &self.layers, &self.values.field()).unwrap()
    }

    /// Replaces the values, in the order of the array.
    fn change(&mut self, change: impl Fn(usize, f32) -> f32) {
        let OwnedReals::F32(values) = &mut self.values.values else { panic!("values in f64") };
        values.iter_mut().enumerate().for_each(|(i, value)| *value = change(i, *value));
    }
}

const HOLLOW: &str = "eye = [0.2, 0.1, -0.3]\ntarget = [0, 1, 1]\nfov = 80";
const HEADLIGHT: &str = "|[light]\nkind = \"headlight\"";

fn scenes() -> Vec<(String, Scene)> {
    let transfers = [(SHELL, "shell"), (STEPS, "steps"), (DENSE, "dense")];
    let rests = ["", "precision = \"f64\"", "core = \"transparent\"", HEADLIGHT];
    iproduct!([(FAR, "far"), (INSIDE, "inside")], transfers, rests)
        .map(|((camera, place), (transfer, name), rest)| {
            (format!("{place}, {name}, {rest:?}"), scene(camera, transfer, rest))
        })
        .collect()
}

/// Few layers and many, values missing or not, both orders of the array: every bit of pixels and errors, and fewer
/// frusta read wherever something is clear.
#[test]
fn empty_space_skipping_changes_no_bit() {
    for (layers, is_level_fastest, misses) in [(6, true, false), (20, false, true), (90, true, true)] {
        let model = Model::new(layers, is_level_fastest, misses);
        for (name, scene) in scenes() {
            let [plain, leaping] = [NONE, LEAPS].map(|savings| model.draw(&scene, savings));
            assert!(bits(&plain) == bits(&leaping), "{layers} layers, {name}: other pixels or errors");
            let [all, read] = [&plain, &leaping].map(|frame| frame.report.counts.frusta);
            assert_eq!(plain.report.counts.void_frusta, leaping.report.counts.void_frusta, "{name}");
            let is_clear = !name.contains("dense") && layers > 6;
            let saves = read <= all && (!is_clear || read < all - all / 20);
            assert!(saves, "{layers} layers, {name}: {read} of {all}");
        }
    }
}

/// Packets leap over macrocells: the same bits and frusta, with far fewer columns where hardly anything shows.
#[test]
fn leaps_change_no_bit() {
    const SPARSE: &str = "knots = [ { value = 0.85, color = \"red\", extinction = 0 }, \
         { value = 0.95, color = \"green\", extinction = 40 } ]";
    let packets = Savings { lanes: true, ..LEAPS };
    let walks = Savings { empty_space: false, ..packets };
    let above = "lon = 200\nlat = -70\ndistance = 1.4\nfov = 70";
    for (layers, misses) in [(20, false), (90, true)] {
        let model = Model::new(layers, true, misses);
        let rests = ["core = \"transparent\"", "", HEADLIGHT];
        for (camera, rest, transfer) in iproduct!([FAR, INSIDE, above, HOLLOW], rests, [SPARSE, SHELL, STEPS]) {
            // An opaque core hides all from an eye inside.
            if camera == HOLLOW && rest != rests[0] {
                continue;
            }
            let name = format!("{layers} layers, {camera}, {rest:?}, {transfer}");
            let scene = scene(camera, transfer, rest);
            let [walked, leapt] = [walks, packets].map(|savings| model.draw(&scene, savings));
            assert!(bits(&walked) == bits(&leapt), "{name}: other pixels or errors");
            let [all, passed] = [&walked, &leapt].map(|frame| frame.report.counts.columns);
            let is_sparse = transfer == SPARSE && camera == FAR && !misses;
            assert!(passed <= all && (!is_sparse || 4 * passed < 3 * all), "{name}: {passed} of {all}");
            assert_eq!(walked.report.counts.rays, leapt.report.counts.rays, "{name}");
        }
    }
}

/// Rays leap over a hollow core, whatever shows in the shell, and over holes of the mesh: the same bits and frusta,
/// with fewer columns.
#[test]
fn a_leap_over_a_hollow_core_changes_no_bit() {
    let model = Model::new(6, true, true);
    let mut holes = holes(model.mesh);
    let (_, stays) = holes.swap_remove(holes.len() / 2);
    let culled = Culled::new(model.mesh, &stays, Style::Triangles, Mark::MinusOne, 0);
    let with_holes = |scene: &Scene, savings: Savings| {
        let grid = culled.grid();
        let values: Vec<f64> = (0..6 * grid.cells()).map(|i| (0.01 * i as f64).sin()).collect();
        let renderer = Renderer::new(2).unwrap().with_savings(savings);
        renderer.render(scene, &grid, &model.layers, &at_centers(&values, 6)).unwrap()
    };
    let savings = Savings { lanes: true, ..LEAPS };
    let walks = Savings { empty_space: false, ..savings };
    let beside = format!(
        "{HEADLIGHT}\n[[surfaces]]\nlayer = 2\ncolor = \"white\"\nopacity = 0.2\n\
         [[lines]]\npattern = \"graticule\"\nspacing = 10\nheight_m = -0.3"
    );
    for (camera, rest) in iproduct!([FAR, INSIDE, HOLLOW], ["", HEADLIGHT, &beside]) {
        let scene = scene(camera, DENSE, &format!("core = \"transparent\"\n{rest}"));
        let whole = [walks, savings].map(|savings| model.draw(&scene, savings));
        for [walked, leapt] in [whole, [walks, savings].map(|savings| with_holes(&scene, savings))] {
            assert!(bits(&walked) == bits(&leapt), "{camera}, {rest}: other pixels or errors");
            let [all, passed] = [&walked, &leapt].map(|frame| frame.report.counts);
            assert_eq!((all.rays, all.frusta), (passed.rays, passed.frusta), "{camera}, {rest}");
            let (few, many) = (passed.columns, all.columns);
            assert!(few < many && (camera != FAR || 4 * few < 3 * many), "{camera}, {rest}: {few} of {many}");
        }
    }
}

/// Cloud water: zero but in few places, and a second one that is 0.3 there, which f32 does not hold exactly.
fn clouds(rest: f32, is_level_fastest: bool) -> Model {
    let mut model = Model::new(40, is_level_fastest, false);
    model.change(|_, value| (value - 0.7).max(0.0) + rest);
    model
}

const CLOUD: &str =
    "knots = [ { value = 0, color = \"white\", extinction = 0 }, { value = 0.3, color = \"white\", extinction = 90 } ]";
const ABOVE: &str = "knots = [ { value = 0, color = \"blue\", extinction = 3 }, { value = 0.3, color = \"red\", extinction = 0 }, \
     { value = 0.9, color = \"white\", extinction = 90 } ]";

/// A value that is exactly a knot's, where nothing but the knot is clear.
#[test]
fn constants_on_clear_knots_are_leapt_over() {
    let rests = ["", "precision = \"f64\"", "method = \"paper\"", HEADLIGHT];
    for ((value, transfer), is_level_fastest) in iproduct!([(0.0, CLOUD), (0.3, ABOVE)], [true, false]) {
        let model = clouds(value, is_level_fastest);
        for rest in rests {
            let scene = scene(FAR, transfer, rest);
            // Rays of packets are in f32, where the field's 0.3 is the knot's.
            let lanes = transfer == ABOVE;
            let [plain, leaping] = [NONE, LEAPS].map(|savings| model.draw(&scene, Savings { lanes, ..savings }));
            assert!(bits(&plain) == bits(&leaping), "{transfer}, {rest:?}: other pixels or errors");
            let [all, read] = [&plain, &leaping].map(|frame| frame.report.counts.frusta);
            let is_knot = transfer == CLOUD || rest.is_empty() || rest == HEADLIGHT;
            assert!(!is_knot || read < all / 2, "{transfer}, {rest:?}: {read} of {all}");
            assert!(plain.pixels.iter().any(|p| p[0] > 0.1), "{transfer}, {rest:?}: nothing is seen");
        }
    }
}

/// Where nothing is seen above a layer rays begin there, which moves their first column's ends by rounding.
#[test]
fn rays_begin_where_something_is_seen() {
    for (layers, is_level_fastest) in [(20, true), (90, false)] {
        let mut model = Model::new(layers, is_level_fastest, true);
        let cells = model.mesh.cells();
        model.change(|i, value| {
            let layer = if is_level_fastest { i % layers } else { i / cells };
            if layer > layers / 3 { -3.0 } else { value }
        });
        let rests = ["", "precision = \"f64\"", "core = \"#404040\"", HEADLIGHT];
        for (camera, rest) in iproduct!([FAR, INSIDE], rests) {
            let scene = scene(camera, SHELL, rest);
            let begins = Savings { layers: true, ..LEAPS };
            let [outer, upper] = [LEAPS, begins].map(|savings| model.draw(&scene, savings));
            let off = difference(&outer, &upper);
            // Rounding may decide whether a lit piece is cut, which changes a channel by less than its error.
            let most = if rest == HEADLIGHT { 5e-5 } else { 2e-6 };
            assert!(off <= most, "{layers} layers, {rest:?}: {off:e}");
            let [all, fewer] = [&outer, &upper].map(|frame| frame.report.counts);
            assert!(fewer.columns < all.columns - all.columns / 20, "{rest:?}: {fewer:?} of {all:?}");
            assert!(fewer.frusta <= all.frusta && fewer.rays <= all.rays, "{rest:?}: {fewer:?} of {all:?}");
        }
    }
}

/// Rays that go on where nothing more is to be seen read more, and show the same to the tolerance.
#[test]
fn rays_end_within_the_tolerance() {
    let model = Model::new(40, true, false);
    let scene = scene(FAR, STEPS, "tolerance = 1e-2\nprecision = \"f64\"");
    let [whole, ended] = [Savings { ends: false, ..LEAPS }, LEAPS].map(|savings| model.draw(&scene, savings));
    let [all, fewer] = [&whole, &ended].map(|frame| frame.report.counts.frusta);
    assert!(fewer < all - all / 5, "{fewer} of {all}");
    let off = difference(&whole, &ended);
    assert!(off > 1e-5 && off < 1e-2, "{off:e}");
    assert!(f64::from(off) <= ended.report.error.max, "{off:e} of {}", ended.report.error.max);
}

/// Packed gradients take 8 bytes instead of 12, and light is as good; asked for more, they are not packed.
#[test]
fn gradients_are_packed_within_the_tolerance() {
    let model = Model::new(20, true, true);
    let (packs, values) = (Savings { packing: true, ..NONE }, model.grid.cells() * 20);
    for (tolerance, is_packed) in [(1e-3, true), (1e-6, false)] {
        let scene = scene(FAR, DENSE, &format!("tolerance = {tolerance:e}{HEADLIGHT}"));
        let [whole, packed] = [NONE, packs].map(|savings| model.draw(&scene, savings));
        let [whole_bytes, bytes] = [&whole, &packed].map(|frame| frame.report.bytes_derived);
        assert_eq!(whole_bytes, values * 12);
        assert_eq!(bytes, if is_packed { 8 } else { 12 } * values);
        let off = difference(&whole, &packed);
        assert!(off < 2e-5 && (off > 0.0) == is_packed, "{tolerance:e}: {off:e}");
    }
}

/// Cameras far and near, in the shell and in the hollow core.
const CAMERAS: [&str; 7] = [
    FAR,
    INSIDE,
    "lon = 10\nlat = 50\ndistance = 1.4\nfov = 12",
    "lon = 250\nlat = -80\ndistance = 30\nfov = 1.5",
    "eye = [1.3, 0, 0]\ntarget = [1.0, 0.6, 0.2]\nfov = 8",
    HOLLOW,
    "eye = [40, 3, 5]\ntarget = [0.5, 0.7, 0]\nfov = 0.8",
];

const DOME: &str = "[[isosurfaces]]\nfield = \"f\"\nvalue = 0.4\ncolor = \"crimson\"";

/// Gradients over cells that no ray of a picture passes are those of another field, which are as long as can be: each
/// picture and its errors have the bits that they have where all gradients are computed; of one view after another,
/// too.
#[test]
fn gradients_beside_the_view_are_not_read() {
    let model = Model::new(20, true, true);
    let mut other = Model::new(20, true, false);
    other.change(|i, _| 1e33 * ((i * 7919) % 13) as f32 - 6e33);
    let field = model.values.field();
    for (transfer, rest, tables) in [
        (DENSE, "core = \"transparent\"", LIT.to_owned()),
        (DENSE, "", LIT.to_owned()),
        (SHELL, "core = \"#404040\"\nantialias = false", LIT.to_owned()),
        (DENSE, "precision = \"f64\"", LIT.to_owned()),
        (SHELL, "", format!("{DOME}\n{LIT}")),
    ] {
        let renderer = Renderer::new(2).unwrap();
        let scene = |camera, transfer, rest: &str| scene(camera, transfer, &format!("{rest}|{tables}"));
        let precision = scene(FAR, transfer, rest).precision;
        let of_all = Scene { precision, ..scene(FAR, DENSE, "core = \"transparent\"") };
        renderer.render(&of_all, &model.grid, &model.layers, &other.values.field()).unwrap();
        // A camera in the opaque core is refused.
        for camera in CAMERAS.into_iter().filter(|camera| rest.contains("transparent") || *camera != HOLLOW) {
            let scene = scene(camera, transfer, rest);
            let seen = renderer.render(&scene, &model.grid, &model.layers, &field).unwrap();
            let all = model.draw(&scene, Savings { gradients: false, ..Savings::ALL });
            assert!(bits(&seen) == bits(&all), "{camera}, {rest:?}: other pixels or errors");
            assert_eq!(seen.report.counts, all.report.counts, "{camera}, {rest:?}");
        }
    }
}

/// One renderer, one field, scenes that ask for other things of it: each frame is that of a renderer of its own.
#[test]
fn cached_data_of_a_field_serve_matching_scenes() {
    let model = Model::new(20, true, true);
    let (field, renderer) = (model.values.field(), Renderer::new(2).unwrap());
    let mut scenes = scenes();
    for key in ["exaggeration = 2", "tolerance = 1e-6"] {
        scenes.push((key.into(), scene(FAR, SHELL, &format!("{key}{HEADLIGHT}"))));
    }
    for (name, scene) in scenes.iter().chain(scenes.iter().rev()) {
        let frame = renderer.render(scene, &model.grid, &model.layers, &field).unwrap();
        let alone = model.draw(scene, Savings::ALL);
        assert!(frame.pixels == alone.pixels && frame.error == alone.error, "{name}");
        assert_eq!(frame.report.counts, alone.report.counts, "{name}");
        assert_eq!(frame.report.value_range, alone.report.value_range, "{name}");
    }
}

/// Rays in packets meet the frusta that rays one after the other meet, and differ by less than both errors. Where
/// the mesh, the transfer function and the values are usual, hardly a piece is left to scalar code.
#[test]
fn packets_differ_by_less_than_errors() {
    let model = Model::new(40, true, true);
    let strict = |tolerance: &str| {
        let rest = format!("tolerance = {tolerance}{HEADLIGHT}");
        (format!("dense, lit, {tolerance}"), scene(FAR, DENSE, &rest))
    };
    for (name, scene) in scenes().into_iter().chain(["1e-2", "1e-4", "1e-5"].map(strict)) {
        let [one, lanes] = [LEAPS, Savings { lanes: true, ..LEAPS }].map(|savings| model.draw(&scene, savings));
        assert_eq!(count_beyond(&one, &lanes, 0.0), 0, "{name}: off by {:e}", difference(&one, &lanes));
        let (one, lanes) = (one.report.counts, lanes.report.counts);
        assert!(one.frusta.abs_diff(lanes.frusta) <= one.frusta / 500, "{name}: {} {}", one.frusta, lanes.frusta);
        assert_eq!(one.scalar_pieces, 0, "{name}");
        let rare = if name.contains("steps") { lanes.frusta / 4 } else { lanes.frusta / 200 };
        assert!(lanes.scalar_pieces <= rare, "{name}: {} of {}", lanes.scalar_pieces, lanes.frusta);
    }
}

/// No cut makes the error smaller that rounding gives to a shade.
#[test]
fn light_below_the_last_digit_is_not_cut_without_end() {
    let model = Model::new(20, true, false);
    let at = |tolerance: &str| {
        let rest = format!("tolerance = {tolerance}{HEADLIGHT}");
        model.draw(&scene(FAR, DENSE, &rest), Savings::ALL)
    };
    let [usual, strict] = ["1e-4", "1e-7"].map(at);
    assert_eq!(count_beyond(&usual, &strict, 0.0), 0, "off by {:e}", difference(&usual, &strict));
}

/// All ways in which a model can lay out its array.
#[test]
fn packets_read_arrays_of_any_layout() {
    let scene = scene(FAR, DENSE, "");
    let frames = [true, false].map(|is_level_fastest| {
        let model = Model::new(20, is_level_fastest, true);
        model.draw(&scene, Savings::ALL)
    });
    assert!(frames[0].pixels == frames[1].pixels && frames[0].error == frames[1].error);
    // In blocks of 7 cells, from the outermost layer in, in f32 and in f64.
    let model = Model::new(20, true, true);
    let whole = model.values.field();
    let shape = Shape::blocked(model.mesh.cells(), 20, 7);
    // What is missing has the mark in f64 as well.
    let value = |cell: usize, layer: usize| Some(whole.value(cell, layer)).filter(|v| !v.is_nan()).unwrap_or(-9e33);
    for is_wide in [false, true] {
        let array = Array::new(shape, is_wide, Location::Center, Some(-9e33), value);
        let field = array.field();
        let frame = Renderer::new(2).unwrap().render(&scene, &model.grid, &model.layers, &field).unwrap();
        assert_eq!(count_beyond(&frame, &frames[0], 0.0), 0, "{}", difference(&frame, &frames[0]));
        assert!(difference(&frame, &frames[0]) < 1e-6);
    }
}

/// Layers above an opaque surface are not read, and rays leap to it.
#[test]
fn a_surface_costs_the_same_below_any_number_of_layers() {
    let costs = |layers: usize| {
        let model = Model::new(layers, true, false);
        let surface = "|[[surfaces]]\nlayer = 0\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [0, 1] }";
        let scene = scene(FAR, "knots = [ { value = 0, color = \"red\", extinction = 0 } ]", surface);
        let frames =
            [Savings::NONE, Savings::ALL].map(|savings| model.draw(&scene, Savings { lanes: true, ..savings }));
        let [walked, leapt] = &frames;
        assert_eq!(count_beyond(walked, leapt, 0.0), 0, "{layers} layers");
        frames.map(|frame| [frame.report.counts.frusta, frame.report.counts.columns])
    };
    let [[few_read, few_walked], [few, few_columns]] = costs(10);
    let [[many_read, _], [many, _]] = costs(160);
    assert!(many_read > 5 * few_read && many <= few && 4 * few < few_read, "{few_read} {many_read} {few} {many}");
    assert!(2 * few_columns < few_walked, "{few_columns} of {few_walked}");
}
