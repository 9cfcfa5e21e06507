//! The times that are whole, the files from which each is drawn, and the times that are drawn already.

use super::folder::{Folder, State, Watched};
use icoray_netcdf::Outline;
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The identity of a time: its date, or file and record if it has none.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TimeId {
    Date(String),
    Record(PathBuf, usize),
}

impl TimeId {
    fn of(file: &Watched, record: usize, date: &Option<String>) -> Self {
        match date {
            Some(date) => TimeId::Date(date.clone()),
            None => TimeId::Record(file.path.clone(), record),
        }
    }
}

impl fmt::Display for TimeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TimeId::Date(date) => f.write_str(date),
            TimeId::Record(path, record) => write!(f, "time {record} of {}", path.display()),
        }
    }
}

/// A record of a file, as it was when it was chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    pub path: PathBuf,
    pub record: usize,
    pub state: State,
    version: u64,
    /// Whether the file still changed when the record was chosen, as a later one had come.
    is_followed: bool,
}

impl Source {
    /// Whether the file still has the chosen record: it is unchanged, or has only grown.
    pub fn is_valid(&self) -> bool {
        State::now(&self.path).is_some_and(|now| now == self.state || now.continues(&self.state, self.is_followed))
    }

    /// Whether the file is still as it was when the record was chosen.
    pub fn is_unchanged(&self) -> bool {
        State::now(&self.path).as_ref() == Some(&self.state)
    }
}

/// A time that may be drawn.
#[derive(Debug, Clone)]
pub struct Moment {
    pub id: TimeId,
    /// The first has the time's number; fields that it lacks are in the others.
    pub sources: Vec<Source>,
    /// Whether a file that it was drawn from was replaced since.
    pub is_replaced: bool,
}

impl Moment {
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.sources.iter().map(|source| &source.path)
    }

    /// Whether all of its files still have the chosen records.
    pub fn is_valid(&self) -> bool {
        self.sources.iter().all(Source::is_valid)
    }

    /// Whether its files are as they were.
    pub fn is_unchanged(&self) -> bool {
        self.sources.iter().all(Source::is_unchanged)
    }

    /// Whether both are read from the same files.
    pub fn shares_files(&self, other: &Moment) -> bool {
        self.paths().eq(other.paths())
    }
}

/// A time that has some fields of the scene and lacks one.
pub struct Lacking {
    pub id: TimeId,
    pub field: String,
    /// The files that have the time.
    pub files: Vec<PathBuf>,
}

/// The times that were drawn, and those that could not be.
#[derive(Default)]
pub struct History {
    /// The files, with their versions, from which each was drawn.
    drawn: HashMap<TimeId, Vec<(PathBuf, u64)>>,
    /// The files as they were when the time could not be drawn, and why.
    failed: BTreeMap<TimeId, (Vec<State>, String)>,
}

impl History {
    /// Whether the time was drawn.
    pub fn has(&self, id: &TimeId) -> bool {
        self.drawn.contains_key(id)
    }

    /// The time need not be drawn again.
    pub fn is_drawn(&mut self, moment: &Moment) {
        self.is_in(&moment.id, &moment.sources);
        self.failed.remove(&moment.id);
    }

    /// The time that was drawn is in these files now: the one that it was drawn from may have been renamed.
    fn is_in(&mut self, id: &TimeId, sources: &[Source]) {
        let sources = sources.iter().map(|source| (source.path.clone(), source.version));
        self.drawn.insert(id.clone(), sources.collect());
    }

    /// The time is not tried again before a file of it changes.
    pub fn has_failed(&mut self, moment: &Moment, reason: String) {
        let states = moment.sources.iter().map(|source| source.state.clone()).collect();
        self.failed.insert(moment.id.clone(), (states, reason));
    }

    /// The times that could not be drawn, and why.
    pub fn failures(&self) -> impl Iterator<Item = (&TimeId, &str)> {
        self.failed.iter().map(|(id, (_, reason))| (id, reason.as_str()))
    }

    fn is_open(&self, id: &TimeId, sources: &[Source]) -> bool {
        let failed = self.failed.get(id);
        !failed.is_some_and(|(states, _)| states.iter().eq(sources.iter().map(|source| &source.state)))
    }

