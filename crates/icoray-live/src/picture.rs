//! A picture on its way to viewers: a PNG with the facts of its frame.

use crate::hub::DrawRequest;
use hyper::body::Bytes;
use icoray::output::png_bytes;
use icoray::{Certainty, Frame};
use serde::Serialize;

/// A picture as it is sent: the length of the facts in four bytes, the facts as JSON, the PNG.
#[derive(Debug)]
pub(crate) struct Picture {
    pub number: u64,
    /// The range that the first volume's colour map has, where it follows the data.
    pub color_range: Option<[f64; 2]>,
    pub bytes: Bytes,
}

/// What is seen, and how well.
#[derive(Serialize, Default)]
struct Facts<'f> {
    number: u64,
    revision: u64,
    is_moving: bool,
    /// Whether a finer picture of the same is being drawn.
    pending: bool,
    width: u32,
    height: u32,
    time: usize,
    time_label: &'f str,
    seconds: f64,
    error: f64,
    tolerance: f64,
    is_bound: bool,
    quality: String,
    left_out: &'f [String],
    value_range: Option<[f64; 2]>,
    /// Why there is no picture.
    failure: Option<String>,
}

impl Picture {
    /// # Errors
    /// Those of the PNG's encoder.
    pub fn new(number: u64, frame: &Frame, request: &DrawRequest, seconds: f64) -> icoray::Result<Self> {
        let report = &frame.report;
        let facts = Facts {
            number,
            revision: request.revision,
            is_moving: request.is_moving,
            pending: !request.is_final && !request.is_moving,
            width: frame.width,
            height: frame.height,
            time: request.time,
            time_label: frame.stamp.date.as_deref().unwrap_or_default(),
            seconds,
            error: report.error.max,
            tolerance: request.scene.tolerance,
            is_bound: report.error.certainty == Certainty::Bound,
            quality: report.quality.to_string(),
            left_out: &report.left_out,
            value_range: report.value_range,
            failure: None,
        };
        // The ranges of maps are in the scene's order, volumes first.
        let color_range = report.colors.first().map(|colors| colors.range);
        Ok(Picture { number, color_range, bytes: envelope(&facts, &png_bytes(frame)?) })
    }

    /// The news that a scene cannot be drawn.
    pub fn failed(number: u64, request: &DrawRequest, error: &icoray::Error) -> Self {
        let DrawRequest { revision, time, is_moving, .. } = *request;
        let failure = Some(error.to_string());
        let facts = Facts { number, revision, time, is_moving, failure, ..Facts::default() };
        Picture { number, color_range: None, bytes: envelope(&facts, &[]) }
    }
}

fn envelope(facts: &Facts, png: &[u8]) -> Bytes {
    let facts = serde_json::to_vec(facts).expect("all keys of facts are text");
    let length = (facts.len() as u32).to_le_bytes();
    [&length[..], &facts, png].concat().into()
}
