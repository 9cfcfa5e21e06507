//! Reports as dicts of Python.

use icoray::{Certainty, FrameReport, Lights, Scheme};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A dict of names and values.
macro_rules! dict {
    ($py:expr, { $($name:literal: $value:expr),* $(,)? }) => {{
        let dict = PyDict::new($py);
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
    Ok(dict!(py, {
        "timing": dict!(py, {
            "prepare_s": r.timing.prepare_s,
            "render_s": r.timing.render_s,
            "write_s": r.timing.write_s,
            "copy_s": r.timing.copy_s,
            "waited_s": r.timing.waited_s,
        }),
        "threads": r.threads,
        "ranks": dict!(py, {
            "count": r.ranks.count,
            "scheme": match r.ranks.sharing.map(|sharing| sharing.scheme) {
                None => "alone",
                Some(Scheme::Fragments) => "fragments",
                Some(Scheme::Auto | Scheme::Tiles) => "tiles",
            },
            "tiles": r.ranks.tiles,
            "compose_s": r.ranks.compose_s,
            "gather_s": r.ranks.gather_s,
            "balance": r.ranks.balance,
            "bytes_received": r.ranks.bytes_received,
        }),
        "device": dict!(py, {
            "name": &r.device.name,
            "left_to_cpu": &r.device.left_to_cpu,
            "upload_s": r.device.upload_s,
            "trace_s": r.device.trace_s,
            "bytes_uploaded": r.device.bytes_uploaded,
        }),
        "error": dict!(py, {
            "max": r.error.max,
            "mean": r.error.mean,
            "p999": r.error.p999,
            "over_tolerance": r.error.over,
            "is_bound": r.error.certainty == Certainty::Bound,
        }),
        "quality": dict!(py, {
            "tolerance": r.quality.tolerance,
            "pixel_step": r.quality.pixel_step,
            "lights": match r.quality.lights {
                Lights::Off => "off",
                Lights::Coarse => "coarse",
                Lights::Full => "full",
            },
        }),
        "sampling": dict!(py, {
            "samples": r.sampling.samples,
            "rays_per_pixel": r.sampling.rays_per_pixel,
            "error_max": sampling_error.map(|error| error.max),
            "error_mean": sampling_error.map(|error| error.mean),
            "cells_per_pixel_max": r.sampling.cells_per_pixel.max,
            "cells_per_pixel_mean": r.sampling.cells_per_pixel.mean,
        }),
        "counts": dict!(py, {
            "rays": r.counts.rays,
            "columns": r.counts.columns,
            "frusta": r.counts.frusta,
            "void_frusta": r.counts.void_frusta,
            "scalar_pieces": r.counts.scalar_pieces,
            "fragments": r.counts.fragments,
            "fragment_bytes": r.counts.fragment_bytes,
        }),
        "edge_pixels": r.edge_pixels,
        "value_range": r.value_range.map(|range| range.to_vec()),
        "missing_values": r.missing_values,
        "colors": colors,
        "bytes_derived": r.derived_bytes,
        "bytes_copied": r.bytes_copied,
        "left_out": r.left_out.clone(),
    }))
}
