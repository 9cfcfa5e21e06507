//! Rendering the pictures of a step, alone or with the other ranks.
//!
//! Pictures are rendered one after the other; a failure does not prevent the others. All ranks go through the same
//! views: a script has no state, and the statistics of conditions are equal on all ranks.

use super::inputs::{ConditionField, check_whole, grid_fact};
use super::levels::{self, Pattern};
use super::{Context, SceneChoice, missing};
use crate::boundary::{Failure, Outcome, caught};
use crate::message::listed;
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::{FrameInputs, FrameSetup, Script, Shot, Statistic, Summary, View};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Instant;

/// Statistics of fields in this step, by field name.
type Summaries = BTreeMap<String, Summary>;

/// Failures of a step.
#[derive(Default)]
struct Failures {
    first: Option<Failure>,
    /// The messages, without the names of views.
    reasons: BTreeSet<String>,
    /// Pictures that failed for a reason that is among them already.
    repeated: usize,
}

impl Context {
    /// Renders the pictures that are scheduled for the step, with the other ranks if there are any.
    pub fn execute(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let start = Instant::now();
        self.drawing.begin_call();
        let outcome = if self.is_shared() { self.execute_collective(stamp) } else { self.execute_alone(stamp) };
        self.drawing.end_call(start.elapsed().as_secs_f64());
        outcome
    }

    fn execute_alone(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let stamp = stamp?;
        let script = self.script()?;
        self.drawing.collect();
        self.drawing.refuse_if_disabled()?;
        let sent = self.hear_viewers();
        let script = if sent.is_any() { self.follow_viewers(&sent, &stamp)? } else { script };
        self.warn_about_old_time_levels(script.as_deref(), &stamp);
        self.draw_step(script.as_deref(), &stamp)?;
        self.drawing.take_unreported()
    }

    /// The script of the scene; `None` if the scene has no keys.
    pub(super) fn script(&self) -> Outcome<Option<Arc<Script>>> {
        match &self.scene {
            SceneChoice::Script(script) => Ok(Some(self.inputs.named(script))),
            SceneChoice::Nothing => Ok(None),
            SceneChoice::Open => Err(missing("icoray_execute", "scene", "icoray_scene_load or icoray_scene_text")),
        }
    }

    /// Logs a warning, at rank 0, for fields whose array looks like an old time level.
    pub(super) fn warn_about_old_time_levels(&mut self, script: Option<&Script>, stamp: &Stamp) {
        if !(self.ranks.is_root() && self.drawing.is_warned()) {
            return;
        }
        let views = script.map(|script| script.scheduled(stamp, self.before.as_ref()).collect::<Vec<_>>());
        let read = views.unwrap_or_default().into_iter().flat_map(|view| {
            let conditions = view.conditions().iter().map(|condition| condition.field().to_owned());
            view.model_fields().into_iter().chain(conditions)
        });
        let hash = |name: String| {
            let field = self.inputs.fields.get(&name)?.field(None).ok()?;
            (field.shape().columns > 0).then(|| (name, field.hash_of_samples(levels::SAMPLES)))
        };
        let hashes: Vec<_> = read.collect::<BTreeSet<_>>().into_iter().filter_map(hash).collect();
        for (name, pattern) in self.levels.step(stamp.step, &hashes) {
            let what = match pattern {
                Pattern::TimeLevel(levels) => format!(
                    "change only at every {} step; a model that swaps time levels calls icoray_field_set before each \
                     icoray_execute",
                    if levels == 2 { "second" } else { "third" }
                ),
                Pattern::Unchanged => {
                    "are those of the picture before; a model may compute a field at some steps only, such as those of its \
                     output"
                        .into()
                }
            };
            self.drawing.warn(&format!("step {}: the values of field {name:?} {what}", stamp.step));
        }
    }

    /// Logs a warning, at rank 0, at the first picture of a grid with holes.
    fn warn_about_holes(&mut self, setup: &FrameSetup) {
        let Some(grid) = setup.drawn_grid().filter(|_| self.ranks.is_root() && self.drawing.is_warned()) else {
            return;
        };
        let token = grid.lifetime_token();
        if self.drawn_grids.iter().any(|known| known.ptr_eq(&token)) {
            return;
        }
        self.drawn_grids.retain(|known| known.strong_count() > 0);
        self.drawn_grids.push(token);
        if let Some(holes) = grid.describe_holes() {
            self.drawing.warn(&format!("the grid has {holes}; only the core is drawn there"));
        }
    }

    /// Renders the pictures of a step, or submits them to the background, which renders all from one copy of fields. The
    /// first failure is returned; others are counted and logged.
    pub(super) fn draw_step(&mut self, script: Option<&Script>, stamp: &Stamp) -> Outcome<()> {
        let before = self.before.replace(stamp.clone());
        let scheduled = script.map(|script| script.scheduled(stamp, before.as_ref()).collect::<Vec<_>>());
        let scheduled = scheduled.unwrap_or_default();
        let (mut failures, mut known, mut copied) = (Failures::default(), Summaries::new(), Vec::new());
        for view in &scheduled {
            let drawn = match self.holds(view, &scheduled, &mut known, stamp) {
                Ok(false) => continue,
                Ok(true) => self.completed(view, stamp),
                Err(failure) => Err(failure),
            };
            let view = match drawn {
                Ok(view) => view,
                Err(failure) => {
                    self.picture_failed(failure, view.name(), &mut failures)?;
                    continue;
                }
            };
            for shot in view.shots(stamp) {
                let given = self.picture_inputs(self.viewers.within_budget(shot), stamp, true);
                let drawn = given.and_then(|given| {
                    self.warn_about_holes(&given.setup);
                    if self.drawing.is_in_background() {
                        copied.push(given);
                        return Ok(());
                    }
                    self.drawing.draw(&mut self.ranks, given)
                });
                if let Err(failure) = drawn {
                    self.picture_failed(failure, view.name(), &mut failures)?;
                }
            }
        }
        for failure in self.drawing.submit_to_background(&mut self.ranks, copied, stamp)? {
            self.picture_failed(failure, "", &mut failures)?;
        }
        if failures.repeated > 0 && self.ranks.is_root() {
            self.drawing
                .warn(&format!("step {}: {} more pictures failed for the same reason", stamp.step, failures.repeated));
        }
        failures.first.map_or(Ok(()), Err)
    }

