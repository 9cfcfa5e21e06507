//! Collective calls.
//!
//! Each begins with an agreement that every rank enters, whatever has failed on it (a poisoned or disabled context, a
//! wrong argument, a missing field). So no rank waits for one that has returned.

use super::viewer_message::ViewerMessage;
use super::{Context, GridInput, SceneChoice};
use crate::boundary::{Failure, Outcome, caught};
use crate::ranks::{RootMessage, agree};
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::{Decomposition, PartCells, PartCorners, Ranks, Script};
use std::sync::Arc;

/// A grid's name, this rank's cells there, and the corners of its fields if it has numbered them.
type PartInput<'a> = (&'a str, PartCells<'a>, Option<PartCorners<'a>>);

impl Context {
    /// Whether some calls are collective over several ranks.
    pub fn is_shared(&self) -> bool {
        !self.ranks.is_alone()
    }

    /// Renders with these ranks from now on. Collective.
    pub fn join(&mut self, mut ranks: Ranks) -> Outcome<()> {
        let joined = self.drawing.join(&mut ranks);
        self.ranks = ranks;
        joined
    }

    /// Members of the config that must be equal on all ranks.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        vec![("async_render", i32::from(self.drawing.is_async()).to_string())]
    }

    /// As [`agree`], recording failures.
    pub(super) fn agree<T>(
        &mut self,
        mine: Outcome<T>,
        call: &'static str,
        facts: Vec<(&'static str, String)>,
        value: &[u8],
    ) -> (Outcome<T>, RootMessage) {
        let (agreed, root_message) = agree(&mut self.ranks, mine, call, facts, value);
        if let Err(failure) = &agreed {
            self.failed_on_all(failure);
        }
        (agreed, root_message)
    }

    /// Records a failure that all ranks have in this call.
    pub(super) fn failed_on_all(&mut self, failure: &Failure) {
        self.is_over |= failure.status == icoray_status::ICORAY_ERR_INTERNAL;
    }

    /// Agrees with the other ranks on the owners of a grid's cells and corners. Works for a lone process too.
    pub fn set_part<'a>(&mut self, part: impl FnOnce() -> Outcome<PartInput<'a>>) -> Outcome<()> {
        let call = "icoray_part_set";
        let mine = caught(|| {
            self.refuse_if_poisoned()?;
            let (name, cells, corners) = part()?;
            Ok((name, self.inputs.grid(name, call)?.clone(), cells, corners))
        });
        // Facts are not compared if this rank fails.
        let facts = mine.iter().map(|(name, ..)| ("grid", format!("{name:?}"))).collect();
        let (agreed, _) = self.agree(mine, call, facts, &[]);
        let (name, input, cells, corners) = agreed?;
        let held = Decomposition::with_corners(&mut self.ranks, &input.grid, &cells, corners.as_ref())?;
        self.inputs.grids.insert(name.into(), GridInput { held: Some(Arc::new(held)), ..input });
        Ok(())
    }

    pub(super) fn execute_collective(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let mut facts = match &stamp {
            Ok(stamp) => vec![("step", stamp.step.to_string()), ("time_s", stamp.time_s.to_string())],
            // Facts are not compared if this rank fails.
            Err(_) => Vec::new(),
        };
        if let (Ok(_), SceneChoice::Script(script)) = (&stamp, &self.scene)
            && script.lacks_field()
        {
            let first = self.inputs.first.as_deref().unwrap_or_default();
            facts.push(("first field", format!("{first:?}")));
        }
        let mine = caught(|| self.ready(stamp));
        let sent = self.hear_viewers();
        let value = both(&self.drawing.root_message(), &sent.bytes());
        let (agreed, root_message) = self.agree(mine, "icoray_execute", facts, &value);
        let (root_message, sent) = of_both(&root_message);
        let unreported = self.drawing.receive_root_message(&root_message);
        let (stamp, mut script) = match agreed {
            Ok(ready) => ready,
            Err(failure) => {
                self.drawing.picture_failed(&failure);
                return Err(failure);
            }
        };
        // All ranks are in this call, so messages between them arrive without delay.
        self.drawing.pump();
        if sent.is_any() {
            script = self.follow_viewers(&sent, &stamp)?;
        }
        self.draw_step(script.as_deref(), &stamp)?;
        if let Some(unreported) = unreported {
            self.drawing.clear_unreported();
            return Err(unreported);
        }
        Ok(())
    }

    /// Stamp and script of the step, or why this rank cannot render.
    fn ready(&mut self, stamp: Outcome<Stamp>) -> Outcome<(Stamp, Option<Arc<Script>>)> {
        self.refuse_if_poisoned()?;
        let stamp = stamp?;
        self.drawing.collect();
        self.drawing.take_unreported_of_rank()?;
        self.drawing.refuse_if_off()?;
        let script = self.script()?;
        self.warn_about_old_time_levels(script.as_deref(), &stamp);
        Ok((stamp, script))
    }

    /// Waits until no frame is rendered in the background. Collective over several ranks, which agree first that all
    /// are in the same `call`.
    pub fn finish_frames(&mut self, call: &'static str) -> Outcome<()> {
        if !self.is_shared() {
            self.drawing.finish_rendering();
            return Ok(());
        }
        if !self.drawing.is_under_way() {
            return Ok(());
        }
        let (met, _) = self.agree(Ok(()), call, Vec::new(), &[]);
        if met.is_ok() || self.ranks.is_gone() {
            self.drawing.finish_rendering();
        }
        met
    }

    pub(super) fn wait_collective(&mut self) -> Outcome<()> {
        self.finish_frames("icoray_wait")?;
        let mine = caught(|| {
            self.refuse_if_poisoned()?;
            self.drawing.finish()
        });
        self.agree_on_end(mine, "icoray_wait")
    }

    /// Waits before close; without the other ranks if MPI was finalised before.
    pub(super) fn finish_collective(&mut self) -> Outcome<()> {
        let is_alone = self.ranks.is_gone();
        let met = self.finish_frames("icoray_close");
        let outcome = caught(|| self.drawing.finish());
        let mine = if self.poison.is_some() { Ok(()) } else { outcome };
        if is_alone {
            return mine;
        }
        met?;
        self.agree_on_end(mine, "icoray_close")
    }

    fn agree_on_end(&mut self, mine: Outcome<()>, call: &'static str) -> Outcome<()> {
        let value = self.drawing.root_message();
        let (agreed, root_message) = self.agree(mine, call, Vec::new(), &value);
        self.drawing.receive_root_message(&root_message);
        agreed
    }
}

/// Rank 0's message of drawing, with its length before it, and that of viewers.
fn both(drawing: &[u8], viewers: &[u8]) -> Vec<u8> {
    [&(drawing.len() as u32).to_le_bytes(), drawing, viewers].concat()
}

/// The messages that [`both`] has put together; rank 0 may be gone and have sent nothing.
fn of_both(message: &RootMessage) -> (RootMessage, ViewerMessage) {
    let Some((length, rest)) = message.0.split_first_chunk::<4>() else {
        return (RootMessage(Vec::new()), ViewerMessage::default());
    };
    let (drawing, viewers) = rest.split_at((u32::from_le_bytes(*length) as usize).min(rest.len()));
    (RootMessage(drawing.to_vec()), ViewerMessage::read(viewers))
}

#[cfg(test)]
mod tests;
