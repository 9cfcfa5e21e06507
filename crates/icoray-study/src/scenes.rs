//! The scenes on which errors are measured, and their grids and fields.

pub(crate) mod multi_scale;
mod stiff;

use glam::DVec3;
use icoray::{Camera, Error, ErrorKind, Field, Grid, Layers, Precision, Renderer, Result, Scene};
use icoray_reference::radial;
use icoray_reference::sphere::{self, Sphere};
use std::path::{Path, PathBuf};

const JW_VORTICITY: &str = include_str!("../../../examples/scenes/jw_vorticity.toml");
const JW_THETA: &str = include_str!("../../../examples/scenes/jw_theta.toml");

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

    /// Looks at the wave of a real field from nearby, or past the limb of a synthetic one.
    pub fn close_up(&mut self) {
        let (eye, target, fov) = match self.dataset {
            Dataset::Vorticity | Dataset::Theta => ([-1.908, -0.406, 1.219], [-0.62, -0.16, 0.80], 14.0),
            _ => ([1.65, 0.95, 0.55], [0.7, 0.5, 0.74], 20.0),
        };
        let camera = Camera::look_at(eye, target, [0.0, 0.0, 1.0], fov);
        self.scene.camera = camera.expect("eye and target are apart");
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

/// The file that the real fields are read from, and the record of day 9.
const MPAS_FILE: &str = "mpas_jw_10242.nc";
const MPAS_TIME: usize = 2;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dataset {
    /// The distance to the centre on the paper's low-resolution grid, 10,242 cells and 61 layers.
    Radial,
    /// Relative vorticity of the baroclinic wave, from an MPAS file.
    Vorticity,
    /// Potential temperature of the baroclinic wave, from an MPAS file.
    Theta,
    /// The multi-scale field on the paper's low-resolution grid.
    MultiScaleLow,
    /// The multi-scale field on the paper's high-resolution grid, 655,362 cells and 99 layers.
    MultiScaleHigh,
    /// The multi-scale field on 2,562 cells and 20 layers.
    Stiff,
}

impl Dataset {
    /// Generates or reads grid and field and hands them to `work`; false if the file is not in `data`. Where it is
    /// `quick`, synthetic grids have 642 cells and 8 layers.
    pub fn with(
        self,
        quick: bool,
        data: &Path,
        renderer: &Renderer,
        work: impl FnOnce(&Grid, &Layers, &Field) -> Result<()>,
    ) -> Result<bool> {
        const SHELL: [f64; 2] = [1.0, 1.15];
        let (level, layers, shell, f): (_, _, _, fn(DVec3) -> f64) = match self {
            Dataset::Radial => (5, 61, [radial::INNER, radial::OUTER], |p| p.length()),
            Dataset::MultiScaleLow => (5, 61, SHELL, sphere::multi_scale),
            Dataset::MultiScaleHigh => (8, 99, SHELL, sphere::multi_scale),
            Dataset::Stiff => (4, 20, SHELL, sphere::multi_scale),
            Dataset::Vorticity => return with_file(data, "vorticity", renderer, work),
            Dataset::Theta => return with_file(data, "theta", renderer, work),
        };
        let (level, layers) = if quick { (3, 8) } else { (level, layers) };
        let sphere = Sphere::new(level, layers, shell, f)?;
        let grid = renderer.run(|| sphere.grid())?;
        work(&grid, &sphere.layers, &sphere.field()?).map(|()| true)
    }
}

fn with_file(
    data: &Path,
    name: &str,
    renderer: &Renderer,
    work: impl FnOnce(&Grid, &Layers, &Field) -> Result<()>,
) -> Result<bool> {
    let path = data.join(MPAS_FILE);
    if !path.exists() {
        return Ok(false);
    }
    let file = icoray_netcdf::open(path)?;
    let (layers, field) = (file.layers(name)?, file.read_field(name, MPAS_TIME)?);
    let grid = renderer.run(|| file.mesh().grid())?;
    work(&grid, &layers, &field.field()?).map(|()| true)
}

/// The directory of data files: `given`, else that of `ICORAY_TEST_DATA`, else `../shared/data`.
pub(crate) fn data_directory(given: Option<&Path>) -> PathBuf {
    let named = || std::env::var_os("ICORAY_TEST_DATA").map(PathBuf::from);
    given.map(Path::to_owned).or_else(named).unwrap_or_else(|| PathBuf::from("../shared/data"))
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
