//! `contact_sheet DIR PREFIX OUT.png`: puts the pictures `PREFIX*.png` of a directory on one sheet, row by row, in the
//! order of their names.

use std::error::Error;
use std::fs;
use std::path::Path;

use image::{GenericImage, Rgb, RgbImage};

/// Longest side of a picture on the sheet, and the gap around each, in pixels.
const SIDE: u32 = 240;
const GAP: u32 = 6;
const BACKGROUND: Rgb<u8> = Rgb([16, 18, 22]);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let [dir, prefix, out] = arguments.as_slice() else { return Err("usage: contact_sheet DIR PREFIX OUT.png".into()) };
    let count = make_sheet(Path::new(dir), &prefix.to_string_lossy(), Path::new(out))?;
    println!("{count} pictures on {}", out.display());
    Ok(())
}

/// Puts the pictures in a directory whose names start with `prefix` on a sheet; returns their number.
fn make_sheet(dir: &Path, prefix: &str, out: &Path) -> Result<usize, Box<dyn Error>> {
    let mut names: Vec<_> = fs::read_dir(dir)?.flatten().map(|entry| entry.file_name()).collect();
    names.retain(|name| name.to_string_lossy().starts_with(prefix) && name.to_string_lossy().ends_with(".png"));
    names.sort();
    let mut tiles = Vec::new();
    for path in names.iter().map(|name| dir.join(name)) {
        let picture = image::open(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        tiles.push(picture.thumbnail(SIDE, SIDE).into_rgb8());
    }
    if tiles.is_empty() {
        return Err(format!("{}: no pictures named {prefix}*.png", dir.display()).into());
    }
    sheet(&tiles).save(out)?;
    Ok(tiles.len())
}

/// As many columns as rows, or one more.
fn sheet(tiles: &[RgbImage]) -> RgbImage {
    let count = tiles.len() as u32;
    let columns = f64::from(count).sqrt().ceil() as u32;
    let rows = count.div_ceil(columns);
    let width = tiles.iter().map(RgbImage::width).max().unwrap_or(0) + GAP;
    let height = tiles.iter().map(RgbImage::height).max().unwrap_or(0) + GAP;
    let mut sheet = RgbImage::from_pixel(columns * width + GAP, rows * height + GAP, BACKGROUND);
    for (i, tile) in (0..).zip(tiles) {
        let (x, y) = (GAP + i % columns * width, GAP + i / columns * height);
        sheet.copy_from(tile, x, y).expect("the sheet has room for all tiles");
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_laid_out_row_by_row() {
        let dir = std::env::temp_dir().join(format!("icoray-contact-sheet-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let colours = [[200, 0, 0], [0, 200, 0], [0, 0, 200]].map(Rgb);
        for (i, colour) in colours.into_iter().enumerate() {
            RgbImage::from_pixel(480, 240, colour).save(dir.join(format!("a_{i}.png"))).unwrap();
        }
        RgbImage::from_pixel(9, 9, Rgb([1, 2, 3])).save(dir.join("other.png")).unwrap();
        let out = dir.join("sheet.png");
        assert_eq!(make_sheet(&dir, "a_", &out).unwrap(), 3);
        let sheet = image::open(&out).unwrap().into_rgb8();
        // Two columns and two rows of 240 x 120 pixels.
        assert_eq!(sheet.dimensions(), (2 * 246 + 6, 2 * 126 + 6));
        let pixel = |x, y| *sheet.get_pixel(x, y);
        for (i, colour) in (0..).zip(colours) {
            let (x, y) = (i % 2 * 246, i / 2 * 126);
            assert_eq!(
                [pixel(x + 6, y + 6), pixel(x + 245, y + 125), pixel(x + 5, y + 6)],
                [colour, colour, BACKGROUND]
            );
        }
        assert_eq!(pixel(246 + 6, 126 + 6), BACKGROUND);
        assert!(make_sheet(&dir, "b_", &out).unwrap_err().to_string().contains("no pictures named b_*.png"));
        fs::remove_dir_all(dir).unwrap();
    }
}
