//! A picture for viewers: a PNG with the facts of its frame.

use crate::hub::DrawRequest;
use hyper::body::Bytes;
use icoray::output::{png_bytes, png_layers};
use icoray::{Certainty, Frame, Pattern, srgb8};
use serde::Serialize;
use serde_json::{Value, json};
use std::sync::{Arc, OnceLock};

/// Largest side of a page's labels, pixels.
const LARGEST: f64 = 4096.0;

/// An encoded picture: the length of the facts in four bytes, the facts as JSON, the PNG. A page that shows it in
/// another size gets the PNG without labels, followed by a PNG of the labels in that size, whose length is `labels` of
/// the facts.
#[derive(Debug)]
pub(crate) struct Picture {
    pub number: u64,
    /// The range of the first volume's colour map, if it follows the data.
    pub color_range: Option<[f64; 2]>,
    /// The frame, or the error of drawing it.
    pub drawn: Result<Arc<Frame>, String>,
    revision: u64,
    is_final: bool,
    facts: Value,
    /// Encoded at the first request, because a model draws many pictures without a viewer.
    bytes: OnceLock<Bytes>,
}

/// The lines that the page draws over a picture, and the data for that: the picture's camera (eye, vectors forwards, to
/// the right and upwards, half the height at distance 1) and the radius of the ground.
fn overlay(frame: &Frame, request: &DrawRequest) -> Option<Value> {
    let legend = frame.legend.as_ref().filter(|_| !request.lines.is_empty())?;
    let camera = &request.scene.camera;
    let (axes, half_height) = camera.frame();
    let lines = request.lines.iter().map(|lines| {
        let spacing = if let Pattern::Graticule { spacing_deg } = lines.pattern { Some(spacing_deg) } else { None };
        json!({ "spacing": spacing, "color": srgb8(lines.color), "width": lines.width_px, "opacity": lines.opacity })
    });
    let (eye, radius, lines) = (camera.eye(), legend.ground_radius(), lines.collect::<Vec<_>>());
    Some(json!({ "eye": eye, "axes": axes, "half_height": half_height, "radius": radius, "lines": lines }))
}

/// The facts of a frame: its view and its quality.
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
    time_label: String,
    /// Number of a running model's step.
    step: i64,
    seconds: f64,
    error: f64,
    tolerance: f64,
    is_bound: bool,
    quality: String,
    left_out: &'f [String],
    value_range: Option<[f64; 2]>,
    overlay: Option<Value>,
    /// Why there is no picture.
    failure: Option<String>,
    /// Why the changes of a viewer are not drawn.
    refused: Option<String>,
}

impl Picture {
    /// The picture of a request.
    pub fn new(number: u64, frame: Frame, request: &DrawRequest, seconds: f64) -> Self {
        let facts = Facts {
            revision: request.revision,
            is_moving: request.is_moving,
            pending: !request.is_final && !request.is_moving,
            time: request.time,
            time_label: frame.stamp.date.clone().unwrap_or_default(),
            overlay: overlay(&frame, request),
            seconds,
            ..Facts::default()
        };
        Picture { is_final: request.is_final, ..Self::with(number, Arc::new(frame), facts) }
    }

    /// The picture of a program that draws at its own times, with the revision of its scene, and the reason why a later
    /// one is not drawn.
    pub fn of_step(number: u64, frame: Arc<Frame>, revision: u64, refused: Option<String>) -> Self {
        let stamp = frame.stamp.clone();
        let when = stamp.date.unwrap_or_else(|| format!("{} s", stamp.time_s));
        let time_label = format!("step {}, {when}", stamp.step);
        let seconds = frame.report.timing.prepare_s + frame.report.timing.render_s;
        Self::with(
            number,
            frame,
            Facts { revision, step: stamp.step, time_label, seconds, refused, ..Facts::default() },
        )
    }

