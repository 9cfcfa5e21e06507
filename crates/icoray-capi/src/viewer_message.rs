//! The message of rank 0 to the others about viewers of the live page.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Changes and questions of viewers, sent to all ranks.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct ViewerMessage {
    /// The text of another scene.
    pub scene: Option<String>,
    /// Whether fields of that scene are not up to date: it is drawn by a later call, before which they are wanted.
    pub is_announced: bool,
    /// Milliseconds that a picture of each view may take where the scene is viewers', by the names of views. Empty if it
    /// is the model's own.
    pub budgets_ms: BTreeMap<String, f64>,
    /// Name of a field whose histogram is asked for.
    pub histogram: Option<String>,
    pub look: Option<LookRequest>,
    pub probe: Option<ProbeRequest>,
}

/// Another field to show in a view of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct LookRequest {
    /// The text of the scene.
    pub text: String,
    pub view: String,
    pub field: String,
}

/// A place of a view's picture whose ray is probed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ProbeRequest {
    pub at: [f64; 2],
    pub view: String,
}

impl ViewerMessage {
    /// Whether there is something to do.
    pub fn is_any(&self) -> bool {
        *self != ViewerMessage::default()
    }

    /// The text of a scene whose fields are wanted before it is drawn, or before a look is suggested for them.
    #[cfg(feature = "live")]
    pub fn announced(&self) -> Option<String> {
        let look = self.look.as_ref().filter(|_| self.scene.is_none());
        self.scene.clone().or_else(|| look.map(|look| format!("field = {:?}\n", look.field)))
    }
}
