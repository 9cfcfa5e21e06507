//! Frames that several ranks render. Rank 0 has the outcomes of the writer and decides whether frames are rendered.

use super::Drawing;
use crate::boundary::{Failure, Outcome};
use crate::host::without_signals;
use icoray_core::{Background, Ranks};
use serde::{Deserialize, Serialize};
use std::thread::current;

/// What all ranks take over from rank 0, which has the outcomes of files.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct RootState {
    /// Whether frames are rendered; `None` if rank 0 cannot be reached.
    is_on: Option<bool>,
    /// The failure of an earlier frame.
    unreported: Option<Failure>,
}

impl Drawing {
    /// The state that rank 0 sends to the others.
    pub fn root_state(&self) -> RootState {
        RootState { is_on: Some(self.policy.is_on()), unreported: self.unreported.clone() }
    }

    /// Takes over the state of rank 0; returns the failure of an earlier frame, which all ranks return.
    pub fn receive_root_state(&mut self, state: RootState) -> Option<Failure> {
        self.is_on_for_all = state.is_on.or(self.is_on_for_all);
        state.unreported
    }

    /// Clears the failure that this call returns on all ranks.
    pub fn clear_unreported(&mut self) {
        if self.is_root {
            self.unreported = None;
        }
    }

    /// Returns the failure of an earlier frame that only this rank had.
    pub fn take_unreported_of_rank(&mut self) -> Outcome<()> {
        if self.is_root { Ok(()) } else { self.take_unreported() }
    }

    /// Sets the ranks to render with. Collective.
    pub fn join(&mut self, ranks: &mut Ranks) -> Outcome<()> {
        if self.is_async { self.render_in_background(ranks) } else { Ok(()) }
    }

    /// Renders frames in the background from now on. Collective; the outcome is equal on all ranks.
    pub fn render_in_background(&mut self, ranks: &mut Ranks) -> Outcome<()> {
        if self.background.is_none() {
            let (renderer, writer) = (self.renderer.clone(), self.writer.clone());
            self.background = Some(without_signals(|| match ranks.is_alone() {
                true => Background::new(renderer, writer),
                false => Background::over(ranks, renderer, writer),
            })?);
        }
        Ok(())
    }

    /// Progresses the messages of frames in the background, on the thread on which MPI may be called.
    pub fn pump(&mut self) {
        if let Some(background) = self.background.as_mut().filter(|_| current().id() == self.opening_thread) {
            background.pump();
        }
    }

    /// Whether submitted frames were not waited for: equal on all ranks.
    pub fn is_under_way(&self) -> bool {
        self.background.as_ref().is_some_and(Background::is_under_way)
    }
}
