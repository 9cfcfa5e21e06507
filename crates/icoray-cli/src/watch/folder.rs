//! The files of the watched directory, as they change.
//!
//! Each scan reads the directory, and the length and time of change of its files. It uses no notifications, which
//! network file systems do not send. A file is opened only when it has changed, and closed again.

use crate::isolated;
use glob::Pattern;
use icoray::{Error, ErrorKind, Result};
use icoray_netcdf::Outline;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, Metadata};
use std::os::unix::fs::{DirEntryExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// In directories with more files than this, those that have not changed for long are asked for less often.
const ALWAYS_ASKED: usize = 32;
/// The longest time between two questions for such a file.
const MAX_BETWEEN: Duration = Duration::from_secs(60);

/// The state of a file that shows whether it was replaced or changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State {
    identity: Identity,
    length: u64,
    modified: Option<SystemTime>,
}

/// Properties by which a file system distinguishes files; `created` is `None` where it has none.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Identity {
    device: u64,
    inode: u64,
    created: Option<SystemTime>,
}

impl State {
    /// The state of the file at `path` now; `None` where there is none.
    pub fn now(path: &Path) -> Option<Self> {
        let metadata = fs::metadata(path).ok().filter(Metadata::is_file)?;
        let identity = Identity { device: metadata.dev(), inode: metadata.ino(), created: metadata.created().ok() };
        Some(State { identity, length: metadata.len(), modified: metadata.modified().ok() })
    }

    /// Whether this is the file of `before`, which is longer now; where `may_be_rewritten`, also of the same length.
    pub fn continues(&self, before: &State, may_be_rewritten: bool) -> bool {
        self.identity == before.identity
            && (self.length > before.length || may_be_rewritten && self.length == before.length)
    }

    /// Whether this is another file, or a shorter one.
    fn replaces(&self, before: &State) -> bool {
        self.identity != before.identity || self.length < before.length
    }
}

/// A file of the directory.
#[derive(Debug)]
pub struct Watched {
    pub path: PathBuf,
    pub state: State,
    /// Number of times that the file was replaced.
    pub version: u64,
    /// The last outline that could be read.
    pub outline: Option<Outline>,
    /// Whether the directory still has it.
    is_there: bool,
    /// That of the directory's entry, which costs no question.
    entry_inode: u64,
    /// When the state was seen first, and when it is asked for again.
    since: Instant,
    next_look: Instant,
    /// The state of the last attempt to read the outline that need not be repeated.
    read_at: Option<State>,
    /// When each record was seen first; `None` of those that the first outline had.
    arrivals: Vec<Option<Instant>>,
}

impl Watched {
    fn new(path: PathBuf, state: State, now: Instant) -> Self {
        Watched {
            path,
            state,
            version: 0,
            outline: None,
            is_there: true,
            entry_inode: 0,
            since: now,
            next_look: now,
            read_at: None,
            arrivals: Vec::new(),
        }
    }

    fn forget(&mut self) {
        self.version += 1;
        self.outline = None;
        self.read_at = None;
        self.arrivals.clear();
    }

    /// Takes the state of now; whether it is a new one.
    fn take(&mut self, state: State, now: Instant) -> bool {
        let is_new = self.state != state;
        if is_new {
            if state.replaces(&self.state) {
                self.forget();
            }
            self.state = state;
            self.since = now;
        }
        is_new
    }

    /// Whether the file has not changed for `settle`.
    pub fn has_settled(&self, now: Instant, settle: Duration) -> bool {
        now.duration_since(self.since) >= settle
    }

    /// Whether a record is whole: the file has settled, or a later record was seen to come that long ago.
    pub fn is_whole(&self, record: usize, now: Instant, settle: Duration) -> bool {
        let is_old = |arrival: &Option<Instant>| arrival.is_some_and(|then| now.duration_since(then) >= settle);
        let is_read = self.read_at.as_ref() == Some(&self.state);
        is_read && self.has_settled(now, settle) || self.arrivals.get(record + 1).is_some_and(is_old)
    }

