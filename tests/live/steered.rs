//! Changes and questions of viewers, on one process and over ranks.

use super::model::{Model, Watched, drawn_alone, one_process, over_ranks};
use super::viewer::Json;
use super::{LIVE, SCENE, drawn};
use icoray_tests::native::text;
use icoray_tests::ranks::FIRST;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A model, run by `run` with a directory and a scene, is watched, steered and asked.
fn watch(run: impl Fn(&Path, &Path) -> Command) {
    let Watched { folder, to, mut model, viewer } = Watched::run(&format!("{SCENE}{LIVE}"), &run);
    let folder = folder.path();
    let described = viewer.get("/api/describe").json();
    assert_eq!((&described["live"], &described["fields"][0]["units"]), (&Value::from(true), &Value::from("K")));

    // Who watches sees the picture that is written, and at which step.
    let (facts, shown) = viewer.picture(0);
    assert_eq!((&facts["step"], &facts["revision"]), (&Value::from(0), &Value::from(1)));
    assert!(shown == drawn(&to, 0) && !to.join("live.toml").exists());

    // What is set holds from the next picture, on all ranks.
    let answer = viewer.set(r#"{"path":["camera","lon"],"value":-70},{"path":["transfer","map"],"value":"plasma"}"#);
    let revision = answer.json()["revision"].as_u64().unwrap();
    assert_eq!(viewer.get("/api/scene").json()["revision"].as_u64(), Some(revision));
    let step = model.draw();
    let (facts, shown) = viewer.picture(facts["number"].as_u64().unwrap());
    assert_eq!((facts["step"].as_u64(), facts["revision"].as_u64()), (Some(1), Some(revision)));
    assert!(shown == drawn(&to, step) && shown != drawn(&to, 0));
    let kept = fs::read_to_string(to.join("live.toml")).unwrap();
    assert!(kept.contains("# A scene.") && kept.contains("lon = -70") && kept.contains("# from here"), "{kept}");

    // What is the model's is not a viewer's, nor what it cannot draw.
    let deep = format!(r#"{{"path":[{}],"value":1}}"#, [r#""a""#; 3000].join(","));
    for (change, wanted) in [
        (deep.as_str(), "a key 3000 steps from the top, expected at most 16"),
        (r#"{"path":["output","cinema"],"value":"/tmp/viewer.cdb"}"#, "output.cinema is the model's"),
        (r#"{"path":["every"],"value":1000000000}"#, "every is the model's"),
        (r#"{"path":["samples"],"value":64}"#, "samples is the model's"),
        (r#"{"path":["output","file"],"value":"../b.png"}"#, "output"),
        (r#"{"path":["output","file"],"value":"b_{step}.png"}"#, "the model's, which a viewer cannot change"),
        (r#"{"path":["image","width"],"value":9000}"#, "the model's, which a viewer cannot change"),
        (r#"{"path":["field"],"value":"zzz"}"#, "field \"zzz\", expected one of f"),
    ] {
        let answer = viewer.set(change);
        let error = answer.json()["error"].as_str().unwrap_or_default().to_owned();
        assert!(answer.status == 400 && error.contains(wanted), "{error}");
    }
    assert_eq!(viewer.set(r#"{"path":["surfaces"],"value":[{"layer":77,"color":"red"}]}"#).status, 200);
    let before = drawn(&to, 1);
    let step = model.draw();
    assert!(drawn(&to, step) == before, "the scene before holds");
    let (facts, _) = viewer.picture(facts["number"].as_u64().unwrap());
    assert!(facts["refused"].as_str().is_some_and(|why| why.contains("77")), "{facts}");
    assert!(!viewer.get("/api/scene").json()["text"].as_str().unwrap().contains("77"));

    // Questions are answered when the model draws.
    let histogram = model.draw_until(viewer.asks("/api/histogram?field=f")).json();
    let known = histogram["counts"].as_array().unwrap().iter().map(|count| count.as_u64().unwrap()).sum::<u64>();
    assert_eq!(known, 642 * 4, "each value once, on however many ranks");
    let unknown = model.draw_until(viewer.asks("/api/histogram?field=zzz"));
    assert!(unknown.status == 422 && text(&unknown.body).contains("zzz"), "{}", text(&unknown.body));
    let probe = model.draw_until(viewer.asks("/api/probe?x=0.5&y=0.5")).json();
    assert!(probe["value"].is_f64() && probe["step"].as_u64() < Some(model.step.into()), "{probe}");
    let [lon, lat] = ["lon", "lat"].map(|key| probe[key].as_f64().unwrap());
    assert!((lon + 70.0).abs() < 1e-6 && (lat - 35.0).abs() < 1e-6, "what the camera looks down on: {probe}");
    let exr = viewer.get("/api/picture?format=exr");
    assert!(exr.status == 200 && exr.body.starts_with(&[0x76, 0x2f, 0x31, 0x01]));

    let last = model.draw();
    let log = model.end();
    assert!(log.contains("live view at http://127.0.0.1:") && !log.contains(&viewer.page.token), "{log}");
    assert!(log.contains("step 1: a viewer has set camera.lon, transfer.map"), "{log}");
    assert!(!to.join("live.url").exists());

    // The saved scene draws the same without viewers; [live] without viewers changes no picture.
    for (name, scene, step) in [("kept", kept.replace(LIVE, ""), last), ("plain", SCENE.to_owned(), 0)] {
        assert!(drawn_alone(&run, folder, name, &scene, step) == drawn(&to, step), "{name}");
    }
}

/// A viewer lights a scene, whose memory is that of the grid that rays pass.
fn light(run: impl Fn(&Path, &Path) -> Command) {
    let Watched { folder, to, mut model, viewer } = Watched::run(&format!("{SCENE}{LIVE}"), &run);
    let answer = viewer.set(r#"{"path":["light","kind"],"value":"headlight"}"#);
    assert_eq!(answer.status, 200, "{}", text(&answer.body));
    let step = model.draw();
    model.end();
    let lit = format!("{SCENE}[light]\nkind = \"headlight\"\n");
    assert!(drawn_alone(&run, folder.path(), "lit", &lit, step) == drawn(&to, step));
}

#[test]
fn a_model_alone_is_watched_and_steered() {
    watch(one_process(""));
    watch(one_process("async"));
}

#[test]
fn a_model_over_ranks_is_watched_and_steered() {
    if !FIRST.is_there() {
        return;
    }
    for (ranks, way) in [(1, ""), (3, ""), (3, "async"), (3, "parts"), (1, "parts")] {
        watch(over_ranks(ranks, way));
    }
    light(over_ranks(3, "parts"));
    // The other ranks hear of another field in the call after which it is wanted.
    choose_fields(over_ranks(3, "wants"), 1);
    choose_looks(over_ranks(3, "wants"));
}

/// Viewers of a model that computes the fields that are wanted choose another one and go back; either is drawn `late`
/// steps later, from values of its own step.
fn choose_fields(run: impl Fn(&Path, &Path) -> Command, late: u32) {
    let Watched { folder, to, mut model, viewer } = Watched::run(&format!("{SCENE}{LIVE}"), &run);
    let folder = folder.path();
    let mut shown = [0; 2];
    let draw = |model: &mut Model, wait: u32| {
        for _ in 0..wait {
            let step = model.draw();
            assert!(viewer.get("/api/scene").json()["revision"] != viewer.picture(step.into()).0["revision"]);
        }
        model.draw()
    };
    // All fields are known once they were set.
    assert_eq!(viewer.set(r#"{"path":["field"],"value":"g"}"#).status, 200);
    shown[0] = draw(&mut model, late);
    // While both are drawn, the camera turns at once.
    viewer.set(r#"{"path":["camera","lon"],"value":50}"#);
    let turned = draw(&mut model, 0);
    viewer.ask("POST /api/undo", "");
    viewer.ask("POST /api/undo", "");
    shown[1] = draw(&mut model, late);
    model.end();
    for (name, scene, step) in [
        ("g", SCENE.replace("\"f\"", "\"g\""), shown[0]),
        ("turned", SCENE.replace("\"f\"", "\"g\"").replace("lon = 20", "lon = 50"), turned),
        ("f", SCENE.to_owned(), shown[1]),
    ] {
        assert!(drawn_alone(&run, folder, name, &scene, step) == drawn(&to, step), "{name}");
    }
}

#[test]
fn fields_that_viewers_choose_are_wanted_before_they_are_drawn() {
    choose_fields(one_process("wants"), 0);
}

/// A scene that names a field alone is steered in the look that it has got; another field has its own, from values that
/// were computed for it.
fn choose_looks(run: impl Fn(&Path, &Path) -> Command) {
    const OPEN: &str = "field = \"f\"\nimage = { width = 40, height = 30 }\n[output]\nfile = \"frame_{step}.png\"\n";
    let Watched { folder, to, mut model, viewer } = Watched::run(&format!("{OPEN}{LIVE}"), &run);
    let shown = || viewer.get("/api/scene").json();
    let first = shown();
    assert_eq!(first["values"]["transfer"]["map"], "coolwarm_bright", "{first}");
    // All fields are known once they were set.
    model.draw();
    let asked = viewer.clone();
    let answer = model.draw_until(std::thread::spawn(move || asked.ask("POST /api/look?field=g", "")));
    assert_eq!(answer.status, 200, "{}", text(&answer.body));
    let second = shown();
    assert_eq!((&second["values"]["field"], &second["values"]["lines"]), (&"g".into(), &first["values"]["lines"]));
    // The values of g are half those of f.
    let [of_f, of_g] = [&first, &second].map(|scene| scene["values"]["transfer"]["range"][1].as_f64().unwrap());
    assert!((of_g / of_f - 0.5).abs() < 0.02, "{of_f}, {of_g}");
    let drawn_first = drawn(&to, 1);
    model.draw();
    let step = model.draw();
    let log = model.end();
    assert!(!log.contains("cannot be drawn"), "{log}");
    assert!(drawn(&to, step) != drawn_first);
    let scene = second["text"].as_str().unwrap().replace("[live]\ntime_budget_ms = 1000000000.0\n", "");
    assert!(drawn_alone(run, folder.path(), "g", &scene, step) == drawn(&to, step));
}

#[test]
fn viewers_choose_fields_that_have_looks_of_their_own() {
    choose_looks(one_process("wants"));
}
