//! All colour maps side by side, with their names.

use super::block::Block;
use super::canvas::Canvas;
use super::font::Size;
use icoray_scene::{color_map_stops, color_maps};

const COLUMNS: usize = 4;
/// Width of a map's colours and of its name, in pixels.
const WIDTH: i64 = 180;
const NAMES: i64 = 130;
/// Height of a row, and room between rows and beside names.
const HEIGHT: i64 = 20;
const GAP: i64 = 6;

/// The upper left corner of a map.
fn place(number: usize, rows: usize) -> (i64, i64) {
    let [column, row] = [number / rows, number % rows].map(|i| i as i64);
    (GAP + column * (WIDTH + NAMES + 3 * GAP), GAP + row * (HEIGHT + GAP))
}

/// A picture of all colour maps in the order of their names, column by column.
pub(crate) fn maps() -> Canvas {
    let names: Vec<&str> = color_maps().split(", ").collect();
    let rows = names.len().div_ceil(COLUMNS);
    let mut block = Block::default();
    for (number, name) in names.iter().enumerate() {
        let (x, y) = place(number, rows);
        let colors = color_map_stops(name, WIDTH as usize).unwrap_or_default();
        block.colors(x, y, WIDTH, colors.repeat(HEIGHT as usize));
        let size = Size(13.0).fitting(name, NAMES);
        block.text(x + WIDTH + GAP, y + HEIGHT / 2 - size.middle(), size.line(name));
    }
    let size = [block.width, block.height].map(|side| (side + GAP) as u32);
    let mut canvas = Canvas { width: size[0], height: 0, rgba: Vec::new() };
    canvas.extend(size[1], [255; 4]);
    block.draw(&mut canvas, 0, 0, [0; 3]);
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_map_has_its_place() {
        let canvas = maps();
        let at = |x: i64, y: i64| &canvas.rgba[4 * (y * i64::from(canvas.width) + x) as usize..][..3];
        let names: Vec<&str> = color_maps().split(", ").collect();
        let rows = names.len().div_ceil(COLUMNS);
        for (number, name) in names.iter().enumerate() {
            let (x, y) = place(number, rows);
            let stops = color_map_stops(name, 2).unwrap();
            assert_eq!([at(x, y), at(x + WIDTH - 1, y + HEIGHT - 1)], [&stops[0], &stops[1]], "{name}");
            let inked = (y..y + HEIGHT).flat_map(|y| (x + WIDTH + 1..x + WIDTH + GAP + NAMES).map(move |x| (x, y)));
            assert!(inked.filter(|(x, y)| at(*x, *y)[0] < 128).count() > 20, "{name} has no name");
        }
    }
}
