//! PNG: 8-bit sRGB with straight alpha, with the picture's description in text chunks.

use super::atomic;
use crate::atomic::Existing;
use crate::frame::Frame;
use crate::label;
use crate::label::Canvas;
use crate::path::io_error;
use crate::srgb::srgb_byte;
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
    let Canvas { width, height, rgba } = labelled(frame);
    write_rgba(path, [width, height], &rgba, &frame.describe(), existing)
}

/// The content of the file that [`write`] writes.
pub(super) fn bytes(frame: &Frame) -> Result<Vec<u8>> {
    encoded(&labelled(frame), &frame.describe())
}

/// The picture without labels, and only the labels in another size; `None` if they do not lie over the picture.
pub(super) fn layers(frame: &Frame, [width, height]: [u32; 2]) -> Result<Option<[Vec<u8>; 2]>> {
    let Some(legend) = frame.legend.as_ref().filter(|legend| legend.labels.place != LabelPlace::Below) else {
        return Ok(None);
    };
    let picture = Canvas { width: frame.width, height: frame.height, rgba: rgba8(frame) };
    let mut labels = Canvas { width, height, rgba: vec![0; 4 * width as usize * height as usize] };
    label::draw(&mut labels, frame, legend);
    Ok(Some([encoded(&picture, &frame.describe())?, encoded(&labels, &[])?]))
}

fn encoded(canvas: &Canvas, texts: &[(String, String)]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let done = encode_rgba(&mut bytes, [canvas.width, canvas.height], &canvas.rgba, texts);
    done.map_err(|e| Error::new(ErrorKind::Io, format!("cannot encode the picture: {e}")))?;
    Ok(bytes)
}

/// The pixels, without labels.
pub(super) fn rgba8(frame: &Frame) -> Vec<u8> {
    frame.pixels.iter().flat_map(|p| encode(*p)).collect()
}

/// The picture with its labels.
fn labelled(frame: &Frame) -> Canvas {
    let mut canvas = Canvas { width: frame.width, height: frame.height, rgba: rgba8(frame) };
    if let Some(legend) = &frame.legend {
        label::draw(&mut canvas, frame, legend);
    }
    canvas
}

/// Writes 8-bit sRGB with straight alpha, and text chunks.
pub(super) fn write_rgba(
    path: &Path,
    size: [u32; 2],
    rgba: &[u8],
    texts: &[(String, String)],
    existing: Existing,
) -> Result<()> {
    let failed = |e: png::EncodingError| io_error(path, "cannot write the picture", e);
    atomic::write(path, existing, "the picture", |out| encode_rgba(out, size, rgba, texts).map_err(failed))
}

fn encode_rgba(
    out: impl Write,
    size: [u32; 2],
    rgba: &[u8],
    texts: &[(String, String)],
) -> std::result::Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Fast);
    for (key, text) in texts {
        encoder.add_itxt_chunk(key.clone(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgba)?;
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
