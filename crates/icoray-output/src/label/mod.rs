//! Labels in the written picture: colour bar, title, and how the picture is to be read.
//!
//! They are put over the bytes of a PNG on their way to the disk; pixels of frames, and so EXR files, have none. All
//! sizes scale with the picture.

mod bar;
mod block;
mod canvas;
mod font;
mod layout;
mod ticks;
mod units;
mod words;

pub(crate) use canvas::Canvas;

use crate::frame::{Frame, Legend};

/// Puts the labels of a frame over its picture.
pub(crate) fn draw(canvas: &mut Canvas, frame: &Frame, legend: &Legend) {
    layout::draw(canvas, frame, legend);
}

#[cfg(test)]
mod tests;
