//! Knots against the map that they stand for.

use super::*;

/// A step of 8 bits, in linear light and of the largest extinction, and a little for how it is measured.
const BOUND: f64 = 1.02 / 255.0;

fn coloring(name: &str, scale: Scale, extinction: &[Stop]) -> Coloring {
    Coloring {
        map: ColorMap::named(name).unwrap(),
        name: name.into(),
        scale,
        range: ColorRange::Fixed([0.0, 1.0]),
        center: None,
        extinction: extinction.to_vec(),
        is_relative: false,
        unit_length: None,
    }
}

#[test]
fn map_and_opacity_knots_are_merged_and_the_unseen_left_out() {
    let coloring = coloring("viridis", Scale::Linear, &[(8.0, 0.0), (10.0, 1.0), (12.5, 0.0)]);
    let tf = coloring.transfer([0.0, 32.0]);
    let values: Vec<f64> = tf.knots.iter().map(|k| k.value).collect();
    let stops = coloring.map.places().map(|place| 32.0 * place).filter(|value| (8.0..12.5).contains(value));
    let mut expected: Vec<f64> = stops.chain([8.0, 10.0, 12.5]).collect();
    expected.sort_by(f64::total_cmp);
    assert!(expected.len() > 3 && values == expected, "{values:?}, {expected:?}");
    for knot in &tf.knots {
        let extinction = if knot.value <= 10.0 { (knot.value - 8.0) / 2.0 } else { (12.5 - knot.value) / 2.5 };
        assert!((knot.extinction - extinction).abs() < 1e-12, "{knot:?}");
        assert_eq!(knot.color, coloring.map.at(knot.value / 32.0));
    }
}

#[test]
fn opaque_ends_keep_the_map_beyond_the_opacity_knots() {
    let coloring = Coloring { unit_length: Some(2.0), ..coloring("greys_r", Scale::Linear, &[(16.0, 1.0)]) };
    let tf = coloring.transfer([0.0, 32.0]);
    let stops = coloring.map.places().filter(|place| *place != 0.5).count();
    assert_eq!((tf.knots.len(), tf.range()), (stops + 1, [0.0, 32.0]));
    assert_eq!(tf.knots[3].extinction / tf.unit_length.unwrap(), 0.5);
    assert_eq!(tf.knots[0].color, ColorMap::named("greys").unwrap().at(1.0));
}

#[test]
fn opacities_may_be_parts_of_the_range() {
    let relative = Coloring { is_relative: true, ..coloring("greys", Scale::Log, &[(0.0, 0.0), (0.5, 1.0)]) };
    let tf = relative.transfer([1e-4, 1.0]);
    let full = tf.knots.iter().find(|k| k.extinction == 1.0).unwrap();
    assert!((full.value - 1e-2).abs() < 1e-12, "{full:?}");
}

/// Colour and extinction of the knots against the map along the scale, at many values.
#[test]
fn knots_keep_to_every_scale_and_are_few() {
    let log = [1e-9, 3.0];
    let signed = [-2e-3, 5e-2];
    let symlog = Scale::SymLog { threshold: 1e-5 };
    for (name, scale, range, stops, max_knots) in [
        ("viridis", Scale::Log, log, [(1e-9, 0.0), (1e-2, 3.0)], 110),
        ("thermal", Scale::Log, log, [(1e-9, 0.5), (1e-2, 3.0)], 110),
        ("rdbu", symlog, signed, [(-2e-3, 3.0), (5e-2, 0.1)], 160),
        ("vik", symlog, signed, [(-2e-3, 3.0), (5e-2, 0.1)], 160),
        ("oleron", Scale::Linear, signed, [(-2e-3, 3.0), (5e-2, 0.1)], 33),
    ] {
        let coloring = coloring(name, scale, &stops);
        let tf = coloring.transfer(range);
        assert!(tf.knots.len() <= max_knots, "{name}, {scale:?}: {} knots", tf.knots.len());
        assert!(tf.knots.is_sorted_by(|a, b| a.value < b.value));
        let [low, high] = range.map(|v| scale.forward(v));
        for part in (0..=5000).map(|i| f64::from(i) / 5000.0) {
            let at = low + (high - low) * part;
            let (color, extinction) = tf.at(scale.backward(at));
            let expected = coloring.map.at(part);
            let deviation = (0..3).map(|k| (color[k] - expected[k]).abs()).fold(0.0, f64::max);
            assert!(deviation < BOUND, "{name}, {scale:?} at {part}: {deviation}");
            let [(from, less), (to, more)] = stops.map(|(v, e)| (scale.forward(v), e));
            let expected = less + (more - less) * ((at - from) / (to - from)).clamp(0.0, 1.0);
            assert!((extinction - expected).abs() < BOUND * 3.0, "{name} at {part}: {extinction}, {expected}");
        }
    }
}

