//! The renderer of this process.

use crate::error::{argument, of_class, raised};
use crate::field::{Field, of_field};
use crate::grid::Grid;
use crate::image::Image;
use crate::interrupt::{Tiles, Turn, check_signals, interruptible, is_main_thread};
use crate::layers::Layers;
use crate::scene::Scene;
use icoray::{Error, Fields, Heights};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::process;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Draws pictures of scenes, on threads of its own.
///
/// It stores data derived from a grid, and from constant fields, for the next picture, so a loop over times or views
/// uses one renderer. A colour range that a scene leaves to the first frame is that of this renderer's first frame of
/// the field. Several threads may share a renderer; they draw one after the other, while Python's lock is released.
///
/// Parameters
/// ----------
/// threads : int
///     Number of rendering threads; 0 is the number of processors in this process's affinity mask.
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Renderer {
    inner: icoray::Renderer,
    turn: Turn,
    stop: Arc<AtomicBool>,
    tiles: Arc<Tiles>,
    /// The process that has the threads.
    process: u32,
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(signature = (threads = 0))]
    pub fn new(threads: i64) -> PyResult<Self> {
        let (stop, tiles) = (Arc::<AtomicBool>::default(), Arc::<Tiles>::default());
        let counted = tiles.clone();
        let inner = made(threads, stop.clone())?.with_progress(Arc::new(move |done, all| counted.count(done, all)));
        Ok(Renderer { inner, turn: Turn::default(), stop, tiles, process: process::id() })
    }

    /// Number of rendering threads.
    #[getter]
    fn threads(&self) -> usize {
        self.inner.threads()
    }

    /// Draws a picture. Ctrl-C ends it with KeyboardInterrupt; the renderer can be used again afterwards.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene, str or os.PathLike
    ///     The scene to draw; a text or a file as in `Scene`.
    /// grid : Grid
    /// layers : Layers
    /// field : Field, array_like or dict
    ///     The scene's field, or fields by the names that the scene uses. Arrays are values at cells.
    /// heights : Field or array_like, optional
    ///     Heights of cells and layers above the planet's surface, metres, for scenes with heights = "native".
    ///
    /// Returns
    /// -------
    /// Image
    ///
    /// Raises
    /// ------
    /// Error
    ///     Of the class that says what is wrong: SceneError, FieldError, LayersError, OutOfMemoryError and others.
    #[pyo3(signature = (scene, grid, layers, field, *, heights = None))]
    fn render(
        &self,
        py: Python,
        scene: &Bound<PyAny>,
        grid: &Bound<Grid>,
        layers: &Bound<Layers>,
        field: &Bound<PyAny>,
        heights: Option<&Bound<PyAny>>,
    ) -> PyResult<Image> {
        let scene = Scene::of_argument(scene)?;
        let scene = &scene.get().inner;
        let (grid, layers) = (&*grid.get().inner, &layers.get().inner);
        let given = GivenFields::new(field, heights.filter(|_| scene.scenery.heights == Heights::Native))?;
        // SAFETY: `given` holds the arrays until the frame is drawn; callers must not write to them.
        let fields = unsafe { given.borrowed(grid, layers)? };
        let mut scene = scene.clone();
        if fields.first(scene.field()).is_ok_and(|field| field.shape().layers == 1) {
            scene.show_as_surface();
        }
        let (scene, fields) = (&scene, fields.on_layers(layers));
        let mut frame = self.draw(py, None, |inner| inner.render(scene, grid, layers, fields))?;
        frame.report.bytes_copied += given.bytes_copied();
        let described = |name: &str| {
            let field = if name == scene.field() { given.first(name) } else { given.get(name) };
            Some((name.to_owned(), field?.get().description.clone()))
        };
        frame.descriptions = scene.shown_fields().into_iter().filter_map(described).collect();
        Ok(Image::new(frame))
    }

    fn __repr__(&self) -> String {
        format!("<icoray.Renderer: {} threads>", self.threads())
    }
}

