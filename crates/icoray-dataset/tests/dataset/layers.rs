//! Dimensions beside columns and time, the heights of layers, and marks of missing and invalid values.

use crate::made::{Made, RECORDS, Values, value};
use crate::made_icon::{Angles, LAYERS};
use crate::memory::{expect, open, opened_with, values};
use icoray::ErrorKind;
use icoray_dataset::{AssumedMark, Dataset, DatasetOptions, LayerSelection, SceneFields};

/// `ta` over triangles with `members` of an ensemble between times and layers; those behind the first have values of
/// time 0 less 1000.
fn ensemble(members: usize) -> Made {
    let mut made = Made::icon_data(Angles::Degrees);
    made.dimensions.push(("member", members));
    let ta = made.variable("ta");
    ta.dimensions = vec!["time", "member", "lev", "ncells"];
    let places = (0..RECORDS * members * LAYERS).flat_map(|i| (0..80).map(move |c| (i, c)));
    let values = places.map(|(i, c)| match i / LAYERS % members {
        0 => value(i / LAYERS / members, c, i % LAYERS) as f32,
        _ => value(0, c, i % LAYERS) as f32 - 1000.0,
    });
    ta.values = Values::F32(values.collect());
    made
}

fn at(name: &str, entry: usize) -> DatasetOptions {
    DatasetOptions { at: vec![(name.to_owned(), entry)], ..DatasetOptions::default() }
}

fn notes(file: &Dataset, field: &str) -> String {
    let (all, text) = (LayerSelection::default(), format!("field = '{field}'\ntransfer = {{ map = 'magma' }}"));
    let script = icoray::Script::parse(&text).unwrap();
    SceneFields::new(file, &script, &all).unwrap().all_notes(&script).unwrap().join("; ")
}

#[test]
fn a_dimension_of_one_entry_is_none_and_an_entry_of_others_is_picked() {
    let read = |file: &Dataset| values(file, "ta", 2)(7, 1);
    assert_eq!(read(&open(&ensemble(1))), value(2, 7, 1));
    expect(
        &open(&ensemble(2)).field_info("ta").unwrap_err(),
        ErrorKind::Field,
        &["member = 2", "80 triangles or their 42 points", "`at` picks an entry"],
    );
    let picked = |entry| opened_with(&ensemble(2), &[], at("member", entry));
    assert_eq!(read(&picked(0).unwrap()), value(2, 7, 1));
    assert_eq!(read(&picked(1).unwrap()), value(0, 7, 1) - 1000.0);
    expect(&picked(2).unwrap_err(), ErrorKind::Argument, &["at member=2", "has 2 entries, expected one below 2"]);
    let error = opened_with(&ensemble(2), &[], at("mebmer", 0)).unwrap_err();
    expect(&error, ErrorKind::Argument, &["at mebmer=0: no file has a dimension mebmer"]);
    // One layer of a field is a 2D field.
    let file = opened_with(&ensemble(1), &[], at("lev", 2)).unwrap();
    assert!(file.field_info("ta").unwrap().is_2d() && read(&file) == value(2, 7, 2));
}

