//! PNG: 8-bit sRGB with straight alpha, with the picture's description in text chunks.

use super::atomic;
use crate::atomic::Existing;
use crate::folder::io_error;
use crate::frame::Frame;
use crate::label::{self, Canvas, srgb_byte};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::LabelPlace;
use std::io::Write;
use std::path::Path;

/// Converts a premultiplied linear pixel to straight sRGB.
fn encode(pixel: [f32; 4]) -> [u8; 4] {
    let [r, g, b, a] = pixel;
    if a <= 0.0 {
        return [0; 4];
    }
    [srgb_byte(r / a), srgb_byte(g / a), srgb_byte(b / a), (a.min(1.0) * 255.0 + 0.5) as u8]
}

pub(super) fn write(path: &Path, frame: &Frame, existing: Existing) -> Result<()> {
    write_canvas(path, &labelled(frame), &frame.describe(), existing)
}

/// The content of the PNG that [`write_picture`](crate::write_picture) writes.
///
/// # Errors
/// [`ErrorKind::Io`] if it cannot be encoded.
pub fn png_bytes(frame: &Frame) -> Result<Vec<u8>> {
    encoded(&labelled(frame), &frame.describe())
}

/// A PNG of the pixels of `frame` without labels, and one of only its labels on transparent ground, of another size in
/// pixels. `None` if labels are below the picture or there are none.
///
/// # Errors
/// [`ErrorKind::Io`] if they cannot be encoded.
pub fn png_layers(frame: &Frame, [width, height]: [u32; 2]) -> Result<Option<[Vec<u8>; 2]>> {
    let Some(legend) = frame.legend.as_ref().filter(|legend| legend.labels.place != LabelPlace::Below) else {
        return Ok(None);
    };
    let mut labels = Canvas { width, height, rgba: vec![0; 4 * width as usize * height as usize] };
    label::draw(&mut labels, frame, legend);
    Ok(Some([encoded(&unlabelled(frame), &frame.describe())?, encoded(&labels, &[])?]))
}

fn encoded(canvas: &Canvas, texts: &[(String, String)]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let done = encode_canvas(&mut bytes, canvas, texts);
    done.map_err(|e| Error::new(ErrorKind::Io, format!("cannot encode the picture: {e}")))?;
    Ok(bytes)
}

/// The pixels of `frame` as 8-bit sRGB with straight alpha, row by row from the top, without labels.
pub fn rgba8(frame: &Frame) -> Vec<u8> {
    frame.pixels.iter().flat_map(|p| encode(*p)).collect()
}

fn unlabelled(frame: &Frame) -> Canvas {
    Canvas { width: frame.width, height: frame.height, rgba: rgba8(frame) }
}

/// The picture with its labels.
fn labelled(frame: &Frame) -> Canvas {
    let mut canvas = unlabelled(frame);
    if let Some(legend) = &frame.legend {
        label::draw(&mut canvas, frame, legend);
    }
    canvas
}

/// Writes a picture and text chunks.
pub(super) fn write_canvas(path: &Path, canvas: &Canvas, texts: &[(String, String)], existing: Existing) -> Result<()> {
    let failed = |e: png::EncodingError| io_error(path, "cannot write the picture", e);
    atomic::write(path, existing, "the picture", |out| encode_canvas(out, canvas, texts).map_err(failed))
}

fn encode_canvas(
    out: impl Write,
    canvas: &Canvas,
    texts: &[(String, String)],
) -> std::result::Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, canvas.width, canvas.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Fast);
    for (key, text) in texts {
        encoder.add_itxt_chunk(key.clone(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&canvas.rgba)?;
    writer.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_is_srgb_with_straight_alpha() {
        assert_eq!(encode([0.0, 0.5, 1.0, 1.0]), [0, 188, 255, 255]);
        assert_eq!(encode([0.1, 0.25, 0.5, 0.5]), [124, 188, 255, 128]);
        assert_eq!(encode([0.0, 0.0, 0.0, 0.0]), [0; 4]);
        assert_eq!(encode([2.0, -1.0, f32::NAN, 1.0])[..2], [255, 0]);
    }
}
