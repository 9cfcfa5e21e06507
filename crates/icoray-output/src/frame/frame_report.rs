//! What a frame cost and what it met.

use super::{Colors, ErrorSummary, Sharing};
use icoray_kernel::Counts;
use icoray_scene::Quality;

/// What a frame cost and what it met.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameReport {
    /// Seconds by stage.
    pub timing: Timing,
    /// Threads that drew, on this rank.
    pub threads: usize,
    /// How the picture was shared out among ranks.
    pub ranks: RanksReport,
    /// What a device did.
    pub device: DeviceReport,
    /// How far pixels may be from the exact integral.
    pub error: ErrorSummary,
    /// What the frame was drawn with: as the scene says, or less to stay inside its time budget.
    pub quality: Quality,
    /// Rays, columns, frusta; also of the rays of [`Self::edge_pixels`].
    pub counts: Counts,
    /// Pixels with the edge of a surface in them, each of which shows the mean of 8 rays in place of its first
    /// ([`Scene::antialias`](icoray_scene::Scene::antialias)).
    pub edge_pixels: u64,
    /// Least and greatest value of the field, `None` when all are missing.
    pub value_range: Option<[f64; 2]>,
    /// Values that are NaN, infinite or the fill value.
    pub missing_values: u64,
    /// Over which values colours went, and how they came to be these: of each colour map in the scene, the first
    /// volume's first. Where the scene gives knots there is none.
    pub colors: Vec<Colors>,
    /// Bytes that were derived from the field: averages of corner fields, gradients; and of the tables that this rank
    /// has of its node's mesh (`Columns::table_bytes`).
    pub derived_bytes: usize,
    /// Bytes of the fields that were copied: 0 but where the frame was drawn of a `Snapshot`, or of
    /// `Columns`: then those that this rank wrote, which are the fields' for each node.
    pub bytes_copied: u64,
    /// What the plan left out, in words.
    pub left_out: Vec<String>,
}

/// Seconds by stage, wall clock, of this rank.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Timing {
    /// Before the first ray: value range, averages of corner fields, gradients.
    pub prepare_s: f64,
    /// In the rays.
    pub render_s: f64,
    /// Encoding and disk.
    pub write_s: f64,
    /// Copying the fields, where the frame was drawn of a `Snapshot` or of `Columns`, with what ranks waited for each
    /// other; else 0.
    pub copy_s: f64,
    /// Waiting of the caller, which is the model: for the frame before to be drawn, or for room among those that wait
    /// to be written.
    pub waited_s: f64,
}

/// How the picture was shared out among ranks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RanksReport {
    /// Ranks that drew: 1, or more where the picture was shared out.
    pub count: usize,
    /// How ranks shared out the picture; `None` where one process drew alone.
    pub sharing: Option<Sharing>,
    /// Tiles of the picture that this rank drew, or put together of fragments.
    pub tiles: usize,
    /// Seconds in which this rank put rays together of fragments.
    pub compose_s: f64,
    /// Seconds in which rank 0 waited for the others' tiles and took them in.
    pub gather_s: f64,
    /// How even ranks were loaded: the mean of the seconds that they drew, of the longest; 1 is even.
    pub balance: f64,
    /// Bytes of tiles that rank 0 received.
    pub bytes_received: u64,
}

/// What a device did for the picture, on this rank.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeviceReport {
    /// The device that traced rays; `None` where the CPU did.
    pub name: Option<String>,
    /// Why the CPU drew, all or some tiles, although there was a device to ask for.
    pub left_to_cpu: Option<String>,
    /// Seconds until rays could begin on the device: preparing what is uploaded, and uploading. In
    /// [`Timing::render_s`].
    pub upload_s: f64,
    /// Seconds in the rays by the device's clock, where it has one.
    pub trace_s: Option<f64>,
    /// Bytes that were uploaded.
    pub bytes_uploaded: u64,
}
