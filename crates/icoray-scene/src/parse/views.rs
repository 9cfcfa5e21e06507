//! Several pictures of one text: views over what they have in common, when they are drawn, how they move, what they
//! sweep.
//!
//! Views are merged as TOML, before anything is checked, so that a view may override every key of a scene. Values keep
//! their places in the text on the way.

pub(super) mod extras;
mod merge;
pub(super) mod motion;
mod sweep;

use super::RawOutput;
use super::camera::RawCamera;
use super::hint::with_hint;
use super::text::Text;
use super::{RawScene, checked, expect_keys};
use crate::keys::Key;
use crate::name::{NameTemplate, Stamp};
use crate::scene::Scene;
use crate::script::{Script, View};
use extras::Names;
use icoray_grid::{Error, Result};
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// Largest number of pictures of one step.
const MAX_PICTURES: usize = 100_000;

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

/// The error about a scene's keys, with all keys that might stand there.
fn with_all_keys(error: &Error) -> Error {
    let tables =
        [[RawScene::KEYS, extras::KEYS], [RawCamera::KEYS, motion::KEYS], [RawOutput::KEYS, extras::OUTPUT_KEYS]];
    let context = tables.iter().fold(error.context().to_owned(), |text, tables| {
        text.replacen(&expected(tables[0]), &expected(&tables.concat()), 1)
    });
    Error::new(error.kind(), context)
}

/// The keys of a table in the words of serde's error about an unknown one.
fn expected(keys: &[Key]) -> String {
    let names: Vec<String> = keys.iter().map(|key| format!("`{}`", key.name)).collect();
    if names.len() == 2 { names.join(" or ") } else { format!("one of {}", names.join(", ")) }
}

impl Script {
    /// Parses a script from the text of a scene file.
    ///
    /// ```
    /// use icoray_scene::{Script, name::Stamp};
    ///
    /// let script = Script::parse(
    ///     "field = 'theta'
    ///      camera = { lon = 0, lat = 45, distance = 3 }
    ///      transfer = { map = 'plasma', range = [300, 400], opacity = [[300, 0], [400, 0.9]] }
    ///      [[views]]
    ///      name = 'seldom'
    ///      every = 10
    ///      [[views]]
    ///      name = 'warm'
    ///      when = 'max(theta) > 390'",
    /// )?;
    /// let now = Stamp { step: 5, ..Stamp::default() };
    /// let scheduled: Vec<_> = script.scheduled(&now, None).collect();
    /// assert_eq!(scheduled.len(), 1);
    /// assert_eq!(scheduled[0].name(), "warm");
    /// assert!(scheduled[0].holds(&mut |_field, _statistic| Ok(Some(395.0)))?);
    /// # Ok::<(), icoray_grid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Scene`](icoray_grid::ErrorKind::Scene) with the view, the line, the key, the value and what was
    /// expected.
    pub fn parse(text: &str) -> Result<Self> {
        script(Text::new(text))
    }

    /// As [`Script::parse`], of a text that a program has composed, of keyword arguments for example: errors name keys,
    /// not lines of a text that no user has seen.
    ///
    /// # Errors
    /// As [`Script::parse`], without the line.
    pub fn parse_composed(text: &str) -> Result<Self> {
        script(Text::composed(text))
    }

    /// As [`Script::parse`], with `None` for a text of nothing but blanks and comments: nothing is to be drawn.
    ///
    /// # Errors
    /// As [`Script::parse`].
    pub fn parse_optional(text: &str) -> Result<Option<Self>> {
        let is_empty = toml::from_str::<toml::Table>(text).is_ok_and(|table| table.is_empty());
        if is_empty { Ok(None) } else { Self::parse(text).map(Some) }
    }
}

/// Parses and checks a script.
fn script(source: Text) -> Result<Script> {
    unhinted(&source).map_err(|e| with_hint(&e))
}

