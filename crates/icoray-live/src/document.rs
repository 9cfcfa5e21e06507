//! A scene as the text of its file: comments and order remain when viewers change its keys.

use serde::Deserialize;
use serde_json::Value as Json;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value};

/// Depth of the deepest key that a change may name, in steps from the top: no scene has a deeper one. The new value is
/// JSON, whose depth its parser bounds, as TOML's does for texts.
const MAX_DEPTH: usize = 16;

/// A change of one key.
#[derive(Debug, Clone, Deserialize, PartialEq)]
pub(crate) struct Change {
    /// Names of sections and keys, and numbers of entries of lists, from the top.
    path: Vec<Step>,
    /// The new value; null removes the key or the entry.
    #[serde(default)]
    value: Json,
}

impl Change {
    /// Sets a key.
    pub fn of(path: &[&str], value: impl Into<Json>) -> Self {
        Change { path: path.iter().map(|key| Step::Key((*key).to_owned())).collect(), value: value.into() }
    }
}

#[derive(Debug, Clone, Deserialize, PartialEq)]
#[serde(untagged)]
enum Step {
    Key(String),
    Entry(usize),
}

/// The text after the changes, which are applied together. In a script with views, `view` is the number of the changed
/// one: a key is set there if the view has the section or key itself, else at the top, for all views.
///
/// # Errors
/// A sentence that names the path or the line.
pub(crate) fn changed(text: &str, changes: &[Change], view: Option<usize>) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| e.to_string())?;
    for Change { path, value } in changes {
        if path.len() > MAX_DEPTH {
            return Err(format!("a key {} steps from the top, expected at most {MAX_DEPTH}", path.len()));
        }
        let of_view = view.filter(|view| is_in_view(document.as_table(), *view, path));
        let place = of_view.map(|view| vec![Step::Key("views".to_owned()), Step::Entry(view)]);
        let whole = [&place.unwrap_or_default()[..], path].concat();
        let done = match whole.split_first() {
            Some((Step::Key(key), rest)) => set_in_table(document.as_table_mut(), key, rest, value),
            _ => Err("expected the name of a key or section first".to_owned()),
        };
        done.map_err(|e| format!("{}: {e}", shown(path)))?;
    }
    Ok(document.to_string())
}

/// Whether a view itself has the section or key at the beginning of a path.
fn is_in_view(document: &Table, view: usize, path: &[Step]) -> bool {
    let Some(Step::Key(key)) = path.first() else { return false };
    document.get("views").and_then(|views| views.get(view)).is_some_and(|view| view.get(key).is_some())
}

/// The scene as JSON; in a script with views the keys of `view` replace those at the top.
pub(crate) fn values(text: &str, view: Option<usize>) -> Json {
    let document = toml::from_str(text).unwrap_or(Json::Null);
    let (Some(view), Json::Object(mut all)) = (view, document.clone()) else { return document };
    let Some(mut own) = all.remove("views").and_then(|mut views| Some(views.get_mut(view)?.take())) else {
        return document;
    };
    if let Json::Object(own) = &mut own {
        own.remove("name");
    }
    let mut values = Json::Object(all);
    lay_over(&mut values, own);
    values
}

fn lay_over(base: &mut Json, over: Json) {
    match (base, over) {
        (Json::Object(base), Json::Object(over)) => {
            for (key, value) in over {
                lay_over(base.entry(key).or_insert(Json::Null), value);
            }
        }
        (base, over) => *base = over,
    }
}

/// The keys in which two texts differ, as `camera.lon`.
pub(crate) fn differences(before: &str, after: &str) -> Vec<String> {
    let mut all = Vec::new();
    differing("", &values(before, None), &values(after, None), &mut all);
    all
}

fn differing(name: &str, before: &Json, after: &Json, all: &mut Vec<String>) {
    match (before, after) {
        (before, after) if before == after => (),
        (Json::Object(keys), Json::Object(left)) => {
            let gone = keys.keys().filter(|key| !left.contains_key(*key));
            for key in gone.chain(left.keys()) {
                let name = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
                differing(&name, &before[key], &after[key], all);
            }
        }
        _ => all.push(name.to_owned()),
    }
}

