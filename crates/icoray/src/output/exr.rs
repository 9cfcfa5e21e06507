//! OpenEXR: linear premultiplied RGBA, the exact floats.

use super::io_error;
use crate::error::Result;
use crate::frame::Frame;
use image::codecs::openexr::OpenExrEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

pub(super) fn write(path: &Path, frame: &Frame) -> Result<()> {
    let file = File::create(path).map_err(|e| io_error(path, "cannot create the picture", e))?;
    let mut out = BufWriter::new(file);
    let floats: &[f32] = bytemuck::cast_slice(&frame.pixels);
    OpenExrEncoder::new(&mut out)
        .write_image(bytemuck::cast_slice(floats), frame.width, frame.height, ExtendedColorType::Rgba32F)
        .map_err(|e| io_error(path, "cannot write the picture", e))?;
    out.flush().map_err(|e| io_error(path, "cannot write the picture", e))
}
