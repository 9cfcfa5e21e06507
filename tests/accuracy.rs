//! Pictures against references, and their errors.

#[path = "../crates/icoray/tests/suite/culled/mod.rs"]
mod culled;
mod errors;
mod holes;
mod pictures;
mod random;

// For `culled`.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
