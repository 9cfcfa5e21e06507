//! The data of a model: checked tables of a geodesic grid ([`Grid`]), fields in any memory layout ([`Field`],
//! [`Shape`]), layers ([`Layers`]), heights of columns ([`heights`]), and gradients at the vertices ([`gradient`]).
//!
//! The grid and its terms (cell, corner, center, frustum) are those of Xie, Yu and Ma, "Interactive Ray Casting of
//! Geodesic Grids" (2013, doi:10.1111/cgf.12135); "the paper" means this one throughout.
#![forbid(unsafe_code)]

pub mod array;
pub mod block;
mod description;
pub mod deviation;
mod error;
pub mod field;
pub mod gradient;
pub mod grid;
mod hash;
pub mod heights;
mod layers;
mod layout;
pub mod macrocells;
pub mod marks;
pub mod memory;
pub mod numbers;
pub mod occupancy;
mod printable;
pub mod real;
mod reals;
pub mod sample;
pub mod samples;
pub mod shape;
pub mod threads;
pub mod vectors;
pub mod visible_cells;

pub use description::Description;
pub use error::{Error, ErrorKind, Result};
pub use field::{ComputedField, CornerColumns, Field, Location, moved};
pub use grid::{
    CellsOver, CoarseGrid, Connectivity, Grid, GridTables, IcosahedralMesh, Indices, LonLat, MAX_LEVEL, OwnedGrid,
    OwnedTables, circumcenter, cut_polygon,
};
pub use layers::Layers;
pub use layout::{ColumnCount, Dimension};
pub use printable::printable;
pub use reals::{OwnedReals, Reals};
pub use shape::Shape;
