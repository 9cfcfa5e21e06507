//! The page of a running model, which rank 0 serves where the scene has `[live]`.
//!
//! Viewers see each picture once it is written. In icoray_execute rank 0 takes their changes and sends them to all
//! ranks with the agreement of that call; from then on they are part of the scene. Questions about the data are
//! answered there too. No call waits for a viewer, and failures of viewers' requests are messages on the page.
//!
//! A scene that reads a field that icoray_wants_field did not want is announced to the ranks first: its fields are
//! wanted from then on, and the next icoray_execute draws it. A single process takes the viewers' changes in
//! icoray_wants_field, and draws them in the same step.

use super::inputs::{Inputs, check_whole};
use super::{Context, SceneChoice};
use crate::boundary::{Failure, Outcome, caught};
use crate::ranks::agree;
use crate::types::icoray_status;
use crate::viewer_message::{LookRequest, ProbeRequest, ViewerMessage};
use icoray_core::output::Stamp;
use icoray_core::suggest::Completion;
use icoray_core::{ColumnCount, FrameSetup, Plan, Ranks, Renderer, Script, Shot};
use icoray_live::Histogram;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

mod page;
mod time_budget;

use page::Page;

/// A picture of viewers' scene may take so many times the memory of the model's own.
const MEMORY_SHARE: u64 = 4;

/// Changes of the scene by viewers, and on rank 0 the page.
#[derive(Default)]
pub(super) struct Viewers {
    page: Option<Page>,
    /// Whether a page could not be opened: that is tried and logged once.
    has_failed: bool,
    /// The scene that viewers have set and that is not drawn yet, with its text.
    next: Option<(String, Arc<Script>)>,
    /// Fields that icoray_wants_field has not asked the model for since the last icoray_execute.
    unwanted: BTreeSet<String>,
    /// The model's own scene, while that of viewers is drawn.
    own: Option<Arc<Script>>,
    /// Milliseconds that a picture of each view may take, while the scene of viewers is drawn.
    budgets_ms: BTreeMap<String, f64>,
}

impl Viewers {
    /// Keeps the scene that viewers have set until it is drawn. Of what cannot be read no field is wanted.
    fn announce(&mut self, text: Option<&str>) {
        if self.next.as_ref().map(|(known, _)| known.as_str()) != text {
            let script = text.map(|text| Some((text.to_owned(), Arc::new(Script::parse(text).ok()?))));
            self.next = script.flatten();
        }
    }

    /// The scene that viewers have set and that is not drawn yet.
    pub(super) fn next(&self) -> Option<&Script> {
        self.next.as_ref().map(|(_, script)| &**script)
    }

    /// Whether a scene reads a field that the model was not asked for; `first` is the field of scenes that name none.
    fn lacks_fields(&self, text: &str, first: Option<&str>) -> bool {
        let is_unwanted = |name: &String| match name.as_str() {
            "" => first.is_some_and(|first| self.unwanted.contains(first)),
            name => self.unwanted.contains(name),
        };
        !self.unwanted.is_empty()
            && Script::parse(text).is_ok_and(|script| script.model_fields().iter().any(is_unwanted))
    }

    /// Notes an answer of icoray_wants_field.
    pub(super) fn answered(&mut self, field: &str, is_wanted: bool) {
        if is_wanted {
            self.unwanted.remove(field);
        } else if !self.unwanted.contains(field) {
            self.unwanted.insert(field.to_owned());
        }
    }

    /// The picture within the time that it may take.
    pub(super) fn within_budget(&self, mut shot: Shot) -> Shot {
        if let Some(ms) = self.budgets_ms.get(&shot.name) {
            shot.scene.time_budget_ms = Some(shot.scene.time_budget_ms.map_or(*ms, |own| own.min(*ms)));
        }
        shot
    }
}

impl Context {
    /// Opens or closes the page as the scene asks, and takes what viewers have sent. Of rank 0; a failure is logged.
    pub(super) fn hear_viewers(&mut self) -> ViewerMessage {
        let script = match &self.scene {
            SceneChoice::Script(script) if self.ranks.is_root() => script.clone(),
            _ => return ViewerMessage::default(),
        };
        let Some(live) = script.live() else {
            if self.viewers.page.take().is_some() {
                self.drawing.pass_frames_on(None);
            }
            return ViewerMessage::default();
        };
        if self.viewers.page.is_none() && !self.viewers.has_failed {
            match caught(|| Page::open(live, &self.scene_text, &self.inputs, &mut self.drawing)) {
                Ok(page) => self.viewers.page = Some(page),
                Err(failure) => {
                    self.viewers.has_failed = true;
                    self.drawing.warn(&format!("no live view: {}", failure.message));
                }
            }
        }
        let Some(page) = &mut self.viewers.page else { return ViewerMessage::default() };
        page.count_pictures(&mut self.drawing);
        let mut sent = page.take(&self.inputs, &script, &self.scene_text);
        let first = self.inputs.first.as_deref();
        sent.is_announced = sent.announced().is_some_and(|text| self.viewers.lacks_fields(&text, first));
        if sent.is_announced
            && let Some(look) = sent.look.take_if(|_| sent.scene.is_none())
        {
            sent.scene = Some(format!("field = {:?}\n", look.field));
        }
        self.viewers.unwanted.clear();
        sent
    }

