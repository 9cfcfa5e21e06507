//! Scenes that name a field and leave its look to the suggestion.

use super::Options;
use icoray_grid::Result;
use icoray_scene::Script;
use toml::{Table, Value};

/// Keys of a scene that give fields their look.
const LOOK: [&str; 5] = ["transfer", "opacity", "volumes", "surfaces", "isosurfaces"];
/// Further keys of scenes for which no scene is suggested: they may draw without a volume, or several pictures.
const OTHER: [&str; 5] = ["lines", "ground", "derive", "views", "sweep"];

/// The text of a scene that names a field alone, over the scene that `suggested` returns for this field (`""` for the
/// first one): its own keys, such as `[camera]` or `every`, go before those of the suggestion. `None` where the scene
/// has a look of its own, or is no TOML.
///
/// With a `field`, the scene is made to show that one: what it says of the look of others is left out.
///
/// # Errors
/// Those of `suggested`; [`ErrorKind::Scene`](icoray_grid::ErrorKind::Scene) where the texts cannot be merged.
pub fn completed(
    text: &str,
    field: Option<&str>,
    suggested: impl FnOnce(&str, Options) -> Result<String>,
) -> Result<Option<String>> {
    let Ok(mut own) = text.parse::<Table>() else { return Ok(None) };
    if let Some(field) = field {
        for key in LOOK.into_iter().chain(["derive"]) {
            own.remove(key);
        }
        // The long name of another field.
        if let Some(Value::Table(labels)) = own.get_mut("labels") {
            labels.remove("name");
        }
        own.insert("field".into(), field.into());
    } else if LOOK.into_iter().chain(OTHER).any(|key| own.contains_key(key)) {
        return Ok(None);
    }
    let image = own.get("image");
    let side = |key| image?.get(key)?.as_integer()?.try_into().ok();
    let options = Options {
        exaggeration: own.get("exaggeration").and_then(number),
        size: side("width").zip(side("height")),
        ..Options::default()
    };
    let name = own.get("field").and_then(Value::as_str).unwrap_or("");
    Script::text_with(&suggested(name, options)?, None, &own.to_string()).map(Some)
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
}
