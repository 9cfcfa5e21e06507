//! The arguments of a call of `icoray.render`.

use super::Opened;
use crate::error::{argument, raised};
use crate::renderer::Renderer;
use crate::scene::{self, Scene};
use icoray::{Level, suggest};
use icoray_dataset::{Dataset, LayerSelection, TimeSelection};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The name of the argument in errors.
const FIELD: &str = "the name of a field";

/// The arguments, which `_render.py` has made a dict of: those that are not given are not in it.
pub(crate) struct Request<'py> {
    pub layers: LayerSelection,
    given: Bound<'py, PyDict>,
}

impl<'py> Request<'py> {
    pub fn new(given: &Bound<'py, PyDict>) -> PyResult<Self> {
        let layers = given.get_item("layers")?.map(|layers| layer_selection(&layers)).transpose()?;
        Ok(Request { layers: layers.unwrap_or_default(), given: given.clone() })
    }

    fn get<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str, expected: &str) -> PyResult<Option<T>> {
        let value = self.given.get_item(name)?;
        let extracted = |value: Bound<'py, PyAny>| {
            value.extract::<T>().map_err(|_| argument(format!("{name}: {value:?}, expected {expected}")))
        };
        value.map(extracted).transpose()
    }

    /// Whether no scene is given.
    #[cfg(feature = "live")]
    pub fn is_suggested(&self) -> PyResult<bool> {
        Ok(!self.given.contains("scene")?)
    }

    /// Whether the picture has a size of its own.
    #[cfg(feature = "live")]
    pub fn has_size(&self) -> PyResult<bool> {
        let keys = self.given.get_item("keys")?;
        Ok(self.given.contains("size")? || keys.is_some_and(|keys| keys.contains("image").unwrap_or(false)))
    }

    /// Number of the time that is drawn.
    pub fn time(&self, dataset: &Dataset) -> PyResult<usize> {
        let text = match self.given.get_item("time")? {
            Some(time) => time.str()?.to_string(),
            None => "-1".into(),
        };
        let selection: TimeSelection = text.parse().map_err(|_| {
            let expected = "expected a number from 0, a negative one from the last, or a date such as 2003-01-01T06";
            argument(format!("time: {text:?}, {expected}"))
        })?;
        let found = selection.of(dataset.times()).map_err(|e| raised(e.within(format_args!("time: {text:?}"))))?;
        match found[..] {
            [one] => Ok(one),
            _ => Err(argument(format!("time: {text:?} is {} times, expected one", found.len()))),
        }
    }

    /// The scene: as given, or suggested for the field's values at a time; with other keys in place of its own.
    pub fn scene(&self, py: Python, opened: &Opened, renderer: &Renderer, time: usize) -> PyResult<Scene> {
        let keys = match self.given.get_item("keys")? {
            Some(keys) => scene::entries(keys.cast::<PyDict>()?, "", 0)?,
            None => Default::default(),
        };
        let view: Option<String> = self.get("view", "the name of a view")?;
        let text = match self.given.get_item("scene")? {
            Some(given) => {
                let instead = "give the scene's keys, such as transfer={...}";
                self.expect_none(&["colormap", "range", "surface", "isosurface"], "scene", instead)?;
                let text = match given.cast::<Scene>() {
                    Ok(scene) => scene.get().to_toml().to_owned(),
                    Err(_) => scene::parsed(&given)?,
                };
                let (field, layers) = (self.get::<String>("field", FIELD)?, self.layers);
                renderer.draw(py, None, move |inner| {
                    let wanted = suggest::Completion { text: &text, field: field.as_deref(), ..Default::default() };
                    opened.dataset.completed_scene(opened.grid(), inner, &wanted, time, &layers)
                })?
            }
            None => self.suggested(py, opened, renderer, time)?,
        };
        Scene::composed(text, view.as_deref(), keys).map_err(raised)
    }

    /// The text of a suggested scene.
    fn suggested(&self, py: Python, opened: &Opened, renderer: &Renderer, time: usize) -> PyResult<String> {
        let field: Option<String> = self.get("field", FIELD)?;
        let info = match &field {
            Some(name) => opened.dataset.field_info(name),
            None => opened.dataset.first_field(),
        };
        let info = info.map_err(raised)?;
        let isosurface: Option<f64> = self.get("isosurface", "a value of the field")?;
        if isosurface.is_some() {
            let instead = "give isosurfaces=[{...}] for its colours";
            self.expect_none(&["colormap", "range", "surface"], "isosurface", instead)?;
        }
        let degrees = "a number of degrees";
        let options = suggest::Options {
            lon_deg: self.get("lon", degrees)?,
            lat_deg: self.get("lat", degrees)?,
            distance: self.get("distance", "a number of planet radii")?,
            exaggeration: self.get("exaggeration", "a number")?,
            color_map: self.get("colormap", "the name of a colour map")?,
            range: self.get("range", "(low, high), two numbers")?,
            surface: self.given.get_item("surface")?.map(|level| surface(&level)).transpose()?,
            isosurface,
            size: self.given.get_item("size")?.map(|size| scene::size(&size)).transpose()?,
            tolerance: self.get("tolerance", "a number")?,
            samples: self.get("samples", "an integer above 0")?,
            ..Default::default()
        };
        let layers = self.layers;
        renderer.draw(py, None, move |inner| {
            opened.dataset.suggest_scene(opened.grid(), inner, info, time, &layers, options)
        })
    }

    fn expect_none(&self, names: &[&str], beside: &str, instead: &str) -> PyResult<()> {
        for name in names {
            if let Some(value) = self.given.get_item(name)? {
                let expected = format!("expected no such argument beside {beside}; {instead}");
                return Err(argument(format!("{name}: {value:?}, {expected}")));
            }
        }
        Ok(())
    }
}

/// Layers as a slice, a pair or a text.
fn layer_selection(layers: &Bound<PyAny>) -> PyResult<LayerSelection> {
    let ends = match layers.cast::<PyTuple>() {
        Ok(pair) if pair.len() == 2 => Some([pair.get_item(0)?, pair.get_item(1)?]),
        _ if layers.hasattr("stop")? => Some([layers.getattr("start")?, layers.getattr("stop")?]),
        _ => None,
    };
    let text = match ends {
        Some(ends) => {
            let end = |end: &Bound<PyAny>| if end.is_none() { String::new() } else { end.to_string() };
            format!("{}..{}", end(&ends[0]), end(&ends[1]))
        }
        None => layers.to_string(),
    };
    text.parse().map_err(|_: String| {
        argument(format!(
            "layers: {layers:?}, expected the first and the one behind the last: (0, 20) or slice(5, None)"
        ))
    })
}

/// The level of a surface: a number, "top" or "bottom".
fn surface(level: &Bound<PyAny>) -> PyResult<Level> {
    match level.str()?.to_string().as_str() {
        "top" => Ok(Level::Top),
        "bottom" => Ok(Level::Layer(0)),
        number => number.parse().map(Level::Layer).map_err(|_| {
            argument(format!(
                "surface: {level:?}, expected the number of a layer from 0, the innermost, \"top\" or \"bottom\""
            ))
        }),
    }
}
