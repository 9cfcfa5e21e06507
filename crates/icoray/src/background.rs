//! Renders frames one at a time on a thread of their own, while the model computes on.
//!
//! The model submits a copy of the fields that the scenes of a step need (`snapshot.rs`) and continues; the frames are
//! drawn from the copy, in order, and passed to the [`Writer`]. At most one step is in progress: submitting the next
//! one blocks the model until then. Memory is one copy of each field, and a model that submits pictures faster than
//! they are drawn is slowed. Tables of the grid are not copied; after [`Background::wait`] no thread reads them.
//!
//! Several ranks can render a frame together in the background ([`Background::over`]). Their drawing threads do not
//! call the transport: the model's thread moves messages in each call.

use crate::ranks::{MessagePump, Ranks};
use crate::render::{Rendered, Renderer};
use crossbeam_channel::{Receiver, Sender, TryRecvError, bounded};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_output::FrameReport;
use icoray_output::outcomes::Outcomes;
use icoray_output::writer::Writer;
use icoray_scene::name::Stamp;
use std::mem;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};
use std::time::Instant;

mod copies;
mod frame_inputs;
mod snapshot;

use copies::Copies;
pub use frame_inputs::{Accepted, Drawn, FrameInputs, FrameSetup};

/// The frames of a step, the copies that they are drawn from, and the cost of submitting them.
type Step = (Vec<FrameSetup>, Copies, Accepted);

/// A thread that draws. Dropping it finishes the frames that are being drawn; frames of several ranks fail instead, so
/// call [`Self::wait`] first.
#[derive(Debug)]
pub struct Background {
    renderer: Arc<Renderer>,
    writer: Arc<Writer>,
    /// `None` only while it is dropped, which ends the thread.
    steps: Option<Sender<Step>>,
    drawn: Receiver<(Vec<Drawn>, Copies)>,
    thread: Option<JoinHandle<()>>,
    /// Whether the thread has a step.
    is_busy: bool,
    /// Moves messages on, where several ranks draw.
    pump: Option<MessagePump>,
    /// Whether a step was submitted since the last [`Self::wait`]: equal on all ranks.
    is_under_way: bool,
    /// Memory of the last copies, while no frame is drawn from it.
    copies: Copies,
    outcomes: Outcomes<Drawn>,
}

impl Background {
    /// Starts a thread that draws with `renderer` and passes frames to `writer`.
    ///
    /// # Errors
    /// [`ErrorKind::Io`] when the thread cannot be started.
    pub fn new(renderer: Arc<Renderer>, writer: Arc<Writer>) -> Result<Self> {
        Self::over(&mut Ranks::alone(), renderer, writer)
    }

    /// As [`Self::new`] for ranks that render frames together; rank 0 passes them to its `writer`. Collective.
    ///
    /// # Errors
    /// The same on all ranks: [`ErrorKind::Io`] when a thread cannot be made, [`ErrorKind::Unsupported`] where the
    /// ranks' team has no messages of its own for this, [`ErrorKind::Mpi`] when the transport fails.
    pub fn over(ranks: &mut Ranks, renderer: Arc<Renderer>, writer: Arc<Writer>) -> Result<Self> {
        let (with, to) = (Arc::clone(&renderer), Arc::clone(&writer));
        let draw = move |ranks: &mut Ranks, setup: FrameSetup, copies: &Copies, accepted| {
            draw(&with, ranks, &to, setup, copies, accepted)
        };
        let (others, pump) = ranks.pumped()?.unzip();
        let made = Self::with(renderer, writer, others.unwrap_or_default(), pump, draw);
        ranks.collective(made)
    }

    /// Starts a thread that calls `draw` for each frame.
    fn with(
        renderer: Arc<Renderer>,
        writer: Arc<Writer>,
        mut ranks: Ranks,
        pump: Option<MessagePump>,
        mut draw: impl FnMut(&mut Ranks, FrameSetup, &Copies, Accepted) -> Result<(FrameReport, Option<Stamp>)>
        + Send
        + 'static,
    ) -> Result<Self> {
        let (steps, todo) = bounded::<Step>(1);
        let (done, drawn) = bounded(1);
        let work = move || {
            for (frames, copies, accepted) in todo {
                // The first frame that is drawn reports the cost of the step.
                let (mut cost, mut all) = (accepted, Vec::with_capacity(frames.len()));
                for setup in frames {
                    let is_first = all.is_empty();
                    let drawn = attempt(&mut ranks, setup, is_first, |ranks, setup| draw(ranks, setup, &copies, cost));
                    if drawn.result.is_ok() {
                        cost = Accepted::default();
                    }
                    all.push(drawn);
                }
                // The receiver is gone while `Background` is being dropped.
                let _ = done.send((all, copies));
            }
        };
        let thread = Builder::new().name("icoray-draw".into()).spawn(work);
        let thread = thread.map_err(|e| Error::new(ErrorKind::Io, format!("cannot start the drawing thread: {e}")))?;
        Ok(Background {
            renderer,
            writer,
            steps: Some(steps),
            drawn,
            thread: Some(thread),
            is_busy: false,
            pump,
            is_under_way: false,
            copies: Copies::default(),
            outcomes: Outcomes::default(),
        })
    }

