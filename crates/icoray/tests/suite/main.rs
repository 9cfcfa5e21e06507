//! The tests of the library from outside, in one program.

mod columns;
mod common;
mod corner_heights;
mod corruption;
mod culled;
mod device;
mod edges;
mod grid;
mod holes;
mod labels;
mod lit;
mod memory_limit;
mod mixed;
mod mixed_packets;
mod native;
mod parts;
mod probe;
mod samples;
mod savings;
mod several;
mod spread;
mod terrain;
mod traverse;
mod walking;

// For `culled`, which other crates and the library's own tests include too.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
