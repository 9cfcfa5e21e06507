//! Without the feature `live`: a scene with `[live]` is drawn without a page, and the log has a warning.

use super::viewer_message::ViewerMessage;
use super::{Context, SceneChoice};
use crate::boundary::Outcome;
use icoray_core::Script;
use icoray_core::output::Stamp;
use std::sync::Arc;

/// Whether it was logged that there is no page.
#[derive(Default)]
pub(super) struct Viewers(bool);

impl Context {
    pub(super) fn hear_viewers(&mut self) -> ViewerMessage {
        if let SceneChoice::Script(script) = &self.scene
            && script.live().is_some()
            && self.ranks.is_root()
            && !std::mem::replace(&mut self.viewers.0, true)
        {
            self.drawing.warn("no live view: this library was built without its feature `live`");
        }
        ViewerMessage::default()
    }

    /// Viewers send nothing: the scene stays.
    pub(super) fn follow_viewers(&mut self, _: &ViewerMessage, _: &Stamp) -> Outcome<Option<Arc<Script>>> {
        self.script()
    }

    /// Viewers ask nothing.
    pub(super) fn answer_viewers(&mut self, _: Option<&Script>, _: &Stamp) {}

    pub(super) fn show_new_scene(&mut self) {
        self.viewers.0 = false;
    }
}
