//! The tests of the studies, in one program.

#[path = "../../../icoray/tests/suite/culled/mod.rs"]
mod culled;
#[cfg(feature = "gpu")]
mod gpu;
mod holes;
mod studies;

// For `culled`.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