/// A map's stop that lies on a stop of opacity but for rounding would be a step to the kernel.
#[test]
fn no_two_knots_all_but_coincide() {
    let symlog = Scale::SymLog { threshold: 1e-4 };
    for (scale, range) in [(Scale::Linear, [-0.7e-3, 0.7e-3]), (Scale::Log, [3e-9, 0.7]), (symlog, [-5e-3, 5e-3])] {
        for name in ["vik", "viridis", "thermal"] {
            let map = ColorMap::named(name).unwrap();
            let [low, high] = range.map(|end| scale.forward(end));
            let value = |place: f64| scale.backward(low + (high - low) * place) * (1.0 + 3e-15);
            let stops: Vec<Stop> = map.places().map(|place| (value(place), place + 0.1)).collect();
            let tf = coloring(name, scale, &stops).transfer(range);
            let places: Vec<f64> = tf.knots.iter().map(|k| scale.forward(k.value)).collect();
            let apart = 1e-6 * (places[places.len() - 1] - places[0]);
            assert!(places.windows(2).all(|pair| pair[1] - pair[0] > apart), "{name} {scale:?}: {places:?}");
        }
    }
}

#[test]
fn a_centre_makes_ranges_even() {
    let about = |center, scale, ends| Coloring { center, ..coloring("vik", scale, &[(0.0, 1.0)]) }.about_center(ends);
    assert_eq!(about(None, Scale::Linear, [1.0, 5.0]), [1.0, 5.0]);
    assert_eq!(about(Some(0.0), Scale::Linear, [-7e-5, 1.2e-4]), [-1.2e-4, 1.2e-4]);
    assert_eq!(about(Some(273.15), Scale::Linear, [223.15, 283.15]), [223.15, 323.15]);
    // All of the values on one side of it.
    assert_eq!(about(Some(0.0), Scale::Linear, [2.0, 5.0]), [-5.0, 5.0]);
    let [low, high] = about(Some(1.0), Scale::Log, [0.5, 100.0]);
    assert!((low - 0.01).abs() < 1e-12 && high == 100.0);
    assert_eq!(
        Coloring { center: Some(0.0), ..coloring("vik", Scale::Linear, &[(0.0, 1.0)]) }.fixed(),
        Some([-1.0, 1.0])
    );
}

#[test]
fn places_lead_back_to_values_and_rise_with_them() {
    let values = [-2e5, -1.0, -1e-3, -2e-4, 0.0, 3e-9, 5e-4, 1e-3, 0.7, 1.0, 4e7];
    for scale in [Scale::Linear, Scale::Log, Scale::SymLog { threshold: 1e-3 }] {
        let admitted: Vec<f64> = values.into_iter().filter(|v| scale.admits(*v)).collect();
        let places: Vec<f64> = admitted.iter().map(|v| scale.forward(*v)).collect();
        assert!(places.is_sorted_by(|a, b| a < b), "{scale:?}: {places:?}");
        for (value, place) in admitted.iter().zip(places) {
            assert!((scale.backward(place) - value).abs() <= 1e-13 * value.abs(), "{scale:?}: {value}");
        }
    }
    assert_eq!(Scale::SymLog { threshold: 0.1 }.forward(-10.0), -3.0);
    assert!(!Scale::Log.admits(0.0) && !Scale::Linear.admits(f64::NAN));
}
