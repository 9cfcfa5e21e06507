//! Sources of variables: a file, or a dataset in memory.

use crate::values::Values;
use icoray::{Error, ErrorKind, OwnedReals, Result, printable};
use std::fmt;
use std::path::Path;

/// Maximum number of variables that a message names.
const NAMED: usize = 8;

/// Type of a variable's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
    /// Integers of any width.
    Integer,
    /// Characters.
    Text,
    /// Anything else.
    Other,
}

impl Kind {
    /// Whether values are `float` or `double`.
    pub fn is_real(self) -> bool {
        matches!(self, Kind::F32 | Kind::F64)
    }

    /// Bytes of a number in memory: 4 of `float`, 8 of others.
    pub fn bytes(self) -> usize {
        if self == Kind::F32 { 4 } else { 8 }
    }

    /// Whether values are `float`, `double` or integers.
    pub fn is_number(self) -> bool {
        self.is_real() || self == Kind::Integer
    }
}

/// A dimension of a variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dimension {
    /// Its name.
    pub name: String,
    /// Number of entries along it.
    pub len: usize,
    /// Whether it is the dimension of the time records.
    pub is_time: bool,
}

impl Dimension {
    /// A dimension; it is that of time if its name, without the path of a group, is `time` in any case or
    /// `time_counter`.
    pub fn new(name: String, len: usize) -> Self {
        let own_name = without_group(&name);
        let is_time = own_name.eq_ignore_ascii_case("time") || own_name == "time_counter";
        Dimension { name, len, is_time }
    }
}

/// A variable: its name, type and dimensions, the slowest first. The dimension of time, if any, comes first.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Type of its values.
    pub kind: Kind,
    /// Its dimensions.
    pub dimensions: Vec<Dimension>,
}

/// A name without the path of a group.
pub(crate) fn without_group(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or_default()
}

impl Variable {
    /// The dimensions behind that of the time records, or all if it has none.
    pub(crate) fn after_time(&self) -> &[Dimension] {
        match self.dimensions.as_slice() {
            [time, rest @ ..] if time.is_time => rest,
            all => all,
        }
    }

    /// Whether there is one array per time record.
    pub fn changes(&self) -> bool {
        self.dimensions.first().is_some_and(|dimension| dimension.is_time)
    }

    /// Whether the dimensions have these names, in this order, with or without times.
    pub(crate) fn lies_at_times_over(&self, names: &[&str]) -> bool {
        self.after_time().iter().map(|d| d.name.as_str()).eq(names.iter().copied())
    }

    /// Start and count along each dimension that select all of it.
    pub fn whole(&self) -> (Vec<usize>, Vec<usize>) {
        let count: Vec<usize> = self.dimensions.iter().map(|d| d.len).collect();
        (vec![0; count.len()], count)
    }
}

/// `theta(Time = 3, nCells = 162) of float`.
impl fmt::Display for Variable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let dimensions: Vec<String> = self.dimensions.iter().map(|d| format!("{} = {}", d.name, d.len)).collect();
        let kind = match self.kind {
            Kind::F32 => "float",
            Kind::F64 => "double",
            Kind::Integer => "integer",
            Kind::Text => "char",
            Kind::Other => "another type",
        };
        write!(f, "{}({}) of {kind}", self.name, dimensions.join(", "))
    }
}

/// The value of an attribute.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    /// Text, without padding; the first of several.
    Text(String),
    /// Numbers, and whether they are of `float` or `double`.
    Numbers {
        /// The numbers, widened.
        values: Vec<f64>,
        /// Whether they are real numbers, not integers.
        is_real: bool,
    },
}

/// An open file or dataset: a list of variables with their attributes, and reads of blocks of them.
///
/// Blocks start at `start` and have `count` entries along each dimension of the variable. Errors name the source.
#[expect(clippy::missing_errors_doc, reason = "the trait has them: `ErrorKind::Io` where a read fails")]
pub trait Source: fmt::Debug + Send + Sync {
    /// The path of the file, or another name for errors.
    fn path(&self) -> &Path;

    /// All variables.
    fn variables(&self) -> &[Variable];

    /// Length of a dimension; `None` when there is none of that name.
    fn dimension_len(&self, name: &str) -> Result<Option<usize>> {
        let mut dimensions = self.variables().iter().flat_map(|variable| &variable.dimensions);
        Ok(dimensions.find(|dimension| dimension.name == name).map(|dimension| dimension.len))
    }

    /// An attribute of a variable, or of the source itself; `None` when it is absent or of an unsupported type.
    fn attribute(&self, variable: Option<&str>, name: &str) -> Result<Option<Attribute>>;