    fn with(number: u64, frame: Arc<Frame>, facts: Facts) -> Self {
        let report = &frame.report;
        let facts = Facts {
            number,
            width: frame.width,
            height: frame.height,
            error: report.error.max,
            tolerance: report.quality.tolerance,
            is_bound: report.error.certainty == Certainty::Bound,
            quality: report.quality.to_string(),
            left_out: &report.left_out,
            value_range: report.value_range,
            ..facts
        };
        // The ranges of maps are in the scene's order, volumes first.
        let color_range = report.colors.first().map(|colors| colors.range);
        let (revision, bytes) = (facts.revision, OnceLock::new());
        let facts = serde_json::to_value(&facts).expect("all keys of facts are text");
        Picture { number, color_range, drawn: Ok(frame), revision, is_final: true, facts, bytes }
    }

    /// The message that a scene cannot be drawn.
    pub fn failed(number: u64, request: &DrawRequest, error: &icoray::Error) -> Self {
        let DrawRequest { revision, time, is_moving, .. } = *request;
        let (why, bytes) = (error.to_string(), OnceLock::new());
        let facts = Facts { number, revision, time, is_moving, failure: Some(why.clone()), ..Facts::default() };
        let facts = serde_json::to_value(&facts).expect("all keys of facts are text");
        Picture { number, color_range: None, drawn: Err(why), revision, is_final: true, facts, bytes }
    }

    /// Whether it is the picture at rest of the scene of this revision or a later one, or the error of it.
    pub fn is_at_rest(&self, revision: u64) -> bool {
        self.is_final && self.revision >= revision
    }

    /// The bytes for a page with this room for a picture, width and height in pixels, if it states them.
    pub fn bytes(&self, room: Option<[f64; 2]>) -> Bytes {
        let frame = self.drawn.as_ref().ok();
        if let (Some(frame), Some(room)) = (frame, room) {
            let size = fitted([frame.width, frame.height], room);
            let is_other = size != [frame.width, frame.height];
            if let Some([picture, labels]) = is_other.then(|| png_layers(frame, size).ok().flatten()).flatten() {
                let mut facts = self.facts.clone();
                facts["labels"] = labels.len().into();
                return sent(&facts, &[&picture, &labels]);
            }
        }
        let png = || frame.and_then(|frame| png_bytes(frame).ok()).unwrap_or_default();
        self.bytes.get_or_init(|| sent(&self.facts, &[&png()])).clone()
    }
}

/// The size of a picture enlarged to the room for it; the room's own size if sides of whole pixels have that aspect.
fn fitted([width, height]: [u32; 2], room: [f64; 2]) -> [u32; 2] {
    let aspect = f64::from(width) / f64::from(height);
    let room = room.map(|side| side.min(LARGEST));
    let fitted = room[0].min(room[1] * aspect);
    let is_same = (room[0] / room[1] / aspect - 1.0).abs() * f64::from(width.min(height)) <= 1.0;
    let size = if is_same { room } else { [fitted, fitted / aspect] };
    size.map(|side| side.round().max(1.0) as u32)
}

fn sent(facts: &Value, parts: &[&[u8]]) -> Bytes {
    let facts = facts.to_string();
    let length = (facts.len() as u32).to_le_bytes();
    [&length[..], facts.as_bytes(), &parts.concat()].concat().into()
}

#[cfg(test)]
mod tests {
    use super::fitted;

    #[test]
    fn labels_have_the_size_of_the_picture_on_the_page() {
        assert_eq!(fitted([640, 480], [1280.0, 1000.0]), [1280, 960]);
        assert_eq!(fitted([480, 640], [1280.0, 1000.0]), [750, 1000]);
        assert_eq!(fitted([661, 465], [908.0, 638.0]), [908, 638], "a draft whose sides are rounded");
        for room in [[f64::NAN, 1.0], [-5.0, 9.0], [f64::INFINITY, f64::INFINITY], [1e300, 1e300], [0.0, 0.0]] {
            for size in [[1, 16384], [16384, 1], [640, 480]] {
                assert!(fitted(size, room).iter().all(|side| (1..=4096).contains(side)), "{size:?} {room:?}");
            }
        }
    }
}
