//! A picture of the error of each pixel: colours over decades, with a labelled bar.

use super::{digits, png_file};
use crate::atomic::Existing;
use crate::frame::Frame;
use colorgrad::{Gradient, preset};
use icoray_grid::{Error, ErrorKind, Result};
use std::path::Path;

/// Powers of ten of the first and the last colour. Fixed, so that pictures can be compared.
const DECADES: [i32; 2] = [-8, -1];
/// Shades of the map.
const SHADES: usize = 512;
/// Rows of the bar below the picture: a gap, colours, ticks, a gap, labels, a gap.
const ROWS: [usize; 6] = [4, 10, 4, 2, 2 * digits::HEIGHT, 4];
/// The narrowest picture that has room for the bar.
const MIN_WIDTH: usize = 160;

type Rgba = [u8; 4];

const CLEAR: Rgba = [0; 4];
const BACK: Rgba = [0, 0, 0, 255];
const INK: Rgba = [255; 4];

/// Writes the error of each pixel of `frame` to the PNG file at `path`.
///
/// The colours are viridis over the logarithm of the error, from dark at 1e-8 and less to bright at 1e-1 and more.
/// Pixels without an error, which are those whose ray meets nothing, are transparent. Where pixels are means of several
/// rays, a map of their estimated sampling errors ([`Frame::sampling_error`]) in the same colours lies below. A bar with a
/// tick at each decade follows, where the picture is at least 160 pixels wide; the text of the file says the same, and
/// what [`Frame::describe`] says. A file of that name is replaced when the new one is complete.
///
/// # Errors
/// [`ErrorKind::Io`] names the path; [`ErrorKind::Argument`] an ending other than `.png`.
pub fn write_error_map(path: &Path, frame: &Frame) -> Result<()> {
    write_error_map_with(path, frame, Existing::Overwrite)
}

/// As [`write_error_map`]; `existing` selects what happens to an existing file.
///
/// # Errors
/// As [`write_error_map`], and [`ErrorKind::Exists`] as [`Existing`] says.
pub fn write_error_map_with(path: &Path, frame: &Frame, existing: Existing) -> Result<()> {
    if path.extension().and_then(|e| e.to_str()) != Some("png") {
        let context = format!("{}: expected a name that ends in .png for the map of errors", path.display());
        return Err(Error::new(ErrorKind::Argument, context));
    }
    let shades = shades();
    let errors = frame.error.iter().chain(&frame.sampling_error);
    let mut pixels: Vec<Rgba> = errors.map(|error| color(&shades, *error)).collect();
    let width = frame.width as usize;
    if width >= MIN_WIDTH {
        pixels.extend(bar(&shades, width));
    }
    let rows = (pixels.len() / width) as u32;
    png_file::write_rgba(path, [frame.width, rows], pixels.as_flattened(), &texts(frame), existing)
}

/// The text entries of the file.
fn texts(frame: &Frame) -> Vec<(String, String)> {
    let mut texts = frame.describe();
    let mut say = |key: &str, text: String| texts.push((key.into(), text));
    say("shows", "the error of each pixel, the largest of its channels, premultiplied linear 0 to 1".into());
    if !frame.sampling_error.is_empty() {
        say(
            "shows below",
            "the estimated sampling error of each pixel, how far its rays' mean may be off its area's".into(),
        );
    }
    say("scale", "viridis over the logarithm; transparent where there is no error".into());
    say("scale range", format!("1e{} to 1e{}", DECADES[0], DECADES[1]));
    texts
}

/// The colours from the first decade to the last.
fn shades() -> Vec<Rgba> {
    let map = preset::viridis();
    (0..SHADES).map(|i| map.at(i as f32 / (SHADES - 1) as f32).to_rgba8()).collect()
}

/// The colour of an error.
fn color(shades: &[Rgba], error: f32) -> Rgba {
    // Not >, so that a NaN error gets the last colour.
    if error <= 0.0 {
        return CLEAR;
    }
    let [low, high] = DECADES.map(|d| d as f32);
    let part = if error.is_nan() { 1.0 } else { (error.log10() - low) / (high - low) };
    shades[(part.clamp(0.0, 1.0) * (SHADES - 1) as f32).round() as usize]
}

