//! Pictures against references, their errors, and the instructions that they take.

#[path = "../crates/icoray/tests/suite/culled/mod.rs"]
mod culled;
mod errors;
mod holes;
mod instructions;
mod pictures;
mod random;

// For `culled`.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
