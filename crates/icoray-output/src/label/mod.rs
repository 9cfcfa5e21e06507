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

pub(crate) use canvas::Canvas;
pub use font::Mask;
pub(crate) use maps::maps;
pub use units::printed_units;

use crate::frame::{Frame, Legend};
use icoray_scene::{Scale, TransferFunction};

/// Draws the labels of a frame into its picture.
pub(crate) fn draw(canvas: &mut Canvas, frame: &Frame, legend: &Legend) {
    layout::draw(canvas, frame, legend);
}

/// Adds rows below a picture, with a bar of the colours of a transfer function; in colours of ink and paper.
pub(crate) fn draw_bar(
    canvas: &mut Canvas,
    scale: Scale,
    transfer: &TransferFunction,
    caption: &str,
    on: [[u8; 3]; 2],
) {
    layout::draw_bar(canvas, &bar::Bar::opaque(scale, transfer), caption, on);
}

#[cfg(test)]
mod tests;
