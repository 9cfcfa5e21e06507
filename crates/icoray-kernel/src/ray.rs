//! What pictures use of the kernel.

pub use crate::budget::{Budget, FAINTEST};
pub use crate::fragment::Fragment;
pub use crate::packet::{PacketScene, beyond_gathers, packets};
pub use crate::scene_tracer::SceneTracer;
pub use crate::trace::{FragmentReport, PrimaryRay, Report, Tracer};
