//! Pictures are encoded and written by a thread of their own, so that a model computes on meanwhile.
//!
//! Frames wait in a short queue: encoding is faster than drawing but for a slow disk. When the queue is full the caller
//! chooses whether to wait or to lose the oldest waiting frame. What became of each frame is kept until it is asked for;
//! no failure of one frame, a panic of an encoder included, keeps the next one from being tried.
//!
//! Queue, names and outcomes are one state behind one lock, which is never held while something is written.

use super::outcomes::{Outcome, Outcomes};
use super::{Existing, FrameNames, Output, Stamp, atomic, io_error, report, write_frame_with};
use crate::error::{Error, ErrorKind, Result};
use crate::frame::Frame;
use std::collections::VecDeque;
use std::mem;
use std::path::{Path, PathBuf, absolute};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Instant;

/// What happens to a frame that finds the queue full.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum WhenFull {
    /// [`Writer::submit`] waits for room: every picture is written, and a slow disk slows the caller.
    #[default]
    Block,
    /// The oldest frame that waits is dropped: the caller never waits, and a slow disk costs pictures.
    DropOldest,
}

/// How a [`Writer`] writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WriterOptions {
    /// Where pictures and `report.csv` go, made when missing. A relative one is meant from where the process is when the
    /// writer is made, wherever it goes later.
    pub directory: PathBuf,
    /// What is done with files that are there already.
    pub existing: Existing,
    /// How many frames may wait, at least 1; the one that is being written does not count.
    pub queue: usize,
    /// What is done when that many wait.
    pub when_full: WhenFull,
}

impl WriterOptions {
    /// Into `directory`, with two frames waiting at most, nothing overwritten and nothing dropped.
    pub fn new(directory: impl Into<PathBuf>) -> Self {
        let (existing, when_full) = (Existing::default(), WhenFull::default());
        WriterOptions { directory: directory.into(), existing, queue: 2, when_full }
    }
}

/// What became of a frame.
#[derive(Debug, Clone)]
pub struct Written {
    /// Which frame it was.
    pub stamp: Stamp,
    /// The picture's path, or why it, the map of its errors or its line of the report could not be written.
    pub result: Result<PathBuf>,
    /// Seconds of encoding and disk.
    pub write_s: f64,
}

impl Outcome for Written {
    fn error(&self) -> Option<&Error> {
        self.result.as_ref().err()
    }
}

/// What handing over a frame cost.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Submitted {
    /// Seconds spent waiting for room in the queue.
    pub waited_s: f64,
    /// The frame that was dropped for this one, with [`WhenFull::DropOldest`]. It has no outcome.
    pub dropped: Option<Stamp>,
}

/// A thread that writes pictures, with its queue. Dropping it writes what waits, which may take its time.
#[derive(Debug)]
pub struct Writer {
    options: WriterOptions,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    /// Told of every change of the state.
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    queue: VecDeque<Entry>,
    /// The files of the frame that is being written; `None` while there is none.
    writing: Option<Vec<PathBuf>>,
    is_closing: bool,
    /// Callers that found the queue full, for tests to know that one of them waits.
    #[cfg(test)]
    blocked: usize,
    outcomes: Outcomes<Written>,
}

/// A frame on its way to the disk.
#[derive(Debug)]
struct Entry {
    frame: Frame,
    output: Output,
    stamp: Stamp,
    /// The files that it will be, without the report.
    files: Vec<PathBuf>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // No code that holds the lock can leave the state half-changed.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until the state is no longer as `is_early` says.
    fn wait_while<'s>(
        &self,
        state: MutexGuard<'s, State>,
        mut is_early: impl FnMut(&State) -> bool,
    ) -> MutexGuard<'s, State> {
        let waited = self.changed.wait_while(state, |state| is_early(state));
        waited.unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes what comes until the queue is closed and empty.
    fn run(&self, mut write: impl FnMut(&mut Entry) -> Result<PathBuf>) {
        loop {
            let mut state = self.wait_while(self.lock(), |state| state.queue.is_empty() && !state.is_closing);
            let Some(mut entry) = state.queue.pop_front() else { return };
            state.writing = Some(mem::take(&mut entry.files));
            drop(state);
            self.changed.notify_all();
            let start = Instant::now();
            let result = Error::of_panics(|| write(&mut entry));
            let written = Written { stamp: entry.stamp, result, write_s: start.elapsed().as_secs_f64() };
            // The picture's memory is free before the next one is let in.
            drop(entry.frame);
            let mut state = self.lock();
            state.writing = None;
            state.outcomes.push(written);
            drop(state);
            self.changed.notify_all();
        }
    }
}

