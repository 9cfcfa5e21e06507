//! Drawing the pictures of a step, alone or together with the other ranks.
//!
//! Pictures come one after the other, and what fails keeps no other from being drawn. All ranks go through the same views:
//! a script remembers nothing, and the numbers that conditions ask for are the same on all.

use super::inputs::{Measured, Subject};
use super::{Choice, Context, levels, missing};
use crate::boundary::{Failure, Outcome, caught};
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::{Script, Shot, Statistic, Summary, View};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Instant;

/// What is known of fields in this step.
type Summaries = BTreeMap<String, Summary>;

impl Context {
    /// Draws the pictures that are due, with the other ranks where there are any.
    pub fn execute(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let start = Instant::now();
        self.drawing.begin_call();
        let outcome = if self.is_shared() { self.execute_together(stamp) } else { self.execute_alone(stamp) };
        self.drawing.end_call(start.elapsed().as_secs_f64());
        outcome
    }

    fn execute_alone(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let stamp = stamp?;
        let script = self.script()?;
        self.drawing.collect();
        self.drawing.refuse_if_off()?;
        self.point_out_old_levels(script.as_deref(), &stamp);
        self.draw_step(script.as_deref(), &stamp)?;
        self.drawing.tell()
    }

    /// The script with the name of the field that was set first where it names none.
    fn named(&self, script: &Arc<Script>) -> Arc<Script> {
        match &self.inputs.first {
            Some(first) if script.lacks_field() => {
                let mut named = Script::clone(script);
                named.name_first_field(first);
                Arc::new(named)
            }
            _ => script.clone(),
        }
    }

    /// What is to be drawn in the course of time, if anything.
    pub(super) fn script(&self) -> Outcome<Option<Arc<Script>>> {
        match &self.scene {
            Choice::Script(script) => Ok(Some(self.named(script))),
            Choice::Nothing => Ok(None),
            Choice::Open => Err(missing("icoray_execute", "scene", "icoray_scene_load or icoray_scene_text")),
        }
    }

    /// Tells the log of fields that look like old time levels: at rank 0, of what that has.
    pub(super) fn point_out_old_levels(&mut self, script: Option<&Script>, stamp: &Stamp) {
        if !(self.ranks.is_root() && self.drawing.is_warned()) {
            return;
        }
        let views = script.map(|script| script.scheduled(stamp, self.before.as_ref()).collect::<Vec<_>>());
        let read = views.unwrap_or_default().into_iter().flat_map(|view| {
            let conditions = view.conditions().iter().map(|condition| condition.field().to_owned());
            view.model_fields().into_iter().chain(conditions)
        });
        let hash = |name: String| {
            let field = self.inputs.fields.get(&name)?.field().ok()?;
            Some((name, levels::hash(&field)?))
        };
        let hashes: Vec<_> = read.collect::<BTreeSet<_>>().into_iter().filter_map(hash).collect();
        for (name, levels) in self.levels.step(stamp.step, &hashes) {
            self.drawing.warn(&format!(
                "step {}: the values of field {name:?} change only at every {} step; a model that swaps time levels calls \
                 icoray_field_set before each icoray_execute",
                stamp.step,
                if levels == 2 { "second" } else { "third" }
            ));
        }
    }

    /// The pictures of a step. The first failure is returned; others are counted and logged.
    pub(super) fn draw_step(&mut self, script: Option<&Script>, stamp: &Stamp) -> Outcome<()> {
        let before = self.before.replace(stamp.clone());
        let scheduled = script.map(|script| script.scheduled(stamp, before.as_ref()).collect::<Vec<_>>());
        let scheduled = scheduled.unwrap_or_default();
        let (mut first, mut known, mut copied) = (None, Summaries::new(), Vec::new());
        for view in &scheduled {
            match self.holds(view, &scheduled, &mut known, stamp) {
                Ok(false) => continue,
                Ok(true) => {}
                Err(failure) => {
                    self.picture_failed(failure, &mut first)?;
                    continue;
                }
            }
            for shot in view.shots(stamp) {
                if let Err(failure) = self.draw_shot(shot, stamp, &mut copied) {
                    self.picture_failed(failure, &mut first)?;
                }
            }
        }
        for failure in self.drawing.hand_over(&mut self.ranks, copied, stamp)? {
            self.picture_failed(failure, &mut first)?;
        }
        first.map_or(Ok(()), Err)
    }

