//! Scenes.

use crate::error::{argument, raised};
use icoray::output::Stamp;
use icoray::{Error, ErrorKind, Script};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
use std::fs;
use std::path::PathBuf;

/// Description of a picture: camera, transfer functions, light, surfaces, labels.
///
/// Keys are those of scene files. Those that are given by name stand in place of the file's: tables are merged key by
/// key, lists are replaced, and a key that goes instead of others (`eye` instead of `lon` and `lat`) takes their place.
///
/// Parameters
/// ----------
/// source : str or os.PathLike, optional
///     A path, or TOML text: a str with a line break or a "=" in it is text.
/// view : str, optional
///     The one to draw of a file with several [[views]].
/// size : (int, int), optional
///     Width and height of the picture, pixels: short for image={"width": ..., "height": ...}.
/// **keys
///     Keys of the scene: field="q", camera={"lon": 20, "lat": 40, "distance": 3}, tolerance=1e-4, samples=16, ...
///
/// Raises
/// ------
/// SceneError
///     With line and key, the value and what was expected; also where the scene has several pictures.
///
/// Examples
/// --------
/// >>> import icoray
/// >>> scene = icoray.Scene(
/// ...     field="q",
/// ...     camera={"lon": 20, "lat": 40, "distance": 3},
/// ...     transfer={"map": "viridis", "range": [0, 1], "opacity": [[0, 0], [1, 0.9]]},
/// ... )
/// >>> scene.replace(size=(320, 200)).width
/// 320
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Scene {
    pub inner: icoray::Scene,
    text: String,
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (source = None, /, *, view = None, size = None, **keys))]
    fn new(
        source: Option<&Bound<PyAny>>,
        view: Option<&str>,
        size: Option<&Bound<PyAny>>,
        keys: Option<&Bound<PyDict>>,
    ) -> PyResult<Self> {
        let (text, path) = source.map(read).transpose()?.unwrap_or_default();
        let keys = table(size, keys)?;
        Self::with(&text, view, keys).map_err(|error| raised(within(&path, error)))
    }

    /// A scene of TOML text.
    #[staticmethod]
    #[pyo3(signature = (text, *, view = None))]
    fn parse(text: &str, view: Option<&str>) -> PyResult<Self> {
        Self::with(text, view, toml::Table::new()).map_err(raised)
    }

    /// The same scene with other keys, given as for `Scene`.
    #[pyo3(signature = (*, size = None, **keys))]
    fn replace(&self, size: Option<&Bound<PyAny>>, keys: Option<&Bound<PyDict>>) -> PyResult<Self> {
        let view = Script::parse(&self.text).map_err(raised)?.views()[0].name().to_owned();
        let view = (!view.is_empty()).then_some(view.as_str());
        Self::composed(self.text.clone(), view, table(size, keys)?).map_err(raised)
    }

    /// The text of a scene file with this scene: as it was read where no keys were given beside it.
    pub fn to_toml(&self) -> &str {
        &self.text
    }

    /// Name of the field that the scene shows first; empty where it names none.
    #[getter]
    fn field(&self) -> &str {
        self.inner.field()
    }

    /// Names of the model's fields that the scene needs.
    #[getter]
    fn fields(&self) -> Vec<&str> {
        self.inner.model_fields()
    }

    /// Width of the picture, pixels.
    #[getter]
    fn width(&self) -> u32 {
        self.inner.width
    }

    /// Height of the picture, pixels.
    #[getter]
    fn height(&self) -> u32 {
        self.inner.height
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    fn __repr__(&self) -> String {
        let icoray::Scene { width, height, .. } = self.inner;
        format!("<icoray.Scene: fields {:?}, {width} x {height} pixels>", self.inner.model_fields())
    }
}

impl Scene {
    /// The scene of an argument: a scene, or what one is made of.
    pub fn of_argument<'py>(scene: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Self>> {
        match scene.cast::<Self>() {
            Ok(scene) => Ok(scene.clone()),
            Err(_) => Bound::new(scene.py(), Self::new(Some(scene), None, None, None)?),
        }
    }

    /// The scene of a user's text with other keys.
    fn with(text: &str, view: Option<&str>, keys: toml::Table) -> icoray::Result<Self> {
        if keys.is_empty() && view.is_none() {
            return Self::of(&Script::parse(text)?, text.to_owned());
        }
        Self::composed(text.to_owned(), view, keys)
    }

    /// The scene of a text that no user has seen, or that is right, with other keys.
    pub fn composed(text: String, view: Option<&str>, keys: toml::Table) -> icoray::Result<Self> {
        let text = if keys.is_empty() && view.is_none() {
            text
        } else {
            let over = toml::to_string(&keys).map_err(|e| bad(format!("keys of a scene: {e}")))?;
            Script::text_with(&text, view, &over)?
        };
        Self::of(&Script::parse_composed(&text)?, text)
    }

    /// The scene of a script and of its text.
    fn of(script: &Script, text: String) -> icoray::Result<Self> {
        let names: Vec<&str> = script.views().iter().map(icoray::View::name).collect();
        let [view] = script.views() else {
            return Err(bad(format!(
                "the scene has the views {names:?}, expected one picture: name one by view=, or give the file to a Context"
            )));
        };
        let pictures = view.pictures();
        if pictures != 1 {
            return Err(bad(format!("sweep: {pictures} pictures, expected one; give the file to a Context")));
        }
        let shot = view.shots(&Stamp::default()).next().ok_or_else(|| bad("no picture".into()))?;
        Ok(Scene { inner: shot.scene, text })
    }
}

