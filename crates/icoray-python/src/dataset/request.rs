//! The arguments of a call of `icoray.render`.

use super::Opened;
use crate::error::{argument, raised};
use crate::renderer::Renderer;
use crate::scene::{self, Scene};
use icoray::{Level, suggest};
use icoray_dataset::{Dataset, LayerSelection, TimeSelection};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

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

    fn get<T: for<'a> FromPyObject<'a, 'py, Error = PyErr>>(&self, name: &str) -> PyResult<Option<T>> {
        let value = self.given.get_item(name)?;
        let extracted = |value: Bound<'py, PyAny>| {
            value.extract::<T>().map_err(|e| argument(format!("{name}: {value}: {}", e.value(value.py()))))
        };
        value.map(extracted).transpose()
    }

    /// Number of the time that is drawn.
    pub fn time(&self, dataset: &Dataset) -> PyResult<usize> {
        let text = match self.given.get_item("time")? {
            Some(time) => time.str()?.to_string(),
            None => "-1".into(),
        };
        let selection: TimeSelection = text.parse().map_err(|e| argument(format!("time: {text:?}: {e}")))?;
        let found = selection.of(dataset.times()).map_err(|e| raised(e.within("time")))?;
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
        let view: Option<String> = self.get("view")?;
        let text = match self.given.get_item("scene")? {
            Some(given) => {
                self.expect_none(&["colormap", "range", "surface"])?;
                let text = match given.cast::<Scene>() {
                    Ok(scene) => scene.get().text().to_owned(),
                    Err(_) => scene::read(&given)?.0,
                };
                let (field, layers) = (self.get::<String>("field")?, self.layers);
                renderer.draw(py, None, move |inner| {
                    let wanted = suggest::Completion { text: &text, field: field.as_deref(), ..Default::default() };
                    opened.dataset.completed_scene((opened.grid(), inner), &wanted, time, &layers)
                })?
            }
            None => self.suggested(py, opened, renderer, time)?,
        };
        Scene::with(&text, view.as_deref(), keys).map_err(raised)
    }

    /// The text of a suggested scene.
    fn suggested(&self, py: Python, opened: &Opened, renderer: &Renderer, time: usize) -> PyResult<String> {
        let field: Option<String> = self.get("field")?;
        let info = match &field {
            Some(name) => opened.dataset.field_info(name),
            None => opened.dataset.first_field(),
        };
        let info = info.map_err(raised)?;
        let options = suggest::Options {
            lon_deg: self.get("lon")?,
            lat_deg: self.get("lat")?,
            distance: self.get("distance")?,
            exaggeration: self.get("exaggeration")?,
            color_map: self.get("colormap")?,
            range: self.get("range")?,
            surface: self.given.get_item("surface")?.map(|level| surface(&level)).transpose()?,
            size: self.get("size")?,
            tolerance: self.get("tolerance")?,
            samples: self.get("samples")?,
            ..Default::default()
        };
        let layers = self.layers;
        renderer.draw(py, None, move |inner| {
            opened.dataset.suggest_scene((opened.grid(), inner), (info, time), &layers, options)
        })
    }

    fn expect_none(&self, names: &[&str]) -> PyResult<()> {
        for name in names {
            if let Some(value) = self.given.get_item(name)? {
                let expected = "expected no such argument beside scene; give the scene's keys, such as transfer={...}";
                return Err(argument(format!("{name}: {value}, {expected}")));
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
    text.parse().map_err(|e| argument(format!("layers: {layers}: {e}")))
}

/// The level of a surface: a number, "top" or "bottom".
fn surface(level: &Bound<PyAny>) -> PyResult<Level> {
    match level.str()?.to_string().as_str() {
        "top" => Ok(Level::Top),
        "bottom" => Ok(Level::Layer(0)),
        number => number.parse().map(Level::Layer).map_err(|_| {
            argument(format!(
                "surface: {level}, expected the number of a layer from 0, the innermost, \"top\" or \"bottom\""
            ))
        }),
    }
}
