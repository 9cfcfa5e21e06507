//! Datasets of xarray and uxarray: what `icoray.open` returns.

mod request;
pub(crate) mod sample;
mod source;
#[cfg(feature = "live")]
mod view;

use crate::error::raised;
use crate::image::Image;
use crate::renderer::Renderer;
use crate::scene::Scene;
use icoray::output::Stamp;
use icoray::{Grid, Ranks, Script, printable};
use icoray_dataset::{
    Combined, DatasetOptions, Drawing, FieldInfo, LayerSelection, Mesh, NativeHeightCache, OwnedField, SceneFields,
    Series, Source,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use request::Request;
use self_cell::self_cell;
use source::Store;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
#[cfg(feature = "live")]
pub(crate) use view::View;

self_cell!(
    /// A mesh and its grid, which borrows the tables.
    struct MeshGrid {
        owner: Arc<Mesh>,
        #[covariant]
        dependent: Grid,
    }
);

/// The last mesh that was checked: datasets of the same mesh share the grid, and with it what renderers derive of it.
static LAST: Mutex<Option<Arc<MeshGrid>>> = Mutex::new(None);

/// A dataset with its grid.
pub(crate) struct Opened {
    pub dataset: icoray_dataset::Dataset,
    grid: Arc<MeshGrid>,
    /// Bytes that were loaded, computed or converted in place of being read in memory.
    bytes_copied: Arc<AtomicU64>,
    heights: Mutex<NativeHeightCache>,
}

impl Opened {
    pub fn grid(&self) -> &Grid<'_> {
        self.grid.borrow_dependent()
    }

    /// Draws a scene at a time.
    fn draw(
        &self,
        renderer: &icoray::Renderer,
        layers: LayerSelection,
        scene: &icoray::Scene,
        time: usize,
    ) -> icoray::Result<icoray::Frame> {
        let (dataset, grid) = (&self.dataset, self.grid());
        let mut script = Script::from(scene.clone());
        if script.lacks_field() {
            script.name_first_field(&dataset.first_field()?.name);
        }
        script.show_as_surfaces(|name| dataset.field_info(name).is_ok_and(FieldInfo::is_2d));
        let scene_fields = SceneFields::new(dataset, &script, &layers)?;
        let drawing = Drawing { scene_fields: &scene_fields, grid, renderer };
        let series = Series::of(dataset, &script, vec![time], false);
        let (_, read) = series.views_of(drawing, time)?;
        let stamp: Stamp = series.stamp(time);
        let shot = script.views()[0].shots(&stamp).next().expect("a scene is one picture");
        let mut heights = self.heights.lock().unwrap_or_else(PoisonError::into_inner);
        heights.get_ready(drawing, std::iter::once(shot.scene.clone()), time)?;
        let frame = drawing.frame(&shot.scene, &read.borrowed()?, &heights, &mut Ranks::alone())?;
        let mut frame = frame.expect("who draws alone is rank 0");
        let masked: usize = read.fields.values().map(OwnedField::bytes).sum();
        frame.report.bytes_copied += masked as u64;
        frame.stamp = stamp;
        Ok(frame)
    }
}

/// A dataset of MPAS, ICON, UGRID or polygons with bounds: its mesh is read and checked, its fields are read when they are
/// drawn. `icoray.open` makes one.
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Dataset {
    opened: Arc<Opened>,
}

#[pymethods]
impl Dataset {
    #[new]
    #[pyo3(signature = (fields, others, *, at = None, heights = None, radius = None, missing = None))]
    fn new(
        py: Python,
        fields: Vec<Bound<PyAny>>,
        others: Vec<Bound<PyAny>>,
        at: Option<HashMap<String, usize>>,
        heights: Option<[f64; 2]>,
        radius: Option<f64>,
        missing: Option<Vec<f64>>,
    ) -> PyResult<Self> {
        let options = DatasetOptions {
            at: at.unwrap_or_default().into_iter().collect(),
            heights_m: heights,
            radius_m: radius,
            missing: missing.unwrap_or_default(),
        };
        let bytes_copied = Arc::<AtomicU64>::default();
        let source = |store: &Bound<PyAny>| -> PyResult<Box<dyn Source>> {
            Ok(Box::new(Store::new(store, bytes_copied.clone())?))
        };
        let fields = fields.iter().map(source).collect::<PyResult<Vec<_>>>()?;
        let others = others.iter().map(source).collect::<PyResult<Vec<_>>>()?;
        let opened = py.detach(|| -> icoray::Result<Opened> {
            let dataset = icoray_dataset::Dataset::new(Combined::of(fields)?, others, None, options)?;
            let grid = checked(dataset.shared_mesh())?;
            Ok(Opened { dataset, grid, bytes_copied, heights: Mutex::default() })
        });
        Ok(Dataset { opened: Arc::new(opened.map_err(raised)?) })
    }

