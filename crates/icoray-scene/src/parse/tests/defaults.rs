//! Defaults of scenes with few keys.

use super::*;
use crate::coloring::ColorRange;
use crate::scene::LightSource;
use crate::scenery::{Level, Paint, Pattern, Surface};
use crate::script::Script;

/// The volume that is shown where nothing is said: viridis over percentiles, rising opacity.
fn has_default_volume(scene: &Scene) -> bool {
    let coloring = scene.volumes[0].coloring.as_ref().unwrap();
    let ends = &over(scene, [10.0, 20.0]).volumes[0].transfer;
    coloring.describe() == "viridis, linear, percentiles 1 to 99 of the first frame"
        && coloring.range() == ColorRange::Percentile([1.0, 99.0])
        && ends.range() == [10.0, 20.0]
        && ends.at(10.0).1 == 0.0
        && (ends.at(20.0).1 - -(0.1f64.ln())).abs() < 1e-12
}

#[test]
fn one_key_of_any_kind_makes_a_scene() {
    for text in [
        "every = 3",
        "exaggeration = 40",
        "background = \"white\"",
        "[image]\nwidth = 640",
        "[camera]",
        "[camera]\nfov = 20",
        "[transfer]",
        "[light]",
        "[labels]",
        "[output]",
        "[[volumes]]",
    ] {
        let scene = parsed(text);
        assert_eq!((scene.field(), scene.shown_fields()), ("", vec![""]), "{text}");
        assert!(has_default_volume(&scene) && scene.has_single_volume() && !scene.has_boundaries(), "{text}");
    }
    let scene = parsed("field = \"theta\"");
    assert_eq!((scene.field(), scene.width, scene.height), ("theta", 512, 512));
    assert!(has_default_volume(&scene));
    assert_eq!((parsed("[image]\nheight = 7").width, parsed("[image]\nheight = 7").height), (512, 7));
    assert_eq!(parsed("[light]").lighting.unwrap().source, LightSource::Headlight);
}

#[test]
fn the_camera_sees_the_whole_planet() {
    for fov in [1.0, 20.0, 30.0, 60.0, 120.0, 170.0] {
        let camera = parsed(&format!("camera.fov = {fov:?}")).camera;
        let [lon, lat, distance, half] = camera.place();
        assert!((lon - 0.0).abs() < 1e-9 && (lat - 25.0).abs() < 1e-9 && (half - fov).abs() < 1e-9);
        // A shell of a tenth of the radius is inside the picture and fills most of it.
        let seen = (1.1 / distance).asin().to_degrees() / (0.5 * fov);
        assert!((0.8..0.9).contains(&seen), "{fov}: {seen}");
    }
    let camera = parsed("camera = { lon = 70, distance = 3 }").camera.place();
    assert!((camera[0] - 70.0).abs() < 1e-9 && (camera[1] - 25.0).abs() < 1e-9 && (camera[2] - 3.0).abs() < 1e-9);
}

#[test]
fn a_centre_is_clear_where_no_opacity_is_given() {
    let centred = over(&parsed("[transfer]\ncenter = 5"), [0.0, 10.0]);
    let transfer = &centred.volumes[0].transfer;
    assert_eq!((transfer.at(5.0).1, transfer.range()), (0.0, [0.0, 10.0]));
    assert!(transfer.at(0.0).1 > 2.0 && transfer.at(10.0).1 > 2.0);
    // Of a fixed range opacities are along it, too.
    assert_eq!(parsed("[transfer]\nrange = [250, 400]").volumes[0].transfer.range(), [250.0, 400.0]);
}

