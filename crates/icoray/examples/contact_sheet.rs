//! Puts pictures of a directory on one sheet: `contact_sheet DIR PREFIX OUT.png`.
//!
//! Takes `PREFIX*.png` in the order of their names, row by row.

use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Longest side of a picture on the sheet, and the gap around each, in pixels.
const SIDE: u32 = 240;
const GAP: u32 = 6;
const BACKGROUND: Rgb<u8> = Rgb([16, 18, 22]);

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

/// Returns the number of pictures on the sheet.
fn make_sheet(dir: &Path, prefix: &str, out: &Path) -> Result<usize, Box<dyn Error>> {
    let paths = pictures(dir, prefix).map_err(|e| format!("{}: {e}", dir.display()))?;
    let mut tiles = Vec::new();
    for path in &paths {
        tiles.push(scaled(path).map_err(|e| format!("{}: {e}", path.display()))?);
    }
    if tiles.is_empty() {
        return Err(format!("{}: no pictures named {prefix}*.png", dir.display()).into());
    }
    sheet(&tiles).save(out).map_err(|e| format!("{}: {e}", out.display()))?;
    Ok(tiles.len())
}

/// The pictures in a directory whose names begin so, in order.
fn pictures(dir: &Path, prefix: &str) -> std::io::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(dir)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with(prefix) && name.ends_with(".png") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// A picture, scaled so that its longer side is `SIDE`.
fn scaled(path: &Path) -> image::ImageResult<RgbImage> {
    let picture = image::open(path)?.into_rgb8();
    let factor = f64::from(SIDE) / f64::from(picture.width().max(picture.height()));
    let [width, height] =
        [picture.width(), picture.height()].map(|n| (f64::from(n) * factor).round().max(1.0));
    Ok(imageops::resize(&picture, width as u32, height as u32, FilterType::Triangle))
}

/// As many columns as rows, or one more.
fn sheet(tiles: &[RgbImage]) -> RgbImage {
    let count = tiles.len() as u32;
    let columns = f64::from(count).sqrt().ceil() as u32;
    let rows = count.div_ceil(columns);
    let width = tiles.iter().map(RgbImage::width).max().unwrap_or(0) + GAP;
    let height = tiles.iter().map(RgbImage::height).max().unwrap_or(0) + GAP;
    let mut sheet = RgbImage::from_pixel(columns * width + GAP, rows * height + GAP, BACKGROUND);
    for (tile, i) in tiles.iter().zip(0..) {
        let (x, y) = (GAP + i % columns * width, GAP + i / columns * height);
        imageops::replace(&mut sheet, tile, x.into(), y.into());
    }
    sheet
}
