//! Scenes for synthetic fields: the choice for each kind of distribution, and the keys of the text.

use super::*;
use crate::common::{at_centers, icosahedral, over_columns};
use icoray_scene::{ColorRange, LightSource, Pattern, Scale, Scene};

const HEIGHT_M: [f64; 6] = [0.0, 2e3, 4e3, 8e3, 12e3, 20e3];
const EARTH_M: f64 = 6.371e6;

/// The text for values of longitude, latitude (radians) and height (m).
fn text_for(value: impl Fn(f64, f64, f64) -> f64, options: &Options) -> Result<String> {
    let (mesh, grid) = icosahedral(4);
    let of_cell =
        |cell: usize, layer: usize| value(mesh.lon_center_rad[cell], mesh.lat_center_rad[cell], HEIGHT_M[layer]);
    let values = over_columns(grid.cells(), HEIGHT_M.len(), of_cell);
    let layers = Layers::from_heights(&HEIGHT_M, EARTH_M).unwrap();
    scene("q", &grid, &layers, &at_centers(&values, HEIGHT_M.len()), options)
}

fn scene_for(value: impl Fn(f64, f64, f64) -> f64, options: &Options) -> Scene {
    let text = text_for(value, options).unwrap();
    Scene::parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A wave in the northern half about a longitude, with both signs.
fn wave(lon: f64, lat: f64, _: f64) -> f64 {
    let about = (lon - 2.0).sin().hypot(1.0 - (lon - 2.0).cos());
    1e-5 * (8.0 * lon).sin() * (-4.0 * (about.powi(2) + (lat - 0.7).powi(2))).exp()
}

#[test]
fn both_signs_have_a_diverging_map_about_0_and_are_clear_there() {
    let scene = scene_for(wave, &Options::default());
    let [low, high] = scene.volumes[0].transfer.range();
    assert!(low == -high && scene.volumes[0].transfer.at(0.0).1 == 0.0 && scene.volumes[0].transfer.at(high).1 > 1.0);
    assert!(scene.volumes[0].coloring.as_ref().unwrap().describe().starts_with("coolwarm_bright"));
    // The camera is over the wave: 115°E 40°N.
    let [lon, lat, distance, fov] = scene.camera.place();
    assert!((lon - 115.0).abs() < 11.0 && (lat - 40.0).abs() < 11.0, "{lon} {lat}");
    // The shell is a tenth of the planet, and all of it is in the picture.
    assert_eq!(scene.exaggeration, 30.0);
    let outer = 1.0 + 30.0 * HEIGHT_M[5] / EARTH_M;
    let half = (outer / distance).asin().to_degrees();
    assert!(half < 0.5 * fov && half > 0.4 * fov, "{half}");
}

#[test]
fn stratified_fields_are_shells_that_end_at_the_ground() {
    let theta = |_: f64, lat: f64, height: f64| 300.0 - 40.0 * lat.sin().powi(2) + 4e-3 * height;
    let scene = scene_for(theta, &Options::default());
    let knots = &scene.volumes[0].transfer.knots;
    let peaks = knots.windows(3).filter(|w| w[1].extinction > w[0].extinction.max(w[2].extinction)).count();
    assert_eq!(peaks, 2, "{knots:?}");
    // Clear between the shells and beyond them.
    assert!(scene.volumes[0].transfer.at(200.0).1 == 0.0 && scene.volumes[0].transfer.at(500.0).1 == 0.0);
    assert!(knots.iter().filter(|knot| knot.extinction == 0.0).count() >= 2 * peaks);
}

#[test]
fn a_long_tail_is_shown_alone() {
    let humid = |lon: f64, lat: f64, height: f64| (4.0 * (lon.sin() * lat.cos())).exp() * (1.3 - 3e-5 * height);
    for (sign, kind) in [(1.0, "highest values"), (-1.0, "lowest values")] {
        let value = |lon: f64, lat: f64, height: f64| 100.0 + sign * humid(lon, lat, height);
        let text = text_for(value, &Options::default()).unwrap();
        assert!(text.contains(kind), "{text}");
        let scene = Scene::parse(&text).unwrap();
        let [low, high] = scene.volumes[0].transfer.range();
        let opaque = if sign > 0.0 { [low, high] } else { [high, low] };
        assert!(scene.volumes[0].transfer.at(opaque[0]).1 == 0.0 && scene.volumes[0].transfer.at(opaque[1]).1 > 1.0);
    }
}

#[test]
fn few_values_that_differ_are_shown_from_the_others_on() {
    let cloud = |lon: f64, lat: f64, height: f64| {
        if (lon - 2.0).hypot(lat - 0.3) < 0.1 && height == 4e3 { 1e-3 } else { 0.0 }
    };
    let scene = scene_for(cloud, &Options::default());
    let transfer = &scene.volumes[0].transfer;
    assert_eq!(scene.volumes[0].coloring.as_ref().unwrap().range(), ColorRange::Fixed([0.0, 1e-3]));
    assert!(transfer.at(0.0).1 == 0.0 && transfer.at(1e-3).1 > 1.0);
    let [lon, lat, ..] = scene.camera.place();
    assert!((lon - 115.0).abs() < 11.0 && (lat - 17.0).abs() < 11.0, "{lon} {lat}");
}

#[test]
fn values_of_many_decades_have_a_logarithmic_scale() {
    let decades = |lon: f64, lat: f64, _: f64| 10f64.powf(-5.0 + 3.0 * lat.cos() * lon.cos());
    for surface in [None, Some(Level::Ground)] {
        let scene = scene_for(decades, &Options { surface, ..Options::default() });
        let paintings = scene.paintings();
        let coloring = paintings[paintings.len() - 1].coloring.unwrap();
        let [low, high] = coloring.fixed().unwrap();
        assert!(coloring.scale() == Scale::Log && low < 1e-7 && high > 5e-3, "{low} to {high}");
    }
    let scale = |value: &dyn Fn(f64, f64, f64) -> f64, is_length: bool| {
        let options = Options { surface: Some(Level::Ground), is_length, ..Options::default() };
        let scene = scene_for(value, &options);
        scene.paintings().last().unwrap().coloring.unwrap().scale()
    };
    // A hill that falls to 1e-8, in metres or not.
    let hill = |lon: f64, lat: f64, _: f64| 100.0 * (-12.0 * (1.0 - lat.cos() * (lon - 2.0).cos())).exp();
    assert_eq!([false, true].map(|is_length| scale(&hill, is_length)), [Scale::Log, Scale::Linear]);
    // A third of the values are spread from 0 to 1, and the others over decades below.
    let spread = |_: f64, lat: f64, _: f64| if lat > 0.3 { lat.sin() } else { 10f64.powf(2.0 * lat - 2.5) };
    assert_eq!(scale(&spread, false), Scale::Linear);
    // A plume has no least value worth a colour.
    let plume = |lon: f64, lat: f64, _: f64| (-30.0 * (lon - 2.0).hypot(lat)).exp();
    assert_eq!(scene_for(plume, &Options::default()).volumes[0].coloring.as_ref().unwrap().scale(), Scale::Linear);
}

#[test]
fn layers_of_one_value_show_anomalies_or_are_cut() {
    let layers = |_: f64, _: f64, height: f64| 300.0 + 4e-3 * height;
    let bubble = move |lon: f64, lat: f64, height: f64| {
        layers(lon, lat, height) + 2.0 * (-10.0 * ((lon - 2.0).powi(2) + lat.powi(2))).exp()
    };
    let scene = scene_for(bubble, &Options::default());
    assert_eq!((scene.field(), scene.model_fields()), ("q_anomaly", vec!["q"]));
    let [lon, lat, ..] = scene.camera.place();
    assert!((lon - 115.0).abs() < 11.0 && lat.abs() < 11.0, "{lon} {lat}");
    // A range is one of the field's own values.
    let ranged = scene_for(bubble, &Options { range: Some([300.0, 380.0]), ..Options::default() });
    let underived = scene_for(bubble, &Options { is_underived: true, ..Options::default() });
    for scene in [ranged, underived, scene_for(layers, &Options::default())] {
        assert!(scene.field() == "q" && scene.scenery.clips.len() == 1);
    }
}

#[test]
fn ice_at_both_poles_is_seen_from_above_one() {
    let ice = |_: f64, lat: f64, _: f64| f64::from(lat.abs() > 1.2);
    for surface in [None, Some(Level::Ground)] {
        let [_, lat, ..] = scene_for(ice, &Options { surface, ..Options::default() }).camera.place();
        assert!(lat.abs() > 50.0, "{lat}");
    }
}

#[test]
fn requested_settings_are_in_the_suggested_text() {
    let options = Options {
        lon_deg: Some(-60.0),
        lat_deg: Some(12.5),
        distance: Some(3.0),
        exaggeration: Some(7.0),
        color_map: Some("plasma_r".into()),
        range: Some([-2e-6, 4e-6]),
        surface: None,
        is_underived: true,
        isosurface: None,
        background: Some("white".into()),
        light: Some(Some(LightSource::Sun { lon_deg: 20.0, lat_deg: -5.0 })),
        has_borders: true,
        is_unlabelled: true,
        is_timeless: true,
        is_length: false,
        size: Some((33, 21)),
        tolerance: Some(1e-5),
        samples: Some(4),
        backend: Some(Backend::Cpu),
        device: Some(Adapter::Name("a \"b\"".into())),
        head: vec!["one\ntwo".into()],
    };
    let text = text_for(wave, &options).unwrap();
    assert!(text.starts_with("# one two\n"), "{text}");
    let scene = Scene::parse(&text).unwrap();
    assert_eq!((scene.background, &scene.labels), (Some([1.0; 3]), &None));
    assert_eq!(scene.lighting.unwrap().source, LightSource::Sun { lon_deg: 20.0, lat_deg: -5.0 });
    assert!(scene.scenery.lines.iter().any(|lines| lines.pattern == Pattern::Borders));
    let title = text_for(wave, &Options { is_timeless: true, ..Options::default() }).unwrap();
    assert!(title.contains("[labels]") && !title.contains("{time}"), "{title}");
    let [lon, lat, distance, _] = scene.camera.place();
    assert!((lon + 60.0).abs() < 1e-9 && (lat - 12.5).abs() < 1e-9 && (distance - 3.0).abs() < 1e-9);
    assert_eq!((scene.exaggeration, scene.width, scene.height, scene.tolerance), (7.0, 33, 21, 1e-5));
    assert_eq!(scene.samples, 4);
    let coloring = scene.volumes[0].coloring.as_ref().unwrap();
    assert_eq!(coloring.range(), ColorRange::Fixed([-2e-6, 4e-6]));
    assert!(coloring.describe().starts_with("plasma_r"));
    assert_eq!((scene.backend, scene.device), (Backend::Cpu, options.device));
}

#[test]
fn surfaces_are_coloured_by_their_own_layer() {
    for (level, expected) in [(Level::Top, Level::Top), (Level::Layer(2), Level::Layer(2))] {
        let options = Options { surface: Some(level), ..Options::default() };
        let scene = scene_for(|lon, lat, height| height + lat.cos() * lon.sin(), &options);
        // A long tail is no reason to leave out the other end.
        let tail = scene_for(|lon, lat, _| 9.0 - 8.0 * (lat.cos() * lon.sin()).powi(8), &options);
        let [low, high] = tail.paintings()[1].coloring.unwrap().fixed().unwrap();
        assert!(low < 2.0 && high > 8.9, "{low} to {high}");
        assert_eq!(scene.scenery.surfaces.len(), 1);
        assert_eq!(scene.scenery.surfaces[0].at, expected);
        // Behind the volume, which is clear.
        let paintings = scene.paintings();
        let [low, high] = paintings[1].coloring.unwrap().fixed().unwrap();
        assert!(high - low < 2.2 && scene.scenery.lines.iter().any(|lines| lines.pattern == Pattern::Coast));
    }
    let options = Options { surface: Some(Level::Layer(6)), ..Options::default() };
    let error = text_for(wave, &options).unwrap_err();
    assert!(error.context().contains("surface on layer 6, expected 0 to 5"), "{error}");
}

#[test]
fn an_isosurface_is_all_that_is_shown() {
    for value in [0.5, 3.0] {
        let options = Options { isosurface: Some(value), ..Options::default() };
        // Of the second field a clip would be suggested, or its anomaly.
        for scene in [scene_for(wave, &options), scene_for(|_, _, height| height, &options)] {
            let shown = &scene.scenery.isosurfaces;
            assert!(shown.len() == 1 && shown[0].value == value && shown[0].field == "q" && scene.field() == "q");
            assert!(scene.scenery.clips.is_empty() && scene.volumes[0].transfer.at(value).1 == 0.0);
            assert_eq!(scene.lighting.unwrap().source, LightSource::Headlight);
        }
    }
}

#[test]
fn fields_that_cannot_be_shown_are_errors() {
    let error = text_for(wave, &Options { exaggeration: Some(-1.0), ..Options::default() }).unwrap_err();
    assert_eq!(error.context(), "exaggeration -1, expected a number from 1e-6 to 1e6");
    let error = text_for(|_, _, _| f64::NAN, &Options::default()).unwrap_err();
    assert!(error.kind() == ErrorKind::Field && error.context().contains("all values are missing"));
    for options in [
        Options { color_map: Some("jet2".into()), ..Options::default() },
        Options { range: Some([1.0, 1.0]), ..Options::default() },
    ] {
        assert_eq!(text_for(wave, &options).unwrap_err().kind(), ErrorKind::Argument);
    }
    // A constant field is drawn.
    let scene = scene_for(|_, _, _| 7.0, &Options::default());
    assert!(scene.volumes[0].transfer.at(7.0).1 > 0.0);
}