#[test]
fn layers_of_mpas_have_any_name_and_their_own_heights() {
    let mut made = Made::history();
    made.dimensions.extend([("nIsoLevelsT", 2), ("nSoilLevels", 2), ("nCategories", 2), ("ONE", 1)]);
    let numbers = Values::F64((0..84).map(f64::from).collect());
    made.add("t_isobaric", &["nCells", "nIsoLevelsT"], numbers.clone());
    made.add("tslb", &["nCells", "nSoilLevels"], numbers.clone());
    made.add("ice", &["nCells", "nCategories", "ONE"], numbers.clone());
    made.add("weights", &["nCells", "maxEdges"], Values::F64(vec![1.0; 42 * 6]));
    made.add("t_iso_levels", &["nIsoLevelsT"], Values::F64(vec![850.0, 500.0]));
    made.last().attributes = vec![("units", "hPa".into())];
    made.add("zs", &["nCells", "nSoilLevels"], Values::F64((0..84).map(|i| [0.1, 0.4][i % 2]).collect()));
    let file = open(&made);
    assert!(file.field_info("weights").is_err(), "a table of the mesh");
    let heights = file.layer_heights("t_isobaric").unwrap();
    assert!(heights.is_of_pressure && (heights.height_m[1] - 5574.4).abs() < 6.0, "{heights:?}");
    assert_eq!(file.layer_heights("tslb").unwrap().height_m, [-0.1, -0.4]);
    assert_eq!(file.find_native_info("tslb").unwrap(), None, "zgrid has none of the soil");
    assert_eq!(values(&file, "ice", 0)(3, 1), 7.0);
    let error = file.layer_heights("ice").unwrap_err();
    expect(&error, ErrorKind::Layers, &["2 layers of ice", "coordinate nCategories", "`heights` says"]);
    // What lies below the sea floor is that of the water alone.
    made.add("maxLevelCell", &["nCells"], Values::I32(vec![1; 42]));
    assert_eq!(values(&open(&made), "ice", 0)(3, 1), 7.0);
}

/// Heights of the layers of `ta`, where `edit` has changed the file.
fn heights(edit: impl Fn(&mut Made)) -> icoray_dataset::LayerHeights {
    let mut made = Made::icon_data(Angles::Degrees);
    edit(&mut made);
    open(&made).layer_heights("ta").unwrap()
}

#[test]
fn depths_are_in_any_unit_of_length() {
    for (unit, scale) in [("cm", 0.01), ("mm", 0.001), ("m", 1.0), ("km", 1000.0)] {
        let found = heights(|made| {
            let lev = made.variable("lev");
            lev.values = Values::F64(vec![1.0, 20.0, 50.0]);
            lev.attributes = vec![("units", unit.into()), ("positive", "down".into())];
        });
        assert_eq!(found.height_m, [-1.0, -20.0, -50.0].map(|depth: f64| depth * scale), "{unit}");
        assert!(!found.is_of_pressure);
    }
}

#[test]
fn coordinates_that_count_layers_space_them_evenly() {
    for (numbers, positive, is_rising) in
        [([1.0, 2.0, 3.0], "down", false), ([3.0, 2.0, 1.0], "down", true), ([1.0, 2.0, 3.0], "up", true)]
    {
        let mut made = Made::icon_data(Angles::Degrees);
        made.variable("lev").values = Values::F64(numbers.to_vec());
        made.variable("lev").attributes = vec![("positive", positive.into())];
        let file = open(&made);
        let found = file.layer_heights("ta").unwrap();
        let [first, middle, last] = found.height_m[..] else { panic!("{found:?}") };
        assert!(found.is_counted && (first < last) == is_rising && middle == 0.5 * (first + last), "{found:?}");
        assert!(notes(&file, "ta").contains("lev only numbers the layers: shown evenly spaced"));
    }
    let mut made = Made::icon_data(Angles::Degrees);
    made.variable("lev").attributes.clear();
    expect(&open(&made).layer_heights("ta").unwrap_err(), ErrorKind::Layers, &["no heights for the 3 layers of ta"]);
}

#[test]
fn pressures_of_columns_and_of_hybrid_levels_are_heights_of_the_standard_atmosphere() {
    let pressures_pa = [100_000.0, 85_000.0, 50_000.0];
    let expected = heights(|_| ()).height_m;
    let of_columns = |made: &mut Made| {
        made.remove("lev");
        // Blocks of all triangles, layer by layer.
        made.add("pfull", &["lev", "ncells"], Values::F64(pressures_pa.map(|pa| vec![0.01 * pa; 80]).concat()));
        made.last().attributes = vec![("units", "hPa".into())];
    };
    let hybrid = |made: &mut Made, a: Vec<f64>| {
        made.variable("lev").values = Values::F64(vec![1.0, 2.0, 3.0]);
        made.variable("lev").attributes.clear();
        made.add("hyam", &["lev"], Values::F64(a));
        made.add("hybm", &["lev"], Values::F64(vec![0.9, 0.5, 0.1]));
        made.add(
            "ps",
            &["time", "ncells"],
            Values::F64([vec![90_000.0; 40], vec![110_000.0; 40], vec![0.0; 160]].concat()),
        );
    };
    // 100 kPa is the mean at the first time.
    let a = [10_000.0, 35_000.0, 40_000.0];
    for found in [
        heights(of_columns),
        heights(|made| hybrid(made, a.to_vec())),
        heights(|made| {
            hybrid(made, a.map(|a| a / 50_000.0).to_vec());
            made.add("P0", &[], Values::F64(vec![50_000.0]));
        }),
    ] {
        assert!(found.is_of_pressure && !found.is_counted);
        assert!(
            found.height_m.iter().zip(&expected).all(|(own, its)| (own - its).abs() < 1e-6),
            "{found:?} {expected:?}"
        );
    }
}

