//! `icoray view`: requests of its page, and of hostile clients.

use crate::made::Made;
use crate::run::{Folder, scene};
use crate::viewer::{Json, Viewer};
use std::collections::BTreeSet;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;

#[test]
fn the_shown_picture_is_that_of_the_saved_scene() {
    let folder = Folder::of(&Made::history());
    let viewer = folder.view(&[]);
    let change = r#"{"changes":[{"path":["camera","lon"],"value":30},{"path":["transfer","map"],"value":"plasma"}],
                     "time":1,"size":[120,90]}"#;
    let facts = viewer.at_rest(viewer.change(change));
    assert_eq!([&facts["width"], &facts["height"], &facts["time"]], [120, 90, 1]);
    let scene = viewer.get("/api/scene").json();
    folder.write("scene.toml", scene["text"].as_str().unwrap());
    let command = scene["command"].as_str().unwrap();
    assert_eq!(command, "icoray render made.nc --scene scene.toml --time 1");
    for format in ["png", "exr"] {
        let name = format!("rendered.{format}");
        folder.prints(&format!("{} -o {name}", command.strip_prefix("icoray ").unwrap()));
        let answer = viewer.get(&format!("/api/picture?format={format}"));
        assert!(answer.head.contains("content-disposition: attachment"), "{}", answer.head);
        let seen = folder.at(format!("seen.{format}"));
        fs::write(&seen, answer.body).unwrap();
        let [seen, rendered] = [seen, folder.at(name)].map(|path| image::open(path).unwrap().to_rgba32f());
        assert!(seen == rendered, "{format}: other pixels");
    }
}

