//! The Python module `icoray._icoray`: grids, fields, scenes, renderers and contexts over numpy arrays.
//!
//! Layout: `array` arrays that are borrowed, or copied where they cannot be; `grid`, `layers`, `field`,
//! `scene` the inputs; `dataset` all of them in a dataset of xarray or uxarray, and its live page; `renderer`
//! frames of this process, with Ctrl-C (`interrupt`); `image` and `report` the picture of a frame and
//! its cost; `context` the contexts of the C interface, whose sources this crate builds as `icoray_context`; `mpi`
//! ranks over mpi4py; `error` Python's classes of errors.

mod array;
mod context;
mod dataset;
mod error;
mod field;
mod grid;
mod image;
mod interrupt;
mod layers;
mod mpi;
mod renderer;
mod report;
mod scene;

/// The compiled half of the package icoray.
#[pyo3::pymodule]
mod _icoray {
    #[pymodule_export]
    use crate::context::Context;
    #[pymodule_export]
    use crate::dataset::Dataset;
    #[cfg(feature = "live")]
    #[pymodule_export]
    use crate::dataset::View;
    #[pymodule_export]
    use crate::dataset::sample::sample;
    #[pymodule_export]
    use crate::field::Field;
    #[pymodule_export]
    use crate::grid::Grid;
    #[pymodule_export]
    use crate::image::{Image, write_animation};
    #[pymodule_export]
    use crate::layers::Layers;
    #[pymodule_export]
    use crate::renderer::Renderer;
    #[pymodule_export]
    use crate::scene::Scene;

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name is Python's")]
    const __version__: &str = icoray::VERSION;
}