    /// Submits the frames of a step: waits for the previous frames, copies those of their fields that the scenes need,
    /// each once by its name, on the renderer's threads, and returns; the fields may then change. A frame with an error
    /// is refused: its number and its error are appended to `refused`; it is left out and has no outcome. Without a
    /// frame that passes, nothing is copied.
    ///
    /// `ranks` are those of [`Self::over`], all of which submit the same frames together: collective, and all ranks
    /// refuse the same frames.
    ///
    /// The errors of a frame are those of [`Plan::new`](crate::plan::Plan::new), [`Writer::check`] and [`Fields::get`],
    /// and [`ErrorKind::Field`] where a scene needs heights and there are none.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`] when the thread is gone; [`ErrorKind::Mpi`] when ranks cannot be reached.
    ///
    /// [`Fields::get`]: crate::Fields::get
    pub fn submit(
        &mut self,
        ranks: &mut Ranks,
        frames: Vec<FrameInputs>,
        refused: &mut Vec<(usize, Error)>,
    ) -> Result<Accepted> {
        let mut frames: Vec<(usize, FrameInputs)> = frames.into_iter().enumerate().collect();
        retain(&mut frames, ranks, refused, FrameInputs::reduce_to_needed);
        let start = Instant::now();
        let waited_s = if self.is_under_way && !frames.is_empty() {
            self.wait();
            start.elapsed().as_secs_f64()
        } else {
            0.0
        };
        let (writer, writes) = (&self.writer, ranks.is_root());
        retain(&mut frames, ranks, refused, |FrameInputs { setup, .. }| {
            // After the wait: only then does the writer have the names of the previous frames.
            if writes {
                writer.check(&setup.scene.output, &setup.stamp, setup.scene.field())?;
            }
            Ok(())
        });
        if frames.is_empty() {
            refused.sort_by_key(|(number, _)| *number);
            return Ok(Accepted { waited_s, ..Accepted::default() });
        }
        let start = Instant::now();
        self.copies.take(ranks, &self.renderer, &frames)?;
        let copy_s = start.elapsed().as_secs_f64();
        let accepted = Accepted { waited_s, copy_s, bytes_copied: self.copies.bytes() };
        let copies = &self.copies;
        retain(&mut frames, ranks, refused, |frame| copies.check_gathered(&frame.setup));
        refused.sort_by_key(|(number, _)| *number);
        let gone = || Error::new(ErrorKind::Internal, "the drawing thread is gone");
        let is_there = self.thread.as_ref().is_some_and(|thread| !thread.is_finished());
        ranks.collective(if is_there { Ok(()) } else { Err(gone()) })?;
        if frames.is_empty() {
            return Ok(accepted);
        }
        let setups = frames.into_iter().map(|(_, frame)| frame.setup).collect();
        let step = (setups, mem::take(&mut self.copies), accepted);
        self.is_busy = self.steps.as_ref().is_some_and(|steps| steps.send(step).is_ok());
        self.is_under_way = self.is_busy;
        if self.is_busy { Ok(accepted) } else { Err(gone()) }
    }

    /// Moves messages between ranks on while frames are being drawn; takes half a millisecond at most, and waits for no
    /// rank. Not collective. The more often all ranks call it, the sooner frames are finished.
    pub fn pump(&mut self) {
        if let (Some(pump), true) = (&mut self.pump, self.is_under_way) {
            pump.pump();
        }
    }

    /// Whether submitted frames have not been waited for: equal on all ranks.
    pub fn is_under_way(&self) -> bool {
        self.is_under_way
    }

    /// The outcomes of frames rendered since the last call.
    pub fn take_outcomes(&mut self) -> Outcomes<Drawn> {
        if self.is_busy {
            self.take_in(self.drawn.try_recv());
        }
        mem::take(&mut self.outcomes)
    }

