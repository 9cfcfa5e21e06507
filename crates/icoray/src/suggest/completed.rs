//! Completes scenes that name a field and leave its look to the suggestion.

use super::Options;
use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::{Level, Script, is_color_map};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Keys of a scene that define the look of fields.
const LOOK: [&str; 5] = ["transfer", "opacity", "volumes", "surfaces", "isosurfaces"];
/// Keys of scenes for which no scene is suggested: they have a look of their own, or several pictures.
const CLOSED: [&str; 4] = ["opacity", "volumes", "derive", "sweep"];
/// Further keys that a suggestion fits to its field.
const SUGGESTED: [&str; 5] = ["exaggeration", "light", "ground", "lines", "clip"];

/// The names of the views of a scene's text that leave their look to the suggestion; the name is empty for a text without
/// `[[views]]`.
pub fn open_views(text: &str) -> BTreeSet<String> {
    views(text).into_iter().filter(|(_, keys)| is_open(keys)).map(|(name, _)| name).collect()
}

/// A scene to be completed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Completion<'c> {
    /// Its text.
    pub text: &'c str,
    /// The view to complete, instead of all that leave their look to the suggestion; `""` in a text without views.
    pub view: Option<&'c str>,
    /// A field to show instead of the view's own.
    pub field: Option<&'c str>,
    /// Whether deriving fields and setting the picture's size are excluded.
    pub is_steered: bool,
}

/// Returns the scene that is suggested for a field (`""` for the first one); `None` if there is no suggestion.
pub type Suggest<'s> = dyn FnMut(&str, Options) -> Result<Option<String>> + 's;

/// The text of a scene in which each view that leaves its look to the suggestion has the keys of the scene that
/// `suggested` returns for its field; the view's own keys, such as `[camera]` or `every`, take precedence. `None` if all
/// views have a look of their own, if `suggested` returns none, or if the text is no TOML.
///
/// A view leaves its look to the suggestion if it states nothing of it but
///
/// - the colours of a volume: a `[transfer]` of `map`, of a `range` of two numbers, or of both;
/// - `[[lines]]` and `[ground]` beside a `field`;
/// - `[[surfaces]]` or `[[isosurfaces]]`, without `[transfer]` and `[labels]`.
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
    let has = |key: &str| keys.contains_key(key);
    let has_surfaces = has("surfaces") || has("isosurfaces");
    // Lines and ground alone are a picture without a volume.
    let is_shown = has("field") || has_surfaces || !has("lines") && !has("ground");
    let is_complete = has_surfaces && (has("transfer") || has("labels"));
    let leaves_opacity = || colored(keys, Options::default()).is_some();
    !keys.is_empty() && !CLOSED.into_iter().any(has) && is_shown && !is_complete && leaves_opacity()
}

/// The options with the map and the range of the keys' `[transfer]`; `None` for a transfer function with other keys.
fn colored(keys: &Table, options: Options) -> Option<Options> {
    let Some(transfer) = keys.get("transfer") else { return Some(options) };
    let transfer = transfer.as_table().filter(|transfer| !transfer.is_empty())?;
    let mut options = options;
    for (key, value) in transfer {
        match key.as_str() {
            "map" => options.color_map = Some(value.as_str().filter(|name| is_color_map(name))?.to_owned()),
            "range" => options.range = Some(range(value)?),
            _ => return None,
        }
    }
    Some(options)
}

/// Two finite numbers, the lower first.
fn range(value: &Value) -> Option<[f64; 2]> {
    let ends: Option<Vec<f64>> = value.as_array()?.iter().map(number).collect();
    let range = <[f64; 2]>::try_from(ends?).ok()?;
    (range[0] < range[1] && range.iter().all(|end| end.is_finite())).then_some(range)
}

/// The first entry of a list of tables.
fn first<'k>(keys: &'k Table, list: &str) -> Option<&'k Table> {
    keys.get(list)?.as_array()?.first()?.as_table()
}

/// The value of the first isosurface.
fn isosurface(keys: &Table) -> Option<f64> {
    let its = first(keys, "isosurfaces")?;
    its.get("value").or_else(|| its.get("values")?.as_array()?.first()).and_then(number)
}

/// The level of the first surface.
fn surface(keys: &Table) -> Option<Level> {
    let its = first(keys, "surfaces")?;
    if let Some(height_m) = its.get("height_m").and_then(number) {
        return Some(Level::Height(height_m));
    }
    Some(match its.get("layer") {
        Some(Value::String(word)) if word == "top" => Level::Top,
        Some(Value::Integer(number)) => Level::Layer(usize::try_from(*number).ok()?),
        _ => Level::Ground,
    })
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
    let name = field(keys);
    let derived = keys.get("derive").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let its = derived.iter().find(|derived| derived.get("name").and_then(Value::as_str) == Some(name));
    its.and_then(|derived| derived.get("anomaly")?.as_str()).unwrap_or(name).to_owned()
}

/// The field that the keys name: that of the scene, or of the first isosurface or surface; `""` for none.
fn field(keys: &Table) -> &str {
    let of_first = |list| first(keys, list)?.get("field");
    let named = keys.get("field").or_else(|| of_first("isosurfaces")).or_else(|| of_first("surfaces"));
    named.and_then(Value::as_str).unwrap_or("")
}

fn options(own: &Table, is_steered: bool) -> Options {
    let image = own.get("image");
    let side = |key| image?.get(key)?.as_integer()?.try_into().ok();
    let isosurface = isosurface(own);
    let options = Options {
        isosurface,
        surface: if isosurface.is_none() { surface(own) } else { None },
        exaggeration: own.get("exaggeration").and_then(number),
        size: side("width").zip(side("height")),
        is_underived: is_steered,
        ..Options::default()
    };
    colored(own, options.clone()).unwrap_or(options)
}

/// A view's own keys, and those of the suggestion for its field; names of files are only its own.
fn with_look(own: &Table, is_steered: bool, suggested: &mut Suggest) -> Result<Option<Table>> {
    let Some(suggested) = suggested(field(own), options(own, is_steered))? else { return Ok(None) };
    let (mut own, mut suggested) = (own.clone(), parsed(&suggested)?);
    suggested.remove("output");
    if !suggested.contains_key("transfer") {
        // The colours of a 2D field are those of its surface.
        own.remove("transfer");
    }
    color_first(&mut own, &suggested, "surfaces", "transfer");
    color_first(&mut own, &suggested, "isosurfaces", "color");
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
    parsed(&Script::text_with(&written(&suggested)?, None, &written(&own)?)?).map(Some)
}

/// Gives the first surface or isosurface of a list the suggested colours, unless it has some or shows another field.
fn color_first(own: &mut Table, suggested: &Table, list: &str, key: &str) {
    const COLORS: [&str; 5] = ["color", "colors", "color_by", "transfer", "values"];
    let Some(color) = first(suggested, list).and_then(|its| its.get(key)) else { return };
    let name = Value::from(field(own));
    let Some(Value::Array(entries)) = own.get_mut(list) else { return };
    if let Some(Value::Table(its)) = entries.first_mut()
        && its.get("field").is_none_or(|of| *of == name)
        && !COLORS.into_iter().any(|key| its.contains_key(key))
    {
        its.insert(key.into(), color.clone());
    }
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
