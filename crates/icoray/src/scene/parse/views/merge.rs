//! A view's keys over those of the file.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What goes instead of what: where a view gives one of the first keys of a section, the second ones of the file do not
/// count for it.
const INSTEAD: [(&str, &[&str], &[&str]); 11] = [
    ("", &["every", "at_steps", "at_times"], &["every", "at_steps", "at_times"]),
    ("camera", &["eye", "target", "up"], &["lon", "lat", "distance", "altitude", "path"]),
    ("camera", &["lon", "lat"], &["eye", "target", "up", "path"]),
    ("camera", &["distance"], &["altitude", "eye", "target", "up"]),
    ("camera", &["altitude"], &["distance", "eye", "target", "up"]),
    ("camera", &["path"], &["lon", "lat", "eye", "target", "up", "orbit"]),
    ("camera", &["orbit"], &["path"]),
    (
        "transfer",
        &["knots"],
        &["map", "reverse", "range", "opacity", "opacity_in", "scale", "threshold", "center"],
    ),
    ("transfer", &["map", "range", "opacity"], &["knots"]),
    ("transfer", &["scale"], &["threshold"]),
    ("light", &["kind"], &["lon", "lat"]),
];

/// Puts `over` over `base`, key by key; `path` is the section that both are.
pub fn merge<'t>(base: &mut DeTable<'t>, over: DeTable<'t>, path: &str) {
    for (_, given, instead) in INSTEAD.iter().filter(|(section, ..)| *section == path) {
        if given.iter().any(|key| over.contains_key(*key)) {
            instead.iter().for_each(|key| drop(base.remove(*key)));
        }
    }
    for (key, value) in over {
        let span = value.span();
        let under = base.remove(key.get_ref().as_ref() as &str).map(Spanned::into_inner);
        let merged = match (under, value.into_inner()) {
            (Some(DeValue::Table(mut under)), DeValue::Table(over)) => {
                let path = if path.is_empty() {
                    key.get_ref().to_string()
                } else {
                    format!("{path}.{}", key.get_ref())
                };
                merge(&mut under, over, &path);
                DeValue::Table(under)
            }
            (_, value) => value,
        };
        base.insert(key, Spanned::new(span, merged));
    }
}
