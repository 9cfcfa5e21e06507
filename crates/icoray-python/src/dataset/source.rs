//! Datasets of Python as sources of variables; `_store.py` has the code for xarray.

use crate::array::RealArray;
use icoray::{Dimension as Extent, Error, ErrorKind, OwnedReals, Reals, Result};
use icoray_dataset::{Attribute, Dimension, Kind, Memory, Source, Values, Variable};
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A variable as `_store.py` lists it: name, kind, names and lengths of dimensions.
type Listed = (String, String, Vec<(String, usize)>);

/// The variables of a dataset.
#[derive(Debug)]
pub(crate) struct Store {
    store: Py<PyAny>,
    path: PathBuf,
    variables: Vec<Variable>,
    dimensions: HashMap<String, usize>,
    /// Bytes that were loaded, computed or converted.
    bytes_copied: Arc<AtomicU64>,
}

impl Store {
    /// `dataset` is a `Store` of `_store.py`; what is not read in place is added to `bytes_copied`.
    pub fn new(dataset: &Bound<PyAny>, bytes_copied: Arc<AtomicU64>) -> PyResult<Self> {
        let listed: Vec<Listed> = dataset.call_method0("variables")?.extract()?;
        let variables = listed.into_iter().map(|(name, kind, dimensions)| {
            let kind = match kind.as_str() {
                "f32" => Kind::F32,
                "f64" => Kind::F64,
                "integer" => Kind::Integer,
                "text" => Kind::Text,
                _ => Kind::Other,
            };
            let dimensions = dimensions.into_iter().map(|(name, len)| Dimension::new(name, len)).collect();
            Variable { name, kind, dimensions }
        });
        let dimensions: Vec<(String, usize)> = dataset.call_method0("dimensions")?.extract()?;
        let mut store = Store {
            path: dataset.getattr("name")?.extract::<String>()?.into(),
            variables: variables.collect(),
            dimensions: dimensions.into_iter().collect(),
            store: dataset.clone().unbind(),
            bytes_copied,
        };
        store.variables = (&store as &dyn Source).with_time_marked();
        Ok(store)
    }

    /// Runs a call of Python; what it raises is an error of reading.
    fn call<T>(&self, what: &str, call: impl FnOnce(&Bound<PyAny>) -> PyResult<T>) -> Result<T> {
        Python::attach(|py| {
            call(self.store.bind(py)).map_err(|raised| {
                let context = format!("{}: {what}: {raised}", self.path.display());
                Error::new(ErrorKind::Io, context)
            })
        })
    }

    /// A block as an array of real numbers that is borrowed or converted.
    fn block(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Block> {
        let name = &variable.name;
        self.call(&format!("variable {name}"), |store| {
            let read = store.call_method1("read", (name, start.to_vec(), count.to_vec()))?;
            let (values, in_memory): (Bound<PyAny>, bool) = read.extract()?;
            let array = RealArray::new(&values, name)?;
            let bytes = match in_memory {
                true => array.bytes_copied,
                false => {
                    let values = values.cast::<numpy::PyUntypedArray>()?;
                    array.bytes_copied.max((values.len() * if array.is_f32() { 4 } else { 8 }) as u64)
                }
            };
            self.bytes_copied.fetch_add(bytes, Relaxed);
            // SAFETY: only the offset is kept.
            let (_, offset) = unsafe { array.reals() };
            Ok(Block { array, offset })
        })
    }
}

impl Source for Store {
    fn path(&self) -> &Path {
        &self.path
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn dimension_len(&self, name: &str) -> Result<Option<usize>> {
        Ok(self.dimensions.get(name).copied())
    }

    fn attribute(&self, variable: Option<&str>, name: &str) -> Result<Option<Attribute>> {
        self.call(&format!("attribute {name}"), |store| {
            let found = store.call_method1("attribute", (variable, name))?;
            if found.is_none() {
                return Ok(None);
            }
            if let Ok(text) = found.extract::<String>() {
                return Ok(Some(Attribute::Text(text)));
            }
            let (values, is_real) = found.extract()?;
            Ok(Some(Attribute::Numbers { values, is_real }))
        })
    }

    fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals> {
        let block = self.block(variable, start, count)?;
        let mut elements = Vec::with_capacity(count.iter().product());
        element_numbers(&block.array.dimensions, block.offset, &mut elements);
        Ok(match (block.reals(), variable.kind) {
            (Reals::F32(v), Kind::F32) => OwnedReals::F32(elements.into_iter().map(|i| v[i]).collect()),
            (reals, _) => OwnedReals::F64(elements.into_iter().map(|i| reals.get(i)).collect()),
        })
    }

    fn values(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Values> {
        let block = self.block(variable, start, count)?;
        let strides = block.array.dimensions.iter().map(|d| d.stride).collect();
        Ok(Values::Shared { offset: block.offset, strides, memory: Arc::new(block) })
    }

    fn text_rows(&self, variable: &Variable, rows: usize) -> Vec<Option<String>> {
        let name = &variable.name;
        let texts = self.call(name, |store| store.call_method1("texts", (name, rows))?.extract());
        texts.unwrap_or_else(|_| vec![None; rows])
    }
}

/// A block in numpy's memory.
#[derive(Debug)]
struct Block {
    array: RealArray,
    /// Element of the first number.
    offset: usize,
}

impl Memory for Block {
    fn reals(&self) -> Reals<'_> {
        // SAFETY: the borrow lives as long as `self`; callers of the Python module must not write to an array while it
        // is read.
        unsafe { self.array.reals() }.0
    }
}

/// The numbers of all elements of an array, the last dimension the fastest.
fn element_numbers(dimensions: &[Extent], offset: usize, numbers: &mut Vec<usize>) {
    match dimensions {
        [] => numbers.push(offset),
        [first, rest @ ..] => {
            for i in 0..first.extent {
                element_numbers(rest, (offset as isize + i as isize * first.stride) as usize, numbers);
            }
        }
    }
}