    /// Whether all conditions of a view hold: on all ranks or on none. A field is read once for all of the `scheduled` views.
    fn holds(
        &mut self,
        view: &View,
        scheduled: &[&View],
        known: &mut Summaries,
        stamp: &Stamp,
    ) -> Outcome<bool> {
        if view.conditions().is_empty() {
            return Ok(true);
        }
        let named = |failure: Failure| failure.of_picture(view.name(), stamp.step);
        let fields: BTreeSet<&str> = view.conditions().iter().map(|condition| condition.field()).collect();
        let unknown = fields.into_iter().filter(|field| !known.contains_key(*field));
        let mine = caught(|| unknown.map(|field| self.inputs.measured(field)).collect::<Outcome<Vec<_>>>());
        for Measured { name, field, held } in
            self.of_one_mind(mine.map_err(named), view.name(), Vec::new())?
        {
            let asked = asked(scheduled, &name);
            let renderer = self.drawing.renderer();
            let summary = renderer.summary(&mut self.ranks, &field, held.as_deref(), &asked);
            let summary = summary.map_err(|e| named(Failure::from(e).within(format_args!("field {name:?}"))));
            known.insert(name, summary?);
        }
        let mut statistic = |field: &str, statistic: Statistic| {
            Ok(known.get(field).and_then(|summary| summary.get(statistic)))
        };
        Ok(view.holds(&mut statistic)?)
    }

    /// Draws a picture, or puts it with those that are drawn from one copy of the fields.
    fn draw_shot<'a>(&mut self, shot: Shot, stamp: &Stamp, copied: &mut Vec<Subject<'a>>) -> Outcome<()> {
        let name = shot.name.clone();
        let named = |failure: Failure| failure.of_picture(&name, stamp.step);
        let Context { inputs, drawing, ranks, .. } = self;
        let mine = caught(|| {
            drawing.refuse_if_off()?;
            if ranks.is_root() && !drawing.is_in_background() {
                // Names that are wrong or taken are known before the first ray.
                drawing.check_names(&shot.scene, stamp)?;
            }
            let subject = inputs.subject(shot)?;
            if ranks.size() > 1 {
                subject.check_whole()?;
            }
            Ok(subject)
        });
        let facts = mine.iter().map(Subject::grid_fact).collect();
        let subject = self.of_one_mind(mine.map_err(named), &name, facts)?;
        if self.drawing.is_in_background() {
            copied.push(subject);
            return Ok(());
        }
        self.drawing.draw(&mut self.ranks, stamp, subject).map_err(named)
    }

    /// What went well everywhere, where all draw the same view and `facts` are the same. Collective.
    fn of_one_mind<T>(
        &mut self,
        mine: Outcome<T>,
        view: &str,
        facts: Vec<(&'static str, String)>,
    ) -> Outcome<T> {
        if !self.is_shared() {
            return mine;
        }
        let facts = [("draws view", format!("{view:?}"))].into_iter().chain(facts).collect();
        let value = self.drawing.said();
        let (agreed, said) = self.agree(mine, "icoray_execute", facts, &value);
        self.drawing.heard(&said);
        agreed
    }

    /// Counts a failure, which is the call's where it is the `first`, and goes on unless icoray itself failed.
    fn picture_failed(&mut self, failure: Failure, first: &mut Option<Failure>) -> Outcome<()> {
        self.failed_on_all(&failure);
        self.drawing.picture_failed(&failure);
        let is_bug = failure.status == icoray_status::ICORAY_ERR_INTERNAL;
        // A bug ends the context, and is told before all else.
        let other = if first.is_none() || is_bug { first.replace(failure) } else { Some(failure) };
        if let Some(other) = other.filter(|_| self.ranks.is_root()) {
            self.drawing.log_failure(&other);
        }
        if is_bug { first.take().map_or(Ok(()), Err) } else { Ok(()) }
    }
}

/// What conditions of any view ask of a field.
fn asked(views: &[&View], field: &str) -> Vec<Statistic> {
    let all = views.iter().flat_map(|view| view.conditions());
    all.filter(|condition| condition.field() == field).map(|condition| condition.statistic()).collect()
}
