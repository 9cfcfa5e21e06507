//! Frames that several ranks draw: rank 0 has the writer's news and the say whether frames are still drawn.

use super::Drawing;
use crate::boundary::{Failure, Outcome};
use crate::context::Subject;
use crate::ranks::Said;
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::{Backend, Frame, Held, Ranks, Rendered, Scene};
use std::time::Instant;

impl Drawing {
    pub fn refuse_if_off(&self) -> Outcome<()> {
        self.policy.refuse_if_off()
    }

    /// Whether the frame's files may be made, known before the first ray. Only who writes need ask.
    pub fn check_names(&self, scene: &Scene, stamp: &Stamp) -> Outcome<()> {
        self.writer.check(&scene.output, stamp, &scene.field)?;
        Ok(())
    }

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

    /// A call that failed on all.
    pub fn fail_together(&mut self, failure: &Failure) {
        use icoray_status::{ICORAY_ERR_DISABLED, ICORAY_ERR_EXISTS};
        if ![ICORAY_ERR_DISABLED, ICORAY_ERR_EXISTS].contains(&failure.status) {
            self.fail(failure);
        }
    }

    /// Draws what is this rank's of a frame whose call came at `start`; rank 0 hands it to the writer. The outcome is the same
    /// on all.
    pub fn draw_together(
        &mut self,
        ranks: &mut Ranks,
        stamp: Stamp,
        subject: Subject,
        start: Instant,
    ) -> Outcome<()> {
        let Subject { scene, grid, held, layers, fields, description, descriptions } = subject;
        self.devices.is_asked = scene.backend == Backend::Gpu;
        let draws = &self.renderer;
        let rendered = match held.as_deref() {
            Some(Held::Columns(columns)) => {
                draws.render_columns(ranks, &scene, &grid, columns, &layers, fields)
            }
            Some(Held::Part(part)) => draws.render_over(ranks, &scene, &grid, Some(part), &layers, fields),
            None => draws.render_over(ranks, &scene, &grid, None, &layers, fields),
        };
        let outcome = rendered.map(|rendered| match rendered {
            Rendered::Here(frame) => {
                self.hand_on(Frame { description, descriptions, ..frame }, &scene, stamp);
            }
            Rendered::AtRoot(report) => {
                self.devices.tell(&stamp, &report, &self.log);
                self.describe(&stamp, &report);
                self.last = Some((stamp, report));
            }
        });
        let host_s = start.elapsed().as_secs_f64();
        if outcome.is_ok() {
            self.totals.last_host_s = host_s;
        }
        Ok(outcome?)
    }
}
