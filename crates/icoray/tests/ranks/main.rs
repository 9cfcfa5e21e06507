//! The tests of ranks, parts and devices from outside, in one program: pictures of several ranks, which are threads here.

mod columns;
#[path = "../suite/common.rs"]
mod common;
mod corner_heights;
#[path = "../suite/culled/mod.rs"]
mod culled;
mod device;
mod parts;
mod several;
#[path = "../suite/spread/mod.rs"]
mod spread;
mod suggested;

// For `culled`, which other crates and the library's own tests include too.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
