//! Pictures are encoded and written by a thread of their own, so that a model computes on meanwhile.
//!
//! Frames wait in a short queue: encoding is faster than drawing but for a slow disk. When the queue is full the caller
//! chooses whether to wait or to lose the oldest waiting frame. What became of each frame is kept until it is asked for;
//! no failure of one frame, a panic of an encoder included, keeps the next one from being tried.
//!
//! Frames go through a bounded channel. Beside it, the names that are taken and the outcomes are one state behind one lock,
//! which is never held while something is written or waits.

use super::outcomes::{Outcome, Outcomes};
use super::series::Text;
use super::{Existing, FrameNames, Output, Stamp, atomic, folder, io_error, report, write_frame_with};
use crate::error::{Error, ErrorKind, Result};
use crate::frame::Frame;
use crossbeam_channel::{Receiver, Select, Sender, TrySendError, bounded};
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

/// A thread that writes pictures, with its queue. Dropping it writes the frames that are still in the queue.
///
/// ```
/// # use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
/// # let mesh = IcosahedralMesh::new(2)?;
/// # let grid = Grid::new(mesh.tables())?;
/// # let layers = Layers::from_heights(&[0.0, 1e6], 6.371e6)?;
/// # let values = vec![1.0f32; 2 * grid.cells()];
/// # let shape = Shape::cell_fastest(grid.cells(), 2);
/// # let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;
/// # let scene = Scene::parse(
/// #     "field = 'one'
/// #      image = { width = 8, height = 8 }
/// #      camera = { lon = 0, lat = 0, distance = 3 }
/// #      transfer = { map = 'viridis', range = [0, 2], opacity = [[0, 0.5], [2, 0.5]] }",
/// # )?;
/// use icoray::output::{Stamp, Writer, WriterOptions};
///
/// let frame = Renderer::new(1)?.render(&scene, &grid, &layers, &field)?;
/// let folder = std::env::temp_dir().join(format!("icoray-doc-writer-{}", std::process::id()));
/// let writer = Writer::new(WriterOptions::new(&folder))?;
/// writer.submit(frame, scene.output.clone(), Stamp { step: 7, ..Stamp::default() });
/// writer.wait();
/// assert!(folder.join("one_000007.png").is_file() && folder.join("report.csv").is_file());
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), icoray::Error>(())
/// ```
#[derive(Debug)]
pub struct Writer {
    options: WriterOptions,
    /// One frame is handed over at a time. `None` only while the writer is dropped, which ends the thread.
    queue: Option<Mutex<Sender<Entry>>>,
    /// The other end, for taking the oldest frame back.
    waiting: Receiver<Entry>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    /// Told when a frame is done with.
    done: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// The files of frames that wait or are being written.
    taken: Vec<PathBuf>,
    /// Reports that were found to be ours: looked at once each, since a look may take its time.
    reports: Vec<PathBuf>,
    /// The same of what is kept of series.
    texts: Vec<Text>,
    /// Frames that wait or are being written.
    unfinished: usize,
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

    /// A frame is done with: its names are free again.
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

    /// Writes what comes until the queue is closed and empty.
    fn run(&self, queue: &Receiver<Entry>, mut write: impl FnMut(&mut Entry) -> Result<PathBuf>) {
        for mut entry in queue {
            let start = Instant::now();
            let result = Error::of_panics(|| write(&mut entry));
            let Entry { frame, stamp, files, .. } = entry;
            let written = Written { stamp, result, write_s: start.elapsed().as_secs_f64() };
            // The picture's memory is free before anybody hears of it.
            drop(frame);
            self.finish(&files, Some(written));
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
        let (queue, waiting) = bounded(options.queue);
        let (on_thread, entries) = (Arc::clone(&shared), waiting.clone());
        let thread =
            Builder::new().name("icoray-writer".into()).spawn(move || on_thread.run(&entries, write));
        let thread =
            thread.map_err(|e| Error::new(ErrorKind::Io, format!("cannot make the writer's thread: {e}")))?;
        Ok(Writer { options, queue: Some(Mutex::new(queue)), waiting, shared, thread: Some(thread) })
    }

    /// How it writes; the directory is absolute.
    pub fn options(&self) -> &WriterOptions {
        &self.options
    }

    /// Refuses a directory in which nothing could be written, or which could not be made: so that it is known before the run.
    /// Leaves nothing behind.
    ///
    /// # Errors
    /// [`ErrorKind::Io`] names the directory and what is in the way.
    pub fn check_directory(&self) -> Result<()> {
        folder::check_folder(&self.options.directory)
    }

    /// Refuses names that could not be written at any step, by those of one frame: names that are too long, or in folders
    /// that cannot be made. Files that are there do not count. Leaves nothing behind.
    ///
    /// # Errors
    /// As [`NameTemplate::name`](super::NameTemplate::name); [`ErrorKind::Io`] names the file and what is in the way.
    pub fn check_folders(&self, output: &Output, stamp: &Stamp, field: &str) -> Result<()> {
        let names = output.names_of_any(stamp, field)?;
        self.files(&names).iter().try_for_each(|file| folder::check_file(file))
    }

    /// The names of a frame's files, relative to the directory, after a look whether they can be written: so that it is
    /// known before the first ray. Names that wait to be written count as taken.
    ///
    /// # Errors
    /// As [`Output::names`]; [`ErrorKind::Exists`] where a file is there and is not to be modified, or where `report.csv`
    /// has other columns than this version's or what is kept of the series is something else; [`ErrorKind::Io`] where a directory has a file's name.
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
        for text in output.series.texts(&self.options.directory, output.error.is_some()) {
            if !self.shared.lock().texts.contains(&text) {
                text.check()?;
                self.shared.lock().texts.push(text);
            }
        }
        Ok(names)
    }

    /// Hands over a frame, which is written with `stamp` under the names that `output` gives. Where the queue is full this
    /// waits or drops the oldest waiting frame, as the options say. Seconds waited are added to the frame's report.
    pub fn submit(&self, frame: Frame, output: Output, stamp: Stamp) -> Submitted {
        self.hand_over(frame, output, stamp, true)
    }

    /// As [`Self::submit`], for a thread on which no model waits: the wait is not put down in the frame's report.
    pub(crate) fn submit_unseen(&self, frame: Frame, output: Output, stamp: Stamp) -> Submitted {
        self.hand_over(frame, output, stamp, false)
    }

    fn hand_over(&self, frame: Frame, output: Output, stamp: Stamp, is_seen: bool) -> Submitted {
        // Names that cannot be made are an outcome, as all that goes wrong with writing.
        let files =
            output.names(&stamp, &frame.field).map_or_else(|_| Vec::new(), |names| self.files(&names));
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
                        entry.frame.report.waited_s += waited_s;
                    }
                }
                WhenFull::DropOldest => {
                    // None waits any more where the thread was faster.
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

    /// What became of frames since this was asked last.
    pub fn take_outcomes(&self) -> Outcomes<Written> {
        mem::take(&mut self.shared.lock().outcomes)
    }

    /// Waits until all that was submitted is on disk or has failed.
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
            // Panics of encoders are outcomes; there is nobody left to tell of another one.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;
