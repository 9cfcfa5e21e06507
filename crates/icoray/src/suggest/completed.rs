//! Completes scenes that name a field and leave its look to the suggestion.

use super::Options;
use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::Script;
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Keys of a scene that define the look of fields.
const LOOK: [&str; 5] = ["transfer", "opacity", "volumes", "surfaces", "isosurfaces"];
/// Further keys of scenes for which no scene is suggested: they may draw without a volume, or several pictures.
const OTHER: [&str; 4] = ["lines", "ground", "derive", "sweep"];
/// Further keys that a suggestion fits to its field.
const SUGGESTED: [&str; 5] = ["exaggeration", "light", "ground", "lines", "clip"];

/// The names of the views of a scene's text that only name a field; the name is empty for a text without `[[views]]`.
pub fn open_views(text: &str) -> BTreeSet<String> {
    views(text).into_iter().filter(|(_, keys)| is_open(keys)).map(|(name, _)| name).collect()
}

/// A scene to be completed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Completion<'c> {
    /// Its text.
    pub text: &'c str,
    /// The view to complete, instead of all that only name a field; `""` in a text without views.
    pub view: Option<&'c str>,
    /// A field to show instead of the view's own.
    pub field: Option<&'c str>,
    /// Whether deriving fields and setting the picture's size are excluded.
    pub is_steered: bool,
}

/// Returns the scene that is suggested for a field (`""` for the first one); `None` if there is no suggestion.
pub type Suggest<'s> = dyn FnMut(&str, Options) -> Result<Option<String>> + 's;

/// The text of a scene in which each view that only names a field has the keys of the scene that `suggested` returns
/// for this field; the view's own keys, such as `[camera]` or `every`, take precedence. `None` if all views have a look
/// of their own, if `suggested` returns none, or if the text is no TOML.
///
/// With a [`Completion::field`] each view shows that field: its keys for the look of other fields are left out, and so
/// are those that `suggested` returns for the previous field.
///
/// # Errors
/// Those of `suggested`; [`ErrorKind::Scene`] if the texts cannot be merged.
pub fn completed(wanted: &Completion, suggested: &mut Suggest) -> Result<Option<String>> {
    let mut whole = None;
    let is_wanted = |name: &str| wanted.view.is_none_or(|view| view == name);
    for (name, mut own) in views(wanted.text).into_iter().filter(|(name, _)| is_wanted(name)) {
        match wanted.field {
            Some(field) => show(&mut own, field, wanted.is_steered, suggested),
            None if !is_open(&own) => continue,
            None => (),
        }
        let Some(keys) = with_look(&own, wanted.is_steered, suggested)? else { continue };
        let before = whole.as_deref().unwrap_or(wanted.text);
        whole = Some(if name.is_empty() { written(&keys)? } else { with_view(before, &name, keys)? });
    }
    Ok(whole)
}

/// The views of a text by name, each with its keys and those of the file.
fn views(text: &str) -> Vec<(String, Table)> {
    let Ok(whole) = text.parse::<Table>() else { return Vec::new() };
    let Some(Value::Array(views)) = whole.get("views") else { return vec![(String::new(), single_volume(whole))] };
    let keys = |view: &Value| {
        let name = view.get("name")?.as_str()?;
        let mut keys = Script::text_with(text, Some(name), "").ok()?.parse::<Table>().ok()?;
        keys.remove("views");
        Some((name.to_owned(), single_volume(keys)))
    };
    views.iter().filter_map(keys).collect()
}

/// The keys, with a volume that only names a field as the scene's `field`.
fn single_volume(mut keys: Table) -> Table {
    if let Some([Value::Table(volume)]) = keys.get("volumes").and_then(Value::as_array).map(Vec::as_slice)
        && volume.keys().eq(["field"])
    {
        let field = volume["field"].clone();
        keys.remove("volumes");
        keys.insert("field".into(), field);
    }
    keys
}

fn is_open(keys: &Table) -> bool {
    !keys.is_empty() && !LOOK.into_iter().chain(OTHER).any(|key| keys.contains_key(key))
}

/// Makes the keys show another field.
fn show(keys: &mut Table, field: &str, is_steered: bool, suggested: &mut Suggest) {
    // Removes the keys of the suggestion for the previous field; without one, all keys stay.
    let before = suggested(&model_field(keys), options(&Table::new(), is_steered)).ok().flatten();
    let before = before.and_then(|text| text.parse::<Table>().ok()).unwrap_or_default();
    for key in SUGGESTED {
        if keys.get(key) == before.get(key) {
            keys.remove(key);
        }
    }
    LOOK.into_iter().for_each(|key| drop(keys.remove(key)));
    if !is_steered {
        keys.remove("derive");
    }
    // The long name of another field.
    if let Some(Value::Table(labels)) = keys.get_mut("labels") {
        labels.remove("name");
    }
    keys.insert("field".into(), field.into());
}

/// The model's field that the keys show, or whose anomaly they show.
fn model_field(keys: &Table) -> String {
    let name = keys.get("field").and_then(Value::as_str).unwrap_or("");
    let derived = keys.get("derive").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let its = derived.iter().find(|derived| derived.get("name").and_then(Value::as_str) == Some(name));
    its.and_then(|derived| derived.get("anomaly")?.as_str()).unwrap_or(name).to_owned()
}

fn options(own: &Table, is_steered: bool) -> Options {
    let image = own.get("image");
    let side = |key| image?.get(key)?.as_integer()?.try_into().ok();
    Options {
        exaggeration: own.get("exaggeration").and_then(number),
        size: side("width").zip(side("height")),
        is_underived: is_steered,
        ..Options::default()
    }
}

/// A view's own keys, and those of the suggestion for its field; names of files are only its own.
fn with_look(own: &Table, is_steered: bool, suggested: &mut Suggest) -> Result<Option<Table>> {
    let name = own.get("field").and_then(Value::as_str).unwrap_or("");
    let Some(suggested) = suggested(name, options(own, is_steered))? else { return Ok(None) };
    let mut suggested = parsed(&suggested)?;
    suggested.remove("output");
    if is_steered {
        suggested.remove("image");
    }
    if own.get("core").and_then(Value::as_str) == Some("transparent") {
        // There is no ground to paint.
        suggested.remove("ground");
        if let Some(Value::Array(lines)) = suggested.get_mut("lines") {
            lines.retain(|lines| lines.get("on").and_then(Value::as_str) != Some("ground"));
        }
    }
    parsed(&Script::text_with(&written(&suggested)?, None, &written(own)?)?).map(Some)
}

/// The text with these keys in its view of that name, except for those that the whole file has.
fn with_view(text: &str, name: &str, mut keys: Table) -> Result<String> {
    let mut whole = parsed(text)?;
    keys.retain(|key, value| whole.get(key) != Some(value));
    keys.insert("name".into(), name.into());
    let views = whole.get_mut("views").and_then(Value::as_array_mut);
    let its = views.and_then(|views| views.iter_mut().find(|view| view.get("name") == keys.get("name")));
    if let Some(its) = its {
        *its = keys.into();
    }
    written(&whole)
}

fn parsed(text: &str) -> Result<Table> {
    text.parse().map_err(|e| Error::new(ErrorKind::Scene, format!("cannot read the scene: {e}")))
}

fn written(keys: &Table) -> Result<String> {
    toml::to_string(keys).map_err(|e| Error::new(ErrorKind::Scene, format!("cannot write the scene: {e}")))
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
}
