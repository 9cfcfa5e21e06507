//! A scene for a file of which the command names none.

use crate::drawn::{Drawn, Opened};
use icoray::output::Existing;
use icoray::{Error, ErrorKind, Grid, Level, Result, suggest};
use icoray_netcdf::{FieldInfo, ModelFile};
use icoray_progress::Progress;
use std::fs;
use std::path::Path;

/// Other fields that are named at most.
const NAMED: usize = 8;

/// The text of a scene, and what is said of it.
pub struct Suggested {
    /// What a scene file would hold.
    pub text: String,
    /// Which field it is of, and which others there are.
    pub said: String,
}

impl Suggested {
    /// Suggests a scene for the field and the last of the times that the command means; it takes the grid, too.
    pub fn new<'f>(drawn: &Drawn, opened: &'f Opened, progress: &Progress) -> Result<(Self, Grid<'f>)> {
        let file = &opened.file;
        let others = file.likely_fields();
        let info = match &drawn.look.field {
            Some(name) => file.field_info(name).map_err(|e| e.within(format!("--field {name}")))?,
            None => first_field(file)?,
        };
        let name = &info.name;
        progress.stage("checking the grid");
        let grid = opened.renderer.run(|| file.mesh().grid())?;
        let time = opened.times[opened.times.len() - 1];
        let range = drawn.wanted.of(info)?;
        progress.stage(format!("reading {name}"));
        let read = file.read_layers(name, time, range.clone())?;
        let layers = file.layer_heights(name)?.layers_over(info, range)?;
        progress.stage(format!("looking at {name}"));
        let options = options(drawn, opened, info, time)?;
        let field = read.field()?;
        let text = opened.renderer.run(|| suggest::scene(name, &grid, &layers, &field, &options))?;
        let said = said(drawn, info, &others);
        Ok((Suggested { text, said }, grid))
    }

    /// Writes the text to a file.
    pub fn save(&self, path: &Path, existing: Existing) -> Result<()> {
        existing.check(path).map_err(|e| e.within("--save-scene"))?;
        let failed = |e| Error::new(ErrorKind::Io, format!("--save-scene {}: {e}", path.display()));
        fs::write(path, &self.text).map_err(failed)
    }
}

/// The field that is drawn where none is named: the likeliest physical one.
pub fn first_field(file: &ModelFile) -> Result<&FieldInfo> {
    file.likely_fields().first().copied().ok_or_else(|| no_field(file))
}

/// The file has a mesh alone, or nothing that is drawn.
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

/// What the command decides. A 2D field is a surface, true to scale.
fn options(drawn: &Drawn, opened: &Opened, info: &FieldInfo, time: usize) -> Result<suggest::Options> {
    let look = &drawn.look;
    let (surface, exaggeration) = match (info.is_2d(), look.surface) {
        (false, surface) => (surface, look.exaggeration),
        (true, Some(Level::Layer(layer @ 1..))) => {
            let context = format!("--surface {layer}: {} is a 2D field, expected 0", info.name);
            return Err(Error::new(ErrorKind::Argument, context));
        }
        (true, _) => (Some(Level::Layer(0)), Some(look.exaggeration.unwrap_or(1.0))),
    };
    Ok(suggest::Options {
        lon_deg: look.lon,
        lat_deg: look.lat,
        distance: look.distance,
        exaggeration,
        color_map: look.colormap.clone(),
        range: look.range,
        surface,
        size: drawn.size,
        tolerance: drawn.tolerance,
        backend: drawn.who.backend(),
        device: drawn.who.device().cloned(),
        head: vec![command(drawn, opened, time)],
    })
}

/// The command that draws the scene once it is saved.
fn command(drawn: &Drawn, opened: &Opened, time: usize) -> String {
    let mut words = vec!["icoray".into(), "render".into(), word(&opened.file.path().to_string_lossy())];
    for mesh in &drawn.input.mesh {
        words.extend(["--mesh".into(), word(&mesh.to_string_lossy())]);
    }
    let saved = drawn.look.save_scene.as_deref().unwrap_or(Path::new("scene.toml"));
    words.extend(["--scene".into(), word(&saved.to_string_lossy())]);
    let time = drawn.time.as_ref().map_or_else(|| time.to_string(), ToString::to_string);
    words.extend(["--time".into(), word(&time)]);
    if let Some(layers) = drawn.wanted.text() {
        words.extend(["--layers".into(), layers]);
    }
    words.join(" ")
}

/// A word as a shell takes it.
fn word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+:,=@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// The field, why it is that one, and what else there is.
fn said(drawn: &Drawn, info: &FieldInfo, others: &[&FieldInfo]) -> String {
    let mut text = format!("suggested for {}", info.name);
    if drawn.look.field.is_some() {
        return text;
    }
    text += if info.is_2d() {
        ", the first 2D field, as none has layers"
    } else {
        ", the first field with layers"
    };
    let names: Vec<&str> =
        others.iter().map(|other| other.name.as_str()).filter(|name| *name != info.name).collect();
    if names.is_empty() {
        return text;
    }
    let more = names.len().saturating_sub(NAMED);
    let named = names[..names.len() - more].join(", ");
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    text + &format!("; --field takes also {named}{more}")
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