fn shown(path: &[Step]) -> String {
    let words = path.iter().map(|step| match step {
        Step::Key(key) => key.clone(),
        Step::Entry(number) => number.to_string(),
    });
    words.collect::<Vec<_>>().join(".")
}

fn set_in_table(table: &mut Table, key: &str, rest: &[Step], value: &Json) -> Result<(), String> {
    if rest.is_empty() {
        match new_item(value)? {
            None => drop(table.remove(key)),
            Some(item) => replace(table.entry(key).or_insert(Item::None), item),
        }
        return Ok(());
    }
    if value.is_null() && !table.contains_key(key) {
        return Ok(());
    }
    let item = table.entry(key).or_insert_with(|| new_container(&rest[0]));
    set_in_item(item, rest, value)?;
    let is_empty = match &*item {
        Item::ArrayOfTables(list) => list.is_empty(),
        Item::Value(Value::Array(list)) => list.is_empty(),
        _ => false,
    };
    if is_empty {
        table.remove(key);
    }
    Ok(())
}

/// Sets the value at `path`, of at least one step, below an item.
fn set_in_item(item: &mut Item, path: &[Step], value: &Json) -> Result<(), String> {
    let (first, rest) = (&path[0], &path[1..]);
    match (item, first) {
        (Item::Table(table), Step::Key(key)) => set_in_table(table, key, rest, value),
        (Item::ArrayOfTables(list), Step::Entry(number)) => set_in_list(list, *number, rest, value),
        (Item::Value(its), _) => set_in_value(its, path, value),
        (item, _) => Err(format!("expected no such key in a {}", item.type_name())),
    }
}

fn expect_entry(number: usize, len: usize) -> Result<(), String> {
    if number > len { Err(format!("entry {number}, expected 0 to {len}")) } else { Ok(()) }
}

fn set_in_list(list: &mut ArrayOfTables, number: usize, rest: &[Step], value: &Json) -> Result<(), String> {
    let len = list.len();
    expect_entry(number, len)?;
    if rest.is_empty() && value.is_null() {
        if number < len {
            list.remove(number);
        }
        return Ok(());
    }
    if number == len {
        list.push(Table::new());
    }
    let table = list.get_mut(number).expect("there is an entry of this number");
    match rest {
        [] => {
            let Json::Object(keys) = value else { return Err("expected a table".to_owned()) };
            table.clear();
            keys.iter().try_for_each(|(key, value)| set_in_table(table, key, &[], value))
        }
        [Step::Key(key), rest @ ..] => set_in_table(table, key, rest, value),
        [Step::Entry(number), ..] => Err(format!("{number}, expected the name of a key")),
    }
}

/// Sets a value below another value, which is a list or a table on one line.
fn set_in_value(its: &mut Value, path: &[Step], value: &Json) -> Result<(), String> {
    let Some((first, rest)) = path.split_first() else {
        *its = new_value(value)?;
        return Ok(());
    };
    match (its, first) {
        (Value::InlineTable(table), Step::Key(key)) => {
            if rest.is_empty() && value.is_null() {
                table.remove(key);
                return Ok(());
            }
            let missing = || match rest.first() {
                Some(Step::Entry(_)) => Value::Array(Array::new()),
                _ => Value::InlineTable(InlineTable::new()),
            };
            let inner = table.entry(key).or_insert_with(missing);
            set_in_value(inner, rest, value)
        }
        (Value::Array(list), Step::Entry(number)) => {
            let len = list.len();
            expect_entry(*number, len)?;
            if rest.is_empty() && value.is_null() {
                if *number < len {
                    list.remove(*number);
                }
                return Ok(());
            }
            if *number == len {
                list.push(InlineTable::new());
            }
            set_in_value(list.get_mut(*number).expect("there is an entry of this number"), rest, value)
        }
        (its, _) => Err(format!("expected no such key in a {}", its.type_name())),
    }
}

