//! `icoray watch --live`: the page shows each picture, and its changes apply to the next ones.

use super::model::records;
use super::{NAMED_BY_DATE, Watcher, folder};
use crate::made::Made;
use crate::run::scene;
use crate::viewer::{Json, Viewer};
use netcdf::Options;
use std::fs;
use std::path::Path;

fn pixels(path: &Path) -> image::RgbaImage {
    image::open(path).unwrap().into_rgba8()
}

#[test]
fn a_page_follows_the_watch_and_steers_the_next_picture() {
    let made = Made::history();
    let folder = folder(&made, &(scene("theta", 0.0, 2042.0) + NAMED_BY_DATE));
    let comes = |number: usize| {
        let unseen = folder.at("run/.unseen.nc");
        records(&made, number..number + 1).write_to(&unseen, Options::_64BIT_OFFSET);
        fs::rename(unseen, folder.at(format!("run/{number}.nc"))).unwrap();
    };
    let watcher = Watcher::start(&folder, &["--live"]);
    watcher.wait("the page", || watcher.text().contains("live      http://"));
    let text = watcher.text();
    let address = text.lines().find_map(|line| line.strip_prefix("live      ")).unwrap();
    let viewer = Viewer::at(address);
    assert_eq!(viewer.get("/api/describe").json()["live"], true);
    comes(0);
    watcher.wait_for("2013-10-25.png");
    let first = folder.at("out/2013-10-25.png");
    let (_, shown) = viewer.first(1, |_| true);
    assert!(shown == pixels(&first));

    // The time that is shown is drawn again for the page alone.
    let written = fs::read(&first).unwrap();
    let change = r#"{"changes":[{"path":["camera","lon"],"value":40}]}"#;
    let (_, turned) = viewer.first(viewer.change(change), |_| true);
    assert!(turned != shown && fs::read(&first).unwrap() == written);
    watcher.wait("the note", || watcher.text().contains("live      a viewer has set camera.lon"));
    let kept = folder.text("out/live.toml");
    assert_eq!(kept, viewer.get("/api/scene").json()["text"]);

    // Questions are answered from it, and what cannot be drawn is refused.
    let histogram = viewer.get("/api/histogram?field=theta").json();
    assert!(histogram["counts"].as_array().unwrap().iter().any(|count| *count != 0));
    let probe = viewer.get("/api/probe?x=0.5&y=0.5").json();
    assert!(probe["value"].is_f64() && probe["error"].is_f64(), "{probe}");
    let unknown = viewer.post("/api/change", r#"{"changes":[{"path":["field"],"value":"zzz"}]}"#);
    assert!(unknown.status == 400 && String::from_utf8_lossy(&unknown.body).contains("expected one of"));
    let layer = r#"{"changes":[{"path":["surfaces"],"value":[{"layer":77,"color":"red"}]}]}"#;
    assert_eq!(viewer.post("/api/change", layer).status, 200);
    watcher.wait("the refusal", || viewer.get("/api/scene").json()["text"] == *kept);

    // The next time is drawn as the viewer has set it.
    comes(1);
    watcher.wait_for("2013-10-26.png");
    watcher.expect_drawn(2);
    watcher.stop();
    folder.write("scene.toml", kept);
    folder.prints("render finished.nc --scene scene.toml --time 1 -o rendered.png");
    assert!(pixels(&folder.at("rendered.png")) == pixels(&folder.at("out/2013-10-26.png")));
}
