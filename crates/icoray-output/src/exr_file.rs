//! OpenEXR: linear premultiplied RGBA and the errors, as exact floats.

use super::atomic;
use crate::atomic::Existing;
use crate::folder::io_error;
use crate::frame::Frame;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Text, WritableImage,
};
use icoray_grid::{Error, ErrorKind, Result};
use std::io::{Cursor, Seek, Write};
use std::path::Path;

/// The picture's description, a line `key: text` each. In one attribute, since the crate writes several in random
/// order, and equal frames must give equal files.
fn comments(frame: &Frame) -> Text {
    let lines: Vec<_> = frame.describe().iter().map(|(key, text)| format!("{key}: {text}")).collect();
    Text::from_slice_unchecked(lines.join("\n").as_bytes())
}

pub(super) fn write(path: &Path, frame: &Frame, existing: Existing) -> Result<()> {
    atomic::write(path, existing, "the picture", |out| {
        encode(frame, out).map_err(|e| io_error(path, "cannot write the picture", e))
    })
}

/// The content of the EXR that [`write_picture`](crate::write_picture) writes.
///
/// # Errors
/// [`ErrorKind::Io`] if it cannot be encoded.
pub fn exr_bytes(frame: &Frame) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let failed = |e| Error::new(ErrorKind::Io, format!("cannot encode the picture: {e}"));
    encode(frame, &mut bytes).map_err(failed)?;
    Ok(bytes.into_inner())
}

fn encode(frame: &Frame, out: impl Write + Seek) -> exr::error::UnitResult {
    let colors = ["R", "G", "B", "A"].into_iter().enumerate();
    let colors = colors.map(|(k, name)| (name, frame.pixels.iter().map(|pixel| pixel[k]).collect()));
    let errors = [("error", &frame.error), ("sampling_error", &frame.sampling_error)];
    let errors = errors.into_iter().filter(|(_, error)| !error.is_empty()).map(|(name, error)| (name, error.clone()));
    let channel = |(name, values): (&str, Vec<f32>)| AnyChannel::new(name, FlatSamples::F32(values));
    let channels = AnyChannels::sort(colors.chain(errors).map(channel).collect());
    let attributes = LayerAttributes { comments: Some(comments(frame)), ..LayerAttributes::default() };
    let size = (frame.width as usize, frame.height as usize);
    let image = Image::from_layer(Layer::new(size, attributes, Encoding::default(), channels));
    // On this thread only, for any features that another user of the crate enables.
    image.write().non_parallel().to_buffered(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::frame;
    use exr::prelude::{ReadChannels, ReadLayers, Vec2, read};

    /// A frame with numbers that lossy ways would change, written; the folder goes when it is dropped.
    fn written(sampling_error: Vec<f32>) -> (tempfile::TempDir, std::path::PathBuf, Frame) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        let mut frame = frame();
        frame.pixels[1] = [1e-30, 70000.3, -0.0, f32::MIN_POSITIVE / 2.0];
        frame.field = "Größe".into();
        frame.sampling_error = sampling_error;
        write(&path, &frame, Existing::NeverModify).unwrap();
        (folder, path, frame)
    }

    #[test]
    fn pixels_and_errors_come_back_bit_by_bit() {
        for sampling_error in [vec![], vec![0.25, 1e-30, 0.0, 0.5, 1.0, 2e-3]] {
            let (_folder, path, frame) = written(sampling_error);
            let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
            let layer = image.all_attributes().from_file(&path).unwrap().layer_data;
            assert_eq!(layer.size, Vec2(3, 2));
            let color = |k: usize| frame.pixels.iter().map(|pixel| pixel[k]).collect();
            let channels: [(&str, Vec<f32>); 6] = [
                ("A", color(3)),
                ("B", color(2)),
                ("G", color(1)),
                ("R", color(0)),
                ("error", frame.error.clone()),
                ("sampling_error", frame.sampling_error.clone()),
            ];
            let expected: Vec<_> = channels.into_iter().filter(|(_, values)| !values.is_empty()).collect();
            assert_eq!(layer.channel_data.list.len(), expected.len());
            for (channel, (name, values)) in layer.channel_data.list.iter().zip(expected) {
                let FlatSamples::F32(samples) = &channel.sample_data else { panic!("{} is not f32", channel.name) };
                let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(channel.name.to_string(), name);
                assert_eq!(bits(samples), bits(&values), "{name}");
            }
            let comments = layer.attributes.comments.unwrap();
            let comments = std::str::from_utf8(comments.as_slice()).unwrap();
            for line in ["step: 7", "field: Größe", "tolerance: 0.002", "camera: far away"] {
                assert!(comments.lines().any(|l| l == line), "{line} is not in {comments}");
            }
        }
    }

    #[test]
    fn readers_of_rgba_see_the_picture() {
        let (_folder, path, frame) = written(vec![]);
        let picture = image::open(&path).unwrap();
        assert_eq!(picture.color(), image::ColorType::Rgba32F);
        let pixels: Vec<_> = picture.to_rgba32f().pixels().map(|p| p.0).collect();
        assert_eq!(pixels, frame.pixels);
    }

    #[test]
    fn equal_frames_are_equal_files() {
        let (_a, one, _) = written(vec![]);
        let (_b, other, _) = written(vec![]);
        assert_eq!(std::fs::read(one).unwrap(), std::fs::read(other).unwrap());
    }
}
