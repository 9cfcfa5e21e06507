//! A view's keys over those of the file.

use super::section;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What goes instead of what: where a view gives one of the first keys, the second ones of the file do not count for it.
const INSTEAD: [(&[&str], &[&str]); 15] = [
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
    (
        &["camera.path"],
        &["camera.lon", "camera.lat", "camera.eye", "camera.target", "camera.up", "camera.orbit"],
    ),
    (&["camera.path", "camera.eye"], &["sweep.lon", "sweep.lat", "sweep.distance"]),
    (&["camera.orbit"], &["camera.path", "sweep.lon"]),
    (
        &["sweep.lon", "sweep.lat", "sweep.distance"],
        &["camera.path", "camera.eye", "camera.target", "camera.up"],
    ),
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
                // A section of which nothing is left is none.
                if inner.is_empty() {
                    table.remove(name);
                }
            }
        }
    }
}

/// A view: `over` over `base`, key by key.
pub fn merge<'t>(base: &mut DeTable<'t>, over: DeTable<'t>) {
    for (given, instead) in INSTEAD {
        if given.iter().any(|key| has(&over, key)) {
            instead.iter().for_each(|key| remove(base, key));
        }
    }
    put_over(base, over);
}

fn put_over<'t>(base: &mut DeTable<'t>, over: DeTable<'t>) {
    for (key, value) in over {
        let span = value.span();
        let under = base.remove(key.get_ref().as_ref() as &str).map(Spanned::into_inner);
        let merged = match (under, value.into_inner()) {
            (Some(DeValue::Table(mut under)), DeValue::Table(over)) => {
                put_over(&mut under, over);
                DeValue::Table(under)
            }
            (_, value) => value,
        };
        base.insert(key, Spanned::new(span, merged));
    }
}
