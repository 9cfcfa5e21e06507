//! Several sources as one: their records in the order of the dates, their other variables side by side.

use crate::mesh::expect_one_name;
use crate::source::{Attribute, Dimension, Kind, Source, Variable};
use crate::times::Times;
use icoray::{Error, ErrorKind, OwnedReals, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// Attributes that determine values from stored numbers: all sources of a variable must have the same.
const STORED_AS: [&str; 4] = ["scale_factor", "add_offset", "_FillValue", "missing_value"];
/// MPAS's variable of the dates.
const DATES: &str = "xtime";

/// Sources of one mesh, such as the files of a run, each of which is read once.
#[derive(Debug)]
pub struct Combined {
    sources: Vec<Box<dyn Source>>,
    variables: Vec<Variable>,
    /// The times in their order.
    times: Vec<Time>,
}

#[derive(Debug)]
struct Time {
    date: Option<String>,
    /// The records of the time, in the order of the sources.
    records: Vec<Record>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Record {
    source: usize,
    record: usize,
}

impl Combined {
    /// Combines sources: records of the same date become one time; those without dates follow those of the last
    /// previous source that has one of their variables, or else begin at time 0. A variable of several sources is read
    /// from the first that has it at a time, one that does not depend on time from the first that has it. A single
    /// source is returned unchanged.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] if there is no source; [`ErrorKind::Field`] if a variable has other dimensions in
    /// another source, or is stored differently, or if some of the sources have dates and one with several records has
    /// none; [`ErrorKind::Io`] as [`Times::read`].
    pub fn of(mut sources: Vec<Box<dyn Source>>) -> Result<Box<dyn Source>> {
        if sources.is_empty() {
            return Err(Error::new(ErrorKind::Argument, "no source, expected one with fields"));
        }
        if sources.len() == 1 {
            return Ok(sources.remove(0));
        }
        expect_one_name(sources.iter().map(AsRef::as_ref))?;
        let times = times(&sources)?;
        let mut variables: Vec<Variable> = Vec::new();
        for source in &sources {
            for variable in source.variables().iter().filter(|v| v.name != DATES) {
                match variables.iter().find(|known| known.name == variable.name) {
                    Some(known) => expect_alike(&sources, known, source.as_ref(), variable)?,
                    None => variables.push(variable.clone()),
                }
            }
        }
        let mut time = None;
        for dimension in variables.iter_mut().filter_map(|v| v.dimensions.first_mut()).filter(|d| d.is_time) {
            dimension.len = times.len();
            time = Some(dimension.clone());
        }
        if let Some(time) = time.filter(|_| times.iter().any(|time| time.date.is_some())) {
            let letters = Dimension::new("StrLen".into(), 64);
            variables.push(Variable { name: DATES.into(), kind: Kind::Text, dimensions: vec![time, letters] });
        }
        Ok(Box::new(Combined { sources, variables, times }))
    }

    /// The first source that has a variable, and the variable there.
    fn first_with(&self, variable: &Variable) -> Result<(usize, &Variable)> {
        let sources = self.sources.iter().enumerate();
        let mut found = sources.filter_map(|(i, source)| Some((i, source.variable(&variable.name)?)));
        found.next().ok_or_else(|| self.lacks(variable, None))
    }

    /// The source of a variable at a time and the record there: `None` for all times.
    fn at(&self, variable: &Variable, time: usize) -> Result<(usize, Option<usize>)> {
        let records = self.times.get(time).map_or(&[][..], |time| &time.records);
        let is_there = |of: &&Record| self.sources[of.source].variable(&variable.name).is_some_and(Variable::changes);
        if let Some(Record { source, record }) = records.iter().find(is_there) {
            return Ok((*source, Some(*record)));
        }
        // A source without dates has its one record at all times.
        let (source, its) = self.first_with(variable)?;
        let is_timed = self.times.iter().flat_map(|time| &time.records).any(|record| record.source == source);
        match (its.changes(), is_timed) {
            (false, _) => Ok((source, None)),
            (true, false) => Ok((source, Some(0))),
            (true, true) => Err(self.lacks(variable, Some(time))),
        }
    }

    fn lacks(&self, variable: &Variable, time: Option<usize>) -> Error {
        let date = time.and_then(|time| self.times.get(time)?.date.as_deref());
        let of = time.map_or_else(String::new, |time| format!(" of time {time} ({})", date.unwrap_or("no date")));
        let own: &dyn Source = self;
        own.error(ErrorKind::Field, format_args!("none of the files has {}{of}", variable.name))
    }
}

/// The times of sources with values over time.
fn times(sources: &[Box<dyn Source>]) -> Result<Vec<Time>> {
    let has_values = |v: &Variable| v.kind.is_number() && v.dimensions.len() > 1 && v.changes();
    let mut dated: BTreeMap<(usize, String), Vec<Record>> = BTreeMap::new();
    let mut undated: Vec<Vec<Record>> = Vec::new();
    // Sources, and the time after their last record.
    let mut ends: Vec<(usize, usize)> = Vec::new();
    for (number, source) in sources.iter().enumerate().filter(|(_, s)| s.variables().iter().any(has_values)) {
        let times = Times::read(source.as_ref())?;
        let own = || source.variables().iter().filter(|v| has_values(v));
        let follows = |(before, _): &&(usize, usize)| own().any(|v| sources[*before].variable(&v.name).is_some());
        let begin = ends.iter().rev().find(follows).map_or(0, |(_, end)| *end);
        ends.push((number, begin + times.records));
        for (record, date) in times.dates.into_iter().enumerate().take(times.records) {
            let of = Record { source: number, record };
            match date {
                // A longer year is a later one.
                Some(date) => dated.entry((date.len(), date)).or_default().push(of),
                None => {
                    undated.resize(undated.len().max(begin + record + 1), Vec::new());
                    undated[begin + record].push(of);
                }
            }
        }
    }
    if dated.is_empty() {
        return Ok(undated.into_iter().map(|records| Time { date: None, records }).collect());
    }
    if let Some(Record { source, .. }) = undated.iter().flatten().find(|of| of.record > 0) {
        let context = "its times have no dates, expected dates as in the other files";
        return Err(sources[*source].error(ErrorKind::Field, context));
    }
    Ok(dated.into_iter().map(|((_, date), records)| Time { date: Some(date), records }).collect())
}

/// Checks that a variable in another source is like that in the previous ones.
fn expect_alike(sources: &[Box<dyn Source>], known: &Variable, source: &dyn Source, other: &Variable) -> Result<()> {
    if known.after_time() != other.after_time() {
        let context = format!("{other}, expected the dimensions of {known} as in the files before");
        return Err(source.error(ErrorKind::Field, context));
    }
    if other.kind == Kind::Integer && other.changes() {
        let before = sources.iter().find(|source| source.variable(&known.name).is_some());
        for name in STORED_AS {
            let here = source.attribute(Some(&other.name), name)?;
            if before.is_some_and(|before| !before.attribute(Some(&known.name), name).is_ok_and(|its| its == here)) {
                let context = format!("{name} of {} is another one than in the files before: unpack them", other.name);
                return Err(source.error(ErrorKind::Field, context));
            }
        }
    }
    Ok(())
}

impl Source for Combined {
    fn path(&self) -> &Path {
        self.sources[0].path()
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn dimension_len(&self, name: &str) -> Result<Option<usize>> {
        let found = self.sources.iter().find_map(|source| source.dimension_len(name).transpose()).transpose()?;
        Ok(found.map(|len| if name.eq_ignore_ascii_case("time") { self.times.len() } else { len }))
    }

    fn attribute(&self, variable: Option<&str>, name: &str) -> Result<Option<Attribute>> {
        let is_asked = |source: &&dyn Source| variable.is_none_or(|name| source.variable(name).is_some());
        let mut sources = self.sources.iter().map(AsRef::as_ref).filter(is_asked);
        sources.find_map(|source| source.attribute(variable, name).transpose()).transpose()
    }

    fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals> {
        if !variable.changes() {
            let (source, variable) = self.first_with(variable)?;
            return self.sources[source].reals(variable, start, count);
        }
        let read = |time: usize| {
            let (source, record) = self.at(variable, time)?;
            let source = self.sources[source].as_ref();
            let block = |first: Option<usize>, rest: &[usize]| [first.as_slice(), rest].concat();
            let (start, count) = (block(record, &start[1..]), block(record.map(|_| 1), &count[1..]));
            source.reals(source.expect(&variable.name)?, &start, &count)
        };
        let mut records = (start[0]..start[0] + count[0]).map(read).collect::<Result<Vec<_>>>()?;
        if records.len() == 1 {
            return Ok(records.remove(0));
        }
        let values = records.iter().flat_map(|reals| (0..reals.as_reals().len()).map(|i| reals.as_reals().get(i)));
        Ok(OwnedReals::F64(values.collect()))
    }

    fn integers(&self, variable: &Variable) -> Result<Vec<i32>> {
        let (source, variable) = self.first_with(variable)?;
        self.sources[source].integers(variable)
    }

    fn text_rows(&self, variable: &Variable, rows: usize) -> Vec<Option<String>> {
        if variable.name == DATES {
            return self.times.iter().map(|time| time.date.clone()).take(rows).collect();
        }
        let rows_of = |(source, variable): (usize, &Variable)| self.sources[source].text_rows(variable, rows);
        self.first_with(variable).map_or_else(|_| Vec::new(), rows_of)
    }
}
