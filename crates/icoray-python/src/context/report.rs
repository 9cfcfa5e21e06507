//! The report of a context's last frame, as a dict.

use crate::report::dict;
use icoray_context::types::{ICORAY_CPU, ICORAY_FRAGMENTS, ICORAY_GPU, ICORAY_TILES, icoray_frame_report};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The members of a report by name; words for numbers that have names, None for what there is not.
pub(super) fn of_context<'py>(py: Python<'py>, r: &icoray_frame_report) -> PyResult<Bound<'py, PyDict>> {
    let known = |number: f64| (!number.is_nan()).then_some(number);
    Ok(dict!(py, {
        "step": r.step,
        "time_s": r.time_s,
        "host_s": r.host_s,
        "waited_s": r.waited_s,
        "copy_s": r.copy_s,
        "prepare_s": r.prepare_s,
        "render_s": r.render_s,
        "write_s": r.write_s,
        "rays": r.rays,
        "columns": r.columns,
        "frusta": r.frusta,
        "void_frusta": r.void_frusta,
        "value_min": known(r.value_min),
        "value_max": known(r.value_max),
        "missing_values": r.missing_values,
        "bytes_copied": r.bytes_copied,
        "bytes_derived": r.bytes_derived,
        "bytes_peak": r.bytes_peak,
        "error_max": r.error_max,
        "error_mean": r.error_mean,
        "error_p999": r.error_p999,
        "tolerance": r.tolerance,
        "error_is_bound": r.error_is_bound != 0,
        "pixel_step": r.pixel_step,
        "lights": ["off", "coarse", "full"][r.lights.clamp(0, 2) as usize],
        "threads": r.threads,
        "frames_written": r.frames_written,
        "frames_failed": r.frames_failed,
        "frames_dropped": r.frames_dropped,
        "host_total_s": r.host_total_s,
        "write_total_s": r.write_total_s,
        "ranks": r.ranks,
        "tiles": r.tiles,
        "gather_s": r.gather_s,
        "balance": r.balance,
        "bytes_received": r.bytes_received,
        "scheme": match r.scheme {
            ICORAY_TILES => "tiles",
            ICORAY_FRAGMENTS => "fragments",
            _ => "alone",
        },
        "fragments": r.fragments,
        "fragment_bytes": r.fragment_bytes,
        "compose_s": r.compose_s,
        "drawn_on": match r.drawn_on {
            ICORAY_CPU => "cpu",
            ICORAY_GPU => "gpu",
            _ => "gpu and cpu",
        },
        "upload_s": r.upload_s,
        "device_s": known(r.device_s),
        "bytes_uploaded": r.bytes_uploaded,
        "frames": r.frames,
        "edge_pixels": r.edge_pixels,
        "pixels_over_tolerance": r.pixels_over_tolerance,
        "rays_per_pixel": r.rays_per_pixel,
        "sampling_error_max": known(r.sampling_error_max),
        "sampling_error_mean": known(r.sampling_error_mean),
        "cells_per_pixel_max": r.cells_per_pixel_max,
        "cells_per_pixel_mean": r.cells_per_pixel_mean,
    }))
}
