//! `contact_sheet DIR PREFIX OUT.png`: puts the pictures `PREFIX*.png` of a directory on one sheet, row by row, in the
//! order of their names.

use std::error::Error;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::Path;
use std::process::ExitCode;

use png::{BitDepth, ColorType, Decoder, Encoder, Transformations};

/// Longest side of a picture on the sheet, and the gap around each, in pixels.
const SIDE: usize = 240;
const GAP: usize = 6;
const BACKGROUND: [u8; 3] = [16, 18, 22];

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let [dir, prefix, out] = arguments.as_slice() else {
        eprintln!("usage: contact_sheet DIR PREFIX OUT.png");
        return ExitCode::FAILURE;
    };
    match make_sheet(Path::new(dir), &prefix.to_string_lossy(), Path::new(out)) {
        Ok(count) => {
            println!("{count} pictures on {}", Path::new(out).display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("contact_sheet: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Puts the pictures in a directory whose names start with `prefix` on a sheet; returns their number.
fn make_sheet(dir: &Path, prefix: &str, out: &Path) -> Result<usize, String> {
    let about = |path: &Path, error: &dyn Display| format!("{}: {error}", path.display());
    let entries = fs::read_dir(dir).map_err(|error| about(dir, &error))?.flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.retain(|name| name.starts_with(prefix) && name.ends_with(".png"));
    names.sort();
    let mut tiles = Vec::new();
    for path in names.iter().map(|name| dir.join(name)) {
        tiles.push(Picture::read(&path).map_err(|error| about(&path, &error))?.scaled(SIDE));
    }
    if tiles.is_empty() {
        return Err(about(dir, &format!("no pictures named {prefix}*.png")));
    }
    sheet(&tiles).write(out).map_err(|error| about(out, &error))?;
    Ok(tiles.len())
}

/// As many columns as rows, or one more.
fn sheet(tiles: &[Picture]) -> Picture {
    let columns = (tiles.len() as f64).sqrt().ceil() as usize;
    let rows = tiles.len().div_ceil(columns);
    let width = tiles.iter().map(|tile| tile.width).max().unwrap_or(0) + GAP;
    let height = tiles.iter().map(Picture::height).max().unwrap_or(0) + GAP;
    let mut sheet = Picture::filled(columns * width + GAP, rows * height + GAP, BACKGROUND);
    for (i, tile) in tiles.iter().enumerate() {
        let (x, y) = (GAP + i % columns * width, GAP + i / columns * height);
        for (row, pixels) in tile.pixels.chunks_exact(tile.width).enumerate() {
            let start = (y + row) * sheet.width + x;
            sheet.pixels[start..start + tile.width].copy_from_slice(pixels);
        }
    }
    sheet
}

/// A picture of 8 bits per channel.
struct Picture {
    width: usize,
    /// Row by row, from the top.
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of one colour.
    fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, pixels: vec![colour; width * height] }
    }

    fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// Reads a PNG of any kind; transparency is dropped.
    fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let mut decoder = Decoder::new(BufReader::new(File::open(path)?));
        decoder.set_transformations(Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("too large")?];
        let info = reader.next_frame(&mut bytes)?;
        let pixels = bytes[..info.buffer_size()].chunks_exact(info.color_type.samples()).map(|pixel| match pixel {
            [r, g, b, ..] => [*r, *g, *b],
            // Grey, with or without opacity.
            _ => [pixel[0]; 3],
        });
        Ok(Self { width: info.width as usize, pixels: pixels.collect() })
    }

    fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let file = BufWriter::new(File::create(path)?);
        let mut encoder = Encoder::new(file, self.width.try_into()?, self.height().try_into()?);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        Ok(writer.finish()?)
    }

    /// The picture scaled so that its longer side is `side`: each pixel is the mean of those that it covers.
    fn scaled(&self, side: usize) -> Picture {
        let longest = self.width.max(self.height());
        let size = |old: usize| (old * side).div_ceil(longest);
        let (width, height) = (size(self.width), size(self.height()));
        // Pixels that two new ones share belong to both.
        let covered = |i: usize, old: usize, new: usize| i * old / new..((i + 1) * old).div_ceil(new);
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut count) = ([0; 3], 0);
                for row in covered(y, self.height(), height) {
                    for pixel in &self.pixels[row * self.width..][covered(x, self.width, width)] {
                        sum.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += usize::from(*channel));
                        count += 1;
                    }
                }
                pixels.push(sum.map(|channel| ((channel + count / 2) / count) as u8));
            }
        }
        Picture { width, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_laid_out_row_by_row() {
        let dir = std::env::temp_dir().join(format!("icoray-contact-sheet-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let colours = [[200, 0, 0], [0, 200, 0], [0, 0, 200]];
        for (i, colour) in colours.into_iter().enumerate() {
            Picture::filled(480, 240, colour).write(&dir.join(format!("a_{i}.png"))).unwrap();
        }
        Picture::filled(9, 9, [1, 2, 3]).write(&dir.join("other.png")).unwrap();
        let out = dir.join("sheet.png");
        assert_eq!(make_sheet(&dir, "a_", &out).unwrap(), 3);
        let sheet = Picture::read(&out).unwrap();
        // Two columns and two rows of 240 x 120 pixels.
        assert_eq!((sheet.width, sheet.height()), (2 * 246 + 6, 2 * 126 + 6));
        let pixel = |x: usize, y: usize| sheet.pixels[y * sheet.width + x];
        for (i, colour) in colours.into_iter().enumerate() {
            let (x, y) = (i % 2 * 246, i / 2 * 126);
            assert_eq!(
                [pixel(x + 6, y + 6), pixel(x + 245, y + 125), pixel(x + 5, y + 6)],
                [colour, colour, BACKGROUND]
            );
        }
        assert_eq!(pixel(246 + 6, 126 + 6), BACKGROUND);
        assert!(make_sheet(&dir, "b_", &out).unwrap_err().contains("no pictures named b_*.png"));
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn scaling_takes_means() {
        let picture = Picture { width: 3, pixels: vec![[0; 3], [90, 60, 30], [0; 3]] };
        assert_eq!(picture.scaled(1).pixels, [[30, 20, 10]]);
        assert_eq!(picture.scaled(2).pixels, [[45, 30, 15]; 2]);
        // Larger pictures too.
        assert_eq!(picture.scaled(6).pixels[2..4], [[90, 60, 30]; 2]);
    }
}