#[test]
fn options_give_heights_radius_and_marks() {
    let mut made = Made::history();
    made.f32s("theta")[9] = -999.0;
    let with = |options: DatasetOptions| opened_with(&made, &[], options);
    let options = DatasetOptions {
        heights_m: Some([0.0, -300.0]),
        radius_m: Some(1e6),
        missing: vec![-999.0],
        ..DatasetOptions::default()
    };
    let file = with(options).unwrap();
    assert_eq!(file.layer_heights("theta").unwrap().height_m, [0.0, -100.0, -200.0, -300.0]);
    assert_eq!(file.find_native_info("theta").unwrap(), None);
    assert_eq!((file.sphere_radius_m(), file.layers("theta").unwrap().planet_radius_m()), (1e6, 1e6));
    assert!(values(&file, "theta", 0)(2, 1).is_nan());
    for (options, what) in [
        (DatasetOptions { heights_m: Some([5.0, 5.0]), ..DatasetOptions::default() }, "heights 5..5"),
        (DatasetOptions { radius_m: Some(-1.0), ..DatasetOptions::default() }, "radius -1"),
    ] {
        expect(&with(options).unwrap_err(), ErrorKind::Argument, &[what, "metres"]);
    }
}

#[test]
fn huge_values_without_an_attribute_are_missing_and_noted() {
    let mark = |edit: &dyn Fn(&mut Made)| {
        let mut made = Made::history();
        (made.f32s("theta")[9], made.f32s("theta")[17]) = (-1e34, -1e34);
        edit(&mut made);
        let file = open(&made);
        (values(&file, "theta", 0)(2, 1), file.assumed_marks("theta"), notes(&file, "theta"))
    };
    let (value, marks, notes) = mark(&|_| ());
    assert!(value.is_nan() && marks == [AssumedMark { value: f64::from(-1e34f32), count: 2 }], "{value} {marks:?}");
    assert!(notes.contains("2 values of theta are -1") && notes.contains("`missing` says"), "{notes}");
    let usual = |made: &mut Made, other: f32| {
        (made.f32s("theta")[9], made.f32s("theta")[17], made.f32s("theta")[18]) = (-999.0, -999.0, other);
    };
    let (value, marks, _) = mark(&|made| usual(made, 0.0));
    assert!(value.is_nan() && marks == [AssumedMark { value: -999.0, count: 2 }], "{value} {marks:?}");
    assert_eq!(mark(&|made| usual(made, 2000.0)).0, -999.0, "others are as far apart");
    // One value alone, values over decades, and a field whose mark is known stay as they are.
    let keeps: [&dyn Fn(&mut Made); 3] =
        [&|made| made.f32s("theta")[17] = 0.0, &|made| made.f32s("theta")[18] = 1e29, &|made| {
            made.variable("theta").attributes.push(("_FillValue", (-5.0f32).into()));
        }];
    for keep in keeps {
        let (value, marks, _) = mark(keep);
        assert!(value == f64::from(-1e34f32) && marks.is_empty(), "{value} {marks:?}");
    }
}

