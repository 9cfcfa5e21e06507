//! Pictures of pixels alone.

use icoray::output::{Stamp, write_picture};
use icoray::{Frame, FrameReport, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// Writes pixels as PNG or EXR, by the name's ending.
pub(crate) fn write_pixels(path: &Path, [width, height]: [u32; 2], pixels: Vec<[f32; 4]>) -> Result<()> {
    let frame = Frame {
        width,
        height,
        error: vec![0.0; pixels.len()],
        sampling_error: Vec::new(),
        pixels,
        field: String::new(),
        descriptions: BTreeMap::new(),
        legend: None,
        notes: Vec::new(),
        stamp: Stamp::default(),
        report: FrameReport::default(),
    };
    write_picture(path, &frame)
}

/// The difference of two pictures, times `amplify`, on black.
pub(crate) fn amplified<T: Copy + Into<f64>>(pixels: &[[f32; 4]], truth: &[[T; 4]], amplify: f64) -> Vec<[f32; 4]> {
    let pixel = |(a, b): (&[f32; 4], &[T; 4])| {
        let [r, g, b] = [0, 1, 2].map(|k| (amplify * (f64::from(a[k]) - b[k].into()).abs()) as f32);
        [r, g, b, 1.0]
    };
    pixels.iter().zip(truth).map(pixel).collect()
}
