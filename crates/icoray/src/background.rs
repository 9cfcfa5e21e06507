//! Frames drawn by a thread of their own, one at a time, while the model computes on.
//!
//! The model hands over a copy of the fields that the scenes of a step need ([`Snapshot`]) and goes on; the frames are drawn
//! from the copy, in their order, and passed to the [`Writer`]. No more than one step is on its way to being drawn: the next
//! one waits for it, with the model, so that memory is one copy of each field and a model that asks for more pictures than can be drawn is slowed, not
//! stopped. Tables of the grid are not copied; [`Background::wait`] says when nobody reads them.

use crate::description::Description;
use crate::error::{Error, ErrorKind, Result};
use crate::fields::Fields;
use crate::frame::FrameReport;
use crate::grid::Grid;
use crate::layers::Layers;
use crate::output::{Outcome, Outcomes, Stamp, Writer};
use crate::plan::Plan;
use crate::render::Renderer;
use crate::scene::Scene;
use crate::snapshot::Snapshot;
use crossbeam_channel::{Receiver, Sender, bounded};
use std::mem;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};
use std::time::Instant;

/// What is to be drawn, but for the fields.
#[derive(Debug, Clone)]
pub struct Job {
    /// What to draw and how.
    pub scene: Arc<Scene>,
    /// The grid.
    pub grid: Arc<Grid<'static>>,
    /// The layers.
    pub layers: Arc<Layers>,
    /// When it is.
    pub stamp: Stamp,
    /// What the field is called.
    pub description: Description,
    /// What the other fields that are shown are called, by name.
    pub descriptions: Vec<(String, Description)>,
    /// What else is written into the picture's file: key and text.
    pub notes: Vec<(&'static str, String)>,
}

/// What handing over frames cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Accepted {
    /// Seconds spent waiting for the frames before.
    pub waited_s: f64,
    /// Seconds of copying the fields.
    pub copy_s: f64,
    /// Bytes copied.
    pub bytes_copied: u64,
}

/// What became of a frame that was handed over.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Which frame it was.
    pub stamp: Stamp,
    /// Whether it is the first one of those that were handed over together.
    pub is_first: bool,
    /// What it cost and met, or why it was not drawn. `write_s` is 0: it has yet to be written, and what comes of that is
    /// an outcome of the [`Writer`].
    pub result: Result<FrameReport>,
    /// The frame that the writer dropped for this one.
    pub dropped: Option<Stamp>,
}

impl Outcome for Drawn {
    fn error(&self) -> Option<&Error> {
        self.result.as_ref().err()
    }
}

/// The jobs of a step, what they are drawn from, and what handing them over cost.
type Step = (Vec<Job>, Snapshot, Accepted);

/// A thread that draws. Dropping it finishes the frames that are being drawn.
#[derive(Debug)]
pub struct Background {
    renderer: Arc<Renderer>,
    writer: Arc<Writer>,
    /// `None` only while it is dropped, which ends the thread.
    jobs: Option<Sender<Step>>,
    drawn: Receiver<(Vec<Drawn>, Snapshot)>,
    thread: Option<JoinHandle<()>>,
    is_busy: bool,
    /// The last snapshot's memory, while no frame is drawn from it.
    spare: Snapshot,
    outcomes: Outcomes<Drawn>,
}

impl Background {
    /// A thread that draws with `renderer` and passes frames to `writer`.
    ///
    /// # Errors
    /// [`ErrorKind::Io`] when the thread cannot be made.
    pub fn new(renderer: Arc<Renderer>, writer: Arc<Writer>) -> Result<Self> {
        let (with, to) = (Arc::clone(&renderer), Arc::clone(&writer));
        Self::with(renderer, writer, move |job, snapshot, accepted| draw(&with, &to, job, snapshot, accepted))
    }

    /// A thread that does `draw` with each frame.
    fn with(
        renderer: Arc<Renderer>,
        writer: Arc<Writer>,
        mut draw: impl FnMut(Job, &Snapshot, Accepted) -> Result<(FrameReport, Option<Stamp>)> + Send + 'static,
    ) -> Result<Self> {
        let (jobs, todo) = bounded::<Step>(1);
        let (done, drawn) = bounded(1);
        let work = move || {
            for (jobs, snapshot, accepted) in todo {
                // Costs are said once, by the first frame that is drawn.
                let (mut cost, mut all) = (accepted, Vec::with_capacity(jobs.len()));
                for job in jobs {
                    let stamp = job.stamp.clone();
                    let (result, dropped) = match Error::of_panics(|| draw(job, &snapshot, cost)) {
                        Ok((report, dropped)) => (Ok(report), dropped),
                        Err(e) => (Err(e), None),
                    };
                    if result.is_ok() {
                        cost = Accepted::default();
                    }
                    all.push(Drawn { stamp, is_first: all.is_empty(), result, dropped });
                }
                // Nobody listens any more while the other end is being dropped.
                let _ = done.send((all, snapshot));
            }
        };
        let thread = Builder::new().name("icoray-draw".into()).spawn(work);
        let thread =
            thread.map_err(|e| Error::new(ErrorKind::Io, format!("cannot make the drawing thread: {e}")))?;
        let (spare, outcomes) = (Snapshot::empty(), Outcomes::default());
        let (jobs, thread) = (Some(jobs), Some(thread));
        Ok(Background { renderer, writer, jobs, drawn, thread, is_busy: false, spare, outcomes })
    }

