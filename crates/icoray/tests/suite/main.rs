//! Tests of the library through its public interface, in one program; those of ranks and devices are in `../ranks`.

mod common;
mod contents;
mod corruption;
mod culled;
mod edges;
mod first_pictures;
mod grid;
mod holes;
mod hooks;
mod labels;
mod levels;
mod lit;
mod memory_limit;
mod mixed;
mod packets;
mod points;
mod probe;
mod samples;
mod savings;
mod terrain;
mod traverse;

// For `culled`, which other crates and the library's own tests include too.
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};
