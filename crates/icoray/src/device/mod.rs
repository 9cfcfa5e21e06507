//! The interface to devices other than the CPU that trace a picture's rays. A device reads the tables of the grid, the
//! scene, and the field's values and gradients as plain numbers.
//!
//! The CPU renderer keeps the plan, ranges, averages of fields at corners, gradients, blending over the background and
//! error bounds, and traces the tiles that the device does not return. Everything is for `f32` kernels.

mod fields;
mod isosurfaces;
mod job;
mod light;
pub mod mirror;
mod scenery;
mod tables;
mod volumes;

pub use crate::raster::Rect;
pub use fields::{FieldId, MAX_FIELDS, SceneField};
pub use icoray_kernel::ray::Fragment;
pub use icoray_kernel::signature::BoundarySignature;
pub use isosurfaces::{ColorByField, Isosurface, IsosurfacePaint};
pub use job::{Content, Job};
pub use light::Shading;
pub(crate) use scenery::unsupported;
pub use scenery::{ClipRegion, MAX_CLIPS, MAX_SURFACES, Material, Paint, Scenery, SurfaceLayer, SurfacePlace};
pub use tables::{BudgetTable, Span, Step, Tables, locate};
pub use volumes::{MAX_VOLUMES, SceneVolume, VolumeMap};

use bytemuck::{Pod, Zeroable};
use icoray_scene::Adapter;
use std::fmt;
use std::ops::AddAssign;
use std::sync::Arc;

/// Stands for a value that is missing, and for the ends of the outer spans: beyond all normalised values, which are
/// held within 1e15. A shader has no reliable NaN or infinity.
pub const ENDLESS: f32 = 3e38;

/// Which device a picture asks for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct DeviceRequest {
    /// The scene's choice; `None` is one of the fastest kind.
    pub adapter: Option<Adapter>,
    /// Whether a processor that acts as a device will do.
    pub or_processor: bool,
    /// Number of this process among those of its node that draw together, which go to different ones of several that
    /// fit.
    pub node_rank: usize,
}

/// Where devices come from. A renderer asks once for pictures that ask alike.
pub trait Devices: fmt::Debug + Send + Sync {
    /// Opens a device.
    ///
    /// # Errors
    /// A [`FallbackReason`] why there is none.
    fn open(&self, wanted: &DeviceRequest) -> Result<Arc<dyn Device>, FallbackReason>;
}

/// A device that traces rays. Several threads may call it at once.
pub trait Device: fmt::Debug + Send + Sync {
    /// Its name, for reports.
    fn name(&self) -> String;

    /// Traces the rays of the tiles of `job` and gives each tile once, in whatever order: those that it did not give
    /// are drawn on the CPU. Without tiles it gets ready only: what it uploads then serves the next job of the same
    /// number.
    ///
    /// Called on a thread of the renderer's pool, so that parallel passes use its threads.
    ///
    /// # Errors
    /// A [`FallbackReason`] why tiles were not given, which goes into the report.
    fn trace(&self, job: &Job, give: &(dyn Fn(Band) + Sync)) -> Result<DeviceCost, FallbackReason>;

    /// As [`Self::trace`], through the own cells of a rank that has a part of them: fragments of rays, which are put
    /// together elsewhere.
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

/// The own triangles of a rank's part.
#[derive(Debug, Clone, Copy)]
pub struct OwnedColumns<'p> {
    /// Whether a triangle is.
    pub triangles: &'p [bool],
    /// Height of the lowest place of any rank's facets over a unit sphere: farther below the innermost layer nothing
    /// is looked for behind an opaque core.
    pub lowest_facet: f64,
    /// Middle of a ball around own columns: a line that misses it has no fragments.
    pub middle: [f64; 3],
    /// The square of the ball's radius: infinite where columns are all around, negative where there are none.
    pub reach: f64,
}

/// Tiles of a job that are traced through a part.
#[derive(Debug, Clone, Copy)]
pub struct Fragments<'b> {
    /// The first one's place in [`Job::tiles`].
    pub first: usize,
    /// The rays of that tile and of those behind it, tile by tile, each row by row.
    pub rays: &'b [RayFragments],
    /// Their fragments, ray by ray and in order along each.
    pub all: &'b [Fragment],
}

/// Result of a ray through a rank's part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct RayFragments {
    /// Columns, frusta and void frusta.
    pub counts: [u32; 3],
    /// How many fragments it has.
    pub fragments: u32,
}

/// Tiles of a job that are traced.
#[derive(Debug, Clone, Copy)]
pub struct Band<'b> {
    /// The first one's place in [`Job::tiles`].
    pub first: usize,
    /// The rays of that tile and of those behind it, tile by tile, each row by row.
    pub rays: &'b [Traced],
    /// Seconds that they took, of which each tile counts as having taken its part.
    pub seconds: f64,
}

/// Result of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Traced {
    /// Premultiplied linear RGB.
    pub color: [f32; 3],
    /// The part of what lies behind that is absorbed.
    pub alpha: f32,
    /// How far a channel may be off, rounding apart; or [`Self::MISSED`].
    pub error: f32,
    /// Variance of rounding.
    pub variance: f32,
    /// Columns, frusta and void frusta.
    pub counts: [u32; 3],
    /// The surfaces that it met, as [`BoundarySignature::values`]: zeros in a plain scene.
    pub surfaces: [f32; 2],
}

impl Traced {
    /// The error of a ray that missed the shell.
    pub const MISSED: f32 = -1.0;
}

/// Cost of a job on a device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeviceCost {
    /// Seconds until rays could begin: preparing and uploading.
    pub upload_s: f64,
    /// Seconds in rays by the device's own clock, where it has one.
    pub device_s: Option<f64>,
    /// Bytes that were uploaded.
    pub bytes_uploaded: u64,
    /// Bytes of the whole field as the device has it, and those of them that no ray reads and that were not uploaded.
    pub field_bytes: u64,
    /// See above.
    pub unread_bytes: u64,
    /// Passes over the field: several where the device has no room for all that rays read.
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
    /// A reason in words that go on behind "drawn on the CPU: ".
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
