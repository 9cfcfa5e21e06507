//! The scenes in the README and the book are scenes.

use icoray_scene::Script;
use std::fs;
use std::path::{Path, PathBuf};
use toml::Table;

/// What a block marked `toml part` leaves out.
const REST: &str = "field = 'theta'\ncamera = { lon = 0, lat = 0, distance = 3 }\n\
                    [transfer]\nmap = 'viridis'\nrange = [0, 1]\nopacity = [[0, 0], [1, 0.5]]\n";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The blocks of a page whose info string is `info`.
fn blocks(page: &str, info: &str) -> Vec<String> {
    let begin = format!("\n```{info}\n");
    let starts = page.split(&begin).skip(1);
    starts.map(|rest| rest.split("\n```").next().unwrap_or_default().to_owned()).collect()
}

/// A part of a scene with the keys that it leaves out.
fn completed(part: &str) -> Table {
    let mut scene: Table = part.parse().unwrap_or_else(|e| panic!("{e}\n{part}"));
    let has_volumes = scene.contains_key("volumes");
    for (key, value) in REST.parse::<Table>().unwrap() {
        match scene.get_mut(&key) {
            None if has_volumes && key != "camera" => continue,
            None => drop(scene.insert(key, value)),
            // A camera that a sweep places, say.
            Some(toml::Value::Table(own)) if key == "camera" && !own.contains_key("eye") => {
                let others = value.as_table().unwrap().clone();
                own.extend(others.into_iter().filter(|(key, _)| key == "distance"));
            }
            Some(_) => (),
        }
    }
    scene
}

#[test]
fn scenes_of_the_pages_are_scenes() {
    let folder = root().join("docs/src");
    let pages = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let mut count = 0;
    for page in pages.filter(|path| path.extension().is_some_and(|end| end == "md")).chain([root().join("README.md")]) {
        let text = fs::read_to_string(&page).unwrap();
        for scene in blocks(&text, "toml") {
            Script::parse(&scene).unwrap_or_else(|e| panic!("{}: {e}\n{scene}", page.display()));
            count += 1;
        }
        for part in blocks(&text, "toml part") {
            let scene = completed(&part).to_string();
            Script::parse(&scene).unwrap_or_else(|e| panic!("{}: {e}\n{scene}", page.display()));
            count += 1;
        }
    }
    assert!(count > 15, "{count}");
}
