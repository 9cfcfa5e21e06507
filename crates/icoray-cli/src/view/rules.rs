//! From the text of a scene to the scene of a file: its fields, and which of them are 2D.

use crate::selection::{Opened, Selection};
use crate::suggested::{Suggested, first_field};
use icoray::{Error, ErrorKind, Result, Scene, Script, View};
use icoray_live::{NamedScene, SceneReader};
use icoray_netcdf::{FieldInfo, ModelFile};
use icoray_progress::Progress;
use std::fs;

/// The text of the scene that is shown first: that of the scene file, or a suggested one.
pub fn text(selection: &Selection, opened: &Opened, progress: &Progress) -> Result<String> {
    let Some(path) = &selection.scene_options.scene else {
        let (suggested, _) = Suggested::new(selection, opened, progress)?;
        return Ok(suggested.text);
    };
    selection.overrides.expect_none()?;
    let failed = |e| Error::new(ErrorKind::Io, format!("{}: cannot read the scene: {e}", path.display()));
    fs::read_to_string(path).map_err(failed)
}

/// Reads scenes as `icoray render` does for this file.
pub fn reader(file: &ModelFile) -> Box<SceneReader> {
    let first = first_field(file).map(|info| info.name.clone());
    let fields: Vec<FieldInfo> = file.fields().to_vec();
    Box::new(move |text| {
        let mut script = Script::parse(text)?;
        if script.lacks_field() {
            script.name_first_field(first.as_ref().map_err(Error::clone)?);
        }
        let info = |name: &str| fields.iter().find(|info| info.name == name);
        script.show_as_surfaces(|name| info(name).is_some_and(FieldInfo::is_2d));
        let scene_of = |view: &View| {
            let mut scenes = view.scenes();
            let (Some(scene), None) = (scenes.next(), scenes.next()) else {
                let why = "the scene file has a sweep, expected views that draw one picture each";
                return Err(Error::new(ErrorKind::Scene, why));
            };
            expect_fields(&scene, info)?;
            Ok(NamedScene { name: view.name().to_owned(), scene })
        };
        script.views().iter().map(scene_of).collect()
    })
}

/// Fails where the file lacks a field of the scene.
fn expect_fields<'f>(scene: &Scene, info: impl Fn(&str) -> Option<&'f FieldInfo>) -> Result<()> {
    match scene.model_fields().into_iter().find(|name| info(name).is_none()) {
        Some(name) => Err(Error::new(ErrorKind::Field, format!("{name}: the file has no such field"))),
        None => Ok(()),
    }
}
