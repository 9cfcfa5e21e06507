//! The scenes to render: those of the scene file, or a suggested one.

use crate::selection::{Opened, Selection};
use icoray::output::{Existing, write_text};
use icoray::{Error, Grid, Result, Script, suggest};
use icoray_dataset::{Dataset, FieldInfo};
use icoray_progress::Progress;
use std::path::Path;

/// Maximum number of other fields that are named.
const NAMED: usize = 8;

/// The text of a suggested scene, and a summary.
pub struct Suggested {
    pub text: String,
    /// The field of the scene, and the other fields of the file.
    pub summary: String,
}

impl Suggested {
    /// Suggests a scene for the selected field at the last selected time; also returns the grid.
    pub fn new<'f>(selection: &Selection, opened: &'f Opened, progress: &Progress) -> Result<(Self, Grid<'f>)> {
        let file = &opened.file;
        let others = file.likely_fields();
        let info = match &selection.scene_options.field {
            Some(name) => file.field_info(name).map_err(|e| e.within(format!("--field {name}")))?,
            None => first_field(file)?,
        };
        let name = &info.name;
        progress.stage("checking the grid");
        let grid = opened.renderer.run(|| file.mesh().grid())?;
        let time = opened.times[opened.times.len() - 1];
        progress.stage(format!("looking at {name}"));
        let options = options(selection, time);
        let layers = &selection.layer_option.layers;
        let text = file.suggest_scene(&grid, &opened.renderer, info, time, layers, options)?;
        let summary = summary(selection, info, &others);
        Ok((Suggested { text, summary }, grid))
    }

    pub fn save(&self, path: &Path, existing: Existing) -> Result<()> {
        let written = existing.check(path).and_then(|()| write_text(path, "the scene", &self.text));
        written.map_err(|e| e.within("--save-scene"))
    }
}

/// The default field: [`Dataset::first_field`].
pub fn first_field(file: &Dataset) -> Result<&FieldInfo> {
    if file.fields().is_empty() && file.mesh().path() != file.path() {
        return file.first_field();
    }
    let path = file.path().display();
    let named = if file.fields().is_empty() { "" } else { "--field NAME, or " };
    let hint = format!("{named}icoray render HISTORY.nc --mesh {path}");
    let with_hint = |e: Error| Error::new(e.kind(), format!("{}: {hint}", e.context()));
    file.first_field().map_err(with_hint)
}

/// Options of the suggestion from the command line.
fn options(selection: &Selection, time: usize) -> suggest::Options {
    let (scene_options, overrides) = (&selection.scene_options, &selection.overrides);
    suggest::Options {
        lon_deg: overrides.lon,
        lat_deg: overrides.lat,
        distance: overrides.distance,
        exaggeration: overrides.exaggeration,
        color_map: scene_options.colormap.clone(),
        range: scene_options.range,
        surface: scene_options.surface,
        isosurface: scene_options.isosurface,
        background: overrides.background.clone(),
        light: overrides.light.map(|light| light.0),
        has_borders: overrides.borders,
        is_unlabelled: overrides.no_labels,
        size: overrides.size,
        tolerance: overrides.tolerance,
        samples: overrides.samples,
        backend: overrides.backend,
        device: overrides.device.clone(),
        head: vec![command(selection, Some(time))],
        ..suggest::Options::default()
    }
}

/// The command line that renders the saved scene, at this time unless others are selected; without one, with `{time}`
/// in its place.
pub fn command(selection: &Selection, time: Option<usize>) -> String {
    let mut words = vec!["icoray".into(), "render".into()];
    words.extend(selection.input.words().iter().map(|text| word(text)));
    let saved = selection.scene_options.save_scene.as_deref().unwrap_or(Path::new("scene.toml"));
    words.extend(["--scene".into(), word(&saved.to_string_lossy())]);
    let time = time.map(|time| selection.time.as_ref().map_or_else(|| time.to_string(), ToString::to_string));
    words.extend(["--time".into(), time.map_or_else(|| "{time}".into(), |time| word(&time))]);
    if !selection.layer_option.layers.is_all() {
        words.extend(["--layers".into(), selection.layer_option.layers.to_string()]);
    }
    words.join(" ")
}

/// Quotes a word for a shell if necessary.
fn word(text: &str) -> String {
    let is_safe = |c: char| c.is_alphanumeric() || "/._-+:,=@%".contains(c);
    if !text.is_empty() && text.chars().all(is_safe) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// The field, the reason for it, and the other fields.
fn summary(selection: &Selection, info: &FieldInfo, others: &[&FieldInfo]) -> String {
    let mut text = format!("suggested for {}", info.name);
    if selection.scene_options.field.is_some() {
        return text;
    }
    text += if info.is_2d() { ", the first 2D field, as none has layers" } else { ", the first field with layers" };
    let names: Vec<&str> = others.iter().map(|other| other.name.as_str()).filter(|name| *name != info.name).collect();
    if names.is_empty() {
        return text;
    }
    let more = names.len().saturating_sub(NAMED);
    let named = names[..names.len() - more].join(", ");
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    text + &format!("; --field also takes {named}{more}")
}

/// The scenes to render.
pub struct Scenes<'f> {
    pub script: Script,
    pub grid: Grid<'f>,
    /// The suggestion, if no scene was given.
    pub suggested: Option<Suggested>,
}

impl Opened {
    /// The scenes of the scene file with the overrides of the command line, or a suggested scene.
    pub fn scenes(&self, selection: &Selection, progress: &Progress) -> Result<Scenes<'_>> {
        let Some(given) = &self.given else {
            let (suggested, grid) = Suggested::new(selection, self, progress)?;
            let script = Script::parse_composed(&suggested.text).map_err(|e| e.within("the suggested scene"))?;
            return Ok(Scenes { script, grid, suggested: Some(suggested) });
        };
        let (text, grid) = self.completed(given, selection, progress)?;
        let mut script = Script::parse(&text)?;
        if script.lacks_field() {
            script.name_first_field(&first_field(&self.file)?.name);
        }
        script.show_as_surfaces(|name| self.file.field_info(name).is_ok_and(FieldInfo::is_2d));
        selection.overrides.apply(&mut script)?;
        Ok(Scenes { script, grid, suggested: None })
    }

    /// The text of a scene with the suggestion for what it leaves open, or for the field of `--field`; and the grid.
    pub fn completed(&self, text: &str, selection: &Selection, progress: &Progress) -> Result<(String, Grid<'_>)> {
        progress.stage("checking the grid");
        let grid = self.renderer.run(|| self.file.mesh().grid())?;
        let field = selection.scene_options.field.as_deref();
        let wanted = suggest::Completion { text, field, ..Default::default() };
        let time = self.times[self.times.len() - 1];
        let layers = &selection.layer_option.layers;
        let text = self.file.completed_scene(&grid, &self.renderer, &wanted, time, layers)?;
        Ok((text, grid))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_split_them() {
        for (text, expected) in
            [("run/history.nc", "run/history.nc"), ("my file.nc", "'my file.nc'"), ("it's", "'it'\\''s'")]
        {
            assert_eq!(word(text), expected);
        }
    }
}
