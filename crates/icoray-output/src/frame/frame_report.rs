//! Report of a frame: cost, error and statistics.

use super::{Colors, ErrorSummary, SamplingReport};
use icoray_kernel::Counts;
use icoray_scene::{Quality, Scheme};
use std::fmt;

/// Report of a frame: cost, error and statistics.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameReport {
    /// Seconds by stage.
    pub timing: Timing,
    /// Number of threads that rendered, on this rank.
    pub threads: usize,
    /// Distribution of the picture over ranks.
    pub ranks: RanksReport,
    /// Work of a device.
    pub device: DeviceReport,
    /// Errors of pixels with respect to the exact integral.
    pub error: ErrorSummary,
    /// Quality of the frame: the scene's, or a lower one to stay within its time budget.
    pub quality: Quality,
    /// Rays per pixel, their sampling errors, and the cells that fall into a pixel.
    pub sampling: SamplingReport,
    /// Numbers of rays, columns and frusta, those of [`Self::edge_pixels`] and of samples included.
    pub counts: Counts,
    /// Number of pixels with the edge of a surface in them; each shows the mean of 8 rays in place of its first
    /// ([`Scene::antialias`](icoray_scene::Scene::antialias)), or of its samples, which are at least 8.
    pub edge_pixels: u64,
    /// Least and greatest value of the field; `None` if all are missing.
    pub value_range: Option<[f64; 2]>,
    /// Least and greatest value of each field that is shown and has values, by name; where ranks have parts, of the first
    /// field only.
    pub value_ranges: Vec<(String, [f64; 2])>,
    /// Colours and isosurfaces that show nothing of these values ([`Scene::off_values`](icoray_scene::Scene::off_values)),
    /// as text.
    pub off_values: Vec<String>,
    /// Number of values that are NaN, infinite or the fill value.
    pub missing_values: u64,
    /// Names of the fields shown all of whose values are missing; where ranks have parts, of the first field only.
    pub without_values: Vec<String>,
    /// Range of values of each colour map, and where the range comes from, in the scene's order. Transfer functions
    /// that are given as knots have none.
    pub colors: Vec<Colors>,
    /// Bytes of data derived from the field: averages of corner fields, gradients. One rank of each node counts what its
    /// ranks share, also the tables of its mesh (`Columns::table_bytes`).
    pub bytes_derived: usize,
    /// Bytes of the fields that this rank copied; 0 unless the frame was rendered in the background or from `Columns`,
    /// which are assembled once per node.
    pub bytes_copied: u64,
    /// Data that the plan left out, as text.
    pub left_out: Vec<String>,
}

/// Seconds by stage, wall clock, of this rank.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Timing {
    /// Before the first ray: value range, averages of corner fields, gradients.
    pub prepare_s: f64,
    /// Tracing rays.
    pub render_s: f64,
    /// Encoding and writing.
    pub write_s: f64,
    /// Copying the fields for the background or into `Columns`, waits of ranks for each other included; else 0.
    pub copy_s: f64,
    /// Waits of the caller, which is the model: for the previous frame, or for room in the writer's queue.
    pub waited_s: f64,
}

/// Distribution of the picture over ranks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RanksReport {
    /// Number of ranks that rendered the picture.
    pub count: usize,
    /// Method of distribution; `None` if one process rendered the picture.
    pub sharing: Option<Sharing>,
    /// Number of tiles that this rank rendered or composed.
    pub tiles: usize,
    /// Seconds in which this rank composed fragments.
    pub compose_s: f64,
    /// Seconds in which rank 0 waited for tiles of others and copied them.
    pub gather_s: f64,
    /// Load balance: mean rendering time of the ranks divided by the longest, 0 to 1.
    pub balance: f64,
    /// Bytes of tiles that rank 0 received.
    pub bytes_received: u64,
}

/// Work of a device for the picture, on this rank.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeviceReport {
    /// Name of the device that traced rays; `None` for the CPU.
    pub name: Option<String>,
    /// The reason why the CPU rendered some or all tiles although the scene allows a device.
    pub left_to_cpu: Option<String>,
    /// Seconds of preparing and uploading data before the first ray; part of [`Timing::render_s`].
    pub upload_s: f64,
    /// Seconds of tracing rays by the device's clock, if it has one.
    pub device_s: Option<f64>,
    /// Bytes uploaded to the device.
    pub bytes_uploaded: u64,
}

/// The distribution of a picture over ranks, with the reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sharing {
    /// Tiles or fragments.
    pub scheme: Scheme,
    why: &'static str,
    /// How ranks obtained the field, if they were given columns of it.
    gathered: Option<&'static str>,
}

impl Sharing {
    /// A scheme with the reason for it.
    pub fn because(scheme: Scheme, why: &'static str) -> Self {
        Sharing { scheme, why, gathered: None }
    }

    /// The scheme for a field that was gathered in each node's memory, or in each rank's own if none could be shared;
    /// with the grid, if ranks have parts of it.
    pub fn of_gathered(self, has_parts: bool, is_refused: bool) -> Self {
        let gathered = match (has_parts, is_refused) {
            (false, false) => "the field is assembled once per node",
            (false, true) => "the field is assembled once per rank, as nodes cannot share memory",
            (true, false) => "its ranks' parts and the field are assembled once per node",
            (true, true) => "parts and the field are assembled once per rank, as nodes cannot share memory",
        };
        let is_of_node = has_parts && !is_refused && self.scheme == Scheme::Tiles;
        let why = if is_of_node { "each node has the whole grid" } else { self.why };
        Sharing { gathered: Some(gathered), why, ..self }
    }
}

impl fmt::Display for Sharing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scheme = if self.scheme == Scheme::Fragments { "fragments" } else { "tiles" };
        write!(f, "{scheme}: {}", self.why)?;
        self.gathered.map_or(Ok(()), |gathered| write!(f, ", {gathered}"))
    }
}
