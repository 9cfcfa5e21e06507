//! RGB pictures: PNG files, scaling, placing.

use std::error::Error;
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Encoder, Transformations};

/// A picture of 8 bits per channel.
pub struct Picture {
    pub width: usize,
    pub height: usize,
    /// Row by row, from the top.
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// Reads a PNG of any kind; transparency is dropped.
    pub fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let mut decoder = Decoder::new(BufReader::new(File::open(path)?));
        decoder.set_transformations(Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let size = reader.output_buffer_size().ok_or("too large")?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes)?;
        let samples = info.color_type.samples();
        let pixels = bytes[..info.buffer_size()].chunks_exact(samples).map(|pixel| match pixel {
            [r, g, b, ..] => [*r, *g, *b],
            // Grey, with or without opacity.
            _ => [pixel[0]; 3],
        });
        Ok(Self { width: info.width as usize, height: info.height as usize, pixels: pixels.collect() })
    }

    /// Writes a PNG.
    pub fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let file = BufWriter::new(File::create(path)?);
        let mut encoder = Encoder::new(file, self.width.try_into()?, self.height.try_into()?);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        Ok(writer.finish()?)
    }

    /// The colour of a pixel.
    #[cfg(test)]
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * self.width + x]
    }

    /// Places `other` with its upper left corner at a pixel. It must lie within this picture.
    pub fn put(&mut self, other: &Picture, x: usize, y: usize) {
        for (row, pixels) in other.pixels.chunks_exact(other.width).enumerate() {
            let start = (y + row) * self.width + x;
            self.pixels[start..start + other.width].copy_from_slice(pixels);
        }
    }

    /// The picture scaled so that its longer side is `side`, by averages over the areas of the new pixels.
    pub fn scaled(&self, side: usize) -> Picture {
        let factor = side as f64 / self.width.max(self.height) as f64;
        let scaled = |size: usize| (size as f64 * factor).round().max(1.0) as usize;
        let (width, height) = (scaled(self.width), scaled(self.height));
        let (columns, rows) = (coverage(self.width, width), coverage(self.height, height));
        let mut pixels = Vec::with_capacity(width * height);
        for row in &rows {
            for column in &columns {
                let mut sum = [0.0; 3];
                for &(y, weight_y) in row {
                    for &(x, weight_x) in column {
                        let pixel = self.pixels[y * self.width + x];
                        for (sum, channel) in sum.iter_mut().zip(pixel) {
                            *sum += weight_x * weight_y * f64::from(channel);
                        }
                    }
                }
                // The weights add up to one; the conversion saturates.
                pixels.push(sum.map(|channel| channel.round() as u8));
            }
        }
        Picture { width, height, pixels }
    }
}

/// The old pixels that each new one covers along an axis, with their weights, which add up to one.
fn coverage(old: usize, new: usize) -> Vec<Vec<(usize, f64)>> {
    let step = old as f64 / new as f64;
    let covered = |i: usize| {
        let (start, end) = (i as f64 * step, ((i + 1) as f64 * step).min(old as f64));
        let last = (end.ceil() as usize).min(old);
        let overlap = |pixel: usize| (end.min(pixel as f64 + 1.0) - start.max(pixel as f64)).max(0.0);
        (start as usize..last).map(|pixel| (pixel, overlap(pixel) / (end - start))).collect()
    };
    (0..new).map(covered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_averages_areas() {
        let mut picture = Picture::filled(3, 1, [0; 3]);
        picture.put(&Picture::filled(1, 1, [90, 60, 30]), 1, 0);
        let half = picture.scaled(1);
        assert_eq!((half.width, half.height), (1, 1));
        assert_eq!(half.pixels, [[30, 20, 10]]);
        let two = picture.scaled(2);
        assert_eq!(two.pixels, [[30, 20, 10]; 2]);
        // Larger pictures too.
        assert_eq!(picture.scaled(6).pixels[2..4], [[90, 60, 30]; 2]);
    }

    #[test]
    fn weights_add_up_to_one() {
        for (old, new) in [(1, 1), (7, 3), (512, 240), (241, 240), (3, 10)] {
            for pixels in coverage(old, new) {
                let sum: f64 = pixels.iter().map(|(_, weight)| weight).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{old} to {new}: {sum}");
            }
        }
    }
}
