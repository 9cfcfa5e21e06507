//! Ranges of made fields: alone, over parts, and from frame to frame.

use super::*;
use crate::common::{icosahedral, on_ranks};
use crate::ranks::Part;
use icoray_grid::{Location, Shape};
use icoray_test_support::Random;

fn scene(range: &str, more: &str) -> Scene {
    let text = format!(
        "field = \"q\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nrange = {range}\n\
         opacity = [[0, 0.0], [1, 0.5]]\n{more}"
    );
    Scene::parse(&text).unwrap()
}

/// The range that a frame of these values is drawn over.
fn settled(ranges: &Ranges, scene: &Scene, values: &[f64]) -> [f64; 2] {
    let threads = Threads::new(2).unwrap();
    let shape = Shape::level_fastest(values.len() / 4, 4);
    let field = Field::new(values.into(), shape, Location::Center, Some(-9e33)).unwrap();
    let values = FieldValues { threads: &threads, field: &field, counted: CountedColumns::default() };
    let settled = ranges.resolve(&mut Ranks::alone(), scene, &|_| values).unwrap().unwrap();
    settled.volumes[0].coloring.as_ref().unwrap().fixed().unwrap()
}

/// Each map follows the values of its own field, and equal colourings are computed once.
#[test]
fn each_map_of_a_scene_has_the_range_of_its_field() {
    let surface = |field: &str, range: &str| {
        format!("[[surfaces]]\nlayer = 0\nfield = \"{field}\"\ntransfer = {{ range = {range} }}\n")
    };
    let follows = "{ union = [0, 100], hysteresis = 1 }";
    let more = [surface("w", follows), surface("w", "[5, 6]"), surface("v", follows), surface("w", follows)];
    let isosurface = "[[isosurfaces]]\nfield = \"q\"\nvalue = 0\ncolor_by = \"q\"\ntransfer = { range = { percentile = [0, 100] } }\n";
    let scene = scene(follows, &(more.concat() + isosurface));
    let threads = Threads::new(1).unwrap();
    let (ranges, shape) = (Ranges::default(), Shape::level_fastest(1, 2));
    let settled = |times: f64| {
        let arrays = ["q", "w", "v"].map(|name| match name {
            "q" => [1.0 * times, 2.0 * times],
            "w" => [10.0 * times, 20.0 * times],
            _ => [f64::NAN; 2],
        });
        let fields = arrays
            .each_ref()
            .map(|values| Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap());
        let asked = std::cell::RefCell::new(Vec::new());
        let values = |name: &str| {
            asked.borrow_mut().push(name.to_owned());
            let field = &fields[["q", "w", "v"].iter().position(|known| *known == name).unwrap()];
            FieldValues { threads: &threads, field, counted: CountedColumns::default() }
        };
        let settled = ranges.resolve(&mut Ranks::alone(), &scene, &values).unwrap().unwrap();
        let found: Vec<_> = settled.paintings().iter().map(|p| p.coloring.unwrap().fixed().unwrap()).collect();
        for painting in settled.paintings() {
            assert_eq!(
                painting.transfer,
                &painting.coloring.unwrap().transfer(painting.coloring.unwrap().fixed().unwrap())
            );
        }
        (found, asked.into_inner())
    };
    let none = [0.0, 1.0];
    let (found, asked) = settled(1.0);
    assert_eq!(found, [[1.0, 2.0], [10.0, 20.0], [5.0, 6.0], none, [10.0, 20.0], [1.0, 2.0]]);
    assert_eq!(asked, ["q", "w", "v", "q"]);
    // Unions go on, as if each were alone; the percentiles of the first frame stay.
    let (found, asked) = settled(2.0);
    assert_eq!(found, [[1.0, 5.0], [10.0, 50.0], [5.0, 6.0], none, [10.0, 50.0], [1.0, 2.0]]);
    assert_eq!(asked, ["q", "w", "v"]);
}

fn close(found: [f64; 2], expected: [f64; 2]) {
    let width = expected[1] - expected[0];
    let off = (0..2).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
    assert!(off < 1e-6 * width, "{found:?}, expected {expected:?}");
}

/// Each whole number from 0 to 9999 times `scale`, in no order, with values that are missing among them.
fn even(scale: f64) -> Vec<f64> {
    let mut values: Vec<f64> = (0..10_000).map(|i| scale * f64::from(i * 7919 % 10_000)).collect();
    values.extend([f64::NAN, f64::INFINITY, -9e33, -9e33]);
    values
}

#[test]
fn percentiles_are_those_of_the_first_frame_that_has_values() {
    let wider = scene("{ percentile = [1, 99] }", "");
    let (ranges, scene) = (Ranges::default(), scene("{ percentile = [1, 98] }", ""));
    assert_eq!(settled(&ranges, &scene, &[f64::NAN; 8]), [0.0, 1.0]);
    // One value is no range; nor is it kept.
    close(settled(&ranges, &scene, &[4.0; 8]), [3.8, 4.2]);
    close(settled(&ranges, &scene, &even(1.0)), [100.0, 9799.0]);
    close(settled(&ranges, &scene, &even(3.0)), [100.0, 9799.0]);
    close(settled(&ranges, &wider, &even(3.0)), [300.0, 29_697.0]);
    close(settled(&Ranges::default(), &scene, &even(3.0)), [300.0, 29_397.0]);
}

