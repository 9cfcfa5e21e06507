//! A view's keys over those of the file.

use super::section::section;
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