impl Writer {
    /// A writer with its thread. Nothing is made on disk before the first frame.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] when the queue has no place; [`ErrorKind::Io`] when the directory is relative and the
    /// working directory is gone, or when the thread cannot be made.
    pub fn new(options: WriterOptions) -> Result<Self> {
        let given = &options.directory;
        let given = if given.as_os_str().is_empty() { Path::new(".") } else { given };
        let directory = absolute(given).map_err(|e| io_error(given, "cannot find the directory", e))?;
        let existing = options.existing;
        let target = directory.clone();
        Self::with(WriterOptions { directory, ..options }, move |entry| {
            write_frame_with(&target, &entry.output, &entry.stamp, &mut entry.frame, existing)
        })
    }

    /// A writer whose thread does `write` with each frame.
    fn with(
        options: WriterOptions,
        write: impl FnMut(&mut Entry) -> Result<PathBuf> + Send + 'static,
    ) -> Result<Self> {
        if options.queue == 0 {
            return Err(Error::new(ErrorKind::Argument, "a writer's queue of 0 frames, expected at least 1"));
        }
        let shared = Arc::new(Shared::default());
        let on_thread = Arc::clone(&shared);
        let thread = Builder::new().name("icoray-writer".into()).spawn(move || on_thread.run(write));
        let thread =
            thread.map_err(|e| Error::new(ErrorKind::Io, format!("cannot make the writer's thread: {e}")))?;
        Ok(Writer { options, shared, thread: Some(thread) })
    }

    /// How it writes; the directory is absolute.
    pub fn options(&self) -> &WriterOptions {
        &self.options
    }

    /// The names of a frame's files, relative to the directory, after a look whether they can be written: so that it is
    /// known before the first ray. Names that wait to be written count as taken.
    ///
    /// # Errors
    /// As [`Output::names`]; [`ErrorKind::Exists`] where a file is there and is not to be modified, or where `report.csv`
    /// has other columns than this version's; [`ErrorKind::Io`] where a directory has a file's name.
    pub fn check(&self, output: &Output, stamp: &Stamp, field: &str) -> Result<FrameNames> {
        let names = output.names(stamp, field)?;
        let files = self.files(&names);
        for file in &files {
            self.options.existing.check(file)?;
        }
        if self.options.existing == Existing::NeverModify {
            let state = self.shared.lock();
            let waiting = state.queue.iter().flat_map(|entry| &entry.files);
            if let Some(taken) =
                waiting.chain(state.writing.iter().flatten()).find(|file| files.contains(file))
            {
                return Err(atomic::exists(taken));
            }
        }
        report::check(&report::beside(&files[0]))?;
        Ok(names)
    }

    /// Hands over a frame, which is written with `stamp` under the names that `output` gives. Where the queue is full this
    /// waits or drops the oldest waiting frame, as the options say. Seconds waited are added to the frame's report.
    pub fn submit(&self, frame: Frame, output: Output, stamp: Stamp) -> Submitted {
        self.queue(frame, output, stamp, true)
    }

    /// As [`Self::submit`], for a thread on which no model waits: the wait is not put down in the frame's report.
    pub(crate) fn submit_unseen(&self, frame: Frame, output: Output, stamp: Stamp) -> Submitted {
        self.queue(frame, output, stamp, false)
    }

    fn queue(&self, mut frame: Frame, output: Output, stamp: Stamp, is_seen: bool) -> Submitted {
        // Names that cannot be made are an outcome, as all that goes wrong with writing.
        let files =
            output.names(&stamp, &frame.field).map_or_else(|_| Vec::new(), |names| self.files(&names));
        let WriterOptions { queue, when_full, .. } = self.options;
        let is_full = |state: &State| state.queue.len() >= queue;
        let (mut waited_s, mut dropped) = (0.0, None);
        let mut state = self.shared.lock();
        if is_full(&state) {
            match when_full {
                WhenFull::Block => {
                    #[cfg(test)]
                    {
                        state.blocked += 1;
                    }
                    let start = Instant::now();
                    state = self.shared.wait_while(state, is_full);
                    waited_s = start.elapsed().as_secs_f64();
                }
                WhenFull::DropOldest => dropped = state.queue.pop_front(),
            }
        }
        if is_seen {
            frame.report.waited_s += waited_s;
        }
        state.queue.push_back(Entry { frame, output, stamp, files });
        drop(state);
        self.shared.changed.notify_all();
        Submitted { waited_s, dropped: dropped.map(|entry| entry.stamp) }
    }

    /// What became of frames since this was asked last.
    pub fn take_outcomes(&self) -> Outcomes<Written> {
        mem::take(&mut self.shared.lock().outcomes)
    }

    /// Waits until all that was submitted is on disk or has failed.
    pub fn wait(&self) {
        let is_working = |state: &State| state.writing.is_some() || !state.queue.is_empty();
        drop(self.shared.wait_while(self.shared.lock(), is_working));
    }

    /// The paths of a frame's files, the picture first.
    fn files(&self, names: &FrameNames) -> Vec<PathBuf> {
        let names = [Some(&names.file), names.error.as_ref()].into_iter().flatten();
        names.map(|name| self.options.directory.join(Path::new(name))).collect()
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.shared.lock().is_closing = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // Panics of encoders are outcomes; there is nobody left to tell of another one.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;
