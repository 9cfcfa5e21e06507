//! The scenes in the README and the book: each is parsed, and the reference has every key that the parser knows.

use icoray::Script;
use std::collections::BTreeSet;
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
    for page in pages.filter(|path| path.is_file()).chain([root().join("README.md")]) {
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

/// The keys in the first column of the tables below a heading of the reference.
fn documented(reference: &str, heading: &str) -> BTreeSet<String> {
    let (_, rest) = reference.split_once(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("{heading}"));
    let section = rest.split("\n## ").next().unwrap();
    let cells = section.lines().filter(|line| line.starts_with("| `")).filter_map(|line| line.split('|').nth(1));
    let words = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
    words.filter(|word| word.chars().all(|c| c.is_ascii_lowercase() || c == '_')).map(str::to_owned).collect()
}

/// The keys that the parser expects where it finds `zzz`.
fn expected(section: &str) -> BTreeSet<String> {
    let scene = completed(section).to_string();
    let error = Script::parse(&scene).expect_err(section).to_string();
    let (found, list) = error.split_once("expected").unwrap_or_else(|| panic!("{error}"));
    assert!(found.contains("zzz"), "{error}");
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_reference_has_all_keys_of_each_section_and_no_others() {
    let reference = fs::read_to_string(root().join("docs/src/scene-reference.md")).unwrap();
    let whole = "transfer = { map = 'vik', range = [0, 1], opacity = [[0, 0.5]] }\n";
    for (heading, scene) in [
        ("`[image]`", "image = { width = 9, height = 9, zzz = 1 }"),
        ("`[camera]`", "camera = { lon = 0, lat = 0, distance = 3, zzz = 1 }"),
        ("`[transfer]`", "transfer = { map = 'vik', zzz = 1 }"),
        ("`[opacity]`", "opacity = { field = 'a', values = [[0, 0.5]], zzz = 1 }"),
        ("`[[volumes]]`", &format!("[[volumes]]\nfield = 'a'\nzzz = 1\n{whole}")),
        ("`[[surfaces]]`", "surfaces = [{ layer = 0, color = 'red', zzz = 1 }]"),
        ("`[[isosurfaces]]`", "isosurfaces = [{ field = 'a', value = 0, color = 'red', zzz = 1 }]"),
        ("`[[lines]]`", "lines = [{ pattern = 'coast', zzz = 1 }]"),
        ("`[ground]`", "ground = { zzz = 1 }"),
        ("`[[clip]]`", "clip = [{ cut = 'inside', lon = [0, 9], zzz = 1 }]"),
        ("`[[derive]]`", "derive = [{ name = 'a', zzz = 1 }]"),
        ("`[light]`", "light = { kind = 'none', zzz = 1 }"),
        ("`[labels]`", "labels = { zzz = 1 }"),
        ("`[output]`", "output = { zzz = 1 }"),
    ] {
        let mut found = documented(&reference, heading);
        if heading == "`[[output]]`" || heading == "`[output]`" {
            // Placeholders are in the same section.
            found.retain(|word| ["file", "error", "cinema", "concat", "fps"].contains(&word.as_str()));
        }
        assert_eq!(found, expected(scene), "{heading}");
    }
    let mut top = documented(&reference, "Top level");
    for heading in reference.lines().filter_map(|line| line.strip_prefix("## ")) {
        let name = heading.trim_matches(|c: char| !c.is_ascii_lowercase());
        top.extend(heading.starts_with('`').then(|| name.to_owned()));
    }
    top.extend(documented(&reference, "When a view is drawn"));
    assert_eq!(top, expected("zzz = 1"));
}
