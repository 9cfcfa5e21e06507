//! Ray casting of geodesic grids.
mod error;
mod field;
mod grid;
mod layers;
pub use error::{Error, ErrorKind, Result};
pub use field::{CenterField, Field, Location, Shape};
pub use grid::{Grid, GridTables, IcosahedralMesh, LonLat, MAX_LEVEL, Reals};
pub use layers::Layers;
