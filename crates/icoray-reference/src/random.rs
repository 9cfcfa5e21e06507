//! Random scenes of all kinds, every pixel against the oracle.

mod check;
mod draw;
mod scene_text;

pub use check::{Checked, check};
pub use draw::RandomScene;
pub use scene_text::KINDS;
