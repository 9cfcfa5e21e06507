//! Pictures side by side with labels, as one picture.

use icoray::output::{Mask, Stamp, write_picture};
use icoray::{Frame, FrameReport, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// Size of text and height of a line, pixels.
const EM: f32 = 14.0;
const LINE: usize = 18;
const GAP: usize = 8;
const PAPER: [f32; 4] = [1.0, 1.0, 1.0, 1.0];

/// A picture of a montage with its label, a line for each line of text.
#[derive(Debug, Clone)]
pub struct Tile {
    /// Premultiplied linear RGBA, of the montage's tile size.
    pub pixels: Vec<[f32; 4]>,
    pub label: String,
}

/// Rows of tiles of `width` × `height` pixels, each row with room for its longest label above it.
pub struct Montage {
    tile: [usize; 2],
    rows: Vec<Vec<Tile>>,
}

impl Montage {
    pub fn new(width: u32, height: u32) -> Self {
        Montage { tile: [width as usize, height as usize], rows: Vec::new() }
    }

    pub fn push(&mut self, row: Vec<Tile>) {
        self.rows.push(row);
    }

    /// Writes the montage as PNG or EXR, by the name's ending.
    pub fn write(&self, path: &Path) -> Result<()> {
        let [width, height] = self.tile;
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let text = |row: &[Tile]| LINE * row.iter().map(|t| t.label.lines().count()).max().unwrap_or(0);
        let across = GAP + columns * (width + GAP);
        let down = GAP + self.rows.iter().map(|row| text(row) + height + GAP).sum::<usize>();
        let mut sheet = Sheet { width: across, pixels: vec![PAPER; across * down] };
        let mut y = GAP;
        for row in &self.rows {
            let text = text(row);
            for (i, tile) in row.iter().enumerate() {
                let x = GAP + i * (width + GAP);
                for (line, words) in tile.label.lines().enumerate() {
                    sheet.write(words, x, y + line * LINE, width);
                }
                sheet.paste(&tile.pixels, width, x, y + text);
            }
            y += text + height + GAP;
        }
        write_picture(path, &frame(across as u32, down as u32, sheet.pixels))
    }
}

/// Pixels as a frame without metadata.
pub(crate) fn frame(width: u32, height: u32, pixels: Vec<[f32; 4]>) -> Frame {
    Frame {
        width,
        height,
        error: vec![0.0; pixels.len()],
        sampling_error: Vec::new(),
        pixels,
        field: String::new(),
        descriptions: BTreeMap::new(),
        legend: None,
        notes: Vec::new(),
        stamp: Stamp::default(),
        report: FrameReport::default(),
    }
}

/// The difference of two pictures, times `amplify`, on black.
pub(crate) fn amplified<T: Copy + Into<f64>>(pixels: &[[f32; 4]], truth: &[[T; 4]], amplify: f64) -> Vec<[f32; 4]> {
    let pixel = |(a, b): (&[f32; 4], &[T; 4])| {
        let [r, g, b] = [0, 1, 2].map(|k| (amplify * (f64::from(a[k]) - b[k].into()).abs()) as f32);
        [r, g, b, 1.0]
    };
    pixels.iter().zip(truth).map(pixel).collect()
}

struct Sheet {
    width: usize,
    pixels: Vec<[f32; 4]>,
}

impl Sheet {
    fn paste(&mut self, pixels: &[[f32; 4]], width: usize, x: usize, y: usize) {
        for (row, line) in pixels.chunks_exact(width).enumerate() {
            let start = (y + row) * self.width + x;
            self.pixels[start..start + width].copy_from_slice(line);
        }
    }

    /// A line of black text, cut at `width` pixels.
    fn write(&mut self, words: &str, x: usize, y: usize, width: usize) {
        let mask = Mask::of_text(words, EM, width as i64);
        for (row, inks) in mask.ink.chunks_exact(mask.width.max(1) as usize).enumerate() {
            let start = (y + row) * self.width + x;
            for (pixel, ink) in self.pixels[start..].iter_mut().zip(inks).take(width) {
                // Mixed in about sRGB, as labels are.
                let light = (1.0 - ink).powf(2.2);
                *pixel = [light, light, light, 1.0];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_and_letters_lie_where_they_should() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("montage.png");
        let mut montage = Montage::new(32, 16);
        let tile = Tile { pixels: vec![[0.5; 4]; 32 * 16], label: "I\ntoo long for it".to_owned() };
        montage.push(vec![tile.clone(), tile.clone()]);
        montage.push(vec![tile]);
        montage.write(&path).unwrap();
        assert!(std::fs::metadata(&path).unwrap().len() > 200);
        let mut sheet = Sheet { width: 40, pixels: vec![PAPER; 40 * 20] };
        sheet.write("HHHHHHHHHHHHHHHHHHHH", 1, 2, 30);
        let ink: Vec<usize> = (0..800).filter(|i| sheet.pixels[*i][0] < 0.9).collect();
        // There are letters, and they stay in their box.
        assert!(ink.len() > 40 && ink.iter().all(|i| (1..31).contains(&(i % 40)) && i / 40 < 20), "{ink:?}");
    }
}
