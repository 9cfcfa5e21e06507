//! The tests of the GPU's kernel, in one program.

#[path = "../../../icoray/tests/suite/culled/mod.rs"]
mod culled;
mod dispatch;
mod functions;
mod light;
mod pictures;
mod shaders;
#[path = "../../../icoray/tests/suite/spread/mod.rs"]
mod spread;
mod variants;

// For `culled`.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