    /// Waits until nothing is being drawn and all frames are with the writer: then grid, layers and renderer are not in
    /// use. The writer may still have to write them ([`Writer::wait`]). Collective, unless ranks can be reached no
    /// more: then frames that need them fail.
    pub fn wait(&mut self) {
        if !mem::take(&mut self.is_under_way) {
            return;
        }
        if let Some(mut pump) = self.pump.take() {
            pump.finish(|| {
                self.take_in(self.drawn.try_recv());
                !self.is_busy
            });
            self.pump = Some(pump);
        } else {
            self.take_in(self.drawn.recv().map_err(TryRecvError::from));
        }
    }

    fn take_in(&mut self, step: std::result::Result<(Vec<Drawn>, Copies), TryRecvError>) {
        match step {
            Ok((drawn, copies)) => {
                drawn.into_iter().for_each(|drawn| self.outcomes.push(drawn));
                self.copies = copies;
                self.is_busy = false;
                // Messages of this rank may still be in flight.
                self.is_under_way &= self.pump.is_some();
            }
            // The thread has ended; the next submission reports that.
            Err(TryRecvError::Disconnected) => self.is_busy = false,
            Err(TryRecvError::Empty) => {}
        }
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        self.steps = None;
        // Its messages are no longer moved.
        self.pump.iter_mut().for_each(MessagePump::cut);
        if let Some(thread) = self.thread.take() {
            // A panic in a frame is one of its outcomes; no receiver is left for another one.
            let _ = thread.join();
        }
    }
}

/// Retains the frames that pass `check` on all ranks; appends the numbers and errors of the others to `refused`.
/// Collective.
fn retain<'f>(
    frames: &mut Vec<(usize, FrameInputs<'f>)>,
    ranks: &mut Ranks,
    refused: &mut Vec<(usize, Error)>,
    mut check: impl FnMut(&mut FrameInputs<'f>) -> Result<()>,
) {
    frames.retain_mut(|(number, frame)| {
        let checked = ranks.collective_work(|| check(frame)).map_err(|error| refused.push((*number, error)));
        checked.is_ok()
    });
}

/// Calls `draw` for a frame and sends an error to the other ranks.
fn attempt(
    ranks: &mut Ranks,
    setup: FrameSetup,
    is_first: bool,
    draw: impl FnOnce(&mut Ranks, FrameSetup) -> Result<(FrameReport, Option<Stamp>)>,
) -> Drawn {
    let (stamp, view, mut has_panicked) = (setup.stamp.clone(), setup.view.clone(), true);
    ranks.begin_frame();
    let drawn = Error::of_panics(|| {
        let drawn = draw(ranks, setup);
        has_panicked = false;
        drawn
    });
    let (result, dropped) = match drawn {
        Ok((report, dropped)) => (Ok(report), dropped),
        Err(error) => {
            let (rank, size) = (ranks.rank(), ranks.size());
            ranks.break_off(&if has_panicked { error.clone().of_rank(rank, size) } else { error.clone() });
            (Err(error), None)
        }
    };
    Drawn { stamp, view, is_first, result, dropped, is_of_all: !has_panicked }
}

/// Draws a frame, or this rank's tiles of it, and submits it to the writer; returns its report and the stamp of the
/// frame that the writer dropped for it.
fn draw(
    renderer: &Renderer,
    ranks: &mut Ranks,
    writer: &Writer,
    setup: FrameSetup,
    copies: &Copies,
    accepted: Accepted,
) -> Result<(FrameReport, Option<Stamp>)> {
    let FrameSetup { scene, grid, layers, .. } = &setup;
    let mut rendered = match copies.gathered(&setup) {
        Some(gathered) => renderer.render_gathered(Instant::now(), ranks, scene, grid, layers, gathered),
        None => renderer.render_over(ranks, scene, grid, layers, copies.fields()),
    }?;
    let report = rendered.report_mut();
    (report.timing.waited_s, report.timing.copy_s) = (accepted.waited_s, accepted.copy_s);
    report.bytes_copied = accepted.bytes_copied;
    let report = report.clone();
    let Rendered::Here(mut frame) = rendered else { return Ok((report, None)) };
    setup.describe(&mut frame);
    let submitted = writer.submit_unseen(frame, setup.scene.output.clone(), setup.stamp);
    Ok((report, submitted.dropped))
}

#[cfg(test)]
mod tests;