    /// Whether all conditions of a view hold; equal on all ranks. Each field is read once for all `scheduled` views.
    fn holds(&mut self, view: &View, scheduled: &[&View], known: &mut Summaries, stamp: &Stamp) -> Outcome<bool> {
        if view.conditions().is_empty() {
            return Ok(true);
        }
        let named = |failure: Failure| failure.of_picture(view.name(), stamp.step);
        let fields: BTreeSet<&str> = view.conditions().iter().map(|condition| condition.field()).collect();
        let unknown = fields.into_iter().filter(|field| !known.contains_key(*field));
        let mine = caught(|| unknown.map(|field| self.inputs.condition_field(field)).collect::<Outcome<Vec<_>>>());
        for ConditionField { name, field, decomposition } in
            self.agree_on_picture(mine.map_err(named), view.name(), Vec::new())?
        {
            let asked = requested_statistics(scheduled, &name);
            let renderer = self.drawing.renderer();
            let summary = renderer.summary(&mut self.ranks, &field, decomposition.as_deref(), &asked);
            let summary = summary.map_err(|e| named(Failure::from(e).within(format_args!("field {name:?}"))));
            known.insert(name, summary?);
        }
        let mut statistic =
            |field: &str, statistic: Statistic| Ok(known.get(field).and_then(|summary| summary.get(statistic)));
        Ok(view.holds(&mut statistic)?)
    }

    /// The inputs of a picture, which all ranks can render, and whose files may be made if it `is_written`. Collective.
    pub(super) fn picture_inputs<'a>(
        &mut self,
        shot: Shot,
        stamp: &Stamp,
        is_written: bool,
    ) -> Outcome<FrameInputs<'a>> {
        let name = shot.name.clone();
        let Context { inputs, drawing, ranks, .. } = self;
        let mine = caught(|| {
            drawing.refuse_if_disabled()?;
            if is_written && ranks.is_root() && !drawing.is_in_background() {
                // Names that are wrong or taken are known before the first ray.
                drawing.check_names(&shot.scene, stamp)?;
            }
            let mut frame_inputs = inputs.frame_inputs(shot, stamp)?;
            frame_inputs.setup.notes.extend(drawing.note.clone());
            if ranks.size() > 1 {
                check_whole(&frame_inputs)?;
            }
            Ok(frame_inputs)
        });
        let facts = mine.iter().flat_map(|FrameInputs { setup, .. }| {
            // All ranks show the same 2D fields as surfaces.
            let fields_2d = listed(inputs.fields_2d(&setup.scene).into_iter());
            [grid_fact(setup), ("has fields of one layer:", fields_2d)]
        });
        let facts = facts.collect();
        self.agree_on_picture(mine.map_err(|failure| failure.of_picture(&name, stamp.step)), &name, facts)
    }

    /// This rank's value if all ranks succeeded, render the same view and have equal `facts`. Collective.
    fn agree_on_picture<T>(&mut self, mine: Outcome<T>, view: &str, facts: Vec<(&'static str, String)>) -> Outcome<T> {
        if !self.is_shared() {
            return mine;
        }
        let facts = [("draws view", format!("{view:?}"))].into_iter().chain(facts).collect();
        let agreed = self.agree_with(mine, "icoray_execute", facts, &self.drawing.root_state());
        self.drawing.receive_root_state(agreed.root_message);
        agreed.outcome
    }

    /// Counts a failure of a view and stores it if it is the first; returns it only after an internal error. One that has
    /// the reason of another view's is counted, not logged.
    fn picture_failed(&mut self, failure: Failure, view: &str, failures: &mut Failures) -> Outcome<()> {
        self.failed_on_all(&failure);
        self.drawing.picture_failed(&failure);
        let first = &mut failures.first;
        let is_known = !failures.reasons.insert(failure.message.replacen(&format!("view {view:?}: "), "", 1));
        let is_bug = failure.status == icoray_status::ICORAY_ERR_INTERNAL;
        // An internal error ends the context and takes precedence.
        let other = if first.is_none() || is_bug { first.replace(failure) } else { Some(failure) };
        failures.repeated += usize::from(is_known);
        if let Some(other) = other.filter(|_| self.ranks.is_root() && !is_known) {
            self.drawing.log_failure(&other);
        }
        if is_bug { first.take().map_or(Ok(()), Err) } else { Ok(()) }
    }
}

/// The statistics of a field that conditions of any view need.
fn requested_statistics(views: &[&View], field: &str) -> Vec<Statistic> {
    let all = views.iter().flat_map(|view| view.conditions());
    all.filter(|condition| condition.field() == field).map(|condition| condition.statistic()).collect()
}
