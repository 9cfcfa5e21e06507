//! Reports as dicts of Python.

use icoray::{Certainty, FrameReport, Lights, Scheme};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A dict of names and values; before these, of members of a struct by their names.
macro_rules! dict {
    ($py:expr, { $($name:literal: $value:expr),* $(,)? }) => {
        $crate::report::dict!($py, () => [] { $($name: $value),* })
    };
    ($py:expr, $from:expr => [$($member:ident)*] { $($name:literal: $value:expr),* $(,)? }) => {{
        let dict = PyDict::new($py);
        $(dict.set_item(stringify!($member), &$from.$member)?;)*
        $(dict.set_item($name, $value)?;)*
        dict
    }};
}
pub(crate) use dict;

/// The report of a frame.
pub(crate) fn of_frame<'py>(py: Python<'py>, r: &FrameReport) -> PyResult<Bound<'py, PyDict>> {
    let colors = r
        .colors
        .iter()
        .map(|colors| Ok(dict!(py, { "field": &colors.field, "range": colors.range.to_vec(), "how": &colors.how })));
    let colors = colors.collect::<PyResult<Vec<_>>>()?;
    let sampling_error = r.sampling.error;
    let whole = dict!(py, r => [threads edge_pixels missing_values bytes_copied left_out] {
        "timing": dict!(py, r.timing => [prepare_s render_s write_s copy_s waited_s] {}),
        "ranks": dict!(py, r.ranks => [count tiles compose_s gather_s balance bytes_received] {
            "scheme": match r.ranks.sharing.map(|sharing| sharing.scheme) {
                None => "alone",
                Some(Scheme::Fragments) => "fragments",
                Some(Scheme::Auto | Scheme::Tiles) => "tiles",
            },
        }),
        "device": dict!(py, r.device => [name left_to_cpu upload_s trace_s bytes_uploaded] {}),
        "error": dict!(py, r.error => [max mean p999] {
            "over_tolerance": r.error.over,
            "is_bound": r.error.certainty == Certainty::Bound,
        }),
        "quality": dict!(py, r.quality => [tolerance pixel_step] {
            "lights": match r.quality.lights {
                Lights::Off => "off",
                Lights::Coarse => "coarse",
                Lights::Full => "full",
            },
        }),
        "sampling": dict!(py, r.sampling => [samples rays_per_pixel] {
            "error_max": sampling_error.map(|error| error.max),
            "error_mean": sampling_error.map(|error| error.mean),
            "cells_per_pixel_max": r.sampling.cells_per_pixel.max,
            "cells_per_pixel_mean": r.sampling.cells_per_pixel.mean,
        }),
        "counts": dict!(py, r.counts => [rays columns frusta void_frusta scalar_pieces fragments fragment_bytes] {}),
        "value_range": r.value_range.map(|range| range.to_vec()),
        "colors": colors,
        "bytes_derived": r.derived_bytes,
    });
    Ok(whole)
}
