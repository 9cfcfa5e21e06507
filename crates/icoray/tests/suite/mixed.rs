//! Several fields and surfaces, against one volume alone and against their definition. Random scenes have all kinds.

use crate::common::*;
use icoray::{Certainty, Isosurface, Knot, Level, Paint, Renderer, Scene, Stretch, Surface, Traversal, Volume};
use std::ops::ControlFlow;

const LAYERS: usize = 9;

fn waves(level: u32) -> Model {
    Model::new(level, &even_heights(LAYERS, 0.15), |_, d, layer| {
        let h = layer as f64 / (LAYERS - 1) as f64;
        let wave =
            |phase: f64| (5.0 * d.x + phase).sin() * (4.0 * d.y - phase).cos() + 0.8 * (7.0 * d.z * h + phase).sin();
        [0.3, 1.9].map(wave)
    })
}

fn scene(side: u32, more: &str) -> Scene {
    let keys = format!(
        "field = \"f\"\nbackend = \"cpu\"\nantialias = false\nprecision = \"f64\"\nbackground = \"transparent\"\n{more}\n\
         image = {{ width = {side}, height = {side} }}"
    );
    let transfer = "[transfer]\nmap = \"viridis\"\nrange = [-1.2, 1.2]\n\
         opacity = [[-1.2, 0.9], [-0.4, 0.5], [0.2, 0.0], [0.5, 0.8]]";
    scene_of("lon = 20\nlat = 35\ndistance = 3.2\nfov = 42", &keys, transfer)
}

fn volume(field: &str, knots: &[Knot]) -> Volume {
    Volume { field: field.into(), transfer: transfer(knots), coloring: None, opacity: None }
}

/// A volume of `g` that is seen beyond all values of the field.
fn volume_beyond() -> Volume {
    volume("g", &[knot(100.0, [0.5; 3], 0.0), knot(101.0, [0.5; 3], 1.0)])
}

#[test]
fn a_volume_looks_the_same_alone_and_mixed() {
    let data = waves(4);
    for (core, light, tolerance) in [("#303030", "", 1e-3), ("transparent", "", 1e-5), ("black", LIT, 1e-4)] {
        let mut plain = scene(96, &format!("core = \"{core}\"\ntolerance = {tolerance}"));
        plain.lighting = Scene::parse(&format!("field = \"f\"\n{light}")).unwrap().lighting;
        let mut general = plain.clone();
        general.volumes.push(volume_beyond());
        let [a, b] = [plain, general].map(|scene| data.draw(&scene));
        let (wrong, most) = (count_beyond(&a, &b, 0.0), difference(&a, &b));
        // Light's errors are estimates: a normal may turn in between the places where it is asked for.
        let few = if light.is_empty() { 0 } else { a.pixels.len() / 500 };
        assert!(wrong <= few, "{core}: {wrong} pixels beyond, {most} at most");
        assert!(most > 0.0, "the rules are not the same");
        assert!(light.is_empty() || most < 5e-4, "{most} at most");
        assert!(!light.is_empty() || b.report.error.max <= 1.5 * tolerance, "{core}: {}", b.report.error.max);
        assert_eq!(a.report.counts.rays, b.report.counts.rays);
    }
}

#[test]
fn errors_are_bounds_beside_isosurfaces_and_estimates_of_several_volumes() {
    let data = waves(3);
    let mut scene = scene(24, "tolerance = 1e-4");
    let surface = |value| Isosurface { field: "g".into(), value, paint: Paint::Plain([1.0, 0.0, 0.0]), opacity: 0.6 };
    scene.scenery.isosurfaces = [0.3, -0.4].map(surface).into();
    assert_eq!(data.draw(&scene).report.error.certainty, Certainty::Bound);
    scene.volumes.push(volume_beyond());
    assert_eq!(data.draw(&scene).report.error.certainty, Certainty::Estimate);
}

#[test]
fn a_layer_shows_its_values_and_hides_the_volume_behind() {
    let data = waves(3);
    let mut scene = scene(24, "core = \"#102030\"");
    scene.volumes[0].transfer = transfer(&[knot(0.0, [0.0; 3], 0.0)]);
    scene.volumes[0].coloring = None;
    let colors = transfer(&[knot(-1.5, [0.0; 3], 0.0), knot(1.5, [1.0, 0.5, 0.25], 0.0)]);
    let surface = |by_cell| Surface {
        at: Level::Layer(4),
        paint: Paint::Field { field: "g".into(), transfer: colors.clone(), coloring: None, by_cell },
        opacity: 1.0,
    };
    let radius = data.layers.shell(1.0).unwrap();
    let traversal = Traversal::new(&data.grid, &radius).unwrap();
    for by_cell in [false, true] {
        scene.scenery.surfaces = vec![surface(by_cell)];
        let frame = data.draw(&scene);
        let (mut met, mut missed) = (0, 0);
        for ((eye, dir), pixel) in rays(&scene).zip(&frame.pixels) {
            let mut expected = [0.0; 4];
            traversal.ray(eye, dir, &mut 0, |stretch| {
                let Stretch::Frustum(frustum) = stretch else { panic!("the layer lies above the core") };
                let rho: f64 = frustum.alpha[1].iter().sum();
                if (rho - radius[4]).abs() > 1e-12 || frustum.layer != 4 {
                    return ControlFlow::Continue(());
                }
                let at = eye + frustum.t[1] * dir;
                let value = |k: usize| f64::from(data.values[1][frustum.cells[k] as usize * LAYERS + 4]);
                let near = |k: usize| data.grid.direction(frustum.cells[k]).dot(at);
                let nearest = (0..3).max_by(|a, b| near(*a).total_cmp(&near(*b))).unwrap();
                let smooth: f64 = (0..3).map(|k| frustum.alpha[1][k] / rho * value(k)).sum();
                let color = colors.at(if by_cell { value(nearest) } else { smooth }).0;
                expected = [color[0], color[1], color[2], 1.0];
                ControlFlow::Break(())
            });
            let off = (0..4).map(|k| (f64::from(pixel[k]) - expected[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6, "{eye} {dir}: {pixel:?} {expected:?}");
            met += u32::from(expected[3] == 1.0);
            missed += u32::from(expected[3] == 0.0);
        }
        assert!(met > 100 && missed > 50, "{met} {missed}");
    }
}

#[test]
fn a_field_that_is_not_there_is_named() {
    let mut scene = scene(24, "");
    scene.volumes.push(volume("h", &[knot(0.0, [1.0; 3], 1.0)]));
    let data = waves(2);
    let drawn = Renderer::new(2).unwrap().render(&scene, &data.grid, &data.layers, data.fields());
    let text = drawn.unwrap_err().to_string();
    assert!(text.contains("\"h\"") && text.contains("\"g\""), "{text}");
}