fn bad(context: String) -> Error {
    Error::new(ErrorKind::Scene, context)
}

/// The text of a source, and the path that it was read from.
pub(crate) fn read(source: &Bound<PyAny>) -> PyResult<(String, String)> {
    if let Ok(text) = source.extract::<String>()
        && text.contains(['\n', '='])
    {
        return Ok((text, String::new()));
    }
    let path: PathBuf = source
        .extract()
        .map_err(|_| argument(format!("scene: {source:?}, expected a Scene, the path of a scene file, or its text")))?;
    let text = fs::read_to_string(&path).map_err(|e| {
        let message = format!("{}: cannot read the scene: {e}", path.display());
        raised(Error::new(ErrorKind::Io, message))
    })?;
    Ok((text, path.display().to_string()))
}

/// The text of a source, with which nothing is wrong: errors name its path and lines.
pub(crate) fn parsed(source: &Bound<PyAny>) -> PyResult<String> {
    let (text, path) = read(source)?;
    match Script::parse(&text) {
        Ok(_) => Ok(text),
        Err(error) => Err(raised(within(&path, error))),
    }
}

/// The error of a text that was read from a path, if from any.
fn within(path: &str, error: Error) -> Error {
    if path.is_empty() { error } else { error.within(path) }
}

/// Width and height of a picture, pixels.
pub(crate) fn size(size: &Bound<PyAny>) -> PyResult<(u32, u32)> {
    let bad = |_| argument(format!("size: {size:?}, expected (width, height), two integers above 0"));
    size.extract::<[u32; 2]>().map(<(u32, u32)>::from).map_err(bad)
}

/// Keys of a scene as TOML.
fn table(size: Option<&Bound<PyAny>>, keys: Option<&Bound<PyDict>>) -> PyResult<toml::Table> {
    let mut table = match keys {
        Some(keys) => entries(keys, "", 0)?,
        None => toml::Table::new(),
    };
    if let Some((width, height)) = size.map(self::size).transpose()? {
        let image = table.entry("image").or_insert_with(|| toml::Table::new().into());
        if let Some(image) = image.as_table_mut() {
            image.insert("width".into(), i64::from(width).into());
            image.insert("height".into(), i64::from(height).into());
        }
    }
    Ok(table)
}

/// Tables and lists within each other, and items of a list: no scene has more. An object may hold itself, or never end.
const DEEPEST: usize = 16;
const LONGEST: usize = 100_000;

/// Keys of a scene, within `depth` tables and lists, as TOML.
pub(crate) fn entries(keys: &Bound<PyDict>, within: &str, depth: usize) -> PyResult<toml::Table> {
    let entry = |(key, value): (Bound<PyAny>, Bound<PyAny>)| {
        let key: String = key.extract()?;
        let value = toml_value(&value, &format!("{within}{key}"), depth + 1)?;
        Ok((key, value))
    };
    keys.iter().map(entry).collect()
}

/// A value of a scene; numpy's numbers and arrays are numbers and lists.
fn toml_value(value: &Bound<PyAny>, key: &str, depth: usize) -> PyResult<toml::Value> {
    if depth > DEEPEST {
        let key: String = key.chars().take(60).collect();
        return Err(raised(bad(format!("key {key}: dicts and lists within each other, expected at most {DEEPEST}"))));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        return Ok(entries(table, &format!("{key}."), depth)?.into());
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(value.is_truthy()?.into());
    }
    if value.is_instance_of::<PyString>() {
        return Ok(value.extract::<String>()?.into());
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(value.extract::<f64>()?.into());
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(value.extract::<i64>()?.into());
    }
    if value.hasattr("tolist")? {
        return toml_value(&value.call_method0("tolist")?, key, depth + 1);
    }
    if let Ok(path) = value.call_method0("__fspath__") {
        return toml_value(&path, key, depth + 1);
    }
    let items = value.try_iter().map_err(|_| {
        let message = format!("key {key}: {value}, expected a number, a text, a list or a dict");
        raised(bad(message))
    })?;
    let items = items.take(LONGEST + 1).map(|item| toml_value(&item?, key, depth + 1));
    let items: Vec<toml::Value> = items.collect::<PyResult<_>>()?;
    match items.len() <= LONGEST {
        true => Ok(items.into()),
        false => Err(raised(bad(format!("key {key}: more than {LONGEST} items")))),
    }
}
