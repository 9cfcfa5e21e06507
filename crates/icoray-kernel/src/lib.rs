//! Rays: the path of a ray through the grid, the integral along it and its light, one file per step:
//!
//! [`plane`] the ray's own plane → [`walk`] from triangle to triangle along the great circle below the ray →
//! [`mod@column`] from layer to layer inside one triangle → [`segment`] the scalar along one frustum, its extremum and
//! its knots → [`piece`] the integral of one monotone piece.
//!
//! `scene_tracer.rs` drives the rays of all scenes. In f32 `packet/` traces them side by side, one in each lane of the machine's
//! vectors. [`general`] traces one ray at a time in double precision: in f64, with the paper's method, on processors
//! without such vectors, and through the frusta of packets in which a ray meets a surface or a cut.
//!
//! Lengths are in planet radii, extinction is per planet radius, colours are linear RGB.
//!
//! Geometry is in f64 up to a column's ends (positions on a real Earth need it); everything from the column's ends on
//! is generic over [`Real`](icoray_grid::real::Real): in f32 there are only numbers of order one, such as fractions,
//! normalised values and lengths.
#![forbid(unsafe_code)]

mod budget;
pub mod column;
mod counts;
mod deviation;
pub mod empty_space_skipping;
mod fragment;
pub mod general;
pub mod ground;
mod leap;
mod light;
pub mod lit;
mod number;
pub mod owned_region;
mod packet;
pub mod piece;
pub mod plane;
mod roundoff;
mod scene_tracer;
pub mod segment;
pub mod shade;
pub mod signature;
mod trace;
pub mod transfer;
mod traverse;
pub mod turn;
mod volume_ray;
pub mod walk;

pub use budget::{Budget, FAINTEST};
pub use counts::Counts;
pub use deviation::Deviations;
pub use fragment::Fragment;
pub use packet::{PacketScene, beyond_gathers};
pub use scene_tracer::{SceneTracer, passages};
pub use trace::{FragmentReport, PrimaryRay, Report, Tracer};
pub use traverse::{Frustum, Stretch, Traversal};
