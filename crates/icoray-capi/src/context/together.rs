//! Calls that all ranks make together.
//!
//! Whatever has gone wrong on a rank, it comes to the agreement at the head of each such call and says so: a context that is
//! broken or switched off, an argument that is wrong, a field that is missing. So nobody waits for a rank that has returned.

use super::{Choice, Context, Spread, known};
use crate::boundary::{Outcome, caught};
use crate::ranks::agree;
use icoray_core::output::Stamp;
use icoray_core::{Held, PartCells, Ranks, Script};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

impl Context {
    /// Whether other ranks make some of the calls together with this one.
    pub fn is_shared(&self) -> bool {
        !self.ranks.is_alone()
    }

    /// The context draws with these from now on.
    pub fn join(&mut self, ranks: Ranks) {
        self.ranks = ranks;
    }

    /// Agrees with the other ranks on whose the cells of a grid are; `said` has its name and what the model says of this
    /// rank's. A lone process takes the same way.
    pub fn set_part<'a>(&mut self, said: impl FnOnce() -> Outcome<(&'a str, PartCells<'a>)>) -> Outcome<()> {
        let call = "icoray_part_set";
        let mine = caught(|| {
            self.refuse_if_poisoned()?;
            let (name, cells) = said()?;
            let Spread { grid, .. } = known(&self.inputs.grids, name, "grid", call, "icoray_grid_set")?;
            Ok((name, grid.clone(), cells))
        });
        // Never compared where this rank refuses.
        let facts = mine.iter().map(|(name, ..)| ("grid", format!("{name:?}"))).collect();
        let (agreed, _) = agree(&mut self.ranks, mine, call, facts, &[]);
        let (name, grid, cells) = agreed?;
        let held = Held::new(&mut self.ranks, &grid, &cells)?;
        self.inputs.grids.insert(name.into(), Spread { grid, held: Some(Arc::new(held)) });
        Ok(())
    }

    pub(super) fn execute_together(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let what = ("scene", self.scene.fingerprint());
        let facts = match &stamp {
            Ok(stamp) => vec![("step", stamp.step.to_string()), ("time_s", stamp.time_s.to_string()), what],
            // Never compared: this rank refuses.
            Err(_) => vec![what],
        };
        let mine = caught(|| self.ready(stamp));
        let value = self.drawing.said();
        let (agreed, said) = agree(&mut self.ranks, mine, "icoray_execute", facts, &value);
        let untold = self.drawing.heard(&said);
        let (stamp, script) = match agreed {
            Ok(ready) => ready,
            Err(failure) => {
                self.drawing.picture_failed(&failure);
                return Err(failure);
            }
        };
        self.draw_step(script.as_deref(), &stamp)?;
        self.drawing.told();
        untold.map_or(Ok(()), Err)
    }

    /// What is drawn when, or why this rank cannot.
    fn ready(&mut self, stamp: Outcome<Stamp>) -> Outcome<(Stamp, Option<Arc<Script>>)> {
        self.refuse_if_poisoned()?;
        let stamp = stamp?;
        self.drawing.collect();
        self.drawing.refuse_if_off()?;
        Ok((stamp, self.script()?))
    }

    pub(super) fn wait_together(&mut self) -> Outcome<()> {
        let mine = caught(|| {
            self.refuse_if_poisoned()?;
            self.drawing.finish()
        });
        self.agree_on_end(mine, "icoray_wait")
    }

    /// Waits for the last time. Where MPI was finalised before, this rank is on its own.
    pub(super) fn finish_together(&mut self) -> Outcome<()> {
        let outcome = caught(|| self.drawing.finish());
        let mine = if self.poison.is_some() { Ok(()) } else { outcome };
        if self.ranks.is_gone() {
            return mine;
        }
        self.agree_on_end(mine, "icoray_close")
    }

    fn agree_on_end(&mut self, mine: Outcome<()>, call: &'static str) -> Outcome<()> {
        let value = self.drawing.said();
        let (agreed, said) = agree(&mut self.ranks, mine, call, Vec::new(), &value);
        self.drawing.heard(&said);
        agreed
    }
}

impl Choice {
    /// The same for scenes that say the same, whatever their files look like.
    fn fingerprint(&self) -> String {
        match self {
            Choice::Open => "that was not given".into(),
            Choice::Nothing => "that is empty".into(),
            Choice::Script(script) => {
                // The hasher has the same keys in every process, and all ranks run the same library.
                let mut hasher = DefaultHasher::new();
                format!("{script:?}").hash(&mut hasher);
                let fields = script.model_fields();
                format!("{:?} with hash {:016x}", fields.join(", "), hasher.finish())
            }
        }
    }
}
