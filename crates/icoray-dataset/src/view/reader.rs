//! Converts the text of a scene to the scene of a dataset: its fields, and the 2D ones among them.

use crate::dataset::Dataset;
use crate::field::FieldInfo;
use icoray::{Error, ErrorKind, Result, Scene, Script, View};
use icoray_live::{NamedScene, SceneReader};

/// Parses the text of scenes for a dataset: a scene without a field shows the likeliest one, and 2D fields are
/// surfaces.
pub fn reader(dataset: &Dataset) -> Box<SceneReader> {
    let first = dataset.first_field().map(|info| info.name.clone());
    let fields: Vec<FieldInfo> = dataset.fields().to_vec();
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

/// Fails if the dataset lacks a field of the scene.
fn expect_fields<'f>(scene: &Scene, info: impl Fn(&str) -> Option<&'f FieldInfo>) -> Result<()> {
    match scene.model_fields().into_iter().find(|name| info(name).is_none()) {
        Some(name) => Err(Error::new(ErrorKind::Field, format!("{name}: there is no such field"))),
        None => Ok(()),
    }
}
