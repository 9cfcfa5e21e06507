//! Vector operations of icoray's kernel that `fearless_simd` lacks: gathers from tables, and f64 vectors in
//! pairs that have as many lanes as one f32 vector.
//!
//! The kernel is generic over [`Machine`], an instruction set. This crate is the only one of the renderer's core with
//! `unsafe` code: the gathers of `gather.rs`, whose indices are clamped to their tables.

mod gather;
mod math;
mod table;
mod wide;

pub use gather::Machine;
pub use math::{exp2, log2, power};
pub use table::{Pairs, Rows, Table};
pub use wide::{Wide, WideMask, wide, wide_mask};

use fearless_simd::Simd;

/// A vector of f32 of the instruction set `V`.
pub type Floats<V> = <V as Simd>::f32s;
/// A vector of u32 with as many lanes as [`Floats`].
pub type Numbers<V> = <V as Simd>::u32s;
/// A mask of [`Floats`] and [`Numbers`].
pub type Mask<V> = <V as Simd>::mask32s;