#[test]
fn the_ends_of_all_values_are_exact_and_mostly_equal_ones_fall_back_to_them() {
    let whole = scene("{ percentile = [0, 100] }", "");
    assert_eq!(settled(&Ranges::default(), &whole, &even(0.3)), [0.0, 0.3 * 9999.0]);
    let mut mostly = vec![0.0; 1000];
    mostly[17] = 5.0;
    assert_eq!(settled(&Ranges::default(), &scene("{ percentile = [1, 99] }", ""), &mostly), [0.0, 5.0]);
}

#[test]
fn logarithms_see_positive_values_only() {
    let log = scene("{ percentile = [10, 100] }", "scale = \"log\"");
    let values: Vec<f64> =
        (0..4000).map(|i| 10f64.powf(f64::from(i) / 400.0 - 9.0)).chain([0.0, -5.0, -5.0, 0.0]).collect();
    let [low, high] = settled(&Ranges::default(), &log, &values);
    assert!((low.log10() + 8.0).abs() < 0.01 && high == values[3999], "{low} {high}");
    assert_eq!(settled(&Ranges::default(), &log, &[-1.0; 8]), [1.0, 10.0]);
}

#[test]
fn a_union_moves_seldom_and_never_back() {
    let ranges = Ranges::default();
    let scene = scene("{ union = [0, 100], hysteresis = 0.25 }", "");
    let frame = |low: f64, high: f64| settled(&ranges, &scene, &[low, high, low, high]);
    assert_eq!(frame(0.0, 4.0), [0.0, 4.0]);
    assert_eq!(frame(1.0, 2.0), [0.0, 4.0]);
    // Within a quarter of the range nothing moves.
    assert_eq!(frame(-1.0, 5.0), [0.0, 4.0]);
    assert_eq!(frame(-1.5, 5.0), [-2.5, 4.0]);
    assert_eq!(frame(-1.5, 9.0), [-2.5, 10.625]);
    assert_eq!(frame(-2.6, 9.0), [-2.5, 10.625]);
}

/// For any frames, a frame exceeds the range by at most the hysteresis, and no end ever moves back.
#[test]
fn unions_hold_all_frames() {
    let hysteresis = 0.1;
    let mut random = Random::new(7);
    let mut known = [0.0, 1.0];
    for step in 0..1000 {
        let middle = (f64::from(step) / 50.0) * (random.unit() - 0.5);
        let seen = [middle - random.unit(), middle + random.unit()];
        let next = widened(Scale::Linear, known, seen, hysteresis);
        assert!(next[0] <= known[0] && next[1] >= known[1], "{known:?} {seen:?} {next:?}");
        let slack = hysteresis * (next[1] - next[0]);
        assert!(seen[0] >= next[0] - slack && seen[1] <= next[1] + slack, "{known:?} {seen:?} {next:?}");
        known = next;
    }
}

#[test]
fn a_centre_stays_in_the_middle_and_views_share_a_range() {
    let ranges = Ranges::default();
    let first = scene("{ union = [0, 100] }", "center = 0");
    assert_eq!(settled(&ranges, &first, &[-1.0, 3.0, 0.0, 0.0]), [-3.0, 3.0]);
    let mut other = first.clone();
    other.width = 77;
    assert_eq!(settled(&ranges, &other, &[-1.0, 2.0, 0.0, 0.0]), [-3.0, 3.0]);
    other.volumes[0].field = "another".into();
    assert_eq!(settled(&ranges, &other, &[-1.0, 2.0, 0.0, 0.0]), [-2.0, 2.0]);
}

#[test]
fn a_scene_with_a_range_of_its_own_is_not_touched() {
    let threads = Threads::new(1).unwrap();
    let field = Field::level_fastest(&[1.0f64; 4][..], 4, Location::Center).unwrap();
    let values = FieldValues { threads: &threads, field: &field, counted: CountedColumns::default() };
    for more in ["", "scale = \"symlog\"\nthreshold = 0.1", "center = 0"] {
        let scene = scene("[0, 1]", more);
        assert_eq!(Ranges::default().resolve(&mut Ranks::alone(), &scene, &|_| values).unwrap(), None);
    }
}

/// Parts of a grid on several ranks find, to the last bit, the range that one process finds.
#[test]
fn parts_find_the_range_of_the_whole() {
    let (_, grid) = icosahedral(3);
    let values: Vec<f64> = (0..grid.cells() * 2).map(|i| ((i * 7919) % 3001) as f64).collect();
    let field = Field::level_fastest(&values, 2, Location::Center).unwrap();
    let scene = scene("{ percentile = [2, 97] }", "");
    let alone = Threads::new(2).unwrap();
    let whole = FieldValues { threads: &alone, field: &field, counted: CountedColumns::default() };
    let expected = Ranges::default().resolve(&mut Ranks::alone(), &scene, &|_| whole).unwrap();
    let found = on_ranks(3, |ranks| {
        let part = Part::of_whole(ranks, &grid).unwrap();
        let threads = Threads::new(1).unwrap();
        let values = FieldValues { threads: &threads, field: &field, counted: CountedColumns::new(Some(&part), None) };
        Ranges::default().resolve(ranks, &scene, &|_| values).unwrap()
    });
    assert!(found.iter().all(|scene| *scene == expected), "{found:?}");
}
