//! Valid and invalid scene files, and the places to which their errors point.

use super::*;
use crate::coloring::{ColorRange, Scale};
use crate::labels::LabelPlace;
use crate::transfer::TransferFunction;

mod defaults;
mod derived;
mod hints;
mod lines;
mod volumes;

/// A camera, for scenes of a few lines.
const CAMERA: &str = "[camera]\nlon = 0\nlat = 0\ndistance = 3\n";

/// Checks that an error has all of these words, which ` | ` separates; `text` is what it is about.
pub(super) fn assert_says(error: &Error, words: &str, text: &str) {
    let error = error.to_string();
    for word in words.split(" | ") {
        assert!(error.contains(word), "'{word}' is not in '{error}' for\n{text}");
    }
}

fn parsed(text: &str) -> Scene {
    Scene::parse(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The scene with all of its colour maps over a range.
fn over(scene: &Scene, range: [f64; 2]) -> Scene {
    scene.over_each(|_, _| Ok(Some(range))).unwrap().unwrap()
}

/// Each text is refused with an error that has all of its words.
fn refused(cases: &[(String, &str)]) {
    for (text, words) in cases {
        assert_says(&Scene::parse(text).expect_err(text), words, text);
    }
}

const GOOD: &str = r##"field = "theta"
exaggeration = 30
background = "transparent"
core = "#202830"
[image]
width = 640
height = 480
[camera]
lon = 20.0
lat = 45.0
distance = 3
[transfer]
map = "viridis"
range = [250, 400]
opacity = [[300, 0.0], [350, 0.8]]
[light]
kind = "sun"
lon = 10
lat = 0
[output]
file = "theta_$Y-$M-$D_{step:06}.png"
"##;

/// [`GOOD`] with a fifth line.
fn with(line: &str) -> Result<Scene> {
    Scene::parse(&GOOD.replacen("[image]", &format!("{line}\n[image]"), 1))
}

#[test]
fn a_good_scene_is_read() {
    let scene = Scene::parse(GOOD).unwrap();
    assert_eq!((scene.width, scene.height, scene.exaggeration), (640, 480, 30.0));
    assert_eq!(scene.background, None);
    assert!(scene.core.is_some() && scene.lighting.is_some());
    assert_eq!(scene.volumes[0].transfer.range(), [300.0, 400.0]);
}

#[test]
fn settings_of_the_renderer_are_read() {
    let plain = parsed(GOOD);
    assert_eq!((plain.backend, &plain.device, plain.ranks), (Backend::Auto, &None, Scheme::Auto));
    assert_eq!(plain.scenery.heights, Heights::Mean);
    let native = Scenery { heights: Heights::Native, ..plain.scenery.clone() };
    let [number, name] = [Adapter::Number(2), Adapter::Name("NVIDIA".into())].map(Some);
    for (lines, expected) in [
        ("backend = \"cpu\"", Scene { backend: Backend::Cpu, ..plain.clone() }),
        ("backend = \"gpu\"\ndevice = 2", Scene { backend: Backend::Gpu, device: number, ..plain.clone() }),
        ("device = \"NVIDIA\"", Scene { device: name, ..plain.clone() }),
        ("ranks = \"auto\"", plain.clone()),
        ("ranks = \"tiles\"", Scene { ranks: Scheme::Tiles, ..plain.clone() }),
        ("ranks = \"fragments\"", Scene { ranks: Scheme::Fragments, ..plain.clone() }),
        ("heights = \"mean\"", plain.clone()),
        ("heights = \"native\"", Scene { scenery: native, ..plain.clone() }),
        ("tolerance = 2e-5", Scene { tolerance: 2e-5, ..plain.clone() }),
        ("samples = 6", Scene { samples: 6, ..plain.clone() }),
        ("time_budget_ms = 250", Scene { time_budget_ms: Some(250.0), ..plain.clone() }),
    ] {
        assert_eq!(with(lines).unwrap(), expected, "{lines}");
    }
}

/// Lines of the good scene replaced by others, and what the error must say.
#[test]
fn errors_name_line_and_key() {
    let [exaggeration, distance, map] = ["exaggeration = 30", "distance = 3", "map = \"viridis\""];
    let [range, opacity] = ["range = [250, 400]", "opacity = [[300, 0.0], [350, 0.8]]"];
    let [output, file] = ["[output]", "file = \"theta_$Y-$M-$D_{step:06}.png\""];
    for (old, new, words) in [
        ("field = \"theta\"", "field = 3", "line 1 | field = 3 | string"),
        (exaggeration, "exageration = 30", "line 2 | exageration | unknown field"),
        (exaggeration, "device = -1", "line 2 | device | -1 | number from 0 | name"),
        (exaggeration, "device = \"\"", "line 2 | device | number from 0"),
        (exaggeration, "device = 0.5", "line 2 | device | 0.5"),
        ("background = \"transparent\"", "background = \"blak\"", "line 3 | background | blak | CSS"),
        ("lat = 45.0", "lat = 95", "line 10 | camera.lat | 95 | -90 to 90"),
        (distance, "distance = nan", "line 11 | camera.distance | NaN"),
        (exaggeration, "samples = 2.5", "line 2 (samples = 2.5)"),
        (distance, "distance = 3\naltitude = 2", "line 12 | camera | either distance or altitude"),
        (map, "map = \"jet\"", "line 13 | transfer.map | jet | viridis"),
        (map, "map = \"jet_r\"", "line 13 | jet_r | batlow | _r"),
        (range, "range = [400, 250]", "line 14 | transfer.range"),
        (range, "range = 3", "line 14 | transfer.range | 3 | percentile | union"),
        (range, "range = [1, 2, 3]", "line 14 | two finite numbers"),
        (range, "range = [0, inf]", "line 14 | transfer.range | finite"),
        (range, "range = { percentile = [99, 1] }", "line 14 | percentile = [99, 1] | 0 to 100"),
        (range, "range = { percentil = [1, 99] }", "line 14 | percentil | union"),
        (range, "range = { percentile = [1, 99], hysteresis = 1 }", "line 14 | hysteresis"),
        (range, "range = [0, 400]\nscale = \"log\"", "line 14 | transfer.range | positive"),
        (opacity, "opacity = [[300, 0.0], [350, 1.0]]", "line 15 | opacity 1 | below 1"),
        (opacity, "opacity = [[300, 0.0], [250, 0.8]]", "line 15 | 250 after 300 | rise"),
        (range, "range = [1, 400]\nscale = \"symlog\"", "line 15 | transfer.scale | threshold"),
        (range, "range = [1, 400]\ncenter = nan", "line 15 | transfer.center | NaN"),
        ("[light]", "[light", "line 16"),
        (
            "range = [250, 400]\nopacity = [[300",
            "range = [250, 400]\nscale = \"log\"\nopacity = [[0",
            "line 16 | transfer.opacity | value 0 | positive",
        ),
        (range, "range = [1, 400]\nscale = \"log\"\nthreshold = 1", "line 16 | threshold | symlog"),
        (range, "range = [1, 400]\nscale = \"log\"\ncenter = -1", "line 16 | center | positive"),
        (output, "[labels]\ntitle = \"{tme}\"\n[output]", "line 21 | labels.title | {tme} | {time}"),
        (output, "[labels]\ncolor = \"inc\"\n[output]", "line 21 | labels.color | inc | CSS"),
        (
            output,
            "[output]\nerror = \"theta_$Y-$M-$D_{step:06}.png\"",
            "line 21 | output.error | theta_$Y | same as output.file | another name",
        ),
        (output, "[output]\nerror = \"e.exr\"", "line 21 | output.error | e.exr | .png"),
        (output, "[output]\nerror = \"e_{x}.png\"", "line 21 | output.error | {x} | {step}"),
        (output, "[output]\nerror = 1", "line 21 | error = 1 | string"),
        (file, "file = \"theta_{stp}.png\"", "line 21 | output.file | stp"),
        (file, "file = \"theta.jpg\"", "line 21 | output.file | .png"),
    ] {
        assert!(GOOD.contains(old), "{old}");
        assert_says(&Scene::parse(&GOOD.replacen(old, new, 1)).expect_err(new), words, new);
    }
}

#[test]
fn a_scene_may_name_either_file_or_none() {
    let output = |lines: &str| {
        let (before, _) = GOOD.split_once("[output]").unwrap();
        Scene::parse(&format!("{before}{lines}")).unwrap().output
    };
    let names = |lines: &str| output(lines).names(&crate::name::Stamp::default(), "q").unwrap();
    assert_eq!(names(""), names("[output]\n"));
    assert_eq!((names("").file.as_str(), names("").error), ("q_000000.png", None));
    let error = "[output]\nerror = \"{field}_error_{step}.png\"\n";
    assert_eq!(names(error).file, "q_000000.png");
    assert_eq!(names(error).error.unwrap(), "q_error_0.png");
}

#[test]
fn knots_take_opacity_or_extinction_and_steps() {
    let text = r##"field = "q"
[camera]
eye = [0.5, 0.0, 1.2]
target = [1.0, 0.0, 1.0]
[transfer]
unit_length = 0.1
knots = [ { value = 0, color = "red", opacity = 0.5 },
          { value = 1, color = "red", extinction = 2 },
          { value = 1, color = "#00f", extinction = 0 } ]
"##;
    let scene_ = Scene::parse(text).unwrap();
    assert_eq!(scene_.volumes[0].transfer.knots[1].extinction, 2.0);
    assert_eq!(scene_.volumes[0].transfer.knots[2].color, [0.0, 0.0, 1.0]);
    assert!(scene_.lighting.is_none());
    let third = text.replace("{ value = 0, color", "{ value = 1, color");
    assert!(Scene::parse(&third).unwrap_err().to_string().contains("at most two knots"));
    let both = text.replace("extinction = 2 }", "extinction = 2, opacity = 0.1 }");
    assert!(Scene::parse(&both).unwrap_err().to_string().contains("line 8"));
}

#[test]
fn a_scene_selects_the_scale_of_colours() {
    let with = |lines: &str| {
        Scene::parse(&GOOD.replacen("range = [250, 400]", lines, 1)).unwrap().volumes[0].coloring.clone().unwrap()
    };
    let plain = with("range = [250, 400]");
    assert_eq!((plain.scale(), plain.fixed()), (Scale::Linear, Some([250.0, 400.0])));
    assert_eq!(plain.range(), ColorRange::Fixed([250.0, 400.0]));
    assert_eq!(plain.describe(), "viridis, linear, fixed");
    let log = with("range = { percentile = [1, 99.5] }\nscale = \"log\"\nreverse = true");
    assert_eq!((log.scale(), log.fixed()), (Scale::Log, None));
    assert_eq!(log.range(), ColorRange::Percentile([1.0, 99.5]));
    assert_eq!(log.describe(), "viridis_r, log, percentiles 1 to 99.5 of the first frame");
    let both = with("range = { union = [0, 100] }\nscale = \"symlog\"\nthreshold = 1e-3\ncenter = 0");
    assert_eq!(both.scale(), Scale::SymLog { threshold: 1e-3 });
    assert_eq!(both.range(), ColorRange::Union { percentile: [0.0, 100.0], hysteresis: 0.1 });
    let text = "viridis, symlog beyond 0.001, centred on 0, percentiles 0 to 100 of all frames so far, hysteresis 0.1";
    assert_eq!(both.describe(), text);
}

/// Where the range follows the data opacities do so too, unless the scene says otherwise.
#[test]
fn opacities_are_of_values_or_of_the_range() {
    let extinction = |range: &str, more: &str| {
        let text = GOOD.replacen("range = [250, 400]", &format!("range = {range}\n{more}"), 1);
        let scene = Scene::parse(&text.replacen("[[300, 0.0], [350, 0.8]]", "[[0.25, 0.0], [0.5, 0.8]]", 1)).unwrap();
        over(&scene, [200.0, 400.0]).volumes[0].transfer.range()[0]
    };
    assert_eq!(extinction("[1, 2]", ""), 0.25);
    assert_eq!(extinction("[1, 2]", "opacity_in = \"range\""), 250.0);
    assert_eq!(extinction("{ percentile = [0, 100] }", ""), 250.0);
    assert_eq!(extinction("{ percentile = [0, 100] }", "opacity_in = \"values\""), 0.25);
}

#[test]
fn the_default_map_depends_on_a_center() {
    let name = |more: &str| {
        let text = GOOD.replacen("map = \"viridis\"", more, 1);
        Scene::parse(&text).unwrap().volumes[0].coloring.clone().unwrap().describe()
    };
    assert!(name("").starts_with("viridis,") && name("center = 300").starts_with("vik,"));
    assert!(name("map = \"Batlow_R\"\nreverse = true").starts_with("Batlow,"));
}

#[test]
fn labels_are_there_where_a_scene_has_a_section_of_them() {
    let with =
        |section: &str| Scene::parse(&GOOD.replacen("[output]", &format!("{section}\n[output]"), 1)).unwrap().labels;
    assert_eq!(with(""), None);
    assert_eq!(with("[labels]\non = false\ntitle = \"{name}\""), None);
    let labels = with("[labels]").unwrap();
    assert!(labels.bar && labels.scale_note && labels.error_note.is_none() && labels.color.is_none());
    assert_eq!((labels.place, labels.size, labels.name), (LabelPlace::Auto, 1.0, None));
    let all = "[labels]\ntitle = \"{name}\"\nname = \"n\"\nunits = \"K\"\nplace = \"below\"\nsize = 2\ncolor = \"white\"\n\
               bar = false\nscale = false\nerror = false";
    let labels = with(all).unwrap();
    assert!(!labels.bar && !labels.scale_note && labels.error_note == Some(false));
    assert_eq!((labels.place, labels.size, labels.color), (LabelPlace::Below, 2.0, Some([1.0; 3])));
    assert_eq!((labels.name.as_deref(), labels.units.as_deref()), (Some("n"), Some("K")));
}