    /// Takes the viewers' changes before fields are computed, in a single process only: other ranks would miss them.
    pub(super) fn hear_viewers_early(&mut self) {
        if let (Some(page), SceneChoice::Script(script), false) =
            (&mut self.viewers.page, &self.scene, self.ranks.size() > 1)
        {
            let sent = page.take(&self.inputs, script, &self.scene_text);
            self.viewers.announce(sent.announced().as_deref());
        }
    }

    /// Does on all ranks what viewers have sent, and returns the script. Collective.
    pub(super) fn follow_viewers(&mut self, sent: &ViewerMessage, stamp: &Stamp) -> Outcome<Option<Arc<Script>>> {
        match &sent.scene {
            Some(text) if sent.is_announced => self.viewers.announce(Some(text)),
            Some(text) => self.take_scene(text, !sent.budgets_ms.is_empty(), stamp),
            None => (),
        }
        self.viewers.budgets_ms = if self.viewers.own.is_some() { sent.budgets_ms.clone() } else { BTreeMap::new() };
        if let Some(field) = &sent.histogram {
            self.answer_histogram(field);
        }
        if let Some(LookRequest { text, view, field }) = &sent.look {
            self.answer_look(&Completion { text, view: Some(view), field: Some(field), is_steered: true }, stamp);
        }
        let script = self.script()?;
        if let (Some(ProbeRequest { at, view }), Some(script)) = (&sent.probe, &script) {
            self.answer_probe(*at, view, script, stamp);
        }
        Ok(script)
    }

    /// Draws the scene of a text from now on if all ranks can; `is_steered` if it is not the model's own. Collective.
    fn take_scene(&mut self, text: &str, is_steered: bool, stamp: &Stamp) {
        self.viewers.next = None;
        let mine = caught(|| self.drawable(text, stamp));
        let agreed = self.agree_for_viewers(mine);
        let outcome = agreed.map(|script| {
            let before = std::mem::replace(&mut self.scene, SceneChoice::Script(script));
            if let (SceneChoice::Script(before), None) = (before, &self.viewers.own) {
                self.viewers.own = Some(before);
            }
            if !is_steered {
                self.viewers.own = None;
            }
            self.keep_text(text.to_owned());
            if is_steered {
                // What viewers leave open is drawn as it is.
                self.open_views.clear();
            }
        });
        if let Some(page) = &mut self.viewers.page {
            page.taken(outcome, self.viewers.own.is_some(), stamp, &mut self.drawing);
        }
    }

    /// The script that a viewer has set, if its pictures of this step can be drawn from what the model has given, and
    /// take no more memory than a share of what those of the model's own take.
    fn drawable(&self, text: &str, stamp: &Stamp) -> Outcome<Arc<Script>> {
        let mut script = Script::parse(text)?;
        script.name_by_date();
        let script = Arc::new(script);
        let bytes = self.memory_of(&script, stamp)?;
        let own = match (&self.viewers.own, &self.scene) {
            (Some(own), _) | (None, SceneChoice::Script(own)) => self.memory_of(own, stamp),
            (None, SceneChoice::Open | SceneChoice::Nothing) => Ok(0),
        };
        // The memory of a scene of the model that cannot be drawn is not known: no limit.
        let limit = own.map_or(u64::MAX, |own| MEMORY_SHARE * own);
        if bytes > limit {
            let message = format!(
                "a picture takes {bytes} bytes of memory, expected at most {limit}, {MEMORY_SHARE} times what one of \
                 the model's own scene takes; show less"
            );
            return Err(Failure::new(icoray_status::ICORAY_ERR_MEMORY, message));
        }
        Ok(script)
    }

    /// The memory of the largest picture of this step, bytes, if all can be drawn from what the model has given.
    fn memory_of(&self, script: &Arc<Script>, stamp: &Stamp) -> Outcome<u64> {
        let mut largest = 0;
        for shot in self.inputs.named(script).views().iter().flat_map(|view| view.shots(stamp)) {
            let given = self.inputs.frame_inputs(shot, stamp)?;
            check_whole(&given)?;
            let (_, field) = given.fields.iter().next().ok_or_else(|| Failure::null("the scene's field"))?;
            let FrameSetup { scene, grid, decomposition, layers, .. } = &given.setup;
            // Some columns over the whole grid have no plan of their own.
            if field.shape().columns == ColumnCount::new(grid, field.location()).columns {
                let plan = Plan::new(scene, grid, layers, field)?;
                // A rank's own part has its tables only.
                let drawn = decomposition.as_ref().map_or(&**grid, |of| of.node_grid(grid));
                let memory = self.drawing.renderer().run(|| plan.memory(scene, drawn));
                largest = largest.max(memory.total());
            }
        }
        Ok(largest)
    }

