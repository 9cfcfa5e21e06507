//! Several fields, surfaces and cuts, against one volume alone and against brute force.

use glam::DVec3;

use crate::common::*;
use crate::culled::towards;
use icoray::{
    Certainty, Clip, Frame, HalfSpace, Isosurface, Knot, Level, LonLatBox, Opacity, Paint, Renderer, Scene, Stretch,
    Surface, Traversal, Volume,
};
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

/// The picture's rays stepped through finely, with the renderer's own walk but values, media and surfaces by their
/// definition.
fn by_steps(data: &Model, scene: &Scene, sees: impl Fn(&Sample) -> ([f64; 3], f64)) -> Vec<[f64; 4]> {
    let radius: Vec<f64> = data.layers.shell(scene.exaggeration).unwrap();
    let traversal = Traversal::new(&data.grid, &radius).unwrap();
    let pixel = |(eye, dir): (DVec3, DVec3)| {
        let (mut color, mut through) = ([0.0; 3], 1.0);
        let mut before: Option<[f64; 2]> = None;
        traversal.ray(eye, dir, &mut 0, |stretch| {
            let Stretch::Frustum(frustum) = stretch else {
                let core = scene.core.unwrap();
                color = [0, 1, 2].map(|k| color[k] + through * core[k]);
                through = 0.0;
                return ControlFlow::Break(());
            };
            const STEPS: usize = 400;
            let length = frustum.t[1] - frustum.t[0];
            let [low, high] = [radius[frustum.layer], radius[frustum.layer + 1]];
            for step in 0..STEPS {
                let w = (step as f64 + 0.5) / STEPS as f64;
                let alpha = [0, 1, 2].map(|k| frustum.alpha[0][k] + w * (frustum.alpha[1][k] - frustum.alpha[0][k]));
                let rho: f64 = alpha.iter().sum();
                let up = (rho - low) / (high - low);
                let values = [0, 1].map(|field| {
                    let value =
                        |k: usize, layer| f64::from(data.values[field][frustum.cells[k] as usize * LAYERS + layer]);
                    let at = |layer| (0..3).map(|k| alpha[k] / rho * value(k, layer)).sum::<f64>();
                    let (g, h) = (at(frustum.layer), at(frustum.layer + 1));
                    g + up * (h - g)
                });
                let position = eye + (frustum.t[0] + w * length) * dir;
                let (layer, length) = (frustum.layer, length / STEPS as f64);
                let (c, opacity) = sees(&Sample { values, before, position, layer, length });
                color = [0, 1, 2].map(|k| color[k] + through * opacity * c[k]);
                through *= 1.0 - opacity;
                before = Some(values);
            }
            if through < 1e-9 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        [color[0], color[1], color[2], 1.0 - through]
    };
    rays(scene).map(pixel).collect()
}

struct Sample {
    values: [f64; 2],
    before: Option<[f64; 2]>,
    position: DVec3,
    layer: usize,
    length: f64,
}

/// Draws a scene, and checks how far pixels are off fine steps at most and in the mean.
fn draw_near(
    (data, scene): (&Model, &Scene),
    limits: [f64; 2],
    what: &str,
    sees: impl Fn(&Sample) -> ([f64; 3], f64),
) -> Frame {
    let frame = data.draw(scene);
    let off = distances(&frame, &by_steps(data, scene, sees));
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let most = off.into_iter().fold(0.0, f64::max);
    assert!(most < limits[0] && mean < limits[1], "{what}: {most} at most, {mean} in the mean");
    frame
}

/// Light and absorption along a length of media in a shell of 0.15 radii, the unit of extinction.
fn mixed(terms: &[([f64; 3], f64)], length: f64) -> ([f64; 3], f64) {
    let rate = terms.iter().map(|(_, extinction)| extinction).sum::<f64>() / 0.15;
    if rate == 0.0 {
        return ([0.0; 3], 0.0);
    }
    let color = [0, 1, 2].map(|k| terms.iter().map(|(c, r)| c[k] * r).sum::<f64>() / (0.15 * rate));
    (color, -(-rate * length).exp_m1())
}

/// Two volumes, and one whose opacity is that of another field.
#[test]
fn two_fields_are_those_of_fine_steps() {
    let data = waves(3);
    let mut two = scene(24, "tolerance = 1e-4");
    let mut by_other = two.clone();
    two.volumes.push(volume(
        "g",
        &[
            knot(-0.5, [1.0, 0.1, 0.0], 0.0),
            knot(0.1, [1.0, 0.8, 0.0], 4.0),
            knot(0.1, [0.0, 0.0, 1.0], 0.0),
            knot(1.0, [0.3; 3], 9.0),
        ],
    ));
    let by = transfer(&[knot(0.2, [0.0; 3], 0.0), knot(0.9, [0.0; 3], 6.0)]);
    by_other.volumes[0].opacity = Some(Opacity { field: "g".into(), transfer: by.clone() });
    let [f, g] = [0, 1].map(|volume: usize| two.volumes[volume].transfer.clone());
    let frame = draw_near((&data, &two), [4e-3, 3e-4], "two fields", |sample| {
        mixed(&[f.at(sample.values[0]), g.at(sample.values[1])], sample.length)
    });
    assert!(frame.report.error.max < 2e-4);
    draw_near((&data, &by_other), [4e-3, 3e-4], "opacity", |sample| {
        mixed(&[(f.at(sample.values[0]).0, by.at(sample.values[1]).1)], sample.length)
    });
}

#[test]
fn isosurfaces_lie_where_values_cross_and_between_volumes() {
    let data = waves(3);
    let mut scene = scene(24, "tolerance = 1e-4");
    let surfaces = [(0.3, [1.0, 0.0, 0.0]), (-0.4, [0.0, 1.0, 0.0])];
    let surface = |(value, color)| Isosurface { field: "g".into(), value, paint: Paint::Plain(color), opacity: 0.6 };
    scene.scenery.isosurfaces = surfaces.map(surface).into();
    let frame = data.draw(&scene);
    let f = scene.volumes[0].transfer.clone();
    let expected = by_steps(&data, &scene, |sample| {
        let (mut color, mut opacity) = mixed(&[f.at(sample.values[0])], sample.length);
        for (value, paint) in surfaces {
            let crosses = sample.before.is_some_and(|b| (b[1] >= value) != (sample.values[1] >= value));
            if crosses {
                // The surface lies in front of the step.
                let whole = 0.6 + 0.4 * opacity;
                color = [0, 1, 2].map(|k| (0.6 * paint[k] + 0.4 * opacity * color[k]) / whole);
                opacity = whole;
            }
        }
        (color, opacity)
    });
    // Steps miss two crossings between two of their middles.
    let off = distances(&frame, &expected);
    let wrong = off.iter().filter(|off| **off > 5e-3).count();
    assert!(wrong <= 3, "{wrong} of {} pixels: {off:?}", off.len());
    assert_eq!(frame.report.error.certainty, Certainty::Bound);
    scene.volumes.push(volume_beyond());
    assert_eq!(data.draw(&scene).report.error.certainty, Certainty::Estimate, "two volumes");
}

#[test]
fn cuts_remove_their_region() {
    let data = waves(3);
    let none = Clip { cuts_inside: true, region: None, layers: None, height_m: None, half_space: None };
    let region = LonLatBox { lon_deg: [-10.0, 60.0], lat_deg: [0.0, 70.0] };
    let clips = [
        Clip { region: Some(region), ..none.clone() },
        Clip { cuts_inside: false, region: Some(region), ..none.clone() },
        Clip { layers: Some([2, 5]), ..none.clone() },
        Clip { cuts_inside: false, height_m: Some([0.03, 0.09]), ..none.clone() },
        Clip { half_space: Some(HalfSpace { towards_deg: [40.0, 20.0], distance: 0.4 }), ..none },
    ];
    for clip in clips {
        let mut scene = scene(24, "tolerance = 1e-4");
        scene.scenery.clips = vec![clip.clone()];
        let f = scene.volumes[0].transfer.clone();
        draw_near((&data, &scene), [8e-3, 4e-4], &format!("{clip:?}"), |sample| {
            let p = sample.position;
            let (lon, lat) = (p.y.atan2(p.x).to_degrees(), (p.z / p.length()).asin().to_degrees());
            let within = |x: f64, [low, high]: [f64; 2]| x >= low && x <= high;
            let inside = clip.region.is_none_or(|r| within(lon, r.lon_deg) && within(lat, r.lat_deg))
                && clip.layers.is_none_or(|[a, b]| sample.layer >= a && sample.layer < b)
                && clip.height_m.is_none_or(|h| within(p.length() - 1.0, h))
                && clip.half_space.is_none_or(|half| {
                    let [lon, lat] = half.towards_deg;
                    towards(lon, lat).dot(p) > half.distance
                });
            if inside == clip.cuts_inside {
                return ([0.0; 3], 0.0);
            }
            mixed(&[f.at(sample.values[0])], sample.length)
        });
    }
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
