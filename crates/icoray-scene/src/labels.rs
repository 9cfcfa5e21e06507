//! Labels that are written into pictures.

use crate::template::Template;
use icoray_grid::Result;

/// Where the colour bar goes. Title and notes go to corners that it leaves free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LabelPlace {
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

/// Labels that are written into a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// The title, with words in braces.
    pub title: Template,
    /// Name of the field, in place of its description's long name.
    pub name: Option<String>,
    /// Units of the field, instead of its description's.
    pub units: Option<String>,
    /// Where the colour bar goes.
    pub place: LabelPlace,
    /// Factor on all sizes.
    pub size: f64,
    /// Linear RGB of the text; `None` is dark on a bright background and bright on a dark one.
    pub color: Option<[f64; 3]>,
    /// Whether there is a colour bar.
    pub bar: bool,
    /// Whether a label states the exaggeration, if there is one.
    pub scale_note: bool,
    /// Whether a label states the error of pixels; `None` states it where it is above the tolerance in
    /// more than one in a thousand of the pixels that have one.
    pub error_note: Option<bool>,
}

impl Labels {
    /// Words that titles may have in braces, beside the step.
    const WORDS: [&str; 5] = ["field", "name", "units", "time", "exaggeration"];

    /// A title's template.
    pub(crate) fn title(text: &str) -> Result<Template> {
        Template::new(text, &Self::WORDS)
    }
}
