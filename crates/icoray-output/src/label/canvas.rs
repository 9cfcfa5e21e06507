//! The bytes of a picture, and drawing on them.

use super::font::Mask;

/// 8-bit sRGB with straight alpha, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Canvas {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<u8>,
}

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rect {
    pub x: i64,
    pub y: i64,
    pub width: i64,
    pub height: i64,
}

impl Rect {
    /// The rectangle with `by` more pixels on each side.
    pub fn grown(self, by: i64) -> Self {
        let Rect { x, y, width, height } = self;
        Rect { x: x - by, y: y - by, width: width + 2 * by, height: height + 2 * by }
    }
}

impl Canvas {
    /// Adds rows below.
    pub fn extend(&mut self, rows: u32, color: [u8; 4]) {
        self.height += rows;
        let added = (0..rows as usize * self.width as usize).flat_map(|_| color);
        self.rgba.extend(added);
    }

    /// Blends a colour over a pixel with the coverage `ink`; does nothing outside the picture.
    pub fn blend(&mut self, x: i64, y: i64, color: [u8; 3], ink: f32) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        if x >= self.width || y >= self.height || ink <= 0.0 {
            return;
        }
        let at = 4 * (y as usize * self.width as usize + x as usize);
        let pixel = &mut self.rgba[at..at + 4];
        let under = f32::from(pixel[3]) / 255.0 * (1.0 - ink);
        let alpha = ink + under;
        for (channel, color) in pixel.iter_mut().zip(color) {
            let mixed = (f32::from(color) * ink + f32::from(*channel) * under) / alpha;
            *channel = (mixed + 0.5) as u8;
        }
        pixel[3] = (alpha * 255.0 + 0.5) as u8;
    }

    /// Blends a colour over a rectangle.
    pub(super) fn fill(&mut self, rect: Rect, color: [u8; 3], ink: f32) {
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                self.blend(x, y, color, ink);
            }
        }
    }

    /// Blends a colour over the ink of a mask whose upper left corner is at (`x`, `y`).
    pub(super) fn stamp(&mut self, x: i64, y: i64, mask: &Mask, color: [u8; 3]) {
        for (row, inks) in (y..).zip(mask.ink.chunks_exact(mask.width.max(1) as usize)) {
            for (column, ink) in (x..).zip(inks) {
                self.blend(column, row, color, *ink);
            }
        }
    }
}

/// sRGB's transfer curve (IEC 61966-2-1): linear light in [0, 1] to a byte.
pub(crate) fn srgb_byte(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_blended_over_the_picture() {
        let mut canvas = Canvas { width: 2, height: 1, rgba: vec![0, 0, 0, 255, 9, 9, 9, 0] };
        canvas.fill(Rect { x: -3, y: -1, width: 9, height: 2 }, [200, 100, 50], 0.5);
        // Over black: half of it; over nothing: all of the colour, half there.
        assert_eq!(canvas.rgba, [100, 50, 25, 255, 200, 100, 50, 128]);
        canvas.blend(1, 0, [0, 0, 0], 1.0);
        assert_eq!(canvas.rgba[4..], [0, 0, 0, 255]);
        canvas.extend(1, [1, 2, 3, 4]);
        assert_eq!((canvas.height, &canvas.rgba[8..]), (2, &[1, 2, 3, 4, 1, 2, 3, 4][..]));
    }
}
