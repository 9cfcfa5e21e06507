//! Scenes of several fields in every mode of the renderer.

use super::*;
use icoray::{Certainty, Lights, Method, Precision, Savings};

struct World {
    grid: Grid<'static>,
    steps: [Arrays; 2],
}

impl World {
    fn new() -> Self {
        let (mesh, grid) = icosahedral(3);
        World { grid, steps: steps(mesh, Location::Corner) }
    }

    fn draw(&self, renderer: Renderer, scene: &Scene) -> Frame {
        draw(&renderer, &self.grid, scene, &self.steps)
    }
}

fn renderer() -> Renderer {
    Renderer::new(2).unwrap()
}

#[test]
fn threads_change_no_bit() {
    let world = World::new();
    for (name, scene) in scenes() {
        let [one, two, four] = [1, 2, 4].map(|threads| world.draw(Renderer::new(threads).unwrap(), &scene));
        assert!(bits(&one) == bits(&two) && bits(&one) == bits(&four), "{name}");
    }
}

/// Packets are in single precision; with several volumes `paper` is not supported and listed among what is left out.
#[test]
fn precision_is_the_requested_one_and_paper_is_for_one_volume() {
    let world = World::new();
    let scene = scene(FAR, "", LIT);
    let expected = world.draw(renderer(), &scene);
    assert_eq!(expected.report.error.certainty, Certainty::Estimate);
    let single = world.draw(renderer(), &Scene { precision: Precision::F32, ..scene.clone() });
    assert!(bits(&single) != bits(&expected));
    assert_eq!(count_beyond(&single, &expected, 0.0), 0);
    assert_eq!(single.report.left_out, expected.report.left_out);
    let paper = world.draw(renderer(), &Scene { method: Method::Paper, ..scene });
    assert!(bits(&paper) == bits(&expected));
    let mut left_out = expected.report.left_out;
    left_out.push("method \"paper\", which supports a single volume only".into());
    assert_eq!(paper.report.left_out, left_out);
}

#[test]
fn a_time_budget_is_kept_and_one_that_is_large_changes_nothing() {
    let world = World::new();
    let mut scene = scene(NEAR, "", LIT);
    let asked = world.draw(renderer(), &scene);
    scene.time_budget_ms = Some(1e7);
    let unhurried = world.draw(renderer(), &scene);
    assert!(bits(&unhurried) == bits(&asked));
    assert_eq!(unhurried.report.quality, asked.report.quality);
    scene.time_budget_ms = Some(1e-3);
    let hurried = world.draw(renderer(), &scene);
    let quality = hurried.report.quality;
    assert!(quality.lights == Lights::Off && quality.pixel_step == 32 && quality.tolerance >= 1e-2);
    // As far as gradients go: none were made for it. Of each cell there is a byte that says whether they are computed.
    let cells = world.grid.cells();
    assert_eq!(hurried.report.bytes_derived, asked.report.bytes_derived - 3 * cells * (LAYERS * 12 + 1));
    let off = hurried.pixels.iter().zip(&asked.pixels).map(|(a, b)| (a[3] - b[3]).abs());
    assert!(off.fold(0.0, f32::max) < 0.5, "opaque where the globe is, clear where it is not");
}

#[test]
fn savings_change_nothing_beyond_errors() {
    let world = World::new();
    for (name, scene) in scenes() {
        let all = world.draw(renderer(), &scene);
        let none = Savings { ends: true, ..Savings::NONE };
        assert!(bits(&world.draw(renderer().with_savings(none), &scene)) == bits(&all), "{name}");
        let none = world.draw(renderer().with_savings(Savings::NONE), &scene);
        assert_eq!(count_beyond(&none, &all, 0.0), 0, "{name}: {:e} at most", difference(&none, &all));
    }
}

/// Of the same fields everything is the same the second time, whether or not it is made anew, and after other pictures.
#[test]
fn cached_fields_change_no_bit() {
    let world = World::new();
    let renderer = renderer();
    let all = scenes();
    let fresh: Vec<Frame> = all
        .iter()
        .map(|(_, scene)| {
            Renderer::new(1).unwrap().render(scene, &world.grid, &layers(), fields(&world.steps[1])).unwrap()
        })
        .collect();
    // One borrow of each field for all frames.
    let fields = fields(&world.steps[1]);
    for _ in 0..2 {
        for ((name, scene), expected) in all.iter().zip(&fresh) {
            let frame = renderer.render(scene, &world.grid, &layers(), fields.clone()).unwrap();
            assert!(bits(&frame) == bits(expected), "{name}");
            assert_eq!(frame.report.bytes_derived, expected.report.bytes_derived, "{name}");
        }
    }
}

/// Bytes of what was made are those of the averages, of the fields on other layers, of visible blocks, and of gradients
/// of what is lit.
#[test]
fn derived_bytes_are_counted() {
    let world = World::new();
    let values = world.grid.cells() * LAYERS;
    let interfaces = world.grid.cells() * INTERFACES;
    // f and h are averaged, g and h moved.
    let made = 4 * values + 4 * interfaces + 8 * values + 4 * values;
    let draw = |tables| {
        let mut scene = scene(FAR, "", tables);
        // Else all blocks are visible.
        let knots = scene.volumes[0].transfer.knots.iter_mut().filter(|knot| knot.value < 0.5);
        knots.for_each(|knot| knot.extinction = 0.0);
        world.draw(renderer(), &scene)
    };
    let (unlit, lit) = (draw(""), draw(LIT));
    let blocks = unlit.report.bytes_derived - made;
    assert!((4..32).contains(&(blocks / world.grid.cells())), "{blocks}");
    assert_eq!(lit.report.bytes_derived, made + blocks + 3 * (12 * values + world.grid.cells()));
}

/// A scene of one field looks at no other, nor at heights: those that would be refused change nothing.
#[test]
fn a_plain_scene_looks_at_one_field_alone() {
    let world = World::new();
    let mut scene = scene(FAR, "", LIT);
    scene.volumes.truncate(1);
    scene.scenery = icoray::Scenery::default();
    let fields = fields(&world.steps[0]);
    let f = *fields.get("f").unwrap();
    let wrong = at_centers(&[f64::NAN; 3], 3);
    let alone = renderer().render(&scene, &world.grid, &layers(), &f).unwrap();
    let draw = |scene: &Scene| {
        let all = Fields::new([("f", f), ("g", wrong), ("h", wrong)]).with_heights(wrong);
        renderer().render(scene, &world.grid, &layers(), all)
    };
    let among = draw(&scene).unwrap();
    assert!(bits(&among) == bits(&alone));
    assert_eq!(among.report.bytes_derived, alone.report.bytes_derived);
    for what in ["other fields", "derived fields", "surfaces", "lines", "table of coasts", "clips", "native heights"] {
        assert!(among.report.left_out.iter().any(|left| left == what), "{what}");
    }
    // What is derived and not shown is not made either.
    scene.scenery.derived =
        vec![Derivation { name: "unused".into(), how: How::Magnitude(vec!["g".into(), "h".into()]) }];
    assert!(bits(&draw(&scene).unwrap()) == bits(&alone));
    // They are looked at where they are shown.
    scene.scenery.heights = Heights::Native;
    assert!(draw(&scene).unwrap_err().to_string().contains("heights: 1 columns of 3 layers"));
    scene.scenery.heights = Heights::Mean;
    scene.volumes.push(Volume { field: "g".into(), transfer: warm(), coloring: None, opacity: None });
    assert!(draw(&scene).unwrap_err().to_string().contains("\"g\": 1 columns"));
}
