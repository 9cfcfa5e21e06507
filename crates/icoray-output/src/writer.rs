//! Encodes and writes pictures on a separate thread while the model computes.
//!
//! Frames are queued in a bounded channel: encoding is faster than drawing unless the disk is slow. When the queue is
//! full the caller blocks or the oldest queued frame is dropped, as specified by [`WhenFull`]. The outcome of each
//! frame is stored until [`Writer::take_outcomes`]; after a failure of one frame, also a panic of an encoder, the next
//! one is tried.
//!
//! The reserved names and the outcomes are one state behind one lock, which no thread keeps while it writes a file or
//! blocks a caller.

use super::lists::{self, IndexFile};
use super::outcomes::{Outcome, Outcomes};
use super::{atomic, folder, report};
use crate::atomic::Existing;
use crate::folder::io_error;
use crate::frame::Frame;
use crate::write::write_frame;
use crossbeam_channel::{Receiver, Select, Sender, TrySendError, bounded};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::name::{FrameNames, Output, Stamp};
use std::mem;
use std::path::{Path, PathBuf, absolute};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Instant;

/// Behaviour of [`Writer::submit`] when the queue is full.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum WhenFull {
    /// [`Writer::submit`] waits for room: every picture is written, and a slow disk slows the caller.
    #[default]
    Block,
    /// The oldest waiting frame is dropped: the caller never waits, and a slow disk loses pictures.
    DropOldest,
}

/// Options of a [`Writer`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WriterOptions {
    /// Directory of pictures and `report.csv`, made if missing. A relative one is resolved against the working
    /// directory when the writer is made.
    pub directory: PathBuf,
    /// Treatment of existing files.
    pub existing: Existing,
    /// Maximum number of waiting frames, at least 1; the one that is being written does not count.
    pub queue: usize,
    /// Behaviour when the queue is full.
    pub when_full: WhenFull,
}

impl WriterOptions {
    /// Writes into `directory`, with at most two waiting frames, nothing overwritten and nothing dropped.
    pub fn new(directory: impl Into<PathBuf>) -> Self {
        let (existing, when_full) = (Existing::default(), WhenFull::default());
        WriterOptions { directory: directory.into(), existing, queue: 2, when_full }
    }
}

/// Outcome of a frame.
#[derive(Debug, Clone)]
pub struct Written {
    /// Step and time of the frame.
    pub stamp: Stamp,
    /// The picture's path, or the error of writing it, the map of its errors or its line of the report.
    pub result: Result<PathBuf>,
    /// Seconds of encoding and writing.
    pub write_s: f64,
}

impl Outcome for Written {
    fn error(&self) -> Option<&Error> {
        self.result.as_ref().err()
    }
}

/// Cost of submitting a frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Submitted {
    /// Seconds spent waiting for room in the queue.
    pub waited_s: f64,
    /// The frame that was dropped for this one, with [`WhenFull::DropOldest`]. It has no outcome.
    pub dropped: Option<Stamp>,
}

/// A thread that writes pictures, with its queue. Dropping it writes the frames that are still in the queue.
#[derive(Debug)]
pub struct Writer {
    options: WriterOptions,
    /// Takes one frame at a time. `None` only while the writer is dropped, which ends the thread.
    queue: Option<Mutex<Sender<Entry>>>,
    /// The receiving end, from which the oldest frame is dropped.
    waiting: Receiver<Entry>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    /// Notified when a frame is finished.
    done: Condvar,
    /// Receives frames that were written.
    next: Mutex<Option<Box<Next>>>,
}

/// The receiver of frames that were written.
type Next = dyn FnMut(Frame) + Send;

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared").field("state", &self.state).finish_non_exhaustive()
    }
}

#[derive(Debug, Default)]
struct State {
    /// The files of frames that wait or are being written.
    taken: Vec<PathBuf>,
    /// Reports whose columns were checked: once each, since reading them may be slow.
    reports: Vec<PathBuf>,
    /// Lists of series that were checked, once each.
    index_files: Vec<IndexFile>,
    /// Frames that wait or are being written.
    unfinished: usize,
    /// Number of callers that found the queue full, by which tests detect a waiting one.
    #[cfg(test)]
    blocked: usize,
    outcomes: Outcomes<Written>,
}

