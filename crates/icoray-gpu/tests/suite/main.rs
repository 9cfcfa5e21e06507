//! The tests of the shaders and of the pictures that the GPU draws, in one program.

#[path = "../../../icoray/tests/suite/common.rs"]
mod common;
#[path = "../../../icoray/tests/suite/contents.rs"]
mod contents;
#[path = "../../../icoray/tests/suite/culled/mod.rs"]
mod culled;
mod dispatch;
mod functions;
mod light;
mod pictures;
mod shaders;
#[path = "../../../icoray/tests/suite/spread/mod.rs"]
mod spread;

// Imported by `culled`.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