fn unhinted(source: &Text) -> Result<Script> {
    let mut base = source.table()?;
    expect_keys(base.get_ref())?;
    let live = extras::live(source, base.get_mut())?;
    let is_async = take::<bool>(source, base.get_mut(), "async_render")?.is_some_and(Spanned::into_inner);
    let script = |views: Vec<(View, Names)>| {
        expect_distinct(source, &views)?;
        Ok(Script { views: views.into_iter().map(|(view, _)| view).collect(), live, is_async })
    };
    let Some(views) = base.get_mut().remove("views") else { return script(vec![view(source, None, base)?]) };
    let (span, wish) = (views.span(), "expected tables [[views]], each with a name");
    let DeValue::Array(list) = views.into_inner() else { return Err(source.bad(span, "views", wish)) };
    if list.is_empty() {
        return Err(source.bad(span, "views", format!("an empty list, {wish}")));
    }
    let mut parsed: Vec<(View, Names)> = Vec::new();
    for over in list {
        let span = over.span();
        let DeValue::Table(mut over) = over.into_inner() else { return Err(source.bad(span, "views", wish)) };
        let raw = take::<String>(source, &mut over, "name")?;
        let raw = raw.ok_or_else(|| source.bad(span.clone(), "views.name", "is absent, expected a name"))?;
        let name = raw.get_ref();
        let bad = |what: &str| Err(source.bad(raw.span(), "views.name", format!("{name:?}{what}")));
        if name.is_empty() || name.contains(char::is_control) {
            return bad(", expected a name");
        }
        if parsed.iter().any(|(view, _)| view.name() == name) {
            return bad(" for a second time, expected distinct names");
        }
        let mut table = base.clone();
        merge::merge(table.get_mut(), over);
        let view = view(source, Some(name.clone()), Spanned::new(span, table.into_inner()));
        parsed.push(view.map_err(|e| e.within(format!("view {name:?}")))?);
    }
    script(parsed)
}

/// A view of whole keys, and where its files' names stand.
fn view(source: &Text, name: Option<String>, mut table: Spanned<DeTable>) -> Result<(View, Names)> {
    let names = Names::of(&table);
    let root = table.get_mut();
    let has_every = root.contains_key("every");
    let mut schedule = extras::schedule(source, root)?;
    let conditions = extras::conditions(source, root)?;
    let (cinema, concat) = extras::series(source, root)?;
    let motion = motion::motion(source, root)?;
    let sweep = sweep::sweep(source, root, &motion)?;
    let scene: Scene = checked(source, table).map_err(|e| with_all_keys(&e))?;
    schedule.every = has_every.then_some(scene.every);
    let has_file = names.has("output.file");
    let mut view = View { name, schedule, conditions, motion, sweep, cinema, concat, scene, has_file };
    if !has_file {
        view.scene.output.file = view.default_file("{step:06}");
    }
    let output = &view.scene.output;
    for (key, template) in [
        ("output.file", Some(output.file.template())),
        ("output.error", output.error.as_ref().map(NameTemplate::template)),
        ("output.cinema", view.cinema.as_ref()),
        ("output.concat", view.concat.as_ref().map(|(file, _)| file)),
    ] {
        let Some(template) = template else { continue };
        view.check_words(template).map_err(|e| source.bad(names.span(key), key, e.context()))?;
    }
    Ok((view, names))
}

/// Refuses two pictures of a step that would be one file, and two views that would mix what is kept of them.
fn expect_distinct(source: &Text, views: &[(View, Names)]) -> Result<()> {
    let stamp = Stamp { date: Some("0001-01-01_00:00:00".into()), ..Stamp::default() };
    let mut files: HashMap<String, &View> = HashMap::new();
    let mut kept: HashMap<String, (&View, String)> = HashMap::new();
    for (view, names) in views {
        let bad = |key: &str, other: &View, what: String| {
            let of = if std::ptr::eq(view, other) {
                "two pictures of a sweep".to_owned()
            } else {
                format!("views {:?} and {:?}", other.name(), view.name())
            };
            source.bad(names.span(key), key, format!("{of} {what} or what is swept in its name"))
        };
        for scene in view.shots(&stamp).map(|shot| shot.scene) {
            let named = scene.output.names(&stamp, scene.field())?;
            for (key, file) in [("output.file", Some(named.file)), ("output.error", named.error)] {
                let Some(file) = file else { continue };
                if let Some(other) = files.insert(file.clone(), view) {
                    return Err(bad(key, other, format!("are {file:?} at one step, expected {{view}}")));
                }
            }
            for (key, file, kind) in kinds(view, &scene) {
                let (other, known) = kept.entry(file.clone()).or_insert((view, kind.clone()));
                if *known != kind {
                    let wish = if key == "output.cinema" { " with other columns" } else { "" };
                    return Err(bad(key, other, format!("add to {file:?}{wish}, expected {{view}}")));
                }
            }
        }
    }
    Ok(())
}

/// Series to which a picture is added: the key, the file, and the common property of its pictures.
fn kinds(view: &View, scene: &Scene) -> Vec<(&'static str, String, String)> {
    let series = &scene.output.series;
    let list = series.concat.as_ref();
    let list = list.map(|concat| ("output.concat", concat.file.clone(), view.name().to_owned()));
    let table = series.cinema.as_ref().map(|cinema| {
        let mut columns: Vec<&str> = cinema.parameters.iter().map(|(name, _)| *name).collect();
        columns.extend(scene.output.error.as_ref().map(|_| "error"));
        ("output.cinema", cinema.folder.clone(), columns.join(", "))
    });
    list.into_iter().chain(table).collect()
}

#[cfg(test)]
mod tests;
