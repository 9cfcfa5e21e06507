//! The scenes to render: those of the scene file, or a suggested one.

use crate::selection::{Opened, Selection};
use icoray::output::Existing;
use icoray::{Error, ErrorKind, Grid, Level, Result, Script, suggest};
use icoray_netcdf::{FieldInfo, ModelFile};
use icoray_progress::Progress;
use std::fs;
use std::path::Path;

/// Maximum number of other fields that are named.
const NAMED: usize = 8;

/// The text of a suggested scene, and a summary.
pub struct Suggested {
    /// The content of a scene file.
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
        let range = selection.layers_wanted.of(info)?;
        progress.stage(format!("reading {name}"));
        let read = file.read_layers(name, time, range.clone())?;
        let layers = file.layer_heights(name)?.layers_over(info, range)?;
        progress.stage(format!("looking at {name}"));
        let options = options(selection, opened, info, time)?;
        let field = read.field()?;
        let text = opened.renderer.run(|| suggest::scene(name, &grid, &layers, &field, &options))?;
        let summary = summary(selection, info, &others);
        Ok((Suggested { text, summary }, grid))
    }

    /// Writes the text to a file.
    pub fn save(&self, path: &Path, existing: Existing) -> Result<()> {
        existing.check(path).map_err(|e| e.within("--save-scene"))?;
        let failed = |e| Error::new(ErrorKind::Io, format!("--save-scene {}: {e}", path.display()));
        fs::write(path, &self.text).map_err(failed)
    }
}

/// The default field: the first of [`ModelFile::likely_fields`].
pub fn first_field(file: &ModelFile) -> Result<&FieldInfo> {
    file.likely_fields().first().copied().ok_or_else(|| no_field(file))
}

/// The error for a file without fields, or without likely ones.
fn no_field(file: &ModelFile) -> Error {
    let path = file.path().display();
    let context = match file.fields() {
        [] => format!(
            "{path}: a mesh without a field, expected a history or output file: icoray render HISTORY.nc --mesh {path}"
        ),
        fields => {
            let names: Vec<&str> = fields.iter().map(|info| info.name.as_str()).collect();
            format!(
                "{path}: no variable looks like a physical field, expected --field NAME with one of {}, or a history or output \
                 file: icoray render HISTORY.nc --mesh {path}",
                names.join(", ")
            )
        }
    };
    Error::new(ErrorKind::Field, context)
}

/// Options of the suggestion from the command line. A 2D field is a surface without exaggeration.
fn options(selection: &Selection, opened: &Opened, info: &FieldInfo, time: usize) -> Result<suggest::Options> {
    let (scene_options, overrides) = (&selection.scene_options, &selection.overrides);
    let (surface, exaggeration) = match (info.is_2d(), scene_options.surface) {
        (false, surface) => (surface, overrides.exaggeration),
        (true, Some(Level::Layer(layer @ 1..))) => {
            let context = format!("--surface {layer}: {} is a 2D field, expected 0", info.name);
            return Err(Error::new(ErrorKind::Argument, context));
        }
        (true, _) => (Some(Level::Layer(0)), Some(overrides.exaggeration.unwrap_or(1.0))),
    };
    Ok(suggest::Options {
        lon_deg: overrides.lon,
        lat_deg: overrides.lat,
        distance: overrides.distance,
        exaggeration,
        color_map: scene_options.colormap.clone(),
        range: scene_options.range,
        surface,
        size: overrides.size,
        tolerance: overrides.tolerance,
        samples: overrides.samples,
        backend: overrides.device_options.backend(),
        device: overrides.device_options.device().cloned(),
        head: vec![command(selection, opened, Some(time))],
    })
}

/// The command line that renders the saved scene, at this time unless others are selected; without one, that of a time
/// that is still to be added.
pub fn command(selection: &Selection, opened: &Opened, time: Option<usize>) -> String {
    let mut words = vec!["icoray".into(), "render".into(), word(&opened.file.path().to_string_lossy())];
    for mesh in &selection.input.mesh {
        words.extend(["--mesh".into(), word(&mesh.to_string_lossy())]);
    }
    let saved = selection.scene_options.save_scene.as_deref().unwrap_or(Path::new("scene.toml"));
    words.extend(["--scene".into(), word(&saved.to_string_lossy())]);
    if let Some(time) = time {
        let time = selection.time.as_ref().map_or_else(|| time.to_string(), ToString::to_string);
        words.extend(["--time".into(), word(&time)]);
    }
    if let Some(layers) = selection.layers_wanted.text() {
        words.extend(["--layers".into(), layers]);
    }
    words.join(" ")
}

/// Quotes a word for a shell if necessary.
fn word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+:,=@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
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
    text + &format!("; --field takes also {named}{more}")
}

/// The scenes to render.
pub struct Scenes<'f> {
    pub script: Script,
    /// The file's grid, if it was needed to suggest the scene.
    pub grid: Option<Grid<'f>>,
    /// The suggestion, if no scene was given.
    pub suggested: Option<Suggested>,
}

impl Opened {
    /// The scenes of the scene file with the overrides of the command line, or a suggested scene.
    pub fn scenes(&self, selection: &Selection, progress: &Progress) -> Result<Scenes<'_>> {
        let Some(mut script) = self.given.clone() else {
            let (suggested, grid) = Suggested::new(selection, self, progress)?;
            let script = Script::parse(&suggested.text).map_err(|e| e.within("the suggested scene"))?;
            return Ok(Scenes { script, grid: Some(grid), suggested: Some(suggested) });
        };
        if script.lacks_field() {
            script.name_first_field(&first_field(&self.file)?.name);
        }
        script.show_as_surfaces(|name| self.file.field_info(name).is_ok_and(FieldInfo::is_2d));
        selection.overrides.apply(&mut script)?;
        Ok(Scenes { script, grid: None, suggested: None })
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