/// A queued frame.
#[derive(Debug)]
struct Entry {
    frame: Frame,
    output: Output,
    stamp: Stamp,
    /// Its files, except the report.
    files: Vec<PathBuf>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // No code that holds the lock can leave the state half-changed.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Finishes a frame: releases its names and stores its outcome.
    fn finish(&self, files: &[PathBuf], outcome: Option<Written>) {
        let mut state = self.lock();
        state.taken.retain(|file| !files.contains(file));
        state.unfinished -= 1;
        if let Some(outcome) = outcome {
            state.outcomes.push(outcome);
        }
        drop(state);
        self.done.notify_all();
    }

    /// Writes the frames of the queue until it is closed and empty.
    fn run(&self, queue: &Receiver<Entry>, mut write: impl FnMut(&mut Entry) -> Result<PathBuf>) {
        for mut entry in queue {
            let start = Instant::now();
            let result = Error::of_panics(|| write(&mut entry));
            let Entry { frame, stamp, files, .. } = entry;
            let written = Written { stamp, result, write_s: start.elapsed().as_secs_f64() };
            // The picture's memory is passed on or freed before the outcome is visible.
            match &mut *self.next.lock().unwrap_or_else(PoisonError::into_inner) {
                // A panic there loses only this frame.
                Some(next) => drop(Error::of_panics(|| {
                    next(frame);
                    Ok(())
                })),
                None => drop(frame),
            }
            self.finish(&files, Some(written));
        }
    }
}

impl Writer {
    /// Starts a writer with its thread. Nothing is created on disk before the first frame.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] when the queue has no place; [`ErrorKind::Io`] when the directory is relative and the
    /// working directory does not exist any more, or when the thread cannot be started.
    pub fn new(options: WriterOptions) -> Result<Self> {
        let given = &options.directory;
        let given = if given.as_os_str().is_empty() { Path::new(".") } else { given };
        let directory = absolute(given).map_err(|e| io_error(given, "cannot find the directory", e))?;
        let existing = options.existing;
        let target = directory.clone();
        Self::with(WriterOptions { directory, ..options }, move |entry| {
            write_frame(&target, &entry.output, &entry.stamp, &mut entry.frame, existing)
        })
    }

    /// Starts a writer whose thread calls `write` for each frame.
    fn with(options: WriterOptions, write: impl FnMut(&mut Entry) -> Result<PathBuf> + Send + 'static) -> Result<Self> {
        if options.queue == 0 {
            return Err(Error::new(ErrorKind::Argument, "a writer's queue of 0 frames, expected at least 1"));
        }
        let shared = Arc::new(Shared::default());
        let (queue, waiting) = bounded(options.queue);
        let (on_thread, entries) = (Arc::clone(&shared), waiting.clone());
        let thread = Builder::new().name("icoray-writer".into()).spawn(move || on_thread.run(&entries, write));
        let thread = thread.map_err(|e| Error::new(ErrorKind::Io, format!("cannot start the writer's thread: {e}")))?;
        Ok(Writer { options, queue: Some(Mutex::new(queue)), waiting, shared, thread: Some(thread) })
    }

    /// The options; the directory is absolute.
    pub fn options(&self) -> &WriterOptions {
        &self.options
    }

    /// Checks that the directory can be written to, or can be made, so that an error is found before the run. Leaves
    /// nothing behind.
    ///
    /// # Errors
    /// [`ErrorKind::Io`] names the directory and the obstacle.
    pub fn check_directory(&self) -> Result<()> {
        folder::check_folder(&self.options.directory)
    }

    /// Checks, by the names of one frame, that names can be written at any step: they are not too long, and their
    /// folders can be made. Existing files are ignored. Leaves nothing behind.
    ///
    /// # Errors
    /// As [`NameTemplate::name`](icoray_scene::name::NameTemplate::name); [`ErrorKind::Io`] names the file and the
    /// obstacle.
    pub fn check_folders(&self, output: &Output, stamp: &Stamp, field: &str) -> Result<()> {
        let names = output.names_of_any(stamp, field)?;
        self.files(&names).iter().try_for_each(|file| folder::check_file(file))
    }