/// The rows of the bar.
fn bar(shades: &[Rgba], width: usize) -> Vec<Rgba> {
    let [gap, colors, ticks, space, ..] = ROWS;
    let mut rows = vec![BACK; width * ROWS.iter().sum::<usize>()];
    let decades = (DECADES[0]..=DECADES[1]).map(|d| format!("1e{d}"));
    let labels: Vec<String> = decades.collect();
    // Half a label sticks out on either side.
    let scale = if width >= 2 * MIN_WIDTH { 2 } else { 1 };
    let label_width = scale * (4 * digits::ADVANCE - 1);
    let margin = label_width / 2 + scale;
    let length = width - 2 * margin;
    for x in 0..length {
        let shade = shades[x * (SHADES - 1) / (length - 1)];
        for y in gap..gap + colors {
            rows[y * width + margin + x] = shade;
        }
    }
    for (i, label) in labels.iter().enumerate() {
        let x = margin + i * (length - 1) / (labels.len() - 1);
        for y in gap + colors..gap + colors + ticks {
            rows[y * width + x] = INK;
        }
        for (dot_x, dot_y) in digits::dots(label) {
            for place in 0..scale * scale {
                let x = x - label_width / 2 + dot_x * scale + place % scale;
                let y = gap + colors + ticks + space + dot_y * scale + place / scale;
                rows[y * width + x] = INK;
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::frame;

    fn wide_frame(width: u32) -> Frame {
        let error = (0..2 * width).map(|i| if i < width { 0.0 } else { 10f32.powf(-(i as f32) / 40.0) });
        let pixels = vec![[0.0; 4]; 2 * width as usize];
        Frame { width, error: error.collect(), pixels, ..frame() }
    }

    fn read(frame: &Frame) -> image::RgbaImage {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.png");
        write_error_map(&path, frame).unwrap();
        image::open(path).unwrap().into_rgba8()
    }

    #[test]
    fn colors_follow_the_decades() {
        let shades = shades();
        assert_eq!(color(&shades, 0.0), CLEAR);
        assert_eq!(color(&shades, 1e-12), color(&shades, 1e-8));
        assert_eq!(color(&shades, 1e-8), shades[0]);
        assert_eq!(color(&shades, 10f32.powf(-4.5)), shades[256]);
        for bad in [0.1, 0.7, f32::INFINITY, f32::NAN] {
            assert_eq!(color(&shades, bad), shades[SHADES - 1]);
        }
        let light = |c: Rgba| c[..3].iter().map(|v| u32::from(*v)).sum::<u32>();
        let decades: Vec<_> = (-8..=-1).map(|d| light(color(&shades, 10f32.powi(d)))).collect();
        assert!(decades.is_sorted_by(|a, b| a < b), "{decades:?}");
    }

    #[test]
    fn the_map_has_the_pictures_pixels_and_a_bar_below() {
        for width in [160, 319, 320, 900] {
            let frame = wide_frame(width);
            let map = read(&frame);
            assert_eq!(map.dimensions(), (width, 2 + ROWS.iter().sum::<usize>() as u32));
            let shades = shades();
            for x in 0..width {
                assert_eq!(map.get_pixel(x, 0).0, CLEAR);
                assert_eq!(map.get_pixel(x, 1).0, color(&shades, frame.error[(width + x) as usize]));
            }
            let row = |y| (0..width).filter(|x| map.get_pixel(*x, y).0 == INK).count();
            let ticks = 2 + (ROWS[0] + ROWS[1]) as u32;
            assert_eq!(row(ticks), 8);
            // The label's middle has the bars of the e and the minus: more dots than that.
            assert!(row(ticks + 6 + 2) > 8 * 6);
            assert_eq!((row(2), row(map.height() - 1)), (0, 0));
        }
    }

    #[test]
    fn sampling_errors_lie_below_the_errors() {
        let mut frame = wide_frame(20);
        let sampling_error: Vec<f32> = frame.error.iter().rev().copied().collect();
        frame.sampling_error = sampling_error.clone();
        let (map, shades) = (read(&frame), shades());
        assert_eq!(map.dimensions(), (20, 4));
        for (at, error) in (0..).zip(frame.error.iter().chain(&sampling_error)) {
            assert_eq!(map.get_pixel(at % 20, at / 20).0, color(&shades, *error));
        }
        let says =
            |frame: &Frame| texts(frame).iter().any(|(key, text)| key == "shows below" && text.contains("sampling"));
        assert!(says(&frame) && !says(&wide_frame(20)));
    }

    #[test]
    fn a_narrow_map_has_no_bar_and_every_map_says_its_scale() {
        assert_eq!(read(&wide_frame(159)).dimensions(), (159, 2));
        let said = texts(&frame());
        let text = |key: &str| said.iter().find(|(k, _)| k == key).unwrap().1.clone();
        assert_eq!(text("scale range"), "1e-8 to 1e-1");
        assert!(text("scale").contains("logarithm"));
        assert_eq!(text("quality"), "tolerance 2e-3, light off, every pixel traced");
    }
}
