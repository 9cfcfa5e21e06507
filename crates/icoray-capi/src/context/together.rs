//! Calls that all ranks make together.
//!
//! Whatever has gone wrong on a rank, it comes to the agreement at the head of each such call and says so: a context that is
//! broken or switched off, an argument that is wrong, a field that is missing. So nobody waits for a rank that has returned.

use super::{Choice, Context, Spread};
use crate::boundary::{Failure, Outcome, caught};
use crate::ranks::{Said, agree};
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::{Held, PartCells, Ranks, Script};
use std::sync::Arc;

impl Context {
    /// Whether other ranks make some of the calls together with this one.
    pub fn is_shared(&self) -> bool {
        !self.ranks.is_alone()
    }

    /// The context draws with these from now on. Collective.
    pub fn join(&mut self, mut ranks: Ranks) -> Outcome<()> {
        let joined = self.drawing.join(&mut ranks);
        self.ranks = ranks;
        joined
    }

    /// What must be the same in the config of all ranks.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        vec![("async_render", i32::from(self.drawing.is_async()).to_string())]
    }

    /// What all ranks make of their outcomes of `call`, as [`agree`].
    pub(super) fn agree<T>(
        &mut self,
        mine: Outcome<T>,
        call: &'static str,
        facts: Vec<(&'static str, String)>,
        value: &[u8],
    ) -> (Outcome<T>, Said) {
        let (agreed, said) = agree(&mut self.ranks, mine, call, facts, value);
        if let Err(failure) = &agreed {
            self.failed_on_all(failure);
        }
        (agreed, said)
    }

    /// A failure that all ranks have, each in this same call.
    pub(super) fn failed_on_all(&mut self, failure: &Failure) {
        self.is_over |= failure.status == icoray_status::ICORAY_ERR_INTERNAL;
    }

    /// Agrees with the other ranks on whose the cells of a grid are; `said` has its name and what the model says of this
    /// rank's. A lone process takes the same way.
    pub fn set_part<'a>(&mut self, said: impl FnOnce() -> Outcome<(&'a str, PartCells<'a>)>) -> Outcome<()> {
        let call = "icoray_part_set";
        let mine = caught(|| {
            self.refuse_if_poisoned()?;
            let (name, cells) = said()?;
            let Spread { grid, .. } = self.inputs.grid(name, call)?;
            Ok((name, grid.clone(), cells))
        });
        // Never compared where this rank refuses.
        let facts = mine.iter().map(|(name, ..)| ("grid", format!("{name:?}"))).collect();
        let (agreed, _) = self.agree(mine, call, facts, &[]);
        let (name, grid, cells) = agreed?;
        let held = Held::new(&mut self.ranks, &grid, &cells)?;
        self.inputs.grids.insert(name.into(), Spread { grid, held: Some(Arc::new(held)) });
        Ok(())
    }

    pub(super) fn execute_together(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let mut facts = match &stamp {
            Ok(stamp) => vec![("step", stamp.step.to_string()), ("time_s", stamp.time_s.to_string())],
            // Never compared: this rank refuses.
            Err(_) => Vec::new(),
        };
        if let (Ok(_), Choice::Script(script)) = (&stamp, &self.scene)
            && script.lacks_field()
        {
            let first = self.inputs.first.as_deref().unwrap_or_default();
            facts.push(("first field", format!("{first:?}")));
        }
        let mine = caught(|| self.ready(stamp));
        let value = self.drawing.said();
        let (agreed, said) = self.agree(mine, "icoray_execute", facts, &value);
        let untold = self.drawing.heard(&said);
        let (stamp, script) = match agreed {
            Ok(ready) => ready,
            Err(failure) => {
                self.drawing.picture_failed(&failure);
                return Err(failure);
            }
        };
        // All ranks are here: what they send each other arrives at once.
        self.drawing.pump();
        self.draw_step(script.as_deref(), &stamp)?;
        if let Some(untold) = untold {
            self.drawing.told();
            return Err(untold);
        }
        Ok(())
    }

    /// What is drawn when, or why this rank cannot.
    fn ready(&mut self, stamp: Outcome<Stamp>) -> Outcome<(Stamp, Option<Arc<Script>>)> {
        self.refuse_if_poisoned()?;
        let stamp = stamp?;
        self.drawing.collect();
        self.drawing.tell_of_this_rank()?;
        self.drawing.refuse_if_off()?;
        let script = self.script()?;
        self.point_out_old_levels(script.as_deref(), &stamp);
        Ok((stamp, script))
    }

    /// Waits until no frame is rendered in the background. Over several ranks that takes all of them: they agree first that
    /// all are in the same `call`, as a rank that is elsewhere would be waited for.
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

    pub(super) fn wait_together(&mut self) -> Outcome<()> {
        self.finish_frames("icoray_wait")?;
        let mine = caught(|| {
            self.refuse_if_poisoned()?;
            self.drawing.finish()
        });
        self.agree_on_end(mine, "icoray_wait")
    }

    /// Waits for the last time. Where MPI was finalised before, this rank is on its own.
    pub(super) fn finish_together(&mut self) -> Outcome<()> {
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
        let value = self.drawing.said();
        let (agreed, said) = self.agree(mine, call, Vec::new(), &value);
        self.drawing.heard(&said);
        agreed
    }
}

#[cfg(test)]
mod tests;
