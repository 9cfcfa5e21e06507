//! Labels in the written picture: colour bar, title and notes.
//!
//! They are drawn into the bytes of a PNG when it is encoded; pixels of frames, and so EXR files, have none. All sizes
//! scale with the picture.

mod bar;
mod block;
mod canvas;
mod font;
mod layout;
mod maps;
mod ticks;
mod units;
mod words;

pub(crate) use canvas::{Canvas, srgb_byte};
pub(crate) use layout::{draw, draw_bar};
pub(crate) use maps::maps;
pub use units::printed_units;

#[cfg(test)]
mod tests;