/// Replaces an item by another, and keeps the comments around it.
fn replace(place: &mut Item, item: Item) {
    match (place, item) {
        (Item::Value(old), Item::Value(mut new)) => {
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        (place, item) => *place = item,
    }
}

/// The new value of a missing key below which a value is to be set.
fn new_container(inner: &Step) -> Item {
    match inner {
        Step::Key(_) => Item::Table(Table::new()),
        Step::Entry(_) => Item::ArrayOfTables(ArrayOfTables::new()),
    }
}

/// The item of a JSON value, `None` for null. Lists of tables and tables become sections.
fn new_item(value: &Json) -> Result<Option<Item>, String> {
    Ok(match value {
        Json::Null => None,
        Json::Object(keys) => {
            let mut table = Table::new();
            keys.iter().try_for_each(|(key, value)| set_in_table(&mut table, key, &[], value))?;
            Some(Item::Table(table))
        }
        value => Some(Item::Value(new_value(value)?)),
    })
}

fn new_value(value: &Json) -> Result<Value, String> {
    Ok(match value {
        Json::Null => return Err("null, expected a value".to_owned()),
        Json::Bool(flag) => Value::from(*flag),
        Json::String(text) => Value::from(text.as_str()),
        Json::Number(number) => match number.as_i64() {
            Some(whole) => Value::from(whole),
            None => Value::from(number.as_f64().ok_or_else(|| format!("{number}, expected a number"))?),
        },
        Json::Array(items) => Value::Array(items.iter().map(new_value).collect::<Result<_, _>>()?),
        Json::Object(keys) => {
            let mut table = InlineTable::new();
            for (key, value) in keys {
                table.insert(key, new_value(value)?);
            }
            Value::InlineTable(table)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const SCENE: &str = "# A scene.\nfield = \"theta\" # potential temperature\ncamera = { lon = 3, lat = 4 }\n\n\
                         [transfer]\nmap = \"viridis\"\n# two cuts\n[[clip]]\nlon = [0, 90]\n[[clip]]\nlat = [0, 9]\n";

    fn after(text: &str, changes: Json) -> Result<String, String> {
        let changes: Vec<Change> = serde_json::from_value(changes).unwrap();
        changed(text, &changes, None)
    }

    #[test]
    fn changes_keep_comments_and_the_rest() {
        let text = after(
            SCENE,
            json!([
                { "path": ["field"], "value": "w" },
                { "path": ["camera", "lon"], "value": -12.5 },
                { "path": ["clip", 0], "value": null },
                { "path": ["transfer", "range"], "value": [1, 2.5] },
            ]),
        );
        let expected = SCENE.replace("theta", "w").replace("lon = 3", "lon = -12.5").replace(
            "map = \"viridis\"\n# two cuts\n[[clip]]\nlon = [0, 90]\n",
            "map = \"viridis\"\nrange = [1, 2.5]\n",
        );
        assert_eq!(text.unwrap(), expected);
    }

    #[test]
    fn missing_sections_and_entries_are_made_and_empty_lists_removed() {
        let text = after(
            "field = \"q\"\n",
            json!([
                { "path": ["light", "kind"], "value": "sun" },
                { "path": ["surfaces", 0, "layer"], "value": 3 },
                { "path": ["surfaces", 1], "value": { "layer": "top", "transfer": { "map": "vik" } } },
                { "path": ["transfer", "opacity"], "value": [[0, 0], [1, 0.5]] },
                { "path": ["transfer", "range", "union"], "value": [1, 99] },
            ]),
        );
        let text = text.unwrap();
        let expected = json!({
            "field": "q",
            "light": { "kind": "sun" },
            "surfaces": [{ "layer": 3 }, { "layer": "top", "transfer": { "map": "vik" } }],
            "transfer": { "opacity": [[0, 0], [1, 0.5]], "range": { "union": [1, 99] } },
        });
        assert_eq!(values(&text, None), expected, "{text}");
        let removed = json!([{ "path": ["surfaces", 1], "value": null }, { "path": ["surfaces", 0], "value": null },
                             { "path": ["nothing", "here"], "value": null }]);
        let text = after(&text, removed).unwrap();
        assert_eq!(values(&text, None).get("surfaces"), None, "{text}");
    }

    #[test]
    fn impossible_changes_are_refused_with_the_path_of_the_key() {
        for (path, value, wanted) in [
            (json!(["field", "x"]), json!(1), "field.x: "),
            (json!(["clip", 7]), json!({}), "clip.7: entry 7, expected 0 to 2"),
            (json!(["clip", 0]), json!(1), "clip.0: expected a table"),
            (json!([]), json!(1), "expected the name"),
            (json!([0]), json!(1), "expected the name"),
            (json!(["camera", 0]), json!(1), "camera.0: "),
        ] {
            let error = after(SCENE, json!([{ "path": path, "value": value }])).unwrap_err();
            assert!(error.contains(wanted), "{path}: {error}");
        }
        assert!(changed("a = ", &[], None).is_err());
    }

    /// Input of any depth is processed only to a depth that fits on every stack.
    #[test]
    fn depth_has_a_bound() {
        for (steps, is_taken) in [(MAX_DEPTH, true), (MAX_DEPTH + 1, false), (100_000, false)] {
            let change = json!([{ "path": vec!["a"; steps], "value": 1 }]);
            assert_eq!(after("", change).is_ok(), is_taken, "{steps}");
        }
        let deep = |steps: usize| format!("{}1{}", "{\"a\":".repeat(steps), "}".repeat(steps));
        let request = |steps: usize| format!("[{{ \"path\": [\"b\"], \"value\": {} }}]", deep(steps));
        assert!(serde_json::from_str::<Vec<Change>>(&request(100_000)).is_err());
        let text = changed("", &serde_json::from_str::<Vec<Change>>(&request(100)).unwrap(), None).unwrap();
        assert!(changed(&text, &[], None).is_err(), "deeper than texts are");
        for deep in ["a.".repeat(100_000) + "a = 1", format!("a = {}", "[".repeat(100_000))] {
            assert!(changed(&deep, &[], None).is_err());
        }
    }

    #[test]
    fn changes_of_a_view_go_where_its_keys_stand() {
        let text = "field = \"q\"\ncamera = { lon = 1, lat = 2 }\n[[views]]\nname = \"a\"\n\
                    camera = { lon = 7 } # its own\n[[views]]\nname = \"b\"\n";
        let changes: Vec<Change> = serde_json::from_value(json!([
            { "path": ["camera", "lat"], "value": 3 },
            { "path": ["field"], "value": "w" },
        ]))
        .unwrap();
        let [a, b] = [0, 1].map(|view| changed(text, &changes, Some(view)).unwrap());
        let field = text.replace("\"q\"", "\"w\"");
        assert_eq!(a, field.replace("{ lon = 7 }", "{ lon = 7 , lat = 3 }"));
        assert_eq!(b, field.replace("lat = 2", "lat = 3"));
        let expected = json!({ "field": "w", "camera": { "lon": 7, "lat": 3 } });
        assert_eq!(values(&a, Some(0)), expected);
        assert_eq!(values(&b, Some(1)), json!({ "field": "w", "camera": { "lon": 1, "lat": 3 } }));
        let added = json!([{ "path": ["views", 2], "value": { "name": "c", "camera": { "lon": 5 } } }]);
        let added = changed(text, &serde_json::from_value::<Vec<Change>>(added).unwrap(), Some(0)).unwrap();
        assert_eq!(values(&added, Some(2))["camera"], json!({ "lon": 5, "lat": 2 }));
        assert_eq!(differences(text, &a), ["field", "views"]);
        assert_eq!(differences(text, &b), ["camera.lat", "field"]);
    }
}
