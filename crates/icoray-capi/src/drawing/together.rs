//! Frames that several ranks draw: rank 0 has the writer's news and the say whether frames are still drawn.

use super::{Drawing, notes};
use crate::boundary::{Failure, Outcome};
use crate::context::Subject;
use crate::host::without_signals;
use crate::ranks::Said;
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::{Background, Ranks, Rendered};
use std::thread::current;

impl Drawing {
    /// What rank 0 tells the others: whether frames are still drawn, and the failure of a frame before.
    pub fn said(&self) -> Vec<u8> {
        let mut said = vec![u8::from(self.policy.is_on())];
        if let Some(failure) = &self.untold {
            said.extend((failure.status as i32).to_le_bytes());
            said.extend(failure.message.as_bytes());
        }
        said
    }

    /// Takes in what rank 0 said; returns the failure of a frame before, which is due to be told on all.
    pub fn heard(&mut self, said: &Said) -> Option<Failure> {
        let (is_on, failure) = said.0.split_first()?;
        self.is_on_for_all = Some(*is_on == 1);
        let (status, message) = failure.split_first_chunk::<4>()?;
        let status = icoray_status::of_number(i32::from_le_bytes(*status));
        Some(Failure::new(status, String::from_utf8_lossy(message)))
    }

    /// The failure of a frame before that rank 0 has is told by this call.
    pub fn told(&mut self) {
        if self.is_root {
            self.untold = None;
        }
    }

    /// The failure of a frame before of which only this rank knows.
    pub fn tell_of_this_rank(&mut self) -> Outcome<()> {
        if self.is_root { Ok(()) } else { self.tell() }
    }

    /// The ranks that draw with this one. Collective.
    pub fn join(&mut self, ranks: &mut Ranks) -> Outcome<()> {
        if self.is_async && self.background.is_none() {
            let (renderer, writer) = (self.renderer.clone(), self.writer.clone());
            self.background = Some(without_signals(|| Background::over(ranks, renderer, writer))?);
        }
        Ok(())
    }

    /// Moves messages of frames in the background on, where the transport may be called on this thread.
    pub fn pump(&mut self) {
        if let Some(background) = self.background.as_mut().filter(|_| current().id() == self.home) {
            background.pump();
        }
    }

    /// Whether frames were handed to the background that were not waited for: the same on all ranks.
    pub fn is_under_way(&self) -> bool {
        self.background.as_ref().is_some_and(Background::is_under_way)
    }

    /// Draws what is this rank's of a frame. The outcome is the same on all.
    pub(super) fn draw_together(
        &mut self,
        ranks: &mut Ranks,
        stamp: &Stamp,
        subject: Subject,
    ) -> Outcome<()> {
        let Subject { view, scene, grid, held, layers, fields, description, descriptions } = subject;
        let draws = &self.renderer;
        let rendered = draws.render_held(ranks, &scene, &grid, held.as_deref(), &layers, fields);
        match rendered? {
            Rendered::Here(mut frame) => {
                (frame.description, frame.descriptions) = (description, descriptions);
                frame.notes.extend(notes(view));
                self.hand_on(frame, &scene, stamp);
            }
            Rendered::AtRoot(report) => {
                self.devices.tell(stamp, &report, &self.log);
                self.describe(stamp, &report);
                self.drew(stamp, report);
            }
        }
        Ok(())
    }
}
