//! The frame report as a C struct.

use crate::memory;
use crate::types::{
    ICORAY_ALONE, ICORAY_CPU, ICORAY_FRAGMENTS, ICORAY_GPU, ICORAY_GPU_AND_CPU, ICORAY_TILES, icoray_frame_report,
};
use icoray_core::output::Stamp;
use icoray_core::{Certainty, FrameReport, Lights, Scheme};

/// Sums over the frames of one icoray_execute.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Call {
    pub frames: u64,
    pub waited_s: f64,
    pub copy_s: f64,
    pub bytes_copied: u64,
}

/// Sums over all frames of the context.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Totals {
    pub written: u64,
    pub failed: u64,
    pub dropped: u64,
    pub host_s: f64,
    pub write_s: f64,
    /// Seconds of the last call.
    pub last_host_s: f64,
    /// Seconds of the last frame that was written.
    pub last_write_s: f64,
}

impl Call {
    pub fn add(&mut self, report: &FrameReport) {
        self.frames += 1;
        self.waited_s += report.timing.waited_s;
        self.copy_s += report.timing.copy_s;
        self.bytes_copied += report.bytes_copied;
    }
}

/// Converts a report to the C struct.
pub(super) fn c_report(stamp: &Stamp, r: &FrameReport, call: &Call, totals: &Totals) -> icoray_frame_report {
    let [value_min, value_max] = r.value_range.unwrap_or([f64::NAN; 2]);
    icoray_frame_report {
        struct_size: size_of::<icoray_frame_report>(),
        step: stamp.step,
        time_s: stamp.time_s,
        host_s: totals.last_host_s,
        waited_s: call.waited_s,
        copy_s: call.copy_s,
        prepare_s: r.timing.prepare_s,
        render_s: r.timing.render_s,
        write_s: totals.last_write_s,
        rays: r.counts.rays,
        columns: r.counts.columns,
        frusta: r.counts.frusta,
        void_frusta: r.counts.void_frusta,
        value_min,
        value_max,
        missing_values: r.missing_values,
        bytes_copied: call.bytes_copied,
        bytes_derived: r.derived_bytes as u64,
        bytes_peak: memory::peak(),
        error_max: r.error.max,
        error_mean: r.error.mean,
        error_p999: r.error.p999,
        tolerance: r.quality.tolerance,
        error_is_bound: (r.error.certainty == Certainty::Bound).into(),
        pixel_step: r.quality.pixel_step as i32,
        lights: match r.quality.lights {
            Lights::Off => 0,
            Lights::Coarse => 1,
            Lights::Full => 2,
        },
        threads: r.threads as i32,
        ranks: r.ranks.count as i32,
        tiles: r.ranks.tiles as i32,
        gather_s: r.ranks.gather_s,
        balance: r.ranks.balance,
        bytes_received: r.ranks.bytes_received,
        scheme: match r.ranks.sharing.map(|sharing| sharing.scheme) {
            None => ICORAY_ALONE,
            Some(Scheme::Fragments) => ICORAY_FRAGMENTS,
            Some(Scheme::Auto | Scheme::Tiles) => ICORAY_TILES,
        },
        fragments: r.counts.fragments,
        fragment_bytes: r.counts.fragment_bytes,
        compose_s: r.ranks.compose_s,
        drawn_on: match (&r.device.name, &r.device.left_to_cpu) {
            (None, _) => ICORAY_CPU,
            (Some(_), None) => ICORAY_GPU,
            (Some(_), Some(_)) => ICORAY_GPU_AND_CPU,
        },
        upload_s: r.device.upload_s,
        device_s: r.device.trace_s.unwrap_or(f64::NAN),
        bytes_uploaded: r.device.bytes_uploaded,
        frames: call.frames,
        edge_pixels: r.edge_pixels,
        pixels_over_tolerance: r.error.over,
        rays_per_pixel: r.sampling.rays_per_pixel,
        sampling_error_max: r.sampling.error.map_or(f64::NAN, |error| error.max),
        sampling_error_mean: r.sampling.error.map_or(f64::NAN, |error| error.mean),
        cells_per_pixel_max: r.sampling.cells_per_pixel.max,
        cells_per_pixel_mean: r.sampling.cells_per_pixel.mean,
        frames_written: totals.written,
        frames_failed: totals.failed,
        frames_dropped: totals.dropped,
        host_total_s: totals.host_s,
        write_total_s: totals.write_s,
    }
}
