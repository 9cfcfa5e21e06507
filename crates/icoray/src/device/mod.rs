//! The interface to devices other than the CPU that trace a picture's rays. A device reads the tables of the grid, the
//! scene, and the field's values and gradients as plain numbers.
//!
//! The CPU renderer computes the plan, ranges, averages of fields at corners, gradients, blending over the background
//! and error bounds, and traces the tiles that the device does not return. All values are for `f32` kernels.

mod fields;
mod job;
mod scenery;

pub use crate::raster::Rect;
pub use fields::{FieldId, MAX_FIELDS, SceneField};
pub use icoray_grid::marks::Marks;
pub use icoray_kernel::Fragment;
pub use icoray_kernel::general::{ClipRegion, PaintedPlace, SurfaceHeight as SurfacePlace};
pub use icoray_kernel::shade::Shading;
pub use icoray_kernel::signature::BoundarySignature;
pub(crate) use job::GradientSource;
pub use job::{Content, Job};
pub(crate) use scenery::unsupported;
pub use scenery::{
    ColorByField, Isosurface, IsosurfacePaint, MAX_CLIPS, MAX_SURFACES, MAX_VOLUMES, Material, NativeLayers, Paint,
    SceneVolume, Scenery, SurfaceLayer, VolumeMap,
};

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use icoray_grid::Grid;
use icoray_scene::Adapter;
use std::fmt;
use std::ops::AddAssign;
use std::sync::Arc;

/// Marks a missing value, and the ends of the outer spans: larger than all normalised values, which are clamped to
/// 1e15. A shader has no reliable NaN or infinity.
pub const ENDLESS: f32 = 3e38;

/// The triangle that contains the direction `target`, searched from the triangle `from`: the nearer, the faster.
pub fn locate(grid: &Grid, from: u32, target: [f64; 3]) -> u32 {
    icoray_kernel::walk::locate(grid, from, DVec3::from_array(target))
}

/// A span between two knots of the transfer function, in which extinction and colour are linear in the normalised
/// value.
pub type Span = icoray_kernel::transfer::Span<f32>;

/// A step of the transfer function: a jump, or a change within the reach of rounding.
pub type Step = icoray_kernel::transfer::Step<f32>;

/// Division of the tolerance along a ray, as [`Budget`](icoray_kernel::Budget).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetTable {
    /// Allowed error of the colour per absorbed light.
    pub color_tolerance: f32,
    /// Transmittance at which a ray ends.
    pub min_transmittance: f32,
    /// Largest linear value that a channel can have behind a ray's end.
    pub brightest: f32,
}

/// A picture's request for a device.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct DeviceRequest {
    /// The scene's choice; `None` is any of the fastest kind.
    pub adapter: Option<Adapter>,
    /// Whether a processor that acts as a device is accepted.
    pub or_processor: bool,
    /// Number of this process among those of its node that draw together; they use different ones of several suitable
    /// devices.
    pub node_rank: usize,
}

/// Opens devices. A renderer calls it once for all pictures with equal requests.
pub trait Devices: fmt::Debug + Send + Sync {
    /// Opens a device.
    ///
    /// # Errors
    /// A [`FallbackReason`] if there is none.
    fn open(&self, wanted: &DeviceRequest) -> Result<Arc<dyn Device>, FallbackReason>;
}

/// A device that traces rays. Several threads may call it at once.
pub trait Device: fmt::Debug + Send + Sync {
    /// Its name, for reports.
    fn name(&self) -> String;

    /// Traces the rays of the tiles of `job` and passes each tile to `give` once, in any order: the CPU draws the
    /// others. Without tiles it only uploads the data that the next job of the same number needs.
    ///
    /// Called on a thread of the renderer's pool, so that parallel passes use its threads.
    ///
    /// # Errors
    /// A [`FallbackReason`] why tiles are missing, which the report contains.
    fn trace(&self, job: &Job, give: &(dyn Fn(Band) + Sync)) -> Result<DeviceCost, FallbackReason>;

    /// As [`Self::trace`], through own cells: passes on fragments of rays, which are composited elsewhere. They are a
    /// rank's part, or all cells if [`Job::is_painted`].
    ///
    /// # Errors
    /// As [`Self::trace`].
    fn fragments(
        &self,
        _job: &Job,
        _own: &OwnedColumns,
        _give: &(dyn Fn(Fragments) + Sync),
    ) -> Result<DeviceCost, FallbackReason> {
        Err(FallbackReason::new(format!("{} does not trace rays through parts of the grid", self.name())))
    }
}