    /// Hands over a frame, as [`Self::submit_all`] does.
    ///
    /// # Errors
    /// What is wrong with the job.
    pub fn submit<'f>(&mut self, job: Job, fields: impl Into<Fields<'f>>) -> Result<Accepted> {
        let mut refused = Vec::new();
        let accepted = self.submit_all(vec![job], fields, &mut refused)?;
        refused.pop().map_or(Ok(accepted), |(_, error)| Err(error))
    }

    /// Hands over the frames of a step: waits for those before, copies those of `fields` that any of the scenes needs on the
    /// renderer's threads, each once, and returns; they may then change. What is wrong with a job itself goes to `refused`
    /// now, with the job's number: that frame is left out and has no outcome. Nothing is copied where none is left.
    ///
    /// [`Plan::new`], [`Writer::check`] and [`Fields::get`] say what can be wrong; [`ErrorKind::Field`] where a scene needs
    /// heights and there are none.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`] when the thread is gone.
    pub fn submit_all<'f>(
        &mut self,
        jobs: Vec<Job>,
        fields: impl Into<Fields<'f>>,
        refused: &mut Vec<(usize, Error)>,
    ) -> Result<Accepted> {
        let (fields, mut needed, mut good) = (fields.into(), Fields::default(), Vec::new());
        for (number, job) in jobs.into_iter().enumerate() {
            match checked(&job, &fields) {
                Ok(its) => good.push((number, job, its)),
                Err(error) => refused.push((number, error)),
            }
        }
        let start = Instant::now();
        let waited_s = if self.is_busy && !good.is_empty() {
            self.wait();
            start.elapsed().as_secs_f64()
        } else {
            0.0
        };
        let mut jobs: Vec<Job> = Vec::new();
        for (number, job, its) in good {
            // After the wait: names of the frames before are known to the writer only now.
            match self.writer.check(&job.scene.output, &job.stamp, &job.scene.field) {
                Ok(_) => {
                    needed = needed.with(its);
                    jobs.push(job);
                }
                Err(error) => refused.push((number, error)),
            }
        }
        refused.sort_by_key(|(number, _)| *number);
        if jobs.is_empty() {
            return Ok(Accepted { waited_s, ..Accepted::default() });
        }
        let start = Instant::now();
        self.spare.take(needed, &self.renderer);
        let copy_s = start.elapsed().as_secs_f64();
        let accepted = Accepted { waited_s, copy_s, bytes_copied: self.spare.bytes() };
        let snapshot = mem::replace(&mut self.spare, Snapshot::empty());
        let sent = self.jobs.as_ref().is_some_and(|all| all.send((jobs, snapshot, accepted)).is_ok());
        self.is_busy = sent;
        if sent { Ok(accepted) } else { Err(Error::new(ErrorKind::Internal, "the drawing thread is gone")) }
    }

    /// What became of frames since this was asked last, those that are drawn.
    pub fn take_outcomes(&mut self) -> Outcomes<Drawn> {
        if let Ok(drawn) = self.drawn.try_recv() {
            self.keep(drawn);
        }
        mem::take(&mut self.outcomes)
    }

    /// Waits until nothing is being drawn and all frames are with the writer: then grid, layers and renderer are not in use.
    /// They may yet have to be written ([`Writer::wait`]).
    pub fn wait(&mut self) {
        if !self.is_busy {
            return;
        }
        match self.drawn.recv() {
            Ok(drawn) => self.keep(drawn),
            // The thread is gone; the next submit says so.
            Err(_) => self.is_busy = false,
        }
    }

    fn keep(&mut self, (drawn, snapshot): (Vec<Drawn>, Snapshot)) {
        drawn.into_iter().for_each(|drawn| self.outcomes.push(drawn));
        self.spare = snapshot;
        self.is_busy = false;
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // Panics are outcomes; there is nobody left to tell of another one.
            let _ = thread.join();
        }
    }
}

/// The fields that a job needs, where it can be drawn of `fields`.
fn checked<'f>(job: &Job, fields: &Fields<'f>) -> Result<Fields<'f>> {
    let needed = fields.needed_by(&job.scene)?;
    if let Some(first) = needed.each().next() {
        Plan::new(&job.scene, &job.grid, &job.layers, first)?;
    }
    Ok(needed)
}

/// Draws a frame and passes it on; returns its report and the frame that was dropped for it.
fn draw(
    renderer: &Renderer,
    writer: &Writer,
    job: Job,
    snapshot: &Snapshot,
    accepted: Accepted,
) -> Result<(FrameReport, Option<Stamp>)> {
    let Job { scene, grid, layers, stamp, description, descriptions, notes } = job;
    let fields = snapshot.fields()?.needed_by(&scene)?;
    let mut frame = renderer.render(&scene, &grid, &layers, fields)?;
    (frame.description, frame.descriptions) = (description, descriptions);
    frame.notes.extend(notes);
    frame.report.waited_s = accepted.waited_s;
    frame.report.copy_s = accepted.copy_s;
    frame.report.bytes_copied = accepted.bytes_copied;
    let report = frame.report.clone();
    let submitted = writer.submit_unseen(frame, scene.output.clone(), stamp);
    Ok((report, submitted.dropped))
}

#[cfg(test)]
mod tests;
