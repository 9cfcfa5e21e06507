//! Tests of ranks, parts and devices through the public interface, in one program; ranks are threads here.

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
