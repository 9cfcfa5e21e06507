//! ICON-O's mask of water.

use crate::made::{Made, RECORDS, Values};
use crate::made_icon::{Angles, LAYERS};
use crate::memory::{expect, open, opened, opened_with, values};
use icoray::{CenterField, ErrorKind};
use icoray_dataset::{Dataset, DatasetOptions};

/// Whether a triangle's layer is water: every fourth triangle is land, every third is shallow.
fn is_wet(triangle: usize, layer: usize) -> bool {
    !triangle.is_multiple_of(4) && (layer == 0 || !triangle.is_multiple_of(3))
}

/// Temperatures of 20 in water and 0 on land, as ICON-O writes them, and 2D and interface fields.
fn sea() -> Made {
    let mut made = Made::icon_data(Angles::Radians);
    made.remove("ta");
    made.dimensions.push(("lev_2", LAYERS + 1));
    let of = |layers: usize| {
        let places = (0..RECORDS * layers).flat_map(|i| (0..80).map(move |t| (i % layers, t)));
        places.map(|(l, t)| if is_wet(t, l.min(LAYERS - 1)) { 20.0 } else { 0.0 }).collect::<Vec<f32>>()
    };
    made.add("to", &["time", "lev", "ncells"], Values::F32(of(LAYERS)));
    made.add("w", &["time", "lev_2", "ncells"], Values::F32(of(LAYERS + 1)));
    made.add("zos", &["time", "ncells"], Values::F32(of(1)));
    let wet = (0..LAYERS).flat_map(|l| (0..80).map(move |t| f32::from(u8::from(is_wet(t, l)))));
    made.add("wet_c", &["lev", "ncells"], Values::F32(wet.collect()));
    made
}

#[test]
fn a_layer_that_is_picked_has_its_land() {
    let options = DatasetOptions { at: vec![("lev".into(), 1)], ..DatasetOptions::default() };
    let field = values(&opened_with(&sea(), &[], options).unwrap(), "to", 1);
    assert!((0..80).all(|triangle| field(triangle, 0).is_finite() == is_wet(triangle, 1)));
}

#[test]
fn land_is_missing() {
    let file = open(&sea());
    for (name, layers) in [("to", LAYERS), ("w", LAYERS + 1), ("zos", 2)] {
        let owned = file.read_field(name, 1).unwrap();
        let field = owned.field().unwrap();
        assert_eq!(field.shape().layers, layers, "{name}");
        for (triangle, layer) in (0..80).flat_map(|t| (0..layers).map(move |l| (t, l))) {
            let expected = match name {
                "to" => is_wet(triangle, layer),
                "w" => (layer.saturating_sub(1)..=layer.min(LAYERS - 1)).any(|l| is_wet(triangle, l)),
                _ => is_wet(triangle, 0),
            };
            assert_eq!(!field.value(triangle, layer).is_nan(), expected, "{name} {triangle} {layer}");
        }
    }
    // Some layers have their own water.
    let owned = file.read_layers("to", 0, 1..3).unwrap();
    for triangle in 0..80 {
        assert_eq!(!owned.field().unwrap().value(triangle, 0).is_nan(), is_wet(triangle, 1));
    }
}

/// A coast has the temperature of the water beside it, not a mean with the zeros of the land.
#[test]
fn coasts_are_as_warm_as_their_water() {
    let file = open(&sea());
    let grid = file.mesh().grid().unwrap();
    let owned = file.read_field("to", 0).unwrap();
    let average = CenterField::average(&grid, &owned.field().unwrap()).unwrap();
    let (range, missing) = average.field().range();
    assert!(range == Some([20.0, 20.0]) && missing < 42 * LAYERS as u64, "{range:?} {missing}");
}

#[test]
fn the_mask_may_be_in_another_file_and_must_fit() {
    let mut data = sea();
    let wet = data.variable("wet_c").clone();
    data.remove("wet_c");
    let mut mask = Made { attributes: Vec::new(), variables: vec![wet], ..data.clone() };
    mask.dimensions.retain(|(name, _)| *name != "time");
    let missing = |file: Dataset| file.read_field("to", 0).unwrap().field().unwrap().range().1;
    assert_eq!(missing(open(&data)), 0);
    assert!(missing(opened(&data, &[&mask]).unwrap()) > 60);
    let mut data = sea();
    data.variable("wet_c").dimensions = vec!["lev"];
    data.variable("wet_c").values = Values::F32(vec![1.0; LAYERS]);
    let error = open(&data).read_field("to", 0).unwrap_err();
    expect(&error, ErrorKind::Field, &["wet_c(lev = 3)", "expected wet_c over layers and 80 triangles"]);
}