    /// Whether a file that the time was drawn from was replaced; `None` where the time was not drawn.
    fn replaced(&self, id: &TimeId, sources: &[Source]) -> Option<bool> {
        let drawn = self.drawn.get(id)?;
        let is_other = |source: &Source| drawn.iter().any(|(path, its)| *path == source.path && *its != source.version);
        Some(sources.iter().any(is_other))
    }
}

/// The whole times of the directory that are not drawn yet, in their order, and those that lack a field.
pub fn open_times(
    folder: &Folder,
    needed: &[String],
    history: &mut History,
    now: Instant,
    settle: Duration,
) -> (Vec<Moment>, Vec<Lacking>) {
    let mut by_time: BTreeMap<TimeId, Vec<(&Watched, usize)>> = BTreeMap::new();
    for file in folder.files() {
        let Some(outline) = &file.outline else { continue };
        for (record, date) in outline.times.dates.iter().enumerate() {
            let is_written = date.is_some() || !outline.times.is_dated;
            let has_any = needed.iter().any(|field| outline.has_record(field, record));
            if !(is_written && has_any && file.is_whole(record, now, settle)) {
                continue;
            }
            let id = TimeId::of(file, record, date);
            let files = by_time.entry(id).or_default();
            // Of a date that a file has twice, the first.
            if files.iter().all(|(known, _)| known.path != file.path) {
                files.push((file, record));
            }
        }
    }
    let (mut open, mut lacking) = (Vec::new(), Vec::new());
    for (id, files) in by_time {
        let chosen = match choose(&files, needed) {
            Ok(chosen) => chosen,
            Err(field) => {
                let files = files.iter().map(|(file, _)| file.path.clone()).collect();
                lacking.push(Lacking { id, field: field.to_owned(), files });
                continue;
            }
        };
        let source = |(file, record): (&Watched, usize)| Source {
            path: file.path.clone(),
            record,
            state: file.state.clone(),
            version: file.version,
            is_followed: !file.has_settled(now, settle),
        };
        let sources: Vec<Source> = chosen.into_iter().map(source).collect();
        let replaced = history.replaced(&id, &sources);
        if replaced == Some(false) {
            history.is_in(&id, &sources);
        } else if history.is_open(&id, &sources) {
            open.push(Moment { id, sources, is_replaced: replaced.is_some() });
        }
    }
    (open, lacking)
}

/// The times of which a file that has settled ends before a field.
pub fn cut_off<'f>(folder: &'f Folder, needed: &[String]) -> impl Iterator<Item = (TimeId, &'f Watched)> {
    folder.files().flat_map(|file| {
        let outline = file.outline.iter();
        let times = outline.flat_map(|outline| outline.times.dates.iter().enumerate().map(move |time| (outline, time)));
        let is_cut = |outline: &Outline, record| {
            let is_cut = |field: &String| outline.promises(field, record) && !outline.has_record(field, record);
            needed.iter().any(is_cut)
        };
        let times: Vec<_> = times.filter(|(outline, (record, _))| is_cut(outline, *record)).collect();
        times.into_iter().map(move |(_, (record, date))| (TimeId::of(file, record, date), file))
    })
}

/// The first file that has all fields, or else for each field the first that has it; the field that none has.
fn choose<'f, 'n>(files: &[(&'f Watched, usize)], needed: &'n [String]) -> Result<Vec<(&'f Watched, usize)>, &'n str> {
    let has = |(file, record): &(&Watched, usize), field: &String| {
        file.outline.as_ref().is_some_and(|outline| outline.has_record(field, *record))
    };
    if let Some(one) = files.iter().find(|file| needed.iter().all(|field| has(file, field))) {
        return Ok(vec![*one]);
    }
    let mut chosen: Vec<(&Watched, usize)> = Vec::new();
    for field in needed {
        if chosen.iter().any(|file| has(file, field)) {
            continue;
        }
        chosen.push(*files.iter().find(|file| has(file, field)).ok_or(field.as_str())?);
    }
    Ok(chosen)
}
