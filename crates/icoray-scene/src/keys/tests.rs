//! The parser takes what the schema states and refuses everything else, and the reference has the schema's tables.

use super::*;
use crate::scene::Scene;
use crate::script::Script;
use icoray_grid::Result;
use std::path::Path;
use toml::{Table, Value};

/// Paths and keys of a whole file. Transfer functions are listed once, at the top.
fn all_keys() -> Vec<(String, &'static Key)> {
    fn add(all: &mut Vec<(String, &'static Key)>, prefix: &str, table: &Key) {
        for key in table.keys() {
            let path = format!("{prefix}{}", key.name);
            all.push((path.clone(), key));
            if key.name != "transfer" || prefix.is_empty() {
                add(all, &format!("{path}."), key);
            }
        }
    }
    let mut all = Vec::new();
    add(&mut all, "", &FILE);
    all
}

/// Keys of the table at `table` that the key at `path` needs beside it.
fn company(table: &str, path: &str) -> Table {
    let keys = match table {
        "" if !path.starts_with("volumes") => "field = 'f'",
        "camera" if ["camera.target", "camera.up"].contains(&path) => "eye = [3, 1, 0]",
        "camera.path" if path != "camera.path.time" => "step = 0",
        "transfer" if path != "transfer.scale" && !path.starts_with("transfer.knots") => {
            "scale = 'symlog'\nthreshold = 1\nopacity = [[0, 0.5]]\nopacity_in = 'values'"
        }
        "transfer.knots" => "value = 0\ncolor = 'red'",
        "transfer.range" if path.ends_with("hysteresis") => "union = [1, 99]",
        "isosurfaces" if path != "isosurfaces.values" => "value = 1",
        "clip" => "lat = [0, 1]",
        "clip.half_space" => "towards = [0, 0]",
        "derive" if path != "derive.magnitude" => "name = 'a'\nanomaly = 'b'\nfrom = 'zonal mean'",
        "derive" => "name = 'a'",
        "output" => "concat = 'a.ffconcat'",
        _ => "",
    };
    keys.parse().unwrap()
}

/// A file with a value for the key at `path`, or with the table around it alone.
fn file(path: &str, value: Option<Value>) -> String {
    let (mut path_left, mut value) = (path, value);
    loop {
        let (table_path, name) = path_left.rsplit_once('.').unwrap_or(("", path_left));
        let mut table = company(table_path, path);
        if let Some(value) = value {
            table.insert(name.to_owned(), value);
        }
        if table_path.is_empty() {
            return table.to_string();
        }
        let is_list = matches!(find(table_path).unwrap().kind, Kind::List(_));
        // A path has two places at least.
        let second = (table_path == "camera.path").then(|| Table::from_iter([("step".into(), 9.into())]));
        let entries = [table.clone()].into_iter().chain(second);
        value = Some(if is_list { entries.collect::<Vec<_>>().into() } else { table.into() });
        path_left = table_path;
    }
}

fn parsed(path: &str, value: Value) -> Result<Script> {
    Script::parse(&file(path, Some(value)))
}

/// Whether a value is refused with all of these words.
fn is_refused(path: &str, value: Value, words: &[&str]) -> bool {
    parsed(path, value).is_err_and(|error| words.iter().all(|word| error.context().contains(word)))
}

/// A value of which `number` is the one that matters; others are further inwards.
fn value_of(kind: Kind, number: f64, inwards: f64) -> Value {
    match kind {
        Kind::Integer | Kind::Layer(_) => Value::from(number as i64),
        Kind::Vector(_) => vec![number.min(number + inwards), number.max(number + inwards)].into(),
        Kind::List(of) => vec![value_of(*of, number, inwards)].into(),
        _ => Value::from(number),
    }
}

#[test]
fn numbers_just_within_the_bounds_are_taken_and_those_just_outside_are_refused() {
    let mut count = 0;
    for (path, key) in all_keys() {
        let next = |number: f64, up: f64| match key.kind {
            Kind::Integer | Kind::Layer(_) => number + up,
            _ if up > 0.0 => number.next_up(),
            _ => number.next_down(),
        };
        let text = key.bounds_text();
        let refused = |number, inwards| {
            let value = value_of(key.kind, number, inwards);
            is_refused(&path, value, &[&format!("key {path}"), &text]) || {
                // An inline table of a transfer function is checked as one value.
                path.starts_with("transfer.range.")
                    && is_refused(&path, value_of(key.kind, number, inwards), &["key transfer.range: ", &text])
            }
        };
        for (bound, inwards) in [(key.bounds.0, 1.0), (key.bounds.1, -1.0)] {
            let (within, outside) = match bound {
                Bound::Included(number) => (number, next(number, -inwards)),
                Bound::Excluded(number) => (next(number, inwards), number),
                Bound::Unbounded => continue,
            };
            assert!(!refused(within, inwards), "{path} = {within}: {:?}", key.bounds);
            assert!(refused(outside, inwards), "{path} = {outside}: {:?}", key.bounds);
            count += 1;
        }
    }
    assert!(count > 90, "{count}");
}

#[test]
fn lists_have_as_many_entries_as_the_schema_allows() {
    let counted: Vec<_> = all_keys().into_iter().filter(|(_, key)| key.count != [0, usize::MAX]).collect();
    assert_eq!(counted.len(), 12, "of knots, pairs of opacity (in [[volumes]] too), values, magnitudes, and sections");
    for (path, key) in counted {
        let entry = |i: usize| match key.kind {
            Kind::List(Kind::Text) => Value::from(format!("f{i}")),
            Kind::List(Kind::Vector(_)) => vec![i as f64, 0.5].into(),
            Kind::List(Kind::Number) => Value::from(i as f64),
            _ if path == "derive" => Value::from(Table::from_iter([
                ("name".to_owned(), format!("f{i}").into()),
                ("magnitude".to_owned(), vec!["a", "b"].into()),
            ])),
            Kind::List(Kind::Section) if path != "transfer.knots" => company(&path, &path).into(),
            _ => Value::from(format!("value = {i}\ncolor = 'red'\nopacity = 0.5").parse::<Table>().unwrap()),
        };
        let list = |count: usize| Value::from((0..count).map(entry).collect::<Vec<_>>());
        let [min, max] = key.count;
        for count in [min, max] {
            parsed(&path, list(count)).unwrap_or_else(|e| panic!("{path}: {e}"));
        }
        let words = format!("expected {min} to {max}");
        let mut wrong = min.checked_sub(1).into_iter().chain([max + 1]);
        assert!(wrong.all(|count| is_refused(&path, list(count), &[&path, &words])), "{path}");
    }
}

#[test]
fn words_are_the_choices() {
    let choosing: Vec<_> = all_keys().into_iter().filter(|(_, key)| !key.choices().is_empty()).collect();
    assert!(choosing.len() > 15, "{choosing:?}");
    for (path, key) in choosing {
        let is_listed =
            |error: &str, word: &str| [format!("{word:?}"), format!("`{word}`")].iter().any(|w| error.contains(w));
        let is_unknown = |word: &str| {
            let refused = parsed(&path, word.into()).err();
            refused.is_some_and(|error| {
                [&[word], key.choices()].concat().iter().all(|word| is_listed(error.context(), word))
            })
        };
        for word in key.choices() {
            assert!(!is_unknown(word), "{path} = {word}");
        }
        assert!(is_unknown("zzz"), "{path}");
    }
}

#[test]
fn absent_keys_have_the_defaults() {
    let mut count = 0;
    for (path, key) in all_keys() {
        let default = match key.default {
            DefaultValue::Number(number) => value_of(key.kind, number, 0.0),
            DefaultValue::Flag(flag) => flag.into(),
            DefaultValue::Word(word) => word.into(),
            DefaultValue::Toml(value) => format!("a = {value}").parse::<Table>().unwrap()["a"].clone(),
            _ => continue,
        };
        let [given, absent] = [file(&path, Some(default)), file(&path, None)];
        match (Scene::parse(&given), Scene::parse(&absent)) {
            (Ok(given), Ok(absent)) => assert_eq!(given, absent, "{path}"),
            // A scene does not have keys of scripts.
            _ => assert_eq!(Script::parse(&given).unwrap(), Script::parse(&absent).unwrap(), "{path}"),
        }
        count += 1;
    }
    assert!(count > 40, "{count}");
}

#[test]
fn errors_about_unknown_keys_list_those_of_the_table() {
    // A view may have any key of a scene.
    let tables = all_keys().into_iter().filter(|(path, key)| key.keys().next().is_some() && path != "views");
    for (path, table) in tables.chain([(String::new(), &FILE)]) {
        let unknown = format!("{path}.zzz");
        let error = parsed(unknown.trim_start_matches('.'), 1.into()).unwrap_err().to_string();
        let (found, expected) = error.split_once("expected").unwrap_or_else(|| panic!("{error}"));
        assert!(found.contains("zzz"), "{error}");
        assert!(table.keys().all(|key| expected.contains(key.name)), "{error}");
    }
}

/// The lines of the reference for the section at a path.
fn lines_of(path: &str) -> Vec<String> {
    let section = section_at(path).unwrap_or_else(|| panic!("no section {path:?}"));
    let row = |ListedKey { name, key }: &ListedKey| {
        format!("| `{name}` | {} | {} | {} | {} |", key.kind, key.default, key.range_text(), key.meaning)
    };
    let head = ["| key | type | default | range | meaning |", "|---|---|---|---|---|"].map(str::to_owned);
    // Keys that are sections of a section have their text in its table.
    let max = find(path).map_or(usize::MAX, |key| key.count[1]);
    let limit = if max == usize::MAX { String::new() } else { format!("At most {max} entries.") };
    let about = format!("{} {limit}", section.about).trim().to_owned();
    let is_listed = !about.is_empty() && !path.contains('.');
    let about = [about, String::new()].into_iter().filter(|_| is_listed);
    about.chain(head).chain(section.keys.iter().map(row)).collect()
}

#[test]
fn the_reference_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/scene-reference.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let mut current = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        current.push(line.to_owned());
        if let Some(section) = line.strip_prefix("<!-- keys").and_then(|line| line.strip_suffix("-->")) {
            current.extend(lines_of(section.trim()));
            current.extend(lines.find(|line| *line == "<!-- end -->").map(str::to_owned));
        }
    }
    let current = current.join("\n") + "\n";
    for (path, key) in all_keys() {
        assert!(current.contains(key.meaning), "the page has no keys of {path}'s section");
    }
    let writes = std::env::var_os("ICORAY_WRITE_REFERENCE").is_some();
    if writes {
        std::fs::write(&path, &current).unwrap();
    }
    assert!(
        writes || page == current,
        "docs/src/scene-reference.md is stale; write it anew with ICORAY_WRITE_REFERENCE=1 cargo test -p icoray-scene"
    );
}
