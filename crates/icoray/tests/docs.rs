//! The scenes in the README and the book: each is parsed, and the reference has every key that the parser knows.

use icoray::Script;
use icoray::keys::{self, Section};
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

/// The keys of a section as the reference has them; of tables within, the table's own.
fn documented(section: &Section) -> BTreeSet<&'static str> {
    section.keys.iter().map(|key| key.name.split('.').next().unwrap_or_default()).collect()
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
    let whole = "transfer = { map = 'vik', range = [0, 1], opacity = [[0, 0.5]] }\n";
    let reference = fs::read_to_string(root().join("docs/src/scene-reference.md")).unwrap();
    let sections = keys::sections();
    for section in &sections {
        let scene = match section.name {
            "" => "zzz = 1".to_owned(),
            "image" => "image = { width = 9, height = 9, zzz = 1 }".to_owned(),
            "camera" => "camera = { lon = 0, lat = 0, distance = 3, zzz = 1 }".to_owned(),
            "transfer" => "transfer = { map = 'vik', zzz = 1 }".to_owned(),
            "opacity" => "opacity = { field = 'a', values = [[0, 0.5]], zzz = 1 }".to_owned(),
            "volumes" => format!("[[volumes]]\nfield = 'a'\nzzz = 1\n{whole}"),
            "surfaces" => "surfaces = [{ layer = 0, color = 'red', zzz = 1 }]".to_owned(),
            "isosurfaces" => "isosurfaces = [{ field = 'a', value = 0, color = 'red', zzz = 1 }]".to_owned(),
            "lines" => "lines = [{ pattern = 'coast', zzz = 1 }]".to_owned(),
            "clip" => "clip = [{ cut = 'inside', lon = [0, 9], zzz = 1 }]".to_owned(),
            "derive" => "derive = [{ name = 'a', zzz = 1 }]".to_owned(),
            "light" => "light = { kind = 'none', zzz = 1 }".to_owned(),
            name => format!("{name} = {{ zzz = 1 }}"),
        };
        let mut found: BTreeSet<&str> = documented(section);
        if section.name.is_empty() {
            found.extend(sections.iter().map(|section| section.name).filter(|name| !name.is_empty()));
            // Keys of scripts, which the reference has in sections of their own.
            let of_scripts = ["at_steps", "at_times", "when", "views", "sweep", "live"];
            found.extend(of_scripts.into_iter().filter(|key| {
                let headings = [format!("\n| `{key}` |"), format!("\n## `[{key}]`"), format!("\n## `[[{key}]]`")];
                headings.iter().any(|heading| reference.contains(heading))
            }));
        }
        let expected = expected(&scene);
        assert_eq!(found, expected.iter().map(String::as_str).collect(), "[{}]", section.name);
    }
}