impl Renderer {
    /// Does `work` with the renderer, without Python's lock, when no other thread does. Ctrl-C ends it. `progress` is
    /// called with the numbers of tiles that are drawn and of all of them, now and then.
    pub fn draw<R: Send>(
        &self,
        py: Python,
        progress: Option<&Bound<PyAny>>,
        work: impl FnOnce(&icoray::Renderer) -> icoray::Result<R> + Send,
    ) -> PyResult<R> {
        self.refuse_fork()?;
        let is_watched = is_main_thread(py)? || progress.is_some();
        let progress = progress.map(|progress| progress.clone().unbind());
        let drawn = py.detach(|| {
            let _turn = self.turn.take(check_signals)?;
            self.tiles.reset();
            let draw = || Error::of_panics(|| work(&self.inner));
            let tick = || match &progress {
                Some(progress) => self.tiles.report(progress),
                None => check_signals(),
            };
            if is_watched { interruptible(&self.stop, tick, draw) } else { Ok(draw()) }
        });
        drawn?.map_err(raised)
    }

    /// Threads are not there in a forked child.
    fn refuse_fork(&self) -> PyResult<()> {
        let here = process::id();
        if here == self.process {
            return Ok(());
        }
        let made = self.process;
        let message =
            format!("the renderer was made by process {made}, of which this one ({here}) was forked; make one here");
        Err(of_class("ForkedError", message))
    }
}

/// A renderer that ends a picture early where `stop` is set.
pub(crate) fn made(threads: i64, stop: Arc<AtomicBool>) -> PyResult<icoray::Renderer> {
    if !(0..=4096).contains(&threads) {
        return Err(argument(format!("threads: {threads}, expected 0 to 4096")));
    }
    let made = icoray::Renderer::new(threads as usize).map_err(raised)?.with_stop(stop);
    #[cfg(feature = "gpu")]
    let made = made.with_devices(Arc::new(icoray_gpu::Gpus));
    Ok(made)
}

/// The fields of a call, which keep their arrays.
struct GivenFields<'py> {
    /// By name; a field without a name is the one that the scene shows first.
    named: Vec<(String, Bound<'py, Field>)>,
    unnamed: Option<Bound<'py, Field>>,
    heights: Option<Bound<'py, Field>>,
}

impl<'py> GivenFields<'py> {
    fn new(fields: &Bound<'py, PyAny>, heights: Option<&Bound<'py, PyAny>>) -> PyResult<Self> {
        let heights = heights.map(Field::of).transpose()?;
        let Ok(by_name) = fields.cast::<PyDict>() else {
            return Ok(GivenFields { named: Vec::new(), unnamed: Some(Field::of(fields)?), heights });
        };
        let named = by_name.iter().map(|(name, field)| Ok((name.extract::<String>()?, Field::of(&field)?)));
        let named = named.collect::<PyResult<Vec<_>>>()?;
        if named.is_empty() {
            return Err(argument("field: no fields, expected at least one".into()));
        }
        Ok(GivenFields { named, unnamed: None, heights })
    }

    /// # Safety
    /// The result is used while `self` lives, and no thread writes to the arrays meanwhile.
    unsafe fn borrowed(&self, grid: &icoray::Grid, layers: &icoray::Layers) -> PyResult<Fields<'static>> {
        // SAFETY: passed on.
        let borrowed = |field: &Bound<'py, Field>| unsafe { field.get().borrowed(grid, layers.count()) };
        let named = self.named.iter().map(|(name, field)| {
            let borrowed = borrowed(field).map_err(|error| of_field(name, error))?;
            Ok((name.clone(), borrowed))
        });
        let mut fields = match &self.unnamed {
            Some(field) => Fields::from(&borrowed(field).map_err(raised)?),
            None => Fields::new(named.collect::<PyResult<Vec<_>>>()?),
        };
        if let Some(heights) = &self.heights {
            fields = fields.with_heights(borrowed(heights).map_err(|error| raised(error.within("heights")))?);
        }
        Ok(fields)
    }

    fn get(&self, name: &str) -> Option<&Bound<'py, Field>> {
        self.named.iter().find(|(known, _)| known == name).map(|(_, field)| field)
    }

    /// The field that a scene calls `name` and shows first.
    fn first(&self, name: &str) -> Option<&Bound<'py, Field>> {
        let first = self.named.first().filter(|_| name.is_empty()).map(|(_, field)| field);
        self.unnamed.as_ref().or(first).or_else(|| self.get(name))
    }

    fn bytes_copied(&self) -> u64 {
        let all = self.named.iter().map(|(_, field)| field).chain(&self.unnamed).chain(&self.heights);
        all.map(|field| field.get().array.bytes_copied).sum()
    }
}