#[test]
fn changes_are_taken_whole_and_undone() {
    let folder = Folder::of(&Made::history());
    folder.write("s.toml", scene("theta", 0.0, 42.0));
    let viewer = folder.view(&["--scene", "s.toml"]);
    let text = || viewer.get("/api/scene").json()["text"].as_str().unwrap().to_owned();
    let first = text();
    for (bad, wanted) in [
        (
            r#"{"changes":[{"path":["camera","lat"],"value":1},{"path":["camera","lon"],"value":999}]}"#,
            "camera.lon: 999",
        ),
        (r#"{"changes":[{"path":["field"],"value":"nothing"}]}"#, "nothing: there is no such field"),
        (r#"{"changes":[{"path":["zzz"],"value":1}]}"#, "zzz"),
        (r#"{"time":99}"#, "time 99"),
        ("garbage", "expected value"),
        (r#"{"unknown":1}"#, "unknown"),
    ] {
        let answer = viewer.post("/api/change", bad);
        assert_eq!(answer.status, 400, "{bad}");
        assert!(answer.json()["error"].as_str().unwrap().contains(wanted), "{bad}: {}", answer.json());
    }
    assert_eq!(text(), first);
    // A scene that has an image keeps its size.
    let revision = viewer.change(r#"{"changes":[{"path":["camera","lat"],"value":10}],"size":[50,40]}"#);
    assert_eq!(viewer.at_rest(revision)["width"], 96);
    assert!(text().contains("lat = 10"));
    assert_eq!(viewer.post("/api/undo", "").status, 200);
    assert_eq!(text(), first);
    viewer.post("/api/redo", "");
    assert!(text().contains("lat = 10"));
    assert_eq!(viewer.post("/api/load", "field = 'theta'\nzzz = 2\n").status, 400);
    assert_eq!(viewer.post("/api/load", "field = 'theta'\n").status, 200);
    assert_eq!(text(), "field = 'theta'\n");
}

#[test]
fn another_field_is_shown_in_its_own_look() {
    let folder = Folder::of(&Made::history());
    let start = |field: &str| folder.view(&["--field", field]);
    let sized = |viewer: &Viewer, size: &str| viewer.change(&format!(r#"{{"size":{size}}}"#));
    let viewer = start("theta");
    let values = || viewer.get("/api/scene").json()["values"].clone();
    sized(&viewer, "[120,90]");
    let first = values();
    for field in ["w", "surface_pressure", "theta"] {
        assert_eq!(viewer.post(&format!("/api/look?field={field}"), "").status, 200, "{field}");
        let other = start(field);
        sized(&other, "[120,90]");
        let (shown, alone) = (values(), other.get("/api/scene").json()["values"].clone());
        let keys: BTreeSet<&String> = [&shown, &alone].iter().flat_map(|v| v.as_object().unwrap().keys()).collect();
        // The place of the camera stays.
        for key in keys.into_iter().filter(|key| *key != "camera") {
            assert_eq!(shown[key], alone[key], "{field}: {key}");
        }
    }
    assert_eq!(values(), first);
    // What the user has changed stays.
    viewer.post("/api/change", r#"{"changes":[{"path":["light"],"value":{"kind":"sun","lon":3,"lat":4}}]}"#);
    viewer.post("/api/look?field=w", "");
    assert_eq!((&values()["light"]["lon"], &values()["lines"]), (&3.into(), &first["lines"]));
    // The picture has the page's size as before.
    let facts = viewer.at_rest(sized(&viewer, "[160,100]"));
    assert_eq!((&facts["width"], facts["error"].as_str()), (&160.into(), None), "{facts}");
    viewer.post("/api/undo", "");
    assert_eq!(values()["field"], "theta");
    // No question has words that its way to other ranks cannot hold.
    for field in ["zzz", "w%01", "w%00"] {
        let answer = viewer.post(&format!("/api/look?field={field}"), "");
        let error = answer.json()["error"].as_str().unwrap().to_owned();
        assert!(answer.status == 400 && error.starts_with("there is no field"), "{error}");
    }
}

#[test]
fn questions_about_the_data_are_answered() {
    let folder = Folder::of(&Made::history());
    folder.write("s.toml", scene("theta", 0.0, 42.0));
    let viewer = folder.view(&["--scene", "s.toml"]);
    let described = viewer.get("/api/describe").json();
    let names: Vec<&str> =
        described["fields"].as_array().unwrap().iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"theta"), "{names:?}");
    assert!(described["sections"].as_array().unwrap().len() > 10 && described["title"] == "made.nc");
    let histogram = viewer.get("/api/histogram?field=theta").json();
    let [low, high] = [0, 1].map(|k: usize| histogram["range"][k].as_f64().unwrap());
    let probe = viewer.get("/api/probe?x=0.5&y=0.5").json();
    assert_eq!(probe["hit"], true);
    // The camera looks down on 190 E 45 N.
    let [lon, lat] = ["lon", "lat"].map(|key| probe[key].as_f64().unwrap());
    assert!((lon + 170.0).abs() < 1e-6 && (lat - 45.0).abs() < 1e-6, "{lon} {lat}");
    let value = probe["value"].as_f64().unwrap();
    assert!((low..=high).contains(&value), "{value} of {low} to {high}");
    let column = probe["column"]["values"].as_array().unwrap();
    assert!(column.len() > 1 && column.iter().all(|value| value.as_f64().is_some()), "{column:?}");
    assert_eq!(viewer.get("/api/probe?x=0.0&y=0.0").json()["hit"], false);
    for (path, wanted) in [
        ("/api/probe?x=2&y=0", "expected 0 to 1"),
        ("/api/probe?x=0.1", "expected y"),
        ("/api/probe?x=nan&y=0", "expected 0 to 1"),
        ("/api/histogram", "expected field"),
        ("/api/histogram?field=zzz", "zzz"),
        ("/api/picture?format=gif", "png or exr"),
        ("/api/frame?after=x", "expected a number"),
    ] {
        let answer = viewer.get(path);
        assert!((400..500).contains(&answer.status), "{path}");
        assert!(answer.json()["error"].as_str().unwrap().contains(wanted), "{path}: {}", answer.json());
    }
}

#[test]
fn hostile_clients_are_refused_without_harm_to_others() {
    let folder = Folder::of(&Made::history());
    let viewer = folder.view(&[]);
    let page = viewer.page.with_token("").ask("GET /", "").unwrap();
    assert!(page.status == 200 && page.head.contains("content-security-policy: default-src 'none'"), "{}", page.head);
    for token in ["", "0123", &format!("{}0", viewer.page.token), &viewer.page.token[1..]] {
        let answer = viewer.page.with_token(token).ask("GET /api/scene", "").unwrap();
        assert_eq!(answer.status, 401);
        assert!(!String::from_utf8_lossy(&answer.body).contains("camera"));
    }
    for (path, status) in
        [("/api/nothing", 404), ("/../Cargo.toml", 404), ("/%2e%2e/made.nc", 404), ("/api/change", 405)]
    {
        assert_eq!(viewer.get(path).status, status, "{path}");
    }
    assert_eq!(viewer.post("/api/load", &"#".repeat(2 << 20)).status, 413);
    let begun = |request: &str, host: &str| {
        let mut stream = viewer.page.connect().unwrap();
        let token = &viewer.page.token;
        let head = format!("GET {request} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        stream
    };
    for host in ["evil.example", "127.0.0.1.evil.example"] {
        let mut stream = begun("/api/scene", host);
        stream.write_all(b"Connection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
    }
    // Some that stall, with half of a request or without reading, and many that come, send garbage and go.
    let stalled: Vec<TcpStream> = (0..20)
        .map(|k| {
            let mut stream = begun("/api/frame?after=0", "localhost");
            if k % 2 == 0 {
                stream.write_all(b"\r\n").unwrap();
            }
            stream
        })
        .collect();
    for k in 0..1000 {
        let mut stream = viewer.page.connect().unwrap();
        // The server may close at once.
        let _ = stream.write_all([&b"\0\xff\x16\x03\x01 garbage\r\n\r\n"[..], b"GET", b""][k % 3]);
    }
    let facts = viewer.at_rest(1);
    assert_eq!(facts["revision"], 1);
    drop(stalled);
}

#[test]
fn a_taken_port_is_another_port() {
    let folder = Folder::of(&Made::history());
    let first = folder.view(&[]);
    let port = first.page.host.rsplit_once(':').unwrap().1;
    let second = folder.view(&["--port", port]);
    assert_ne!(first.page.host, second.page.host);
    assert_ne!(first.page.token, second.page.token);
    assert_eq!(first.page.with_token(&second.page.token).ask("GET /api/scene", "").unwrap().status, 401);
}