    /// The names of a frame's files, relative to the directory, after a check that they can be written, so that an
    /// error is found before the first ray. Names of queued frames count as existing.
    ///
    /// # Errors
    /// As [`Output::names`]; [`ErrorKind::Exists`] if a file exists and must not be modified, or if `report.csv` has
    /// other columns than this version's or a list of the series is a different file; [`ErrorKind::Io`] if a directory
    /// has a file's name.
    pub fn check(&self, output: &Output, stamp: &Stamp, field: &str) -> Result<FrameNames> {
        let names = output.names(stamp, field)?;
        let files = self.files(&names);
        for file in &files {
            self.options.existing.check(file)?;
        }
        if self.options.existing == Existing::NeverModify {
            let state = self.shared.lock();
            if let Some(taken) = state.taken.iter().find(|file| files.contains(file)) {
                return Err(atomic::exists(taken));
            }
        }
        let report = report::beside(&files[0]);
        if !self.shared.lock().reports.contains(&report) {
            report::check(&report)?;
            self.shared.lock().reports.push(report);
        }
        for file in lists::index_files(&output.series, &self.options.directory, output.error.is_some()) {
            if !self.shared.lock().index_files.contains(&file) {
                file.check()?;
                self.shared.lock().index_files.push(file);
            }
        }
        Ok(names)
    }

    /// Submits a frame, which is written with `stamp` under the names that `output` gives. If the queue is full this
    /// waits or drops the oldest waiting frame, as specified by the options. The waiting time is added to the frame's
    /// report.
    pub fn submit(&self, frame: Frame, output: Output, stamp: Stamp) -> Submitted {
        self.enqueue(frame, output, stamp, true)
    }

    /// As [`Self::submit`], for a thread that does not block the model: the wait is not added to the frame's report.
    pub fn submit_unseen(&self, frame: Frame, output: Output, stamp: Stamp) -> Submitted {
        self.enqueue(frame, output, stamp, false)
    }

    fn enqueue(&self, frame: Frame, output: Output, stamp: Stamp, is_seen: bool) -> Submitted {
        // Invalid names become an outcome, like every other failure to write.
        let files = output.names(&stamp, &frame.field).map_or_else(|_| Vec::new(), |names| self.files(&names));
        let mut state = self.shared.lock();
        state.taken.extend_from_slice(&files);
        state.unfinished += 1;
        drop(state);
        let queue = self.queue.as_ref().expect("the queue is there until the writer is dropped");
        let queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
        let mut entry = Entry { frame, output, stamp, files };
        let mut submitted = Submitted::default();
        loop {
            entry = match queue.try_send(entry) {
                Ok(()) => return submitted,
                Err(TrySendError::Full(entry)) => entry,
                Err(TrySendError::Disconnected(_)) => unreachable!("this writer has a receiver too"),
            };
            match self.options.when_full {
                WhenFull::Block => {
                    let waited_s = self.wait_for_room(&queue);
                    submitted.waited_s += waited_s;
                    if is_seen {
                        entry.frame.report.timing.waited_s += waited_s;
                    }
                }
                WhenFull::DropOldest => {
                    // The writer's thread may have taken the last frame meanwhile.
                    if let Ok(oldest) = self.waiting.try_recv() {
                        self.shared.finish(&oldest.files, None);
                        submitted.dropped = Some(oldest.stamp);
                    }
                }
            }
        }
    }

    /// Waits until the queue has room; returns the seconds.
    fn wait_for_room(&self, queue: &Sender<Entry>) -> f64 {
        #[cfg(test)]
        {
            self.shared.lock().blocked += 1;
        }
        let start = Instant::now();
        let mut room = Select::new();
        room.send(queue);
        room.ready();
        start.elapsed().as_secs_f64()
    }

    /// Passes each frame to `next`, on the writer's thread, after it was written or failed; `None` ends that.
    pub fn pass_on(&self, next: Option<Box<dyn FnMut(Frame) + Send>>) {
        *self.shared.next.lock().unwrap_or_else(PoisonError::into_inner) = next;
    }

    /// Outcomes of frames since the last call.
    pub fn take_outcomes(&self) -> Outcomes<Written> {
        mem::take(&mut self.shared.lock().outcomes)
    }

    /// Waits until all submitted frames are on disk or have failed.
    pub fn wait(&self) {
        let state = self.shared.lock();
        let idle = self.shared.done.wait_while(state, |state| state.unfinished > 0);
        drop(idle.unwrap_or_else(PoisonError::into_inner));
    }

    /// The paths of a frame's files, the picture first.
    fn files(&self, names: &FrameNames) -> Vec<PathBuf> {
        let names = [Some(&names.file), names.error.as_ref()].into_iter().flatten();
        names.map(|name| self.options.directory.join(Path::new(name))).collect()
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.queue = None;
        if let Some(thread) = self.thread.take() {
            // A panic of an encoder is an outcome of its frame.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;
