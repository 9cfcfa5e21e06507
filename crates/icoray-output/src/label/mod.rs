//! Labels in the written picture: colour bar, title and notes.
//!
//! They are drawn into the bytes of a PNG when it is encoded; pixels of frames, and so EXR files, have none. All sizes
//! scale with the picture.

mod bar;
mod block;
mod canvas;
mod font;
mod layout;
mod ticks;
mod units;
mod words;

pub(crate) use canvas::Canvas;
pub use units::printed_units;

use crate::frame::{Frame, Legend};

/// Draws the labels of a frame into its picture.
pub(crate) fn draw(canvas: &mut Canvas, frame: &Frame, legend: &Legend) {
    layout::draw(canvas, frame, legend);
}

#[cfg(test)]
mod tests;