    /// The outcome of all ranks. What viewers ask closes no context, not even by an internal error.
    fn agree_for_viewers<T>(&mut self, mine: Outcome<T>) -> Outcome<T> {
        agree(&mut self.ranks, mine, "icoray_execute", Vec::new(), &()).outcome
    }

    /// The answer to a viewer's question: once all ranks have what `given` returns, `answer` computes it on each. A
    /// panic of either is a failure. Collective.
    fn asked<G, T>(
        &mut self,
        given: impl FnOnce(&Inputs) -> Outcome<G>,
        answer: impl FnOnce(&Renderer, &mut Ranks, G) -> Outcome<T>,
    ) -> Outcome<T> {
        let mine = caught(|| given(&self.inputs));
        let given = self.agree_for_viewers(mine)?;
        caught(|| answer(self.drawing.renderer(), &mut self.ranks, given))
    }

    /// Counts the values of a field. Collective.
    fn answer_histogram(&mut self, name: &str) {
        let found = self.asked(
            |inputs| inputs.condition_field(name),
            |renderer, ranks, known| {
                let decomposition = known.decomposition.as_deref();
                Ok(renderer.histogram(ranks, &known.field, decomposition, Histogram::FINE_BINS)?)
            },
        );
        if let Some(page) = &mut self.viewers.page {
            page.answer_histogram(name, found, &self.inputs);
        }
    }

    /// Suggests a look for a field. Collective.
    fn answer_look(&mut self, wanted: &Completion, stamp: &Stamp) {
        let found = self.suggested(wanted, stamp);
        if let Some(page) = &mut self.viewers.page {
            page.answer_look(found);
        }
    }

    /// Follows the ray through a place of a view's picture. Collective.
    fn answer_probe(&mut self, at: [f64; 2], view: &str, script: &Script, stamp: &Stamp) {
        let given = |inputs: &Inputs| {
            let shot = script.views().iter().find(|its| its.name() == view).and_then(|its| its.shots(stamp).next());
            let gone = || Failure::new(icoray_status::ICORAY_ERR_ARGUMENT, format!("the view {view:?} is gone"));
            let given = inputs.frame_inputs(shot.ok_or_else(gone)?, stamp)?;
            check_whole(&given)?;
            Ok(given)
        };
        let found = self.asked(given, |renderer, ranks, given| {
            let (scene, data) = (&given.setup.scene, given.setup.distributed_grid());
            Ok(renderer.probe_decomposed(ranks, scene, data, given.fields.clone(), at)?)
        });
        if let Some(page) = &mut self.viewers.page {
            page.answer_probe(found, stamp, &self.inputs);
        }
    }

    /// Shows viewers a scene that the model has set.
    pub(super) fn show_new_scene(&mut self) {
        self.viewers = Viewers { page: self.viewers.page.take(), ..Viewers::default() };
        self.show_scene();
    }

    /// Shows viewers the model's own scene, as it is drawn from now on.
    pub(super) fn show_scene(&mut self) {
        if let (Some(page), SceneChoice::Script(script)) = (&mut self.viewers.page, &self.scene)
            && let Some(live) = script.live()
        {
            page.load(live, &self.scene_text, &mut self.drawing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::tests::config;
    use icoray_core::ranks::on_local_nodes;

    /// A panic of one rank before the ranks agree, and of all in the answer: a failure, which the page shows.
    #[test]
    fn a_panic_of_a_viewers_question_closes_no_context() {
        let ask = |ranks: Ranks| {
            let mut context = Context::new(&config(), "", &ranks, 1).unwrap();
            let is_root = ranks.is_root();
            context.join(ranks).unwrap();
            let before = |_: &Inputs| if is_root { panic!("a bug before") } else { Ok(()) };
            let before = context.asked(before, |_, _, ()| Ok(()));
            let answer = context.asked(|_| Ok(()), |_, _, ()| -> Outcome<()> { panic!("a bug of the answer") });
            for (outcome, bug) in [(before, "a bug before"), (answer, "a bug of the answer")] {
                let Failure { status, message, .. } = outcome.unwrap_err();
                assert!(status == icoray_status::ICORAY_ERR_INTERNAL && message.contains(bug), "{message}");
            }
            context.refuse_if_over().unwrap();
            context.refuse_if_poisoned().unwrap();
            assert!(!context.is_over);
        };
        ask(Ranks::alone());
        on_local_nodes(&[0; 2], |team| ask(Ranks::new(team)));
    }
}
