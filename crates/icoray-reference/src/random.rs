//! Random scenes of all kinds, every pixel against the oracle.

mod check;
mod draw;

pub use check::{Checked, check};
pub use draw::{KINDS, RandomScene};
