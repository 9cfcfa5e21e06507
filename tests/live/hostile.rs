//! Random and hostile requests, which leave a model as it is.

use super::model::{Watched, drawn_alone, one_process};
use super::viewer::Viewer;
use super::{LIVE, SCENE, drawn};
use icoray_test_support::{Random, count};
use icoray_tests::native::text;
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::{fs, thread};

/// Keys that random requests set, and values of which each key takes some.
const PATHS: &str = "field camera.lon camera.distance transfer.map transfer.range surfaces.0 surfaces.0.layer \
    clip.0.lat isosurfaces.0.value light.kind every output.file output.cinema output.concat image.width derive.0 live samples";
const VALUES: &str = r#"["f", "g", 3, -70, 1e9, "magma", [-1, 1], { "layer": 1, "color": "red" }, null, "headlight",
    "../x.png", "x.cdb", "x.ffconcat", { "name": "d", "magnitude": ["f", "g"] }, {}]"#;

/// Random requests to a model in the pattern of costly diagnostics: its fields stay (`live.c` looks), each step is
/// drawn, and nothing is written beside its pictures.
#[test]
fn random_requests_leave_a_model_as_it_is() {
    let own = format!("{SCENE}{LIVE}");
    let Watched { folder, to, mut model, viewer } = Watched::start("wants", &own);
    let (paths, values): (Vec<&str>, Vec<Value>) = (PATHS.split(' ').collect(), serde_json::from_str(VALUES).unwrap());
    let mut random = Random::new(0);
    let mut taken = 0;
    for _ in 0..count(150, 500) {
        let answer = match random.below(8) {
            0 => viewer.ask("POST /api/undo", ""),
            1 => viewer.ask("POST /api/redo", ""),
            2 => {
                let line = ["lines = [{}]\n", "every = 7\n", "", "when = \"max(f) > 9\"\n"][random.below(4)];
                viewer.ask("POST /api/load", &format!("{line}{own}"))
            }
            _ => {
                let steps = paths[random.below(paths.len())].split('.');
                let path: Vec<Value> = steps.map(|step| step.parse::<u64>().map_or(step.into(), Value::from)).collect();
                let value = &values[random.below(values.len())];
                viewer.set(&serde_json::json!({ "path": path, "value": value }).to_string())
            }
        };
        assert!([200, 400].contains(&answer.status), "{}", text(&answer.body));
        taken += u32::from(answer.status == 200);
        if random.below(3) == 0 {
            model.draw();
        }
    }
    assert!(taken > 20, "{taken}");
    assert_eq!(viewer.ask("POST /api/load", &own).status, 200);
    let last = model.draw();
    model.end();
    let names = |directory: &Path| {
        let all = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        all.collect::<BTreeSet<_>>()
    };
    assert_eq!(names(folder.path()), ["scene.toml", "watched"].map(str::to_owned).into());
    let pictures = (0..=last).map(|step| format!("frame_{step}.png"));
    assert_eq!(names(&to), pictures.chain(["report.csv", "live.toml"].map(str::to_owned)).collect());
    let Watched { folder: _kept, to: alone, mut model, .. } = Watched::start("wants", &own);
    while model.draw() < last {}
    model.end();
    assert!(drawn(&alone, last) == drawn(&to, last));
}

#[test]
fn two_viewers_and_hostile_ones_leave_the_model_as_it_is() {
    let run = one_process("");
    let Watched { folder, to, mut model, viewer } = Watched::run(&format!("{SCENE}{LIVE}"), &run);
    let stalled: Vec<TcpStream> = (0..20)
        .map(|_| {
            let mut stream = viewer.page.connect().unwrap();
            stream.write_all(b"GET /api/frame?after=0 HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect();
    for garbage in [&b"\0\xff\xfe\r\n\r\n"[..], b"GET / HTTP/9.9\r\n\r\n", b"POST /api/change HTTP/1.1\r\n\r\n{"] {
        let mut stream = viewer.page.connect().unwrap();
        stream.write_all(garbage).unwrap();
    }
    let wrong = Viewer { page: viewer.page.with_token(&"0".repeat(32)) };
    assert_eq!(wrong.set(r#"{"path":["camera","lon"],"value":1}"#).status, 401);
    for _ in 0..100 {
        drop(viewer.page.connect().unwrap());
    }
    // Two viewers steer against each other: the last one holds.
    let steer = |side: f64| {
        let viewer = viewer.clone();
        thread::spawn(move || {
            for turn in 0..20 {
                let change = format!(r#"{{"path":["camera","lon"],"value":{}}}"#, side * f64::from(turn));
                assert_eq!(viewer.set(&change).status, 200);
            }
        })
    };
    let (left, right) = (steer(-1.0), steer(1.0));
    model.draw_until(left);
    model.draw_until(right);
    viewer.set(r#"{"path":["camera","lon"],"value":20}"#);
    let last = model.draw();
    drop(stalled);
    model.end();
    let alone = |step: u32| drawn_alone(&run, folder.path(), &format!("alone {step}"), SCENE, step);
    assert!(alone(last) == drawn(&to, last) && alone(0) == drawn(&to, 0));
}
