//! Contexts: what the C interface offers, over arrays of Python.
//!
//! The calls are those of icoray-capi, whose sources this crate builds. Here arguments are converted, arrays kept while
//! the context may read them, and statuses turned into errors.

use crate::error::{argument, of_class};
use crate::grid::Grid;
use crate::layers::Layers;
use crate::scene::Scene;
use icoray::{PartCells, PartCorners};
use icoray_context::bindings::PartInput;
use icoray_context::icoray_ctx;
use icoray_context::types::{
    ICORAY_BLOCK, ICORAY_DISABLE, ICORAY_DROP_OLDEST, ICORAY_IGNORE, ICORAY_NEVER_MODIFY, ICORAY_OVERWRITE,
    ICORAY_WARN, icoray_config,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::CString;
use std::path::PathBuf;

mod arrays;
mod config;
mod date;
mod handle;
mod part;

use arrays::{ArrayNames, CArray};
use config::chosen;
use handle::Handle;
use part::Rows;

/// Draws inside of a running model: as the C interface, over arrays of Python.
///
/// A model sets grid, layers and a scene once, gives its fields in the time loop and calls `execute` at each step. A
/// thread writes the pictures and report.csv. Arrays are given by reference: a native array of 32- or 64-bit floats is
/// read during `execute` and kept alive by the context until it is replaced; one that cannot be borrowed is copied when
/// it is given (`report()["bytes_copied"]`), so give it again at each step. The context logs to the logger "icoray".
///
/// With `comm` the ranks of an MPI communicator draw each picture together. Then construction, `part_set`,
/// `scene_load`, `scene_text`, `execute`, `wait` and `close` are collective: all ranks call them in the same order,
/// also after failed calls. Ranks of a node share no memory: with parts each draws its cells and fragments of rays are
/// composed; with columns each has a copy of the fields. Python's lock is released in all calls. Signals are handled
/// after a call: `execute` is not interrupted, as other ranks would wait.
///
/// Parameters
/// ----------
/// output_dir : str or os.PathLike
///     Directory of the pictures and of report.csv; made if missing.
/// scene : Scene, str or os.PathLike, optional
///     As `scene_load` (a path) or `scene_text` (a text, as in `Scene`).
/// comm : mpi4py.MPI.Comm or int, optional
///     A communicator, or Fortran's integer of one; it is duplicated. Needs mpi4py.
/// threads : int
///     Rendering threads; 0 is this rank's share of the processors.
/// existing : {"keep", "overwrite"}
///     What happens to existing pictures: with "keep", `execute` raises ExistsError.
/// on_error : {"warn", "ignore", "disable"}
///     Failures are logged, or not, or switch the context off after `disable_after` failed frames in a row. They are
///     raised in any case.
/// disable_after : int
///     0 is 3.
/// async_render : bool
///     `execute` copies the fields and returns; a thread renders.
/// writer_queue : int
///     Frames that may wait for the writing thread; 0 is 2.
/// when_full : {"block", "drop"}
///     Whether `execute` then waits, or the oldest frame is dropped.
///
/// Examples
/// --------
/// >>> with icoray.Context("pictures", scene="scene.toml", existing="overwrite") as context:  # doctest: +SKIP
/// ...     context.grid_set(grid)
/// ...     context.layers_set(layers)
/// ...     for step in range(steps):
/// ...         model.advance()
/// ...         context.field_set("q", model.q)
/// ...         context.execute(step, step * model.dt)
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Context {
    /// Closed before what it borrows is freed.
    handle: Handle,
}

#[pymethods]
impl Context {
    #[new]
    #[pyo3(signature = (output_dir = None, scene = None, comm = None, *, threads = 0, existing = "keep",
                        on_error = "warn", disable_after = 0, async_render = false, writer_queue = 0,
                        when_full = "block"))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn new(
        py: Python,
        output_dir: Option<PathBuf>,
        scene: Option<&Bound<PyAny>>,
        comm: Option<&Bound<PyAny>>,
        threads: i32,
        existing: &str,
        on_error: &str,
        disable_after: i32,
        async_render: bool,
        writer_queue: i32,
        when_full: &str,
    ) -> PyResult<Self> {
        let on_error_is = [("warn", ICORAY_WARN), ("ignore", ICORAY_IGNORE), ("disable", ICORAY_DISABLE)];
        let settings = icoray_config {
            threads,
            existing: chosen("existing", existing, &[("keep", ICORAY_NEVER_MODIFY), ("overwrite", ICORAY_OVERWRITE)])?,
            on_error: chosen("on_error", on_error, &on_error_is)?,
            disable_after,
            async_render: async_render.into(),
            writer_queue,
            when_full: chosen("when_full", when_full, &[("block", ICORAY_BLOCK), ("drop", ICORAY_DROP_OLDEST)])?,
            ..Default::default()
        };
        let handle = Handle::open(py, output_dir, settings, comm)?;
        let context = Context { handle };
        if let Some(scene) = scene
            && let Err(error) = context.set_scene(py, scene)
        {
            // All ranks are here, as they agree on a scene.
            let _ = context.close(py);
            return Err(error);
        }
        Ok(context)
    }

    /// Sets a grid, which the context keeps until the next one of the same name.
    ///
    /// Parameters
    /// ----------
    /// grid : Grid
    ///     Over ranks: the whole grid, or the rank's part of it with a halo (`part_set`).
    /// name : str
    ///     Name of the grid, for contexts with several.
    #[pyo3(signature = (grid, name = ""))]
    fn grid_set(&self, py: Python, grid: &Bound<Grid>, name: &str) -> PyResult<()> {
        let inner = grid.get().inner.clone();
        // The tables are kept, and the previous ones until the call has replaced them.
        let tables = grid.clone().unbind();
        let set = |context: &icoray_ctx| context.set_grid(name, inner);
        let _replaced = self.handle.give(py, set, |kept| kept.grids.insert(name.to_owned(), tables))?;
        Ok(())
    }

    /// Declares which cells of a grid belong to this rank, where ranks have parts of the grid, or the whole grid and
    /// some columns of the fields. Collective.
    ///
    /// Parameters
    /// ----------
    /// cell_global : array_like of int, shape (cells,)
    ///     Number in the whole grid of each cell that this rank's fields have, counted from the grid's index_base.
    /// owned_cells : int, optional
    ///     Number of own cells, which come first; all by default.
    /// is_owned : array_like of bool, shape (cells,), optional
    ///     Which cells are own, in place of `owned_cells`.
    /// corner_global, owned_corners, is_corner_owned : optional
    ///     The same of corners, for fields and heights at corners of which the rank has some columns, with the whole grid's
    ///     tables. Of ICON these are its triangles.
    /// grid : str
    ///     Name of the grid.
    #[pyo3(signature = (cell_global, owned_cells = None, is_owned = None, *, corner_global = None,
                        owned_corners = None, is_corner_owned = None, grid = ""))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn part_set(
        &self,
        py: Python,
        cell_global: &Bound<PyAny>,
        owned_cells: Option<i64>,
        is_owned: Option<&Bound<PyAny>>,
        corner_global: Option<&Bound<PyAny>>,
        owned_corners: Option<i64>,
        is_corner_owned: Option<&Bound<PyAny>>,
        grid: &str,
    ) -> PyResult<()> {
        let cells = Rows::new(cell_global, owned_cells, is_owned, ["cell_global", "owned_cells", "is_owned"]);
        let names = ["corner_global", "owned_corners", "is_corner_owned"];
        let corners = corner_global.map(|global| Rows::new(global, owned_corners, is_corner_owned, names));
        let rows = cells.and_then(|cells| Ok((cells, corners.transpose()?)));
        let part = rows.as_ref().ok().map(|(cells, corners)| {
            // SAFETY: the tables live until the call returns.
            let (cells, corners) =
                unsafe { (cells.borrowed(py), corners.as_ref().map(|corners| corners.borrowed(py))) };
            let cells = PartCells { global: cells.0, owned: cells.1 };
            PartInput { grid, cells, corners: corners.map(|(global, owned)| PartCorners { global, owned }) }
        });
        // Ranks wait for each other here, so one with wrong arguments goes on with none.
        let set = self.handle.call(py, |context| context.set_part(part));
        rows.map(drop).and(set)
    }

    /// Sets the radii of layers, which are copied.
    ///
    /// Parameters
    /// ----------
    /// layers : Layers
    /// name : str
    ///     Name of the layers, for contexts with several.
    #[pyo3(signature = (layers, name = ""))]
    fn layers_set(&self, py: Python, layers: &Bound<Layers>, name: &str) -> PyResult<()> {
        let inner = &layers.get().inner;
        self.handle.call(py, |context| context.set_layers(name, inner.radius_m(), inner.planet_radius_m()))
    }

    /// Sets the heights of cells and layers above the planet's surface, metres, for scenes with heights = "native";
    /// None removes them.
    ///
    /// Parameters
    /// ----------
    /// values : Field, array_like or None
    ///     As for `field_set`, as many layers as `layers_set` has. Heights at corners are averaged to cells.
    /// location : {"cell", "corner"}
    #[pyo3(signature = (values, location = "cell", fill = None, *, layer_axis = None, grid = "", layers = ""))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn heights_set(
        &self,
        py: Python,
        values: Option<&Bound<PyAny>>,
        location: &str,
        fill: Option<f64>,
        layer_axis: Option<isize>,
        grid: &str,
        layers: &str,
    ) -> PyResult<()> {
        let Some(values) = values else {
            // SAFETY: no array.
            let unset = |context: &icoray_ctx| unsafe { context.set_heights(None) };
            let _replaced = self.handle.give(py, unset, |kept| kept.heights.take())?;
            return Ok(());
        };
        let names = ArrayNames::new(grid, layers)?;
        let given = arrays::given(values, location, fill, layer_axis);
        let field = given.map_err(|error| self.handle.refuse(py, "icoray_heights_set", "", error))?;
        let array = CArray::new(field.get(), &names);
        let _replaced =
            self.handle.give(py, move |context| array.set_heights(context), |kept| kept.keep_heights(field))?;
        Ok(())
    }

    /// Sets a field under the name that scenes use, until it is set again.
    ///
    /// Parameters
    /// ----------
    /// name : str
    /// values : Field or array_like
    ///     As for `Field`; of a Field, the following are its own. Grid and layers must be set before.
    /// location : {"cell", "corner"}
    /// fill : float, optional
    ///     Value that marks missing ones.
    /// layer_axis : int, optional
    ///     The dimension with the layers, where two could be.
    /// grid, layers : str
    ///     Names of the field's grid and layers.
    #[pyo3(signature = (name, values, location = "cell", fill = None, *, layer_axis = None, grid = "", layers = ""))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn field_set(
        &self,
        py: Python,
        name: &str,
        values: &Bound<PyAny>,
        location: &str,
        fill: Option<f64>,
        layer_axis: Option<isize>,
        grid: &str,
        layers: &str,
    ) -> PyResult<()> {
        let (name, names) = (plain(name, "name")?, ArrayNames::new(grid, layers)?);
        let given = arrays::given(values, location, fill, layer_axis);
        let field = given.map_err(|error| self.handle.refuse(py, "icoray_field_set", name, error))?;
        let array = CArray::new(field.get(), &names);
        let description = field.get().description.clone();
        let set = move |context: &icoray_ctx| array.set_field(context, name);
        let _replaced = self.handle.give(py, set, |kept| kept.keep_field(name, field))?;
        if description.long_name.is_some() || description.units.is_some() {
            self.field_describe(py, name, description.long_name.as_deref(), description.units.as_deref())?;
        }
        Ok(())
    }

    /// Sets the long name and the units of a field, for labels and texts of pictures.
    #[pyo3(signature = (name, long_name = None, units = None))]
    fn field_describe(&self, py: Python, name: &str, long_name: Option<&str>, units: Option<&str>) -> PyResult<()> {
        let name = plain(name, "name")?;
        let long_name = plain(long_name.unwrap_or_default(), "long_name")?;
        let units = plain(units.unwrap_or_default(), "units")?;
        self.handle.call(py, |context| context.describe_field(name, long_name, units))
    }

    /// Loads the scene from a file, on rank 0, for all ranks: one picture or several views, with their triggers and
    /// camera motions. On failure the previous scene stays in effect. Collective.
    #[pyo3(signature = (path))]
    fn scene_load(&self, py: Python, path: PathBuf) -> PyResult<()> {
        let path = path.to_string_lossy();
        let path = plain(&path, "path")?;
        self.handle.call(py, |context| context.load_scene(path))
    }

    /// As `scene_load`, from TOML text. Collective: all ranks use the text of rank 0.
    #[pyo3(signature = (text))]
    fn scene_text(&self, py: Python, text: &str) -> PyResult<()> {
        let text = plain(text, "text")?;
        self.handle.call(py, |context| context.set_scene_text(text))
    }

    /// Whether `execute` may draw a picture at this step; with a field's name, whether it may read that field. Local,
    /// with the same answer on all ranks.
    #[pyo3(signature = (step, time_s = 0.0, field = None))]
    fn wants(&self, py: Python, step: i64, time_s: f64, field: Option<&str>) -> PyResult<bool> {
        let field = field.map(|field| plain(field, "field")).transpose()?;
        let mut wants = false;
        self.handle.call(py, |context| context.wants(field, step, time_s, &mut wants))?;
        Ok(wants)
    }

    /// Renders all pictures that are due at this step from the fields as they are now. A thread writes them.
    ///
    /// Parameters
    /// ----------
    /// step : int
    ///     The model's step; views with `every` or `at_steps` refer to it.
    /// time_s : float
    ///     Model time, seconds; views with `at_times` refer to it.
    /// date : str, datetime or numpy.datetime64, optional
    ///     "YYYY-MM-DD_hh:mm:ss", for names of pictures.
    ///
    /// Raises
    /// ------
    /// Error
    ///     The first failure at this step, or of a picture of an earlier one that could not be written.
    #[pyo3(signature = (step, time_s = 0.0, date = None))]
    fn execute(&self, py: Python, step: i64, time_s: f64, date: Option<&Bound<PyAny>>) -> PyResult<()> {
        let date = date.map(date::text_of).transpose()?;
        let date = date.as_deref().map(|date| plain(date, "date")).transpose()?;
        if time_s.is_finite() && self.wants(py, step, time_s, None).unwrap_or(false) {
            self.handle.kept().count_copies();
        }
        // SAFETY: tables and arrays are kept, callers must not write to them.
        self.handle.call(py, |context| unsafe { context.execute(step, time_s, date) })
    }

    /// Waits until all frames are on disk. Collective.
    fn wait(&self, py: Python) -> PyResult<()> {
        self.handle.call(py, |context| context.wait())
    }

    /// Cost and error of the last rendered frame, and counts of all frames so far: the members of icoray_frame_report
    /// by name, with words for numbers that have some and None for NaN. bytes_copied includes the copies of arrays that could not be borrowed.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut report = self.handle.call(py, |context| context.report())?;
        report.bytes_copied += self.handle.kept().frame_copied;
        crate::report::of_figures(py, report.figures())
    }

    /// Waits for all frames and closes the context; arrays and tables are not read any more. A second call does nothing.
    /// Collective.
    fn close(&self, py: Python) -> PyResult<()> {
        self.handle.close(py)
    }

    /// Whether the context is closed.
    #[getter]
    fn closed(&self) -> bool {
        self.handle.is_closed()
    }

    fn __enter__(slf: Bound<Self>) -> Bound<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python, _error: &Bound<pyo3::types::PyTuple>) -> PyResult<()> {
        self.close(py)
    }
}

impl Context {
    fn set_scene(&self, py: Python, scene: &Bound<PyAny>) -> PyResult<()> {
        if let Ok(scene) = scene.cast::<Scene>() {
            return self.scene_text(py, scene.get().to_toml());
        }
        match scene.extract::<String>() {
            Ok(source) if source.contains(['\n', '=']) => self.scene_text(py, &source),
            _ => self.scene_load(py, scene.extract()?),
        }
    }
}

/// A text, which has no NUL, as names in C have none.
fn plain<'t>(text: &'t str, what: &str) -> PyResult<&'t str> {
    c_string(text, what).map(|_| text)
}

/// A string of C.
fn c_string(text: &str, what: &str) -> PyResult<CString> {
    CString::new(text).map_err(|_| argument(format!("{what}: {text:?} has a NUL in it")))
}

/// The error of a closed context.
fn closed() -> PyErr {
    of_class("OrderError", "the context is closed".into())
}
