//! A view's keys over those of the file, and the text of a scene file with other keys.

use super::{section, take};
use crate::did_you_mean;
use crate::parse::text::Text;
use crate::script::Script;
use icoray_grid::{Error, ErrorKind, Result};
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys that exclude each other: if a view has one of the first keys, the second ones of the file are ignored for it.
const REPLACEMENTS: [(&[&str], &[&str]); 15] = [
    (&["volumes"], &["field", "transfer", "opacity", "sweep.field"]),
    (&["field", "transfer", "opacity", "sweep.field"], &["volumes"]),
    (&["every", "at_steps", "at_times"], &["every", "at_steps", "at_times"]),
    (
        &["camera.eye", "camera.target", "camera.up"],
        &["camera.lon", "camera.lat", "camera.distance", "camera.altitude", "camera.path"],
    ),
    (&["camera.lon", "camera.lat"], &["camera.eye", "camera.target", "camera.up", "camera.path"]),
    (&["camera.distance"], &["camera.altitude", "camera.eye", "camera.target", "camera.up"]),
    (&["camera.altitude"], &["camera.distance", "camera.eye", "camera.target", "camera.up"]),
    (&["camera.path"], &["camera.lon", "camera.lat", "camera.eye", "camera.target", "camera.up", "camera.orbit"]),
    (&["camera.path", "camera.eye"], &["sweep.lon", "sweep.lat", "sweep.distance"]),
    (&["camera.orbit"], &["camera.path", "sweep.lon"]),
    (&["sweep.lon", "sweep.lat", "sweep.distance"], &["camera.path", "camera.eye", "camera.target", "camera.up"]),
    (
        &["transfer.knots"],
        &[
            "transfer.map",
            "transfer.reverse",
            "transfer.range",
            "transfer.opacity",
            "transfer.opacity_in",
            "transfer.scale",
            "transfer.threshold",
            "transfer.center",
        ],
    ),
    (&["transfer.map", "transfer.range", "transfer.opacity"], &["transfer.knots"]),
    (&["transfer.scale"], &["transfer.threshold"]),
    (&["light.kind"], &["light.lon", "light.lat"]),
];

fn has(table: &DeTable, key: &str) -> bool {
    match key.split_once('.') {
        None => table.contains_key(key),
        Some((section, key)) => {
            table.get(section).and_then(|section| section.get_ref().as_table()).is_some_and(|t| has(t, key))
        }
    }
}

fn remove(table: &mut DeTable, key: &str) {
    match key.split_once('.') {
        None => drop(table.remove(key)),
        Some((name, key)) => {
            if let Some(inner) = section(table, name) {
                remove(inner, key);
                // An empty section is removed.
                if inner.is_empty() {
                    table.remove(name);
                }
            }
        }
    }
}

/// A view: `over` over `base`, key by key.
pub fn merge<'t>(base: &mut DeTable<'t>, over: DeTable<'t>) {
    for (given, replaced) in REPLACEMENTS {
        if given.iter().any(|key| has(&over, key)) {
            replaced.iter().for_each(|key| remove(base, key));
        }
    }
    override_keys(base, over);
}

fn override_keys<'t>(base: &mut DeTable<'t>, over: DeTable<'t>) {
    for (key, value) in over {
        let span = value.span();
        let under = base.remove(key.get_ref().as_ref() as &str).map(Spanned::into_inner);
        let merged = match (under, value.into_inner()) {
            (Some(DeValue::Table(mut under)), DeValue::Table(over)) => {
                override_keys(&mut under, over);
                DeValue::Table(under)
            }
            (_, value) => value,
        };
        base.insert(key, Spanned::new(span, merged));
    }
}

impl Script {
    /// The text of a scene file in which the keys of `over`, TOML too, stand in place of its own, as those of a view
    /// would: tables are merged key by key, arrays are replaced. With the name of a `view` of the file, the text has that
    /// view alone. Comments of the file are not kept.
    ///
    /// ```
    /// use icoray_scene::Script;
    ///
    /// let text = "field = 'q'
    ///             camera = { eye = [3, 0, 0] }
    ///             [[views]]
    ///             name = 'a'
    ///             [[views]]
    ///             name = 'b'
    ///             tolerance = 0.01";
    /// let text = Script::text_with(text, Some("b"), "camera = { lon = 10, lat = 20 }")?;
    /// let table: toml::Table = text.parse().unwrap();
    /// assert_eq!(table["tolerance"].as_float(), Some(0.01));
    /// assert_eq!(table["camera"].as_table().unwrap().len(), 2, "lon and lat go in place of eye");
    /// # Ok::<(), icoray_grid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] for texts that are not TOML, and for a view that the file does not have.
    pub fn text_with(text: &str, view: Option<&str>, over: &str) -> Result<String> {
        let source = &Text::new(text);
        let mut base = source.table()?;
        if let Some(name) = view {
            let over = named_view(source, base.get_mut(), name)?;
            merge(base.get_mut(), over);
        }
        merge(base.get_mut(), Text::new(over).table()?.into_inner());
        let mut table = toml::Table::deserialize(toml::Deserializer::from(base)).map_err(|e| source.refused(&e))?;
        if let Some(name) = view {
            // It keeps its name, which names of files may have.
            let name = toml::Table::from_iter([("name".to_owned(), name.into())]);
            table.insert("views".into(), toml::Value::Array(vec![name.into()]));
        }
        toml::to_string(&table).map_err(|e| Error::new(ErrorKind::Scene, format!("cannot write the scene: {e}")))
    }
}

/// Takes the views out of a file and returns the keys of one.
fn named_view<'t>(source: &Text, base: &mut DeTable<'t>, name: &str) -> Result<DeTable<'t>> {
    let mut names = Vec::new();
    if let Some(DeValue::Array(views)) = base.remove("views").map(Spanned::into_inner) {
        for view in views {
            let DeValue::Table(mut keys) = view.into_inner() else { continue };
            let its = take::<String>(source, &mut keys, "name")?.map(Spanned::into_inner).unwrap_or_default();
            if its == name {
                return Ok(keys);
            }
            names.push(its);
        }
    }
    let known =
        if names.is_empty() { "the scene has no [[views]]".into() } else { format!("expected one of {names:?}") };
    let hint = did_you_mean(name, names.iter().map(String::as_str));
    Err(Error::new(ErrorKind::Scene, format!("view {name:?}{hint}, {known}")))
}
