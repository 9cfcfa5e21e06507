//! The page of a running model, which rank 0 serves where the scene has `[live]`.
//!
//! Viewers see each picture once it is written. What they set is taken by rank 0 in icoray_execute, sent to all ranks with
//! the agreement of that call, and is the scene from then on; what they ask of the data is answered there too. Nothing
//! waits for a viewer, and what fails for one is a sentence on the page.

use super::viewer_message::ViewerMessage;
use super::{Context, SceneChoice};
use crate::boundary::{Failure, Outcome, caught};
use icoray_core::output::Stamp;
use icoray_core::{ColumnCount, Plan, Script};
use icoray_live::Histogram;
use std::sync::Arc;

mod page;

use page::Page;

/// The page, on rank 0.
#[derive(Default)]
pub(super) struct Viewers {
    page: Option<Page>,
    /// Whether a page could not be opened: that is tried and logged once.
    has_failed: bool,
}

impl Context {
    /// Opens or closes the page as the scene asks, and takes what viewers have sent. Of rank 0; a failure is logged.
    pub(super) fn hear_viewers(&mut self) -> ViewerMessage {
        let live = match &self.scene {
            SceneChoice::Script(script) if self.ranks.is_root() => script.live(),
            _ => return ViewerMessage::default(),
        };
        let Some(live) = live else {
            self.viewers.page = None;
            return ViewerMessage::default();
        };
        if self.viewers.page.is_none() && !self.viewers.has_failed {
            match caught(|| Page::open(live, &self.scene_text, &self.inputs, &self.drawing)) {
                Ok(page) => self.viewers.page = Some(page),
                Err(failure) => {
                    self.viewers.has_failed = true;
                    self.drawing.warn(&format!("no live view: {}", failure.message));
                }
            }
        }
        self.viewers.page.as_mut().map(|page| page.take(&self.inputs)).unwrap_or_default()
    }

    /// Does on all ranks what viewers have sent, and returns the script. Collective.
    pub(super) fn follow_viewers(&mut self, sent: &ViewerMessage, stamp: &Stamp) -> Outcome<Option<Arc<Script>>> {
        if let Some(text) = &sent.scene {
            let mine = caught(|| self.drawable(text, stamp));
            let agreed = if self.is_shared() { self.agree(mine, "icoray_execute", Vec::new(), &[]).0 } else { mine };
            let outcome = agreed.map(|script| {
                self.scene = SceneChoice::Script(script);
                self.scene_text.clone_from(text);
            });
            if let Some(page) = &mut self.viewers.page {
                page.taken(outcome, stamp, &mut self.drawing);
            }
        }
        for name in &sent.histograms {
            self.answer_histogram(name);
        }
        self.script()
    }

    /// Answers what viewers ask of rank 0's own data.
    pub(super) fn answer_viewers(&mut self, script: Option<&Script>, stamp: &Stamp) {
        if let (Some(page), Some(script)) = (&mut self.viewers.page, script) {
            page.answer_probes(script, stamp, &self.inputs, &self.drawing);
        }
    }

    /// The script that a viewer has set, if its pictures of this step can be drawn from what the model has given.
    fn drawable(&self, text: &str, stamp: &Stamp) -> Outcome<Arc<Script>> {
        let mut script = Script::parse(text)?;
        script.name_by_date()?;
        let script = Arc::new(script);
        for shot in self.named(&script).views().iter().flat_map(|view| view.shots(stamp)) {
            let given = self.inputs.frame_inputs(shot)?;
            given.check_whole()?;
            let (_, field) = given.fields.iter().next().ok_or_else(|| Failure::null("the scene's field"))?;
            // Some columns over the whole grid have no plan of their own.
            if field.shape().columns == ColumnCount::new(&given.grid, field.location()).columns {
                Plan::new(&given.scene, &given.grid, &given.layers, field)?;
            }
        }
        Ok(script)
    }

    /// Counts the values of a field. Collective.
    fn answer_histogram(&mut self, name: &str) {
        let mine = caught(|| self.inputs.condition_field(name));
        let agreed = if self.is_shared() { self.agree(mine, "icoray_execute", Vec::new(), &[]).0 } else { mine };
        let found = match agreed {
            Ok(known) => {
                let (renderer, held) = (self.drawing.renderer(), known.held.as_deref());
                let found = renderer.histogram(&mut self.ranks, &known.field, held, Histogram::FINE_BINS);
                found.map_err(Failure::from)
            }
            Err(failure) => Err(failure),
        };
        if let Some(page) = &mut self.viewers.page {
            page.answer_histogram(name, found, &self.inputs);
        }
    }

    /// Shows viewers a scene that the model has set.
    pub(super) fn show_new_scene(&mut self) {
        self.viewers.has_failed = false;
        if let (Some(page), SceneChoice::Script(script)) = (&mut self.viewers.page, &self.scene)
            && script.live().is_some()
        {
            page.load(&self.scene_text);
        }
    }
}