    /// Reads a block of numbers: `float` in single precision, `double` and integers in double precision.
    fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals>;

    /// As [`Source::reals`], without a copy if the values are in memory.
    fn values(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Values> {
        self.reals(variable, start, count).map(Values::from)
    }

    /// Reads a whole variable of integers; a value that does not fit into 32 bits is an error. NaN, which xarray makes of
    /// the mark of an entry that is missing, is 0.
    fn integers(&self, variable: &Variable) -> Result<Vec<i32>> {
        let (start, count) = variable.whole();
        let numbers = self.reals(variable, &start, &count)?;
        let integer = |i: usize| {
            let number = Some(numbers.as_reals().get(i)).filter(|number| !number.is_nan()).unwrap_or(0.0);
            let fits = number.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&number);
            fits.then_some(number as i32).ok_or_else(|| {
                let (path, name) = (self.path().display(), &variable.name);
                let context = format!("{path}: {name}: entry {i} is {number}, expected an integer of 32 bits");
                Error::new(ErrorKind::Grid, context)
            })
        };
        (0..numbers.as_reals().len()).map(integer).collect()
    }

    /// Reads the first `rows` rows of a `char` variable of two dimensions, without the padding; `None` for a row that
    /// cannot be read, such as behind the end of a file that is cut off.
    fn text_rows(&self, variable: &Variable, rows: usize) -> Vec<Option<String>>;
}

impl dyn Source + '_ {
    /// The variables, in which the dimension of time is marked: for implementations of [`Source::variables`]. If none
    /// has its name it is the longest whose coordinate has `axis = "T"`, `standard_name = "time"` or units such as
    /// `days since 2000-01-01` (CF conventions 1.11, §4.4).
    pub fn with_time_marked(&self) -> Vec<Variable> {
        let mut variables = self.variables().to_vec();
        if variables.iter().flat_map(|v| &v.dimensions).any(|dimension| dimension.is_time) {
            return variables;
        }
        let axes = variables.iter().filter(|v| matches!(&v.dimensions[..], [only] if only.name == v.name));
        let times = axes.filter(|v| {
            let text = |attribute| self.text_of(&v.name, attribute).ok().flatten().unwrap_or_default();
            text("axis") == "T" || text("standard_name") == "time" || text("units").contains(" since ")
        });
        if let Some(time) = times.map(|v| v.dimensions[0].clone()).max_by_key(|dimension| dimension.len) {
            let dimensions = variables.iter_mut().flat_map(|v| &mut v.dimensions);
            dimensions.filter(|dimension| dimension.name == time.name).for_each(|dimension| dimension.is_time = true);
        }
        variables
    }

    /// Variables of numbers with their dimensions, only the first ones if there are many, for a message.
    pub(crate) fn numbers_in_words(&self) -> String {
        let is_table = |variable: &&Variable| variable.kind.is_number() && !variable.dimensions.is_empty();
        let all: Vec<String> = self.variables().iter().filter(is_table).map(Variable::to_string).collect();
        match all.len() {
            0 => "no variables of numbers".to_owned(),
            number if number <= NAMED => all.join(", "),
            number => format!("{} and {} more", all[..NAMED].join(", "), number - NAMED),
        }
    }

    /// An error about this source.
    pub fn error(&self, kind: ErrorKind, context: impl fmt::Display) -> Error {
        Error::new(kind, format!("{}: {context}", self.path().display()))
    }

    /// The variable of that name, or else the first of that name in a group.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        let (name, all) = (name.trim_start_matches('/'), || self.variables().iter());
        all().find(|v| v.name == name).or_else(|| all().find(|v| without_group(&v.name) == name))
    }

    /// The variable of that name, with its source.
    pub(crate) fn find(&self, name: &str) -> Option<SourceVariable<'_>> {
        self.variable(name).map(|variable| self.with(variable))
    }

    /// One of the variables, with its source.
    pub(crate) fn with<'s>(&'s self, variable: &'s Variable) -> SourceVariable<'s> {
        SourceVariable { source: self, variable }
    }

    /// All variables, with their source.
    pub(crate) fn each_variable(&self) -> impl Iterator<Item = SourceVariable<'_>> {
        self.variables().iter().map(|variable| self.with(variable))
    }

    /// The variable of that name; an error if there is none.
    pub(crate) fn expect(&self, name: &str) -> Result<&Variable> {
        self.variable(name).ok_or_else(|| self.error(ErrorKind::Grid, format_args!("variable {name} is missing")))
    }

    /// The text of a global attribute.
    pub(crate) fn text(&self, attribute: &str) -> Result<Option<String>> {
        self.attribute(None, attribute).map(text)
    }

    /// The first number of a global attribute.
    pub(crate) fn number(&self, attribute: &str) -> Result<Option<f64>> {
        Ok(numbers(self.attribute(None, attribute)?).first().copied())
    }

    /// The text of an attribute of a variable.
    ///
    /// # Errors
    /// As [`Source::attribute`].
    pub fn text_of(&self, variable: &str, attribute: &str) -> Result<Option<String>> {
        let name = self.variable(variable).map_or(variable, |found| &found.name);
        self.attribute(Some(name), attribute).map(text)
    }
}