/// The own triangles of a rank's part, or all triangles with data.
#[derive(Debug, Clone, Copy)]
pub struct OwnedColumns<'p> {
    /// Marks of the own triangles, by number.
    pub triangles: &'p Marks<'p>,
    /// Lowest height of any rank's facets, for a layer that is a unit sphere: deeper below the innermost layer, nothing
    /// is searched behind an opaque core.
    pub lowest_facet: f64,
    /// Centre of a ball around own columns: a line that misses it has no fragments.
    pub middle: [f64; 3],
    /// The square of the ball's radius: infinite if columns are all around, negative if there are none.
    pub reach: f64,
}

/// Tiles of a job that are traced through a part.
#[derive(Debug, Clone, Copy)]
pub struct Fragments<'b> {
    /// Index of the first tile in [`Job::tiles`].
    pub first: usize,
    /// The rays of that tile and of those behind it, tile by tile, each row by row.
    pub rays: &'b [RayFragments],
    /// Their fragments, ray by ray and in order along each.
    pub all: &'b [TracedFragment],
}

/// A fragment of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracedFragment {
    /// Its light.
    pub fragment: Fragment,
    /// The place at which it ends and continues in the next fragment, if the host computes the light there
    /// ([`Job::has_ground`], [`SurfaceLayer::is_painted`]).
    pub painted: Option<PaintedPlace>,
}

/// Result of a ray through a rank's part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct RayFragments {
    /// Numbers of columns, frusta and void frusta.
    pub counts: [u32; 3],
    /// Number of fragments.
    pub fragments: u32,
}

/// Tiles of a job that are traced.
#[derive(Debug, Clone, Copy)]
pub struct Band<'b> {
    /// Index of the first tile in [`Job::tiles`].
    pub first: usize,
    /// The rays of that tile and of those behind it, tile by tile, each row by row.
    pub rays: &'b [Traced],
    /// Seconds of tracing, of which each tile is assigned a share.
    pub seconds: f64,
}

/// Result of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Traced {
    /// Premultiplied linear RGB.
    pub color: [f32; 3],
    /// The absorbed part of the light from behind.
    pub alpha: f32,
    /// Error bound of a channel, without rounding; or [`Self::MISSED`].
    pub error: f32,
    /// Variance of rounding.
    pub variance: f32,
    /// Numbers of columns, frusta and void frusta.
    pub counts: [u32; 3],
    /// The surfaces that it met, as [`BoundarySignature::values`]: zeros without [`Job::scenery`].
    pub surfaces: [f32; 2],
}

impl Traced {
    /// The error of a ray that missed the shell.
    pub const MISSED: f32 = -1.0;
}

/// Cost of a job on a device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeviceCost {
    /// Seconds of preparation and upload before rays start.
    pub upload_s: f64,
    /// Seconds of tracing by the device's own clock, if it has one.
    pub device_s: Option<f64>,
    /// Bytes that were uploaded.
    pub bytes_uploaded: u64,
    /// Bytes of the whole field in the device's format.
    pub field_bytes: u64,
    /// Bytes of [`Self::field_bytes`] that no ray reads and that were not uploaded.
    pub unread_bytes: u64,
    /// Passes over the field: several if the device has no room for all values that rays read.
    pub passes: u32,
}

impl AddAssign for DeviceCost {
    fn add_assign(&mut self, other: Self) {
        self.upload_s += other.upload_s;
        self.bytes_uploaded += other.bytes_uploaded;
        self.field_bytes = self.field_bytes.max(other.field_bytes);
        self.unread_bytes = self.unread_bytes.max(other.unread_bytes);
        self.passes = self.passes.max(other.passes);
        self.device_s = self.device_s.into_iter().chain(other.device_s).reduce(|a, b| a + b);
    }
}

/// The reason why a device does not draw something.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FallbackReason(String);

impl FallbackReason {
    /// A reason in words that follow "drawn on the CPU: ".
    pub fn new(words: impl Into<String>) -> Self {
        FallbackReason(words.into())
    }
}

impl fmt::Display for FallbackReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for FallbackReason {}
