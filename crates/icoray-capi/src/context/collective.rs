//! Collective calls.
//!
//! Each begins with an agreement that every rank enters, even after a failure on it (a poisoned or disabled context, a
//! wrong argument, a missing field). So no rank waits for one that has returned.

use super::{Context, GridInput, SceneChoice};
use crate::boundary::{Failure, Outcome, caught};
use crate::drawing::RootState;
use crate::ranks::{Agreed, agree};
use crate::types::icoray_status;
use crate::viewer_message::ViewerMessage;
use icoray_core::output::Stamp;
use icoray_core::{Decomposition, Grid, PartCells, PartCorners, Ranks, Script};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// This rank's part of a grid.
pub struct PartInput<'a> {
    /// Name of the grid.
    pub grid: &'a str,
    /// Its cells.
    pub cells: PartCells<'a>,
    /// The corners of this rank's fields, if it has numbered them.
    pub corners: Option<PartCorners<'a>>,
}

/// The message of rank 0 in icoray_execute.
#[derive(Default, Serialize, Deserialize)]
struct RootMessage {
    drawing: RootState,
    viewers: ViewerMessage,
}

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

    /// As [`agree`] with a message of rank 0, recording failures.
    pub(super) fn agree_with<T, M: Serialize + DeserializeOwned + Default>(
        &mut self,
        mine: Outcome<T>,
        call: &'static str,
        facts: Vec<(&'static str, String)>,
        message: &M,
    ) -> Agreed<T, M> {
        let agreed = agree(&mut self.ranks, mine, call, facts, message);
        if let Err(failure) = &agreed.outcome {
            self.failed_on_all(failure);
        }
        agreed
    }

    /// The outcome of [`Self::agree_with`] without a message or facts.
    pub(super) fn agree<T>(&mut self, mine: Outcome<T>, call: &'static str) -> Outcome<T> {
        self.agree_with(mine, call, Vec::new(), &()).outcome
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
            let PartInput { grid, cells, corners } = part()?;
            let mut input = self.inputs.grid(grid, call)?.clone();
            if input.has_joined_part() {
                let tables = *input.grid.tables();
                input.grid = Arc::new(self.drawing.renderer().run(|| Grid::new(tables))?);
            }
            Ok((input, PartInput { grid, cells, corners }))
        });
        // Facts are not compared if this rank fails.
        let facts = mine.iter().map(|(_, part)| ("grid", format!("{:?}", part.grid))).collect();
        let (input, PartInput { grid: name, cells, corners }) = self.agree_with(mine, call, facts, &()).outcome?;
        let decomposition = Decomposition::with_corners(&mut self.ranks, &input.grid, &cells, corners.as_ref())?;
        let mut input = GridInput { decomposition: Some(Arc::new(decomposition)), ..input };
        if input.has_joined_part() {
            input.grid = Arc::new(input.grid.tables_only());
        }
        self.inputs.grids.insert(name.into(), input);
        self.ranks.trim_heap();
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
        let viewers = self.hear_viewers();
        let message = RootMessage { drawing: self.drawing.root_state(), viewers };
        let agreed = self.agree_with(mine, "icoray_execute", facts, &message);
        let RootMessage { drawing, viewers: sent } = agreed.root_message;
        let unreported = self.drawing.receive_root_state(drawing);
        let (stamp, mut script) = match agreed.outcome {
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
        self.drawing.refuse_if_disabled()?;
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
        let met = self.agree(Ok(()), call);
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
        let agreed = self.agree_with(mine, call, Vec::new(), &self.drawing.root_state());
        self.drawing.receive_root_state(agreed.root_message);
        agreed.outcome
    }
}

#[cfg(test)]
mod tests;