    /// Names of the fields that are worth showing, the likeliest first.
    #[getter]
    fn likely_fields(&self) -> Vec<&str> {
        self.opened.dataset.likely_fields().into_iter().map(|info| info.name.as_str()).collect()
    }

    /// All fields by name: a dict of long_name, units, location ("cell" or "corner"), layers (1 of a 2D field) and
    /// whether it depends on time.
    #[getter]
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for info in self.opened.dataset.fields() {
            let one = crate::report::dict!(py, {
                "long_name": &info.description.long_name,
                "units": &info.description.units,
                "location": if info.location == icoray::Location::Center { "cell" } else { "corner" },
                "layers": info.layers,
                "time_dependent": info.time_dependent,
            });
            all.set_item(&info.name, one)?;
        }
        Ok(all)
    }

    /// The date of each time; None where there is none.
    #[getter]
    fn times(&self) -> Vec<Option<&str>> {
        self.opened.dataset.times().iter().map(Option::as_deref).collect()
    }

    /// The conventions that the mesh follows: "MPAS", "ICON", "UGRID", "ESMF", "FESOM2", "FVCOM", "polygons", or "points"
    /// for columns without tables.
    #[getter]
    fn convention(&self) -> &'static str {
        self.opened.dataset.mesh().format()
    }

    /// Number of cells: the points of ICON's triangles.
    #[getter]
    fn cells(&self) -> usize {
        self.opened.dataset.mesh().cells()
    }

    /// Number of corners: ICON's triangles.
    #[getter]
    fn corners(&self) -> usize {
        self.opened.dataset.mesh().corners()
    }

    /// Radius of the sphere, metres.
    #[getter]
    fn sphere_radius_m(&self) -> f64 {
        self.opened.dataset.sphere_radius_m()
    }

    /// Heights of the layers, or of the interfaces between them, on which a field lies.
    ///
    /// Parameters
    /// ----------
    /// field : str
    ///
    /// Returns
    /// -------
    /// list of float
    ///     Metres above the sphere: means over all columns where these differ.
    fn layer_heights(&self, py: Python, field: &str) -> PyResult<Vec<f64>> {
        py.detach(|| self.opened.dataset.layer_heights(field)).map(|heights| heights.height_m).map_err(raised)
    }

    /// The scene that `render` draws with the same arguments, to be kept or changed.
    #[pyo3(signature = (renderer, request))]
    fn scene(&self, py: Python, renderer: &Renderer, request: &Bound<PyDict>) -> PyResult<Scene> {
        let request = Request::new(request)?;
        let time = request.time(&self.opened.dataset)?;
        request.scene(py, &self.opened, renderer, time)
    }

    #[pyo3(signature = (renderer, request, progress = None))]
    fn render(
        &self,
        py: Python,
        renderer: &Renderer,
        request: &Bound<PyDict>,
        progress: Option<&Bound<PyAny>>,
    ) -> PyResult<Image> {
        let request = Request::new(request)?;
        let time = request.time(&self.opened.dataset)?;
        // What a suggestion looks at counts too.
        let before = self.opened.bytes_copied.load(Relaxed);
        let scene = request.scene(py, &self.opened, renderer, time)?;
        let layers = request.layers;
        let mut frame = renderer.draw(py, progress, |inner| self.opened.draw(inner, layers, &scene.inner, time))?;
        frame.report.bytes_copied += self.opened.bytes_copied.load(Relaxed) - before;
        Ok(Image::new(frame))
    }

    /// Serves the live page.
    #[cfg(feature = "live")]
    #[pyo3(signature = (renderer_threads, request, port = None))]
    fn view(&self, py: Python, renderer_threads: i64, request: &Bound<PyDict>, port: Option<i64>) -> PyResult<View> {
        View::open(py, &self.opened, renderer_threads, &Request::new(request)?, port)
    }

    fn __repr__(&self) -> String {
        let dataset = &self.opened.dataset;
        let (cells, fields, times) = (dataset.mesh().cells(), dataset.fields().len(), dataset.times().len());
        let (name, convention) = (dataset.path().display(), dataset.mesh().format());
        let name = printable(&name.to_string()).into_owned();
        format!("<icoray.Dataset {name}: {convention}, {cells} cells, {fields} fields, {times} times>")
    }
}

/// The grid of a mesh; the last one's where that has the same tables.
fn checked(mesh: Arc<Mesh>) -> icoray::Result<Arc<MeshGrid>> {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = last.as_ref().filter(|known| known.borrow_owner().is_same(&mesh)) {
        return Ok(known.clone());
    }
    let grid = Arc::new(MeshGrid::try_new(mesh, |mesh| mesh.grid())?);
    *last = Some(grid.clone());
    Ok(grid)
}
