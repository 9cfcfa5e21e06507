//! A picture of the error of each pixel: colours over decades, with a labelled bar.

use crate::atomic::Existing;
use crate::frame::Frame;
use crate::label::{self, Canvas};
use crate::png_file;
use colorgrad::{Gradient, preset};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::{Knot, Scale, TransferFunction};
use std::path::Path;

/// Powers of ten of the first and the last colour. Fixed, so that pictures can be compared.
const DECADES: [i32; 2] = [-8, -1];
/// Shades of the map.
const SHADES: usize = 512;
/// The narrowest picture that has room for the bar.
const MIN_WIDTH: u32 = 160;

type Rgba = [u8; 4];

const CLEAR: Rgba = [0; 4];
const INK: [u8; 3] = [255; 3];
const PAPER: [u8; 3] = [0; 3];

/// Writes the error of each pixel of `frame` to the PNG file at `path`.
///
/// The colours are viridis over the logarithm of the error, from dark at 1e-8 and less to bright at 1e-1 and more.
/// Pixels without an error, which are those whose ray meets nothing, are transparent. If pixels are means of several
/// rays, a map of their estimated sampling errors ([`Frame::sampling_error`]) in the same colours lies below. A bar
/// with a tick at each decade follows if the picture is at least 160 pixels wide; the text of the file states the same,
/// and the entries of [`Frame::describe`]. `existing` selects the treatment of an existing file.
///
/// # Errors
/// [`ErrorKind::Io`] names the path; [`ErrorKind::Argument`] an extension other than `.png`; [`ErrorKind::Exists`] as
/// specified by [`Existing`].
pub fn write_error_map(path: &Path, frame: &Frame, existing: Existing) -> Result<()> {
    if path.extension().and_then(|e| e.to_str()) != Some("png") {
        let context = format!("{}: expected a name that ends in .png for the map of errors", path.display());
        return Err(Error::new(ErrorKind::Argument, context));
    }
    let shades = shades();
    let errors = frame.error.iter().chain(&frame.sampling_error);
    let rgba: Vec<u8> = errors.flat_map(|error| color(&shades, *error)).collect();
    let height = (rgba.len() / 4) as u32 / frame.width;
    let mut canvas = Canvas { width: frame.width, height, rgba };
    if canvas.width >= MIN_WIDTH {
        label::draw_bar(&mut canvas, Scale::Log, &transfer(), "error of each pixel", [INK, PAPER]);
    }
    png_file::write_canvas(path, &canvas, &texts(frame), existing)
}

/// The text entries of the file.
fn texts(frame: &Frame) -> Vec<(String, String)> {
    let mut texts = frame.describe();
    let mut say = |key: &str, text: String| texts.push((key.into(), text));
    say("shows", "the error of each pixel, the largest of its channels, premultiplied linear 0 to 1".into());
    if !frame.sampling_error.is_empty() {
        say(
            "shows below",
            "the estimated sampling error of each pixel, how far its rays' mean may be off its area's, or a \
             pixel that was not traced off its ray"
                .into(),
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

fn color(shades: &[Rgba], error: f32) -> Rgba {
    // Not >, so that a NaN error gets the last colour.
    if error <= 0.0 {
        return CLEAR;
    }
    let [low, high] = DECADES.map(|d| d as f32);
    let part = if error.is_nan() { 1.0 } else { (error.log10() - low) / (high - low) };
    shades[(part.clamp(0.0, 1.0) * (SHADES - 1) as f32).round() as usize]
}

/// The colours as a function of the error, for the bar.
fn transfer() -> TransferFunction {
    let (map, [low, high]) = (preset::viridis(), DECADES.map(f64::from));
    let knot = |i: usize| {
        let part = i as f32 / (SHADES - 1) as f32;
        let [r, g, b, _] = map.at(part).to_linear_rgba().map(f64::from);
        let value = 10f64.powf(low + (high - low) * f64::from(part));
        Knot { value, color: [r, g, b], extinction: 1.0 }
    };
    TransferFunction { knots: (0..SHADES).map(knot).collect(), unit_length: None }
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
        write_error_map(&path, frame, Existing::Overwrite).unwrap();
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
            let shades = shades();
            for x in 0..width {
                assert_eq!(map.get_pixel(x, 0).0, CLEAR);
                assert_eq!(map.get_pixel(x, 1).0, color(&shades, frame.error[(width + x) as usize]));
            }
            let is_paper = |x, y| map.get_pixel(x, y).0[..3] == PAPER;
            assert!((0..width).all(|x| is_paper(x, 2) && is_paper(x, map.height() - 1)), "{width}");
            // The bar, between its outlines, has the colours of the map in their order.
            let inked = |y| (0..width).filter(|x| map.get_pixel(*x, y).0[..3] == INK).collect::<Vec<_>>();
            let top = (2..map.height()).find(|y| inked(*y).len() as u32 > width / 2).unwrap();
            let [left, right] = [0, inked(top).len() - 1].map(|i| inked(top)[i]);
            let length = right - left - 1;
            assert!(length >= width * 3 / 4, "{width}: {length}");
            for x in 0..length {
                let error = 10f32.powf(-8.0 + 7.0 * (x as f32 + 0.5) / length as f32);
                let (found, expected) = (map.get_pixel(left + 1 + x, top + 3).0, color(&shades, error));
                assert!((0..4).all(|k| found[k].abs_diff(expected[k]) <= 2), "{width} {x}: {found:?} {expected:?}");
            }
            // Ticks of decades, and labels and a caption below them.
            let bottom = (top + 4..map.height()).find(|y| inked(*y).len() as u32 > width / 2).unwrap();
            assert!(inked(bottom + 1).len() >= 8, "{width}");
            let lit = |y| (0..width).filter(|x| map.get_pixel(*x, y).0[0] > 128).count();
            assert!((bottom + 5..map.height()).map(lit).sum::<usize>() > 60, "{width}");
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
    fn a_narrow_map_has_no_bar_and_every_map_states_its_scale() {
        assert_eq!(read(&wide_frame(159)).dimensions(), (159, 2));
        let said = texts(&frame());
        let text = |key: &str| said.iter().find(|(k, _)| k == key).unwrap().1.clone();
        assert_eq!(text("scale range"), "1e-8 to 1e-1");
        assert!(text("scale").contains("logarithm"));
        assert_eq!(text("tolerance"), "0.002");
    }
}
