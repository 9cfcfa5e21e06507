//! Datasets in memory as declared by [`Made`], and their expected errors.

use crate::made::{Made, MadeVariable, Values};
use icoray::{Error, ErrorKind, LonLat, OwnedReals, Result};
use icoray_dataset::{Attribute, Dataset, DatasetOptions, Dimension, Kind, Source, Variable};
use std::path::Path;

/// A source of variables in memory.
#[derive(Debug)]
struct MemorySource {
    made: Made,
    variables: Vec<Variable>,
}

impl MemorySource {
    fn new(made: &Made) -> Self {
        let dimension = |name: &&str| Dimension::new((*name).to_owned(), made.dimension(name));
        let describe = |variable: &MadeVariable| Variable {
            name: variable.name.to_owned(),
            kind: match variable.values {
                Values::F32(_) => Kind::F32,
                Values::F64(_) => Kind::F64,
                Values::I32(_) => Kind::Integer,
                Values::Text(_) => Kind::Text,
            },
            dimensions: variable.dimensions.iter().map(dimension).collect(),
        };
        let variables = made.variables.iter().map(describe).collect();
        let mut source = MemorySource { made: made.clone(), variables };
        source.variables = (&source as &dyn Source).with_time_marked();
        source
    }

    fn made(&self, name: &str) -> Result<&MadeVariable> {
        let found = self.made.variables.iter().find(|variable| variable.name == name);
        found.ok_or_else(|| (self as &dyn Source).error(ErrorKind::Io, format_args!("no such variable: {name}")))
    }
}

impl Source for MemorySource {
    fn path(&self) -> &Path {
        Path::new(self.made.path)
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn dimension_len(&self, name: &str) -> Result<Option<usize>> {
        Ok(self.made.dimensions.iter().any(|(its, _)| *its == name).then(|| self.made.dimension(name)))
    }

    fn attribute(&self, variable: Option<&str>, name: &str) -> Result<Option<Attribute>> {
        let attributes = match variable {
            Some(variable) => &self.made(variable)?.attributes,
            None => &self.made.attributes,
        };
        let found = attributes.iter().find(|(its, _)| *its == name);
        Ok(found.map(|(_, value)| match value {
            Values::Text(text) => Attribute::Text(trimmed(text)),
            numbers => Attribute::Numbers { values: widened(numbers), is_real: !matches!(numbers, Values::I32(_)) },
        }))
    }

    fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals> {
        Ok(match &self.made(&variable.name)?.values {
            Values::F32(values) => OwnedReals::F32(block(values, variable, start, count)),
            numbers => OwnedReals::F64(block(&widened(numbers), variable, start, count)),
        })
    }

    fn text_rows(&self, variable: &Variable, rows: usize) -> Vec<Option<String>> {
        let Ok(MadeVariable { values: Values::Text(text), .. }) = self.made(&variable.name) else {
            panic!("{variable}, expected text")
        };
        let mut texts: Vec<_> = text.chunks(variable.dimensions[1].len).map(|row| Some(trimmed(row))).collect();
        texts.resize(rows, None);
        texts
    }
}

fn trimmed(text: &[u8]) -> String {
    String::from_utf8_lossy(text).trim().to_owned()
}

fn widened(values: &Values) -> Vec<f64> {
    match values {
        Values::F32(values) => values.iter().map(|value| f64::from(*value)).collect(),
        Values::F64(values) => values.clone(),
        Values::I32(values) => values.iter().map(|value| f64::from(*value)).collect(),
        Values::Text(text) => panic!("{text:?} is text, expected numbers"),
    }
}

/// The entries of a block of a variable.
fn block<T: Copy>(values: &[T], variable: &Variable, start: &[usize], count: &[usize]) -> Vec<T> {
    let entry = |mut i: usize| {
        let (mut at, mut stride) = (0, 1);
        for (k, dimension) in variable.dimensions.iter().enumerate().rev() {
            at += (start[k] + i % count[k]) * stride;
            i /= count[k];
            stride *= dimension.len;
        }
        values[at]
    };
    (0..count.iter().product()).map(entry).collect()
}

/// The dataset of a source with fields and of others with what it lacks.
pub fn opened(fields: &Made, others: &[&Made]) -> Result<Dataset> {
    opened_with(fields, others, DatasetOptions::default())
}

/// As [`opened`], with options.
pub fn opened_with(fields: &Made, others: &[&Made], options: DatasetOptions) -> Result<Dataset> {
    Dataset::new(source(fields), others.iter().map(|made| source(made)).collect(), None, options)
}

pub fn source(made: &Made) -> Box<dyn Source> {
    Box::new(MemorySource::new(made))
}

pub fn open(made: &Made) -> Dataset {
    opened(made, &[]).unwrap()
}

pub fn open_error(made: &Made) -> Error {
    opened(made, &[]).unwrap_err()
}

/// The error of a dataset in which `spoil` has changed something.
pub fn spoilt(mut made: Made, spoil: impl FnOnce(&mut Made)) -> Error {
    spoil(&mut made);
    open_error(&made)
}

/// The values of a field at a time, by column and layer.
pub fn values(file: &Dataset, name: &str, time: usize) -> impl Fn(usize, usize) -> f64 + use<> {
    let owned = file.read_field(name, time).unwrap();
    move |column, layer| owned.field().unwrap().value(column, layer)
}

/// The names of the fields.
pub fn names(file: &Dataset) -> Vec<&str> {
    file.fields().iter().map(|info| info.name.as_str()).collect()
}

/// The direction from the sphere's middle.
pub fn direction(lon_rad: f64, lat_rad: f64) -> [f64; 3] {
    [lat_rad.cos() * lon_rad.cos(), lat_rad.cos() * lon_rad.sin(), lat_rad.sin()]
}

pub fn direction_of(at: LonLat, i: usize) -> [f64; 3] {
    direction(at.lon_rad.get(i), at.lat_rad.get(i))
}

/// Asserts the kind and that the sentence holds all `parts`.
pub fn expect(error: &Error, kind: ErrorKind, parts: &[&str]) {
    assert_eq!(error.kind(), kind, "{error}");
    for part in parts {
        assert!(error.to_string().contains(part), "{error}\nlacks: {part}");
    }
}
