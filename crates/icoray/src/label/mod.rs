//! Labels in the written picture: colour bar, title, and how the picture is to be read.
//!
//! They are put over the bytes of a PNG on their way to the disk; pixels of frames, and so EXR files, have none. All sizes
//! scale with the picture.

mod bar;
mod block;
mod canvas;
mod font;
mod layout;
mod ticks;
mod units;
mod words;

pub(crate) use canvas::Canvas;

use crate::error::Result;
use crate::frame::Frame;
use crate::output::Template;
use crate::scene::Scene;

/// Where the colour bar goes. Title and notes go to corners that it leaves free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// To the right, to the bottom or to the left, in the picture's middle or in a corner: where it hides least of the
    /// planet. It depends on the camera alone, so that it stays from frame to frame.
    #[default]
    Auto,
    /// Inside, upright, at the right.
    Right,
    /// Inside, lying, at the bottom.
    Bottom,
    /// Inside, upright, at the left.
    Left,
    /// In rows that the picture gets below its own, where nothing is hidden: the file is higher than the scene's image.
    Below,
}

/// What is written into a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    pub(crate) title: Template,
    /// What the field is called, instead of its description's long name.
    pub name: Option<String>,
    /// Units of the field, instead of its description's.
    pub units: Option<String>,
    /// Where the colour bar goes.
    pub place: Place,
    /// Factor on all sizes.
    pub size: f64,
    /// Linear RGB of the text; `None` is dark on a bright background and bright on a dark one.
    pub color: Option<[f64; 3]>,
    /// Whether there is a colour bar.
    pub bar: bool,
    /// Whether the exaggeration is told, where there is one.
    pub scale_note: bool,
    /// Whether it is told how far pixels may be off.
    pub error_note: bool,
}

impl Labels {
    /// Words that titles may have in braces, beside the step.
    const WORDS: [&str; 5] = ["field", "name", "units", "time", "exaggeration"];

    /// A title's template.
    pub(crate) fn title(text: &str) -> Result<Template> {
        Template::new(text, &Self::WORDS)
    }
}

/// What the labels of a frame are about; a renderer makes it for scenes that ask for labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// What the labels are.
    pub(crate) labels: Labels,
    /// The scene as it was drawn, its colours' range known.
    pub(crate) scene: Scene,
    /// The outermost layer's radius, exaggerated.
    pub(crate) outer: f64,
}

impl Legend {
    /// The legend of a scene that asks for one.
    pub(crate) fn of(scene: &Scene, radius: &[f64]) -> Option<Box<Self>> {
        let labels = scene.labels.clone()?;
        let outer = radius.last().copied().unwrap_or(1.0);
        Some(Box::new(Legend { labels, scene: scene.clone(), outer }))
    }
}

/// Puts the labels of a frame over its picture.
pub(crate) fn draw(canvas: &mut Canvas, frame: &Frame, legend: &Legend) {
    layout::draw(canvas, frame, legend);
}

#[cfg(test)]
mod tests;
