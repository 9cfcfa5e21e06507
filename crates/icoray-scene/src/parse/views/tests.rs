//! Scene files with several views, and the places to which their errors point.

use super::*;
use crate::camera::Camera;
use crate::parse::tests::assert_says;
use crate::scene::LightSource;
use crate::script::Live;
use icoray_grid::ErrorKind;

const BASE: &str = r##"field = "theta"
exaggeration = 30
every = 6
[image]
width = 640
height = 480
[camera]
lon = 20.0
lat = 45.0
distance = 3
fov = 40
[transfer]
map = "viridis"
range = [250, 400]
opacity = [[300, 0.0], [350, 0.8]]
[light]
kind = "sun"
lon = 10
lat = 0
"##;

fn parse(text: &str) -> Script {
    Script::parse(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The only shot of each view at a step.
fn shots(text: &str, step: i64) -> Vec<Scene> {
    let stamp = Stamp { step, time_s: 100.0 * step as f64, date: None };
    parse(text).views().iter().flat_map(|view| view.shots(&stamp).collect::<Vec<_>>()).map(|s| s.scene).collect()
}

fn names(scenes: &[Scene], step: i64) -> Vec<String> {
    let stamp = Stamp { step, ..Stamp::default() };
    scenes.iter().map(|scene| scene.output.names(&stamp, scene.field()).unwrap().file).collect()
}

#[test]
fn a_file_without_views_is_a_script_of_its_scene() {
    let script = parse(BASE);
    assert_eq!(script.views().len(), 1);
    assert_eq!(script.views()[0].name(), "");
    let scene = Scene::parse(BASE).unwrap();
    // A scene does not say whether its file names the pictures.
    let view = View { has_file: false, ..Script::from(scene.clone()).views()[0].clone() };
    assert_eq!(script, Script { views: vec![view], live: None, is_async: false });
    assert_eq!(shots(BASE, 12), [scene]);
    for empty in ["", " \n\t\r\n", "# nothing to draw\n   # today"] {
        assert_eq!(Script::parse_optional(empty).unwrap(), None, "{empty:?}");
        assert!(Scene::parse(empty).unwrap_err().to_string().contains("no keys: nothing is drawn"));
    }
    for (bad, part) in [("field = 3", "line 1"), ("[camera]\nlon = 400", "camera.lon"), ("# a\n\u{1}", "line 2")] {
        assert!(Script::parse_optional(bad).unwrap_err().to_string().contains(part), "{bad:?}");
    }
}

#[test]
fn a_view_overrides_any_key_and_keeps_the_others() {
    let text = format!(
        "{BASE}{}",
        r##"
[[views]]
name = "as it is"
[[views]]
name = "other"
field = "w"
core = "transparent"
image.width = 32
camera = { lon = -5 }
transfer.range = [0, 1]
transfer.opacity = [[0, 0.5]]
light.kind = "headlight"
[views.labels]
title = "{name}"
"##
    );
    let [same, other] = &shots(&text, 0)[..] else { panic!("two views") };
    let mut base = Scene::parse(BASE).unwrap();
    assert!(base.core.is_some());
    base.output.file = NameTemplate::new("as it is_{field}_{step:06}.png").unwrap();
    assert_eq!(same.volumes[0].transfer, base.volumes[0].transfer);
    assert_eq!(names(&[same.clone(), base.clone(), other.clone()], 7).concat(), {
        let as_it_is = "as it is_theta_000007.png";
        format!("{as_it_is}{as_it_is}other_w_000007.png")
    });
    assert_eq!((other.field(), other.core, other.exaggeration), ("w", None, 30.0));
    assert_eq!([other.width, other.height, other.every], [32, 480, 6]);
    assert_eq!(other.camera, Camera::above(-5.0, 45.0, 3.0, 40.0).unwrap());
    assert_eq!(other.volumes[0].coloring.as_ref().unwrap().fixed(), Some([0.0, 1.0]));
    assert_eq!(other.lighting.unwrap().source, LightSource::Headlight);
    assert!(other.labels.is_some() && same.labels.is_none());
}

#[test]
fn alternative_keys_of_a_view_replace_each_other() {
    let camera = |over: &str, base: &str| {
        let base = BASE.replace("lon = 20.0\nlat = 45.0\ndistance = 3", base);
        shots(&format!("{base}[[views]]\nname = \"v\"\ncamera = {{ {over} }}\n"), 0)[0].camera
    };
    let place = "lon = 20.0\nlat = 45.0\ndistance = 3";
    let eye = "eye = [0, 0.5, 2]\ntarget = [0, 0, 1]\nup = [1, 0, 0]";
    let above = |lon, lat, distance| Camera::above(lon, lat, distance, 40.0).unwrap();
    assert_eq!(camera("altitude = 1", place), above(20.0, 45.0, 2.0));
    assert_eq!(camera("lon = 1, lat = 2, distance = 3", eye), above(1.0, 2.0, 3.0));
    let looks = Camera::look_at([0.0, 3.0, 1.0], [0.0; 3], [0.0, 0.0, 1.0], 40.0).unwrap();
    assert_eq!(camera("eye = [0, 3, 1]", place), looks);
    let scene = |over: &str| shots(&format!("{BASE}[[views]]\nname = \"v\"\n{over}\n"), 0).remove(0);
    let knots = "transfer.knots = [{ value = 0, color = \"red\", opacity = 0.5 }]";
    assert!(scene(knots).volumes[0].coloring.is_none() && scene("").volumes[0].coloring.is_some());
    assert!(scene("light.kind = \"none\"").lighting.is_none());
    let log = format!("{}[[views]]\nname = \"v\"\ntransfer.scale = \"log\"\n", {
        BASE.replace("map = \"viridis\"", "map = \"viridis\"\nscale = \"symlog\"\nthreshold = 1")
    });
    assert_eq!(shots(&log, 0)[0].volumes[0].coloring.as_ref().unwrap().scale(), crate::coloring::Scale::Log);
    let moving = |keys: &str, over: &str| {
        let base = BASE.replace("lon = 20.0\nlat = 45.0\ndistance = 3", keys);
        shots(&format!("{base}[[views]]\nname = \"v\"\n{over}\n"), 2).iter().map(|s| s.camera).collect::<Vec<_>>()
    };
    let path = "path = [{ step = 0, lon = 0, lat = 0 }, { step = 2, lon = 8, lat = 9 }]\ndistance = 3";
    assert_eq!(moving(path, ""), [above(8.0, 9.0, 3.0)]);
    assert_eq!(moving(path, "camera.lon = 5\ncamera.lat = 6"), [above(5.0, 6.0, 3.0)]);
    let swept = [above(1.0, 0.0, 3.0), above(2.0, 0.0, 3.0)];
    assert_eq!(moving(path, "sweep = { lat = [0], lon = [1, 2] }"), swept);
    let text = BASE.replace("fov = 40\n", "");
    let base = format!("{text}[sweep]\nlon = [1, 2]\n[[views]]\nname = \"v\"\n");
    let orbit = shots(&format!("{base}camera.orbit.degrees_per_step = 0\n"), 2);
    assert_eq!(orbit.len(), 1);
    assert_eq!(shots(&format!("{base}camera.{}\n", path.replace('\n', "\ncamera.")), 2).len(), 1);
    // Volumes instead of a field with its transfer function, and the other way round.
    let volume = |field: &str| {
        format!(
            "[[views.volumes]]\nfield = \"{field}\"\n[views.volumes.transfer]\n\
                 knots = [{{ value = 0, color = \"red\", opacity = 0.5 }}]\n"
        )
    };
    let fields = |over: &str| scene(over).shown_fields().join(" ");
    assert_eq!(fields(&(volume("p") + &volume("q"))), "p q");
    let short = "field = \"w\"\ntransfer = { map = \"viridis\", range = [0, 1], opacity = [[0, 0.5]] }";
    let base = BASE.replacen("field = \"theta\"\n", "", 1).split("[transfer]").next().unwrap().to_owned();
    let base = base + &volume("p").replace("views.", "");
    let shown: Vec<String> = shots(&format!("{base}[[views]]\nname = \"a\"\n[[views]]\nname = \"b\"\n{short}\n"), 0)
        .iter()
        .map(|scene| scene.shown_fields().join(" "))
        .collect();
    assert_eq!(shown, ["p", "w"]);
    // A schedule is one, conditions are others.
    let schedule = |over: &str| {
        let base = format!("at_steps = [7]\nwhen = \"max(q) > 1\"\n{BASE}");
        let script = parse(&format!("{base}[[views]]\nname = \"v\"\n{over}\n"));
        let view = &script.views()[0];
        let due = |step: &i64| script.scheduled(&Stamp { step: *step, ..Stamp::default() }, None).count() == 1;
        ((1..14).filter(due).collect::<Vec<i64>>(), view.conditions().len())
    };
    assert_eq!(schedule(""), (vec![6, 7, 12], 1));
    assert_eq!(schedule("at_steps = [3]"), (vec![3], 1));
    assert_eq!(schedule("every = 5\nwhen = [\"min(q) < 0\", \"mean(q) > 0\"]"), (vec![5, 10], 2));
    assert_eq!(schedule("when = []"), (vec![6, 7, 12], 0));
}

/// Lines after the base, whose last one is 19, are refused with an error that has all of these words.
fn refused(lines: &str, words: &str) {
    let error = Script::parse(&format!("{BASE}{lines}\n")).expect_err(lines);
    assert_eq!(error.kind(), ErrorKind::Scene);
    assert_says(&error, words, lines);
}

#[test]
fn errors_name_view_line_and_key() {
    let path = |keys: &str| format!("camera.path = [{{ step = 0, lon = 1, lat = 2 }}{keys}]");
    for (lines, words) in [
        ("exageration = 3", "view \"a\": line 22 | exageration | unknown field"),
        ("camera.lat = 95", "view \"a\": line 22, key camera.lat: 95"),
        ("field = 3", "view \"a\": line 22 (field = 3) | string"),
        ("at_times = []", "line 22, key at_times | empty"),
        ("at_times = [0, inf]", "line 22, key at_times: inf"),
        ("at_steps = [0.5]", "line 22 (at_steps = [0.5]) | an integer"),
        ("when = [\"max(q) > 1\",\n  \"max(q) >> 1\"]", "line 22, key when: \"max(q) >> 1\" | \"> 1\" at character 9"),
        ("when = 3", "line 22 | max(theta) > 300"),
        ("camera.orbit = 2", "line 22 (camera.orbit = 2)"),
        ("camera.orbit = { turn = 360 }", "line 22, key camera.orbit | degrees_per_step, or turn and steps"),
        (&path(""), "line 22, key camera.path: 1 keys, expected at least 2"),
        (&path(",\n{ step = 0, lon = 5, lat = 2 }"), "line 23, key camera.path: 0 after 0"),
        (&path(",\n{ time = 5, lon = 5, lat = 2 }"), "line 23, key camera.path: expected each key"),
        ("camera.eye = [0, 0, 3]\nsweep.lon = [1]", "view \"a\": line 23, key sweep.lon | not with eye"),
        ("camera.orbit.degrees_per_step = 1\nsweep.lon = [1]", "line 23, key sweep.lon | orbit"),
    ] {
        refused(&format!("[[views]]\nname = \"a\"\n{lines}"), words);
    }
}

#[test]
fn errors_of_views_sweeps_and_outputs_name_line_and_key() {
    let two = "[[views]]\nname = \"a\"\n[[views]]\nname = \"b\"\n";
    for (lines, words) in [
        ("[[views]]\nlabels.on = false", "line 20, key views.name | absent"),
        ("[[views]]\nname = \"\"", "line 21, key views.name | \"\", expected a name"),
        ("[[views]]\nname = \"a\"\n[[views]]\nname = \"a\"", "line 23, key views.name | second time"),
        ("[views]\nname = \"a\"", "line 20, key views | [[views]]"),
        ("[sweep]\nlons = [1]", "line 21, key sweep.lons | lon, lat, distance, exaggeration or field"),
        ("[sweep]\nlon = []", "line 21, key sweep.lon | empty"),
        ("[sweep]\nlat = [0,\n91]", "line 22, key sweep.lat: 91"),
        ("[sweep]\nlon = 3", "line 21 (lon = 3)"),
        ("[sweep]\nfield = [\"a\", \"\"]", "line 21, key sweep.field | \"\""),
        ("[sweep]", "line 20, key sweep: nothing"),
        ("[output]\nfile = \"{lon}.png\"", "line 21, key output.file: {lon} is no placeholder here | one of {field}"),
        (
            "[sweep]\nlon = [1]\n[output]\nfile = \"{view}_{lon}.png\"",
            "line 23, key output.file: {view} | {field}, {lon}",
        ),
        ("[output]\nconcat = \"a.txt\"", "line 21, key output.concat | .ffconcat"),
        ("[output]\nconcat = \"{step}.ffconcat\"", "line 21, key output.concat | neither step nor date"),
        ("[output]\ncinema = \"a\"", "line 21, key output.cinema | .cdb"),
        ("[output]\nfps = 10", "line 21, key output.fps | is valid only with output.concat"),
        (&format!("[output]\nfile = \"{{step}}.png\"\n{two}"), "key output.file | \"a\" | \"b\" | 0.png"),
        (
            &format!("[output]\nfile = \"{{view}}{{step}}.png\"\nerror = \"e{{step}}.png\"\n{two}"),
            "line 22, key output.error | e0.png",
        ),
        (
            "[sweep]\nlon = [1, 2]\n[output]\nfile = \"{step}.png\"",
            "line 23, key output.file: two pictures of a sweep | 0.png | swept",
        ),
        (&format!("[output]\nconcat = \"m.ffconcat\"\n{two}"), "key output.concat | m.ffconcat | {view}"),
        (
            &format!("[output]\ncinema = \"m.cdb\"\n{two}sweep.lon = [1]\n"),
            "line 21, key output.cinema | m.cdb | other columns",
        ),
    ] {
        refused(lines, words);
    }
}

#[test]
fn scenes_alone_refuse_keys_of_scripts() {
    for lines in ["[[views]]\nname = \"a\"", "[sweep]\nlon = [1]", "[output]\ncinema = \"a.cdb\""] {
        let error = Scene::parse(&format!("{BASE}{lines}\n")).unwrap_err().to_string();
        assert!(error.contains("unknown field"), "{error}");
    }
    let word = Scene::parse(&format!("{BASE}[output]\nfile = \"{{lon}}.png\"\n")).unwrap();
    let error = word.output.names(&Stamp::default(), "q").unwrap_err().to_string();
    assert!(error.contains("{lon}"), "{error}");
}

#[test]
fn a_sweep_is_the_product_of_its_lists_in_their_order() {
    let text = BASE.replace("lon = 20.0\nlat = 45.0\n", "").replace("field = \"theta\"\n", "");
    let sweep = "[sweep]\nlat = [0, 30]\nfield = [\"theta\", \"a/b\"]\nlon = [-10, 22.5]\n";
    let scenes = shots(&format!("{text}{sweep}"), 3);
    let name = |lat: i32, field: &str, lon: f64| format!("{field}_000003_lat{lat}_lon{lon}.png");
    let mut expected = Vec::new();
    for lat in [0, 30] {
        for field in ["theta", "a_b"] {
            for lon in [-10.0, 22.5] {
                expected.push(name(lat, field, lon));
            }
        }
    }
    assert_eq!(names(&scenes, 3), expected);
    assert_eq!(scenes[7].field(), "a/b");
    assert_eq!(scenes[7].camera, Camera::above(22.5, 30.0, 3.0, 40.0).unwrap());
    assert_eq!(scenes[0].camera, Camera::above(-10.0, 0.0, 3.0, 40.0).unwrap());
    let heights = shots(&format!("{BASE}[sweep]\ndistance = [2, 4]\nexaggeration = [1, 9]\n"), 0);
    let seen: Vec<_> = heights.iter().map(|s| (s.camera, s.exaggeration)).collect();
    let at = |distance| Camera::above(20.0, 45.0, distance, 40.0).unwrap();
    assert_eq!(seen, [(at(2.0), 1.0), (at(2.0), 9.0), (at(4.0), 1.0), (at(4.0), 9.0)]);
    let fields = parse(&format!("when = \"max(c) > 1\"\n{text}{sweep}")).model_fields();
    assert_eq!(fields, ["theta", "a/b", "c"]);
}

#[test]
fn a_moving_camera_moves_in_each_picture() {
    let orbit = format!("{BASE}[sweep]\nlat = [0, 30]\n").replace("fov = 40", "orbit.degrees_per_step = 2");
    let cameras: Vec<_> = shots(&orbit, 20).iter().map(|s| s.camera.eye()).collect();
    for (eye, lat) in cameras.iter().zip([0.0, 30.0]) {
        let expected = Camera::above(60.0, lat, 3.0, 30.0).unwrap().eye();
        assert!(eye.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{eye:?} {expected:?}");
    }
    let keys = "[{ time = 0, lon = 0, lat = 10, altitude = 1 }, { time = 900, lon = 90, lat = 0, fov = 20 }]";
    let path = BASE.replace("lon = 20.0\nlat = 45.0\ndistance = 3", &format!("distance = 5\npath = {keys}"));
    let camera = |step| shots(&path, step)[0].camera;
    assert_eq!(camera(0), Camera::above(0.0, 10.0, 2.0, 40.0).unwrap());
    assert_eq!(camera(9), Camera::above(90.0, 0.0, 5.0, 20.0).unwrap());
    assert_eq!(camera(10), camera(9));
    // A view's path goes instead of the file's place.
    let keys = keys.replace("lat = 0,", "lat = 0, distance = 4,").replace('\n', "");
    let view = format!("{BASE}[[views]]\nname = \"v\"\ncamera.path = {keys}\n");
    assert_eq!(shots(&view, 9)[0].camera, Camera::above(90.0, 0.0, 4.0, 20.0).unwrap());
}

#[test]
fn lists_of_pictures_are_named_by_view_and_sweep() {
    let text = format!(
        "{BASE}{}",
        r#"[output]
file = "image/{lon}_{step}.png"
cinema = "{view}.cdb"
concat = "{view}_{lon}.ffconcat"
fps = 10
[sweep]
lon = [1, 2.5]
[[views]]
name = "a/b"
[[views]]
name = "c"
"#
    );
    let scenes = shots(&text, 4);
    let kept: Vec<_> = scenes.iter().map(|s| &s.output.series).collect();
    let cinema = kept[1].cinema.as_ref().unwrap();
    assert_eq!(cinema.folder, "a_b.cdb");
    assert_eq!(cinema.parameters, [("view", "a/b".to_owned()), ("lon", "2.5".to_owned())]);
    assert_eq!(kept[0].cinema.as_ref().unwrap().parameters[1].1, "1.0");
    let concat = kept[3].concat.as_ref().unwrap();
    assert_eq!((concat.file.as_str(), concat.fps), ("c_2.5.ffconcat", 10.0));
    let expected = ["a_b.cdb/image/1_4.png", "a_b.cdb/image/2.5_4.png", "c.cdb/image/1_4.png"];
    assert_eq!(names(&scenes, 4)[..3], expected);
}

#[test]
fn default_names_contain_the_date_if_requested() {
    let text = format!(
        "{BASE}[sweep]\nlat = [0, 30]\n[[views]]\nname = \"a\"\n[[views]]\nname = \"b\"\n\
         output.file = \"own_{{lat}}.png\"\n"
    )
    .replace("lat = 45.0\n", "");
    let mut script = parse(&text);
    script.name_by_date();
    let name = |date: Option<&str>| {
        let stamp = Stamp { step: 3, date: date.map(String::from), ..Stamp::default() };
        let shots = script.views().iter().flat_map(|view| view.shots(&stamp));
        shots.map(|shot| shot.scene.output.names(&stamp, "q").unwrap().file).collect::<Vec<_>>()
    };
    let own = ["own_0.png", "own_30.png"];
    assert_eq!(name(None)[..2], ["a_q_000003_lat0.png", "a_q_000003_lat30.png"]);
    assert_eq!(name(None)[2..], own);
    let dated = name(Some("2026-11-22T06:30:00"));
    assert_eq!(dated[0], "a_q_2026-11-22_06.30.00_000003_lat0.png");
    assert_eq!(dated[2..], own);
}

#[test]
fn only_the_file_requests_a_live_page() {
    assert_eq!(parse(BASE).live(), None);
    assert_eq!(parse(&format!("{BASE}[live]\n")).live(), Some(Live::default()));
    let script = parse(&format!(
        "{BASE}[live]\nport = 9000\ntime_budget_ms = 40\n[[views]]\nname = 'a'\n[[views]]\nname = 'b'\n"
    ));
    assert_eq!((script.live(), script.views().len()), (Some(Live { port: Some(9000), time_budget_ms: Some(40.0) }), 2));
    refused("[[views]]\nname = 'a'\nlive = {}", "unknown field `live`");
}
