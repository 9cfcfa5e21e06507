//! Without the feature `live`: a scene with `[live]` is drawn without a page, and the log has a warning.

use super::{Context, SceneChoice};
use crate::boundary::Outcome;
use crate::viewer_message::ViewerMessage;
use icoray_core::output::Stamp;
use icoray_core::{Script, Shot};
use std::sync::Arc;

/// Whether it was logged that there is no page.
#[derive(Default)]
pub(super) struct Viewers(bool);

impl Viewers {
    /// Viewers set no scene.
    pub(super) fn next(&self) -> Option<&Script> {
        None
    }

    pub(super) fn answered(&mut self, _: &str, _: bool) {}

    pub(super) fn within_budget(&self, shot: Shot) -> Shot {
        shot
    }
}

impl Context {
    pub(super) fn hear_viewers_early(&mut self) {}

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

    pub(super) fn show_scene(&mut self) {}

    pub(super) fn show_new_scene(&mut self) {
        self.viewers.0 = false;
    }
}