#[test]
fn surfaces_beside_the_volume_show_the_first_field() {
    let both = parsed(
        "field = \"q\"\n[transfer]\n[opacity]\nvalues = [[0, 0], [1, 0.5]]\n[[surfaces]]\n[[isosurfaces]]\nvalue = 3\n",
    );
    assert_eq!(both.shown_fields(), ["q"]);
    assert_eq!((both.scenery.surfaces[0].at, both.scenery.surfaces[0].opacity), (Level::Layer(0), 1.0));
    for paint in both.scenery.paints() {
        let Paint::Field { field, coloring: Some(coloring), .. } = paint else { panic!("{paint:?}") };
        assert_eq!((field.as_str(), coloring.range()), ("q", ColorRange::Percentile([1.0, 99.0])));
    }
    // A surface without a field is of the one that another names.
    let scene = parsed("[[surfaces]]\n[[isosurfaces]]\nfield = \"t\"\nvalue = 3\n");
    assert_eq!((scene.field(), scene.shown_fields()), ("t", vec!["t"]));
    let [clip, lines] = ["[[clip]]\nlon = [0, 9]", "[[lines]]"].map(parsed);
    assert!(clip.scenery.clips[0].cuts_inside);
    assert_eq!(lines.scenery.lines[0].pattern, Pattern::Graticule { spacing_deg: 30.0 });
    assert_eq!(lines.volumes[0].transfer.knots.len(), 1, "lines alone have no volume beside them");
}

#[test]
fn the_first_field_gets_its_name_from_the_caller() {
    let text = "[[views]]\nname = \"a\"\n[[views]]\nname = \"b\"\nfield = \"w\"\n[[views.surfaces]]\n";
    let mut script = Script::parse(text).unwrap();
    assert!(script.lacks_field());
    assert_eq!(script.model_fields(), ["", "w"]);
    script.name_first_field("theta");
    assert!(!script.lacks_field());
    assert_eq!(script.model_fields(), ["theta", "w"]);
}

#[test]
fn fields_without_layers_are_surfaces_unless_an_opacity_is_given() {
    let shown = |text: &str| {
        let mut script = Script::parse(text).unwrap();
        script.show_as_surfaces(|field| field == "ps");
        script.views()[0].scenes().next().unwrap()
    };
    let scene = shown("field = \"ps\"\n[transfer]\nmap = \"plasma\"\nrange = [900, 1000]");
    let [Surface { at: Level::Layer(0), paint: Paint::Field { field, transfer, .. }, opacity: 1.0 }] =
        &scene.scenery.surfaces[..]
    else {
        panic!("{:?}", scene.scenery.surfaces)
    };
    assert_eq!((field.as_str(), transfer.range()), ("ps", [900.0, 1000.0]));
    assert!(scene.volumes[0].transfer.knots.iter().all(|knot| knot.extinction == 0.0));
    for text in ["field = \"theta\"", "field = \"ps\"\n[transfer]\nopacity = [[0, 0.1], [1, 0.2]]"] {
        assert!(shown(text).scenery.surfaces.is_empty(), "{text}");
    }
}

/// For any omitted key, no message is serde's about a field of a struct.
#[test]
fn no_key_is_missing_in_words_of_the_parser() {
    for (text, words) in [
        ("[[isosurfaces]]", "line 1 | isosurfaces.value | either value or values"),
        ("[[derive]]\nsum = { u = 1 }", "line 1 | derive.name | expected a name"),
        ("[transfer]\nknots = [{ value = 1 }]", "line 2 | transfer.knots | value and color"),
        ("[[clip]]\nhalf_space = {}", "line 2 | clip.half_space.towards | longitude"),
        ("[opacity]", "line 1 | opacity.values | pairs"),
        ("[[views]]\nfield = \"q\"", "line 1 | views.name | expected a name"),
    ] {
        let error = Script::parse(text).expect_err(text);
        assert!(!error.to_string().contains("missing field"), "{error}");
        assert_says(&error, words, text);
    }
    // Places of a path have the camera's defaults.
    Script::parse("camera.path = [{ step = 0 }, { step = 9, lon = 40 }]").unwrap();
    Script::parse("[sweep]\nlon = [0, 90]").unwrap();
}
