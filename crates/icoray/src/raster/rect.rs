//! Rectangles of traced pixels.

/// A rectangle of traced pixels: from the first to before the last in each direction, counted in steps of
/// [`Quality::pixel_step`](icoray_scene::Quality::pixel_step) pixels. The last one of a picture's row or column may
/// come after a shorter step: node `i` of a side is its pixel `min(i · step, side - 1)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Rect {
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}
