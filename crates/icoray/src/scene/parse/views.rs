//! Several pictures of one text: views over what they have in common, when they are drawn, how they move, what they sweep.
//!
//! Views are merged as TOML, before anything is checked, so that a view may override every key of a scene. Values keep
//! their places in the text on the way.

mod extras;
mod merge;
mod motion;
mod sweep;

use super::{Scene, Text, checked};
use crate::error::{Error, Result};
use crate::output::{NameTemplate, Stamp};
use crate::script::{Script, View};
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// More pictures of one step than anybody looks at.
const MOST_PICTURES: usize = 100_000;

/// Takes a key out of a table.
fn take<T: DeserializeOwned>(source: &Text, table: &mut DeTable, key: &str) -> Result<Option<Spanned<T>>> {
    let Some(value) = table.remove(key) else { return Ok(None) };
    let span = value.span();
    let value = T::deserialize(ValueDeserializer::from(value)).map_err(|e| match e.span() {
        Some(_) => source.refused(&e),
        None => source.bad(span.clone(), key, e.message()),
    })?;
    Ok(Some(Spanned::new(span, value)))
}

/// A table of a table, where there is one.
fn section<'t, 's>(table: &'s mut DeTable<'t>, key: &str) -> Option<&'s mut DeTable<'t>> {
    match table.get_mut(key)?.get_mut() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}

/// Parses and checks a script.
pub(crate) fn script(text: &str) -> Result<Script> {
    let source = &Text { text };
    let mut base = source.table()?;
    let Some(views) = base.get_mut().remove("views") else {
        return distinct(source, vec![view(source, None, base)?]);
    };
    let (span, wish) = (views.span(), "expected tables [[views]], each with a name");
    let DeValue::Array(list) = views.into_inner() else { return Err(source.bad(span, "views", wish)) };
    if list.is_empty() {
        return Err(source.bad(span, "views", format!("an empty list, {wish}")));
    }
    let mut parsed: Vec<View> = Vec::new();
    for over in list {
        let span = over.span();
        let DeValue::Table(mut over) = over.into_inner() else { return Err(source.bad(span, "views", wish)) };
        let name = take::<String>(source, &mut over, "name")?;
        let name =
            name.ok_or_else(|| source.bad(span.clone(), "views.name", "is absent, expected a name"))?;
        if name.get_ref().is_empty() || name.get_ref().contains(char::is_control) {
            let what = format!("{:?}, expected a name", name.get_ref());
            return Err(source.bad(name.span(), "views.name", what));
        }
        if parsed.iter().any(|view| view.name() == name.get_ref()) {
            let what = format!("{:?} for a second time, expected distinct names", name.get_ref());
            return Err(source.bad(name.span(), "views.name", what));
        }
        let name = name.into_inner();
        let within = |e: Error| e.within(format!("view {name:?}"));
        let mut table = base.clone();
        merge::merge(table.get_mut(), over, "");
        parsed
            .push(view(source, Some(name.clone()), Spanned::new(span, table.into_inner())).map_err(within)?);
    }
    distinct(source, parsed)
}

fn view(source: &Text, name: Option<String>, mut table: Spanned<DeTable>) -> Result<View> {
    let root = table.get_mut();
    let schedule = extras::schedule(source, root)?;
    let conditions = extras::conditions(source, root)?;
    let kept = extras::kept(source, root)?;
    let file = extras::spans_of_names(root);
    let motion = motion::motion(source, root)?;
    let sweep = sweep::sweep(source, root, &motion)?;
    let mut scene: Scene = checked(source, table)?;
    if file.picture.is_none() {
        let mut words: Vec<String> = name.iter().map(|_| "{view}".to_owned()).collect();
        words.extend(["{field}".to_owned(), "{step:06}".to_owned()]);
        let swept = sweep.axes.iter().map(|axis| axis.name()).filter(|name| *name != "field");
        words.extend(swept.map(|name| format!("{name}{{{name}}}")));
        scene.output.file = NameTemplate::new(&format!("{}.png", words.join("_")))?;
    }
    let schedule = schedule.with_every(&scene);
    let view =
        View { name, schedule, conditions, motion, sweep, cinema: kept.cinema, concat: kept.concat, scene };
    let output = &view.scene.output;
    let names = [
        ("output.file", file.picture, Some(output.file.template())),
        ("output.error", file.error, output.error.as_ref().map(NameTemplate::template)),
        ("output.cinema", kept.cinema_span, view.cinema.as_ref()),
        ("output.concat", kept.concat_span, view.concat.as_ref().map(|(file, _)| file)),
    ];
    for (key, span, template) in names {
        let (Some(span), Some(template)) = (span, template) else { continue };
        view.check_words(template).map_err(|e| source.bad(span, key, e.context()))?;
    }
    Ok(view)
}

/// The script, unless two pictures of a step would be one file, or two views would mix what is kept of them.
fn distinct(source: &Text, views: Vec<View>) -> Result<Script> {
    let stamp = Stamp { date: Some("0001-01-01_00:00:00".into()), ..Stamp::default() };
    let mut files: HashMap<String, String> = HashMap::new();
    let mut kept: HashMap<String, (usize, String)> = HashMap::new();
    let end = source.text.len()..source.text.len();
    let bad = |key: &str, what: String| source.bad(end.clone(), key, what);
    for (number, view) in views.iter().enumerate() {
        for shot in view.shots(&stamp) {
            let (scene, of) = (&shot.scene, format!("view {:?}", shot.name));
            let names = scene.output.names(&stamp, &scene.field)?;
            for (key, file) in [("output.file", Some(names.file)), ("output.error", names.error)] {
                let Some(file) = file else { continue };
                if let Some(other) = files.insert(file.clone(), of.clone()) {
                    let what = format!("{other} and {of} both write {file:?} at one step");
                    return Err(bad(key, format!("{what}; expected {{view}} or what is swept in its name")));
                }
            }
            let series = &scene.output.series;
            let list = series.concat.as_ref().map(|concat| (concat.file.clone(), number.to_string()));
            let table = series.cinema.as_ref().map(|cinema| {
                let mut columns: Vec<&str> = cinema.parameters.iter().map(|(name, _)| *name).collect();
                columns.extend(scene.output.error.as_ref().map(|_| "error"));
                (cinema.folder.clone(), columns.join(", "))
            });
            for (key, text) in [("output.concat", list), ("output.cinema", table)] {
                let Some((file, kind)) = text else { continue };
                let known = kept.entry(file.clone()).or_insert((number, kind.clone()));
                if known.1 != kind {
                    let other = format!("view {:?}", views[known.0].name());
                    let wish = if key == "output.concat" { "" } else { " with other columns" };
                    let what = format!("{other} and {of} both add to {file:?}{wish}");
                    return Err(bad(key, format!("{what}; expected {{view}} in its name")));
                }
            }
        }
    }
    Ok(Script::new(views))
}

#[cfg(test)]
mod tests;
