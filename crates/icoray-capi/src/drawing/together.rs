//! Frames that several ranks draw: rank 0 has the writer's news and the say whether frames are still drawn.

use super::{Drawing, notes};
use crate::boundary::{Failure, Outcome};
use crate::context::Subject;
use crate::ranks::Said;
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::{Held, Ranks, Rendered};

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

    /// The failure of a frame before is told by this call.
    pub fn told(&mut self) {
        self.untold = None;
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
        let rendered = match held.as_deref() {
            Some(Held::Columns(columns)) => {
                draws.render_columns(ranks, &scene, &grid, columns, &layers, fields)
            }
            Some(Held::Part(part)) => draws.render_over(ranks, &scene, &grid, Some(part), &layers, fields),
            None => draws.render_over(ranks, &scene, &grid, None, &layers, fields),
        };
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