#[test]
fn a_thickness_that_is_a_fill_is_no_layer() {
    let (ocean, name) = (Made::ocean(), "timeMonthly_avg_layerThickness");
    let expected = open(&ocean.clone().with_thickness(name, &["Time", "nCells", "nVertLevels"]));
    let mut made = ocean.with_thickness(name, &["Time", "nCells", "nVertLevels"]);
    made.remove("maxLevelCell");
    for thickness in made.f64s(name).iter_mut().filter(|thickness| **thickness < 0.0) {
        *thickness = 1e20;
    }
    made.variable(name).attributes.push(("_FillValue", 1e20.into()));
    let heights = |file: &Dataset| file.layer_heights("theta").unwrap().height_m;
    assert_eq!(heights(&open(&made)), heights(&expected));
    // Each column's own end there too.
    let (file, grid) = (open(&made), expected.mesh().grid().unwrap());
    let native = file.native_heights(&grid, "theta", 0).unwrap().unwrap();
    let range = native.all().unwrap().range().0.unwrap();
    assert!(range[0] > -600.0 && range[1] < 600.0, "{range:?}");
}

type Attributes = Vec<(&'static str, Values)>;

/// The range and the number of missing values of `rho`, which holds 0.1, 1, 2, ... 167, with attributes.
fn rho(attributes: Attributes) -> ([f64; 2], u64) {
    let mut made = Made::history();
    *made.f32s("rho") = (0..168).map(|i| if i == 0 { 0.1 } else { i as f32 }).collect();
    made.variable("rho").attributes = attributes;
    let owned = open(&made).read_field("rho", 0).unwrap();
    let (range, missing) = owned.field().unwrap().range();
    (range.unwrap(), missing)
}

#[test]
fn values_outside_the_valid_range_are_missing() {
    let range = |ends: [f32; 2]| ("valid_range", Values::F32(ends.to_vec()));
    assert_eq!(rho(vec![range([10.0, 100.0])]), ([10.0, 100.0], 168 - 91));
    assert_eq!(rho(vec![("valid_min", 5.0f32.into())]), ([5.0, 167.0], 5));
    assert_eq!(rho(vec![("valid_max", 20i32.into())]), ([f64::from(0.1f32), 20.0], 147));
    // Both, of which CF wants one: the narrower counts.
    assert_eq!(rho(vec![range([10.0, 100.0]), ("valid_max", 50.0f32.into())]), ([10.0, 50.0], 168 - 41));
    // 0.1 in double precision is below 0.1 in single, and above what it is rounded to.
    assert_eq!(rho(vec![("valid_min", 0.1f64.into())]), ([f64::from(0.1f32), 167.0], 0));
}

/// CF's packed integers, as converters write them to save space.
#[test]
fn packed_values_are_unpacked_and_ends_are_of_these_if_they_are_real() {
    let packed = |valid: Attributes| {
        let mut made = Made::history();
        let levels = made.variable("levels");
        levels.values = Values::I32((0..168).collect());
        levels.attributes = vec![("scale_factor", 0.5f64.into()), ("add_offset", 100.0f64.into())];
        levels.attributes.extend(valid);
        levels.attributes.push(("units", "K".into()));
        let file = open(&made);
        assert_eq!(file.field_info("levels").unwrap().description.units.as_deref(), Some("K"));
        let owned = file.read_field("levels", 0).unwrap();
        assert_eq!(owned.values().len(), 168);
        let (range, missing) = owned.field().unwrap().range();
        (range.unwrap(), missing)
    };
    assert_eq!(packed(Vec::new()), ([100.0, 183.5], 0));
    assert_eq!(packed(vec![("_FillValue", 0i32.into())]), ([100.5, 183.5], 1));
    let stored = Values::I32(vec![10, 19]);
    assert_eq!(packed(vec![("valid_range", stored)]), ([105.0, 109.5], 158));
    assert_eq!(packed(vec![("valid_max", 19i32.into())]), ([100.0, 109.5], 148));
    let unpacked = Values::F64(vec![105.0, 109.5]);
    assert_eq!(packed(vec![("valid_range", unpacked)]), ([105.0, 109.5], 158));
}
