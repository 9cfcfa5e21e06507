//! The report of a context's last frame, as a dict.

use crate::report::dict;
use icoray_context::types::{ICORAY_CPU, ICORAY_FRAGMENTS, ICORAY_GPU, ICORAY_TILES, icoray_frame_report};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The members of a report by name; words for numbers that have names, None for what there is not.
pub(super) fn of_context<'py>(py: Python<'py>, r: &icoray_frame_report) -> PyResult<Bound<'py, PyDict>> {
    let known = |number: f64| (!number.is_nan()).then_some(number);
    let members = dict!(py, r => [
        step time_s host_s waited_s copy_s prepare_s render_s write_s rays columns frusta void_frusta missing_values
        bytes_copied bytes_derived bytes_peak error_max error_mean error_p999 tolerance pixel_step threads frames_written
        frames_failed frames_dropped host_total_s write_total_s ranks tiles gather_s balance bytes_received fragments
        fragment_bytes compose_s upload_s bytes_uploaded frames edge_pixels pixels_over_tolerance rays_per_pixel
        cells_per_pixel_max cells_per_pixel_mean
    ] {
        "value_min": known(r.value_min),
        "value_max": known(r.value_max),
        "error_is_bound": r.error_is_bound != 0,
        "lights": ["off", "coarse", "full"][r.lights.clamp(0, 2) as usize],
        "scheme": match r.scheme {
            ICORAY_TILES => "tiles",
            ICORAY_FRAGMENTS => "fragments",
            _ => "alone",
        },
        "drawn_on": match r.drawn_on {
            ICORAY_CPU => "cpu",
            ICORAY_GPU => "gpu",
            _ => "gpu and cpu",
        },
        "device_s": known(r.device_s),
        "sampling_error_max": known(r.sampling_error_max),
        "sampling_error_mean": known(r.sampling_error_mean),
    });
    Ok(members)
}
