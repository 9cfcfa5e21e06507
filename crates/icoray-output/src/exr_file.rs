//! OpenEXR: linear premultiplied RGBA and the error, the exact floats.

use super::atomic;
use crate::atomic::Existing;
use crate::frame::Frame;
use crate::path::io_error;
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, Vec2, WritableImage};
use icoray_grid::Result;
use std::path::Path;

/// What the picture says of itself, a line `key: text` each. In one attribute, since the crate writes several in an
/// order of chance, and equal frames are to be equal files.
fn comments(frame: &Frame) -> Text {
    let lines: Vec<_> = frame.describe().iter().map(|(key, text)| format!("{key}: {text}")).collect();
    Text::from_slice_unchecked(lines.join("\n").as_bytes())
}

pub(super) fn write(path: &Path, frame: &Frame, existing: Existing) -> Result<()> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let channels = SpecificChannels::build()
        .with_channel("R")
        .with_channel("G")
        .with_channel("B")
        .with_channel("A")
        .with_channel("error")
        .with_pixel_fn(|at: Vec2<usize>| {
            let pixel = at.y() * width + at.x();
            let [r, g, b, a] = frame.pixels[pixel];
            (r, g, b, a, frame.error[pixel])
        });
    let attributes = LayerAttributes { comments: Some(comments(frame)), ..LayerAttributes::default() };
    let image = Image::from_layer(Layer::new((width, height), attributes, Encoding::default(), channels));
    atomic::write(path, existing, "the picture", |out| {
        // On this thread alone, whatever features another user of the crate asks for.
        let written = image.write().non_parallel().to_buffered(out);
        written.map_err(|e| io_error(path, "cannot write the picture", e))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::frame;
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};

    /// A frame with numbers that lossy ways would change, written; the folder goes when it is dropped.
    fn written() -> (tempfile::TempDir, std::path::PathBuf, Frame) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        let mut frame = frame();
        frame.pixels[1] = [1e-30, 70000.3, -0.0, f32::MIN_POSITIVE / 2.0];
        frame.field = "Größe".into();
        write(&path, &frame, Existing::NeverModify).unwrap();
        (folder, path, frame)
    }

    #[test]
    fn pixels_and_errors_come_back_bit_by_bit() {
        let (_folder, path, frame) = written();
        let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
        let layer = image.all_attributes().from_file(&path).unwrap().layer_data;
        assert_eq!(layer.size, Vec2(3, 2));
        let names: Vec<_> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["A", "B", "G", "R", "error"]);
        for (channel, place) in layer.channel_data.list.iter().zip([3, 2, 1, 0, 4]) {
            let FlatSamples::F32(samples) = &channel.sample_data else { panic!("{} is not f32", channel.name) };
            let of_frame = frame.pixels.iter().zip(&frame.error);
            let expected: Vec<f32> = of_frame.map(|(p, e)| if place == 4 { *e } else { p[place] }).collect();
            let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(samples), bits(&expected), "{}", channel.name);
        }
        let said = layer.attributes.comments.unwrap();
        let said = std::str::from_utf8(said.as_slice()).unwrap();
        for line in
            ["step: 7", "field: Größe", "quality: tolerance 2e-3, light off, every pixel traced", "camera: far away"]
        {
            assert!(said.lines().any(|l| l == line), "{line} is not in {said}");
        }
    }

    #[test]
    fn readers_of_rgba_see_the_picture() {
        let (_folder, path, frame) = written();
        let picture = image::open(&path).unwrap();
        assert_eq!(picture.color(), image::ColorType::Rgba32F);
        let pixels: Vec<_> = picture.to_rgba32f().pixels().map(|p| p.0).collect();
        assert_eq!(pixels, frame.pixels);
    }

    #[test]
    fn equal_frames_are_equal_files() {
        let (_a, one, _) = written();
        let (_b, other, _) = written();
        assert_eq!(std::fs::read(one).unwrap(), std::fs::read(other).unwrap());
    }
}
