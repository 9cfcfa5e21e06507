//! The scenes on which errors are measured, and their grids and fields.

mod dataset;
pub(crate) mod multi_scale;
mod stiff;

pub(crate) use dataset::data_directory;
pub use dataset::{Dataset, PreparedDataset};

use icoray::{Error, ErrorKind, Precision, Result, Scene};
use icoray_reference::radial;

const JW_VORTICITY: &str = include_str!("../../../examples/scenes/jw_vorticity.toml");
const JW_THETA: &str = include_str!("../../../examples/scenes/jw_theta.toml");

/// A named scene and its dataset.
#[derive(Debug, Clone)]
pub struct StudyScene {
    /// Its name in options and tables.
    pub name: String,
    pub dataset: Dataset,
    /// Camera, transfer function and light, in the default precision; one ray per pixel, as others draw.
    pub scene: Scene,
}

impl StudyScene {
    fn new(name: impl Into<String>, dataset: Dataset, scene: Scene) -> Self {
        let mut scene = scene;
        (scene.precision, scene.antialias) = (Precision::default(), false);
        StudyScene { name: name.into(), dataset, scene }
    }

    /// Makes the picture `width` pixels wide, its shape kept.
    pub fn resize(&mut self, width: u32) {
        let height = f64::from(self.scene.height) * f64::from(width) / f64::from(self.scene.width);
        (self.scene.width, self.scene.height) = (width, (height.round() as u32).max(1));
    }
}

/// All scenes, grouped by dataset, each `width` pixels wide.
pub fn all(width: u32) -> Result<Vec<StudyScene>> {
    let mut scenes = vec![
        StudyScene::new("radial", Dataset::Radial, radial::scene(width, false)?),
        StudyScene::new("radial_lit", Dataset::Radial, radial::scene(width, true)?),
    ];
    for (name, dataset, text) in
        [("jw_vorticity", Dataset::Vorticity, JW_VORTICITY), ("jw_theta", Dataset::Theta, JW_THETA)]
    {
        let lit = Scene::parse(text)?;
        scenes.push(StudyScene::new(name, dataset, Scene { lighting: None, ..lit.clone() }));
        scenes.push(StudyScene::new(format!("{name}_lit"), dataset, lit));
    }
    for (grid, dataset) in [("low", Dataset::MultiScaleLow), ("high", Dataset::MultiScaleHigh)] {
        for (name, opacity) in multi_scale::TRANSFERS {
            let scene = multi_scale::scene(width, opacity, "", "")?;
            scenes.push(StudyScene::new(format!("{grid}_{name}"), dataset, scene));
        }
    }
    for (name, knots) in stiff::TRANSFERS {
        scenes.push(StudyScene::new(format!("stiff_{name}"), Dataset::Stiff, stiff::scene(width, knots)?));
    }
    scenes.iter_mut().for_each(|scene| scene.resize(width));
    Ok(scenes)
}

/// Those of `all` with the given names, in the order of `all`, or all without names; a name that ends in `*` stands for
/// all that begin so.
///
/// # Errors
/// [`ErrorKind::Argument`] lists the names of all when one is unknown.
pub fn select<T>(all: Vec<T>, names: &[String], name: impl Fn(&T) -> &str) -> Result<Vec<T>> {
    let matches = |item: &T, wanted: &String| match wanted.strip_suffix('*') {
        Some(start) => name(item).starts_with(start),
        None => name(item) == *wanted,
    };
    if let Some(unknown) = names.iter().find(|wanted| !all.iter().any(|item| matches(item, wanted))) {
        let known: Vec<&str> = all.iter().map(&name).collect();
        let context = format!("there is no {unknown:?}; expected one of {}", known.join(", "));
        return Err(Error::new(ErrorKind::Argument, context));
    }
    let is_wanted = |item: &T| names.is_empty() || names.iter().any(|wanted| matches(item, wanted));
    Ok(all.into_iter().filter(is_wanted).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_found_by_name_and_beginning() {
        let names = |wanted: &[&str]| -> Vec<String> {
            let wanted: Vec<String> = wanted.iter().map(|s| (*s).to_owned()).collect();
            select(all(64).unwrap(), &wanted, |s| &s.name).unwrap().into_iter().map(|s| s.name).collect()
        };
        assert_eq!(names(&[]).len(), 18);
        assert_eq!(names(&["stiff_step", "radial"]), ["radial", "stiff_step"]);
        assert_eq!(names(&["jw_theta*"]), ["jw_theta", "jw_theta_lit"]);
        let error = select(all(64).unwrap(), &["nothing".to_owned()], |s| &s.name).unwrap_err();
        assert!(error.to_string().contains("no \"nothing\"") && error.to_string().contains("low_dense"));
    }

    #[test]
    fn pictures_keep_their_shape() {
        let scenes = select(all(96).unwrap(), &["jw_theta".to_owned()], |s| &s.name).unwrap();
        assert_eq!((scenes[0].scene.width, scenes[0].scene.height), (96, 72));
    }
}