/// A variable of a source.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SourceVariable<'a> {
    pub source: &'a dyn Source,
    pub variable: &'a Variable,
}

impl<'a> SourceVariable<'a> {
    /// Its name.
    pub fn name(self) -> &'a str {
        &self.variable.name
    }

    /// Its name without the path of its group, which conventions determine.
    pub fn own_name(self) -> &'a str {
        without_group(self.name())
    }

    /// An error about the source.
    pub fn error(self, kind: ErrorKind, context: impl fmt::Display) -> Error {
        self.source.error(kind, context)
    }

    /// The error that the variable is not as `expected`.
    pub fn unexpected(self, kind: ErrorKind, expected: impl fmt::Display) -> Error {
        self.error(kind, format_args!("variable {}, expected {expected}", self.variable))
    }

    /// The text of an attribute.
    pub fn text(self, attribute: &str) -> Result<Option<String>> {
        self.source.text_of(self.name(), attribute)
    }

    /// The numbers of an attribute; none when it is absent.
    pub fn numbers(self, attribute: &str) -> Result<Vec<f64>> {
        self.source.attribute(Some(self.name()), attribute).map(numbers)
    }

    /// Whether an attribute is of `float` or `double`.
    pub fn is_real(self, attribute: &str) -> Result<bool> {
        let value = self.source.attribute(Some(self.name()), attribute)?;
        Ok(matches!(value, Some(Attribute::Numbers { is_real: true, .. })))
    }

    /// Start and count of the whole variable, for one over time of its first record.
    pub fn first_record(self) -> Result<(Vec<usize>, Vec<usize>)> {
        let (start, mut count) = self.variable.whole();
        if self.variable.changes() {
            if count[0] == 0 {
                let context = format!("variable {} has no record, expected one at least", self.variable);
                return Err(self.error(ErrorKind::Grid, context));
            }
            count[0] = 1;
        }
        Ok((start, count))
    }

    /// Reads a whole table of numbers, `float` in single precision; for one over time, to which xarray's
    /// `open_mfdataset` converts all, its first record, which the last one must equal.
    pub fn all_reals(self) -> Result<OwnedReals> {
        let SourceVariable { source, variable } = self;
        let (mut start, count) = self.first_record()?;
        let first = source.reals(variable, &start, &count)?;
        if variable.changes() && variable.dimensions[0].len > 1 {
            start[0] = variable.dimensions[0].len - 1;
            let last = source.reals(variable, &start, &count)?;
            let (first, last) = (first.as_reals(), last.as_reals());
            if (0..first.len()).any(|i| first.get(i).to_bits() != last.get(i).to_bits()) {
                let context =
                    format!("variable {variable}: the last record differs from the first, expected one table");
                return Err(self.error(ErrorKind::Grid, context));
            }
        }
        Ok(first)
    }

    /// As [`Self::all_reals`], in double precision.
    pub fn all_numbers(self) -> Result<Vec<f64>> {
        let reals = self.all_reals()?;
        Ok((0..reals.as_reals().len()).map(|i| reals.as_reals().get(i)).collect())
    }

    /// As [`Self::all_reals`], of integers.
    pub fn all_integers(self) -> Result<Vec<i32>> {
        let (_, count) = self.first_record()?;
        let mut integers = self.source.integers(self.variable)?;
        let entries = count.iter().product::<usize>();
        if let Some(record) = integers.chunks(entries.max(1)).position(|record| record != &integers[..entries]) {
            let variable = self.variable;
            let context = format!("variable {variable}: record {record} differs from the first, expected one table");
            return Err(self.error(ErrorKind::Grid, context));
        }
        integers.truncate(entries);
        Ok(integers)
    }
}

/// Text of an attribute on one line, for printing.
fn text(value: Option<Attribute>) -> Option<String> {
    match value {
        Some(Attribute::Text(text)) => Some(printable(&text).into_owned()),
        _ => None,
    }
}

fn numbers(value: Option<Attribute>) -> Vec<f64> {
    match value {
        Some(Attribute::Numbers { values, .. }) => values,
        _ => Vec::new(),
    }
}