    /// Reads the outline where the file has changed. A file that cannot be read is an error once it has settled.
    fn read_outline(&mut self, now: Instant, settle: Duration) -> Result<()> {
        if self.read_at.as_ref() == Some(&self.state) {
            return Ok(());
        }
        let has_settled = self.has_settled(now, settle);
        let is_classic = Outline::is_classic(&self.path);
        if !has_settled && !is_classic.as_ref().is_ok_and(|is_classic| *is_classic) {
            return Ok(());
        }
        let try_reading = |is_classic| if is_classic { Ok(()) } else { isolated::try_in_child(&self.path, &[]) };
        let tried = is_classic.and_then(try_reading);
        match tried.and_then(|()| Outline::read(&self.path)) {
            Ok(outline) => {
                self.compare(outline, now);
                self.read_at = Some(self.state.clone());
                Ok(())
            }
            Err(error) if has_settled => {
                self.read_at = Some(self.state.clone());
                self.outline = None;
                Err(error)
            }
            Err(_) => Ok(()),
        }
    }

    /// Takes a new outline; where its dates do not go on from those before, the file was written anew.
    fn compare(&mut self, outline: Outline, now: Instant) {
        let goes_on = |before: &Outline| {
            let [old, new] = [before, &outline].map(|outline| &outline.times.dates);
            let both = old.iter().zip(new);
            old.len() <= new.len() && both.into_iter().all(|(old, new)| old.is_none() || old == new)
        };
        if self.outline.as_ref().is_some_and(|before| !goes_on(before)) {
            self.forget();
        }
        let records = outline.begun_records();
        let first_seen = self.outline.is_some().then_some(now);
        self.arrivals.resize(records.max(self.arrivals.len()), first_seen);
        self.outline = Some(outline);
    }
}

pub struct Folder {
    path: PathBuf,
    pattern: Pattern,
    settle: Duration,
    files: BTreeMap<PathBuf, Watched>,
}

impl Folder {
    /// The directory at `path`, of which files are taken whose names fit the pattern.
    pub fn new(path: &Path, pattern: Pattern, settle: Duration) -> Self {
        Folder { path: path.to_owned(), pattern, settle, files: BTreeMap::new() }
    }

    /// The files that are there, by name.
    pub fn files(&self) -> impl Iterator<Item = &Watched> {
        self.files.values().filter(|file| file.is_there)
    }

    pub fn file(&self, path: &Path) -> Option<&Watched> {
        self.files.get(path)
    }

    /// Looks at the directory; whether anything has changed.
    pub fn look(&mut self, now: Instant) -> Result<bool> {
        let failed = |e| Error::new(ErrorKind::Io, format!("{}: cannot read the directory: {e}", self.path.display()));
        let entries = fs::read_dir(&self.path).map_err(failed)?;
        let has_many = self.files.len() > ALWAYS_ASKED;
        let mut has_changed = false;
        let mut there = BTreeSet::new();
        for entry in entries {
            let entry = entry.map_err(failed)?;
            let name = entry.file_name();
            let Some(name) = name.to_str().filter(|name| !name.starts_with('.') && self.pattern.matches(name)) else {
                continue;
            };
            let (path, inode) = (self.path.join(name), entry.ino());
            let known = self.files.get(&path).filter(|file| file.is_there && file.entry_inode == inode);
            if known.is_some_and(|file| file.next_look > now) {
                there.insert(path);
                continue;
            }
            // A file may go between the two questions.
            let Some(state) = State::now(&path) else { continue };
            let is_new = !self.files.contains_key(&path);
            let file = self.files.entry(path.clone()).or_insert_with(|| Watched::new(path.clone(), state.clone(), now));
            has_changed |= file.take(state, now) || is_new;
            file.entry_inode = inode;
            let between = if has_many { (now.duration_since(file.since) / 8).min(MAX_BETWEEN) } else { Duration::ZERO };
            file.next_look = now + between;
            there.insert(path);
        }
        self.files.iter_mut().for_each(|(path, file)| file.is_there = there.contains(path));
        Ok(has_changed)
    }

    /// Asks for the state of a file at the next look, whenever it was asked for last.
    pub fn ask_for(&mut self, path: &Path) {
        if let Some(file) = self.files.get_mut(path) {
            file.next_look = file.since;
        }
    }

    /// Reads the outlines of changed files; the errors of those that cannot be read though they have settled.
    pub fn read_outlines(&mut self, now: Instant) -> Vec<Error> {
        let files = self.files.values_mut().filter(|file| file.is_there);
        files.filter_map(|file| file.read_outline(now, self.settle).err()).collect()
    }

    /// Whether all files have settled.
    pub fn has_settled(&self, now: Instant) -> bool {
        self.files().all(|file| file.has_settled(now, self.settle))
    }
}
