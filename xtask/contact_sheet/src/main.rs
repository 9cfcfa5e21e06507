//! `contact_sheet DIR PREFIX OUT.png`: puts the pictures `PREFIX*.png` of a directory on one sheet, row by row, in the
//! order of their names.

mod picture;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use picture::Picture;

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

/// Returns the number of pictures on the sheet.
fn make_sheet(dir: &Path, prefix: &str, out: &Path) -> Result<usize, Box<dyn Error>> {
    let paths = pictures(dir, prefix).map_err(|e| format!("{}: {e}", dir.display()))?;
    let mut tiles = Vec::new();
    for path in &paths {
        let picture = Picture::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        tiles.push(picture.scaled(SIDE));
    }
    if tiles.is_empty() {
        return Err(format!("{}: no pictures named {prefix}*.png", dir.display()).into());
    }
    sheet(&tiles).write(out).map_err(|e| format!("{}: {e}", out.display()))?;
    Ok(tiles.len())
}

/// The pictures in a directory whose names start with `prefix`, in order.
fn pictures(dir: &Path, prefix: &str) -> std::io::Result<Vec<PathBuf>> {
    let paths = std::fs::read_dir(dir)?.map(|entry| Ok(entry?.path()));
    let mut paths = paths.collect::<std::io::Result<Vec<_>>>()?;
    paths.retain(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(prefix) && name.ends_with(".png")
    });
    paths.sort();
    Ok(paths)
}

/// As many columns as rows, or one more.
fn sheet(tiles: &[Picture]) -> Picture {
    let columns = (tiles.len() as f64).sqrt().ceil() as usize;
    let rows = tiles.len().div_ceil(columns);
    let width = tiles.iter().map(|tile| tile.width).max().unwrap_or(0) + GAP;
    let height = tiles.iter().map(|tile| tile.height).max().unwrap_or(0) + GAP;
    let mut sheet = Picture::filled(columns * width + GAP, rows * height + GAP, BACKGROUND);
    for (i, tile) in tiles.iter().enumerate() {
        sheet.put(tile, GAP + i % columns * width, GAP + i / columns * height);
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_laid_out_row_by_row() {
        let dir = std::env::temp_dir().join(format!("icoray-contact-sheet-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let colours = [[200, 0, 0], [0, 200, 0], [0, 0, 200]];
        for (i, colour) in colours.into_iter().enumerate() {
            Picture::filled(480, 240, colour).write(&dir.join(format!("a_{i}.png"))).unwrap();
        }
        Picture::filled(9, 9, [1, 2, 3]).write(&dir.join("other.png")).unwrap();
        let out = dir.join("sheet.png");
        assert_eq!(make_sheet(&dir, "a_", &out).unwrap(), 3);
        let sheet = Picture::read(&out).unwrap();
        // Two columns and two rows of 240 x 120 pixels.
        assert_eq!((sheet.width, sheet.height), (2 * 246 + 6, 2 * 126 + 6));
        for (i, colour) in colours.into_iter().enumerate() {
            let (x, y) = (i % 2 * 246, i / 2 * 126);
            assert_eq!(sheet.pixel(x + 6, y + 6), colour);
            assert_eq!(sheet.pixel(x + 245, y + 125), colour);
            assert_eq!(sheet.pixel(x + 5, y + 6), BACKGROUND);
        }
        assert_eq!(sheet.pixel(246 + 6, 126 + 6), BACKGROUND);
        assert!(make_sheet(&dir, "b_", &out).unwrap_err().to_string().contains("no pictures named b_*.png"));
        std::fs::remove_dir_all(dir).unwrap();
    }
}
