//! Arrays of Python as the library borrows them.
//!
//! A numpy array of native, aligned 32- or 64-bit floats is borrowed with any strides. Everything else is copied by
//! numpy, which counts its bytes. All assumptions about numpy's memory are here.

use crate::error::{argument, bad_field};
use crate::report::dict;
use icoray::{Dimension, Indices, Reals};
use numpy::{Element, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::slice;

/// A real array with its memory's owner.
#[derive(Debug)]
pub(crate) struct RealArray {
    owner: Py<PyAny>,
    /// Address of the element with all indices 0.
    pub first: Pointer,
    /// Extents and strides, which count elements.
    pub dimensions: Vec<Dimension>,
    /// Bytes that were copied, 0 where the array is borrowed.
    pub bytes_copied: u64,
}

/// Address of an element, with its type.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Pointer {
    F32(*const f32),
    F64(*const f64),
}

// SAFETY: addresses in memory that `owner` keeps alive; what is read there is said where it is borrowed.
unsafe impl Send for RealArray {}
// SAFETY: as above.
unsafe impl Sync for RealArray {}

impl RealArray {
    /// Borrows or copies `values`, called `name` in messages.
    pub fn new(values: &Bound<PyAny>, name: &str) -> PyResult<Self> {
        let NumpyArray { array, bytes_copied } = NumpyArray::of(values)?;
        if let Some(borrowed) = Self::borrowed(&array)? {
            return Ok(RealArray { bytes_copied, ..borrowed });
        }
        let dtype = array.dtype();
        let target = real_type(dtype.kind(), dtype.itemsize())
            .ok_or_else(|| bad_field(format!("{name}: an array of {dtype}, expected real numbers")))?;
        let copied = Self::copied(&array, target, "K")?;
        Ok(RealArray { bytes_copied: bytes_copied.max(copied.bytes_copied), ..copied })
    }

    /// As [`Self::new`], in C's order, of `shape`.
    pub fn packed(values: &Bound<PyAny>, shape: &[usize], name: &str) -> PyResult<Self> {
        let array = Self::new(values, name)?;
        check_shape(array.dimensions.iter().map(|d| d.extent), shape, name)?;
        let owner = array.owner.bind(values.py()).cast::<PyUntypedArray>()?;
        if owner.is_c_contiguous() { Ok(array) } else { array.in_c_order(values.py()) }
    }

    /// A copy of an array in native numbers.
    fn copied(array: &Bound<PyUntypedArray>, dtype: &str, order: &str) -> PyResult<Self> {
        let copied = converted(array, dtype, order)?;
        let taken = Self::borrowed(&copied)?.expect("numpy's own arrays are native and aligned");
        Ok(RealArray { bytes_copied: bytes(&copied), ..taken })
    }

    /// A copy in C's order.
    fn in_c_order(&self, py: Python) -> PyResult<Self> {
        let owner = self.owner.bind(py).cast::<PyUntypedArray>()?;
        Self::copied(owner, if self.is_f32() { "float32" } else { "float64" }, "C")
    }

    /// `None` for arrays that the library cannot read in place.
    fn borrowed(array: &Bound<PyUntypedArray>) -> PyResult<Option<Self>> {
        let (first, size) = if let Ok(array) = array.cast::<PyArrayDyn<f32>>() {
            (Pointer::F32(array.data()), 4)
        } else if let Ok(array) = array.cast::<PyArrayDyn<f64>>() {
            (Pointer::F64(array.data()), 8)
        } else {
            return Ok(None);
        };
        if !array.is_aligned() || array.strides().iter().any(|stride| stride % size != 0) {
            return Ok(None);
        }
        let dimensions = array.shape().iter().zip(array.strides());
        let dimensions =
            dimensions.map(|(extent, stride)| Dimension { extent: *extent, stride: stride / size }).collect();
        Ok(Some(RealArray { owner: array.clone().into_any().unbind(), first, dimensions, bytes_copied: 0 }))
    }

    /// A copy of an array of which elements share memory, such as `numpy.broadcast_to` makes.
    pub fn without_shared_elements(self, py: Python) -> PyResult<Self> {
        let is_shared = self.dimensions.iter().any(|d| d.stride == 0 && d.extent > 1);
        if is_shared { self.in_c_order(py) } else { Ok(self) }
    }

    pub fn is_f32(&self) -> bool {
        matches!(self.first, Pointer::F32(_))
    }

    /// The array that has the memory.
    pub fn owner<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.owner.bind(py).clone()
    }

    /// All elements from the lowest to the highest in memory, and the place of the first one among them.
    ///
    /// # Safety
    /// The elements are read only while `self` lives and no thread writes to the array.
    pub unsafe fn reals(&self) -> (Reals<'static>, usize) {
        let (mut low, mut high) = (0isize, 0isize);
        for Dimension { extent, stride } in &self.dimensions {
            let reach = (*extent as isize - 1) * stride;
            if reach < 0 { low += reach } else { high += reach }
        }
        let length = if self.dimensions.iter().any(|d| d.extent == 0) { 0 } else { (high - low) as usize + 1 };
        let low = if length == 0 { 0 } else { low };
        // SAFETY: numpy's array has all these elements, aligned, in one allocation that `owner` keeps; the caller
        // promises the rest.
        let reals = unsafe {
            match self.first {
                Pointer::F32(_) if length == 0 => Reals::F32(&[]),
                Pointer::F64(_) if length == 0 => Reals::F64(&[]),
                Pointer::F32(first) => Reals::F32(slice::from_raw_parts(first.offset(low), length)),
                Pointer::F64(first) => Reals::F64(slice::from_raw_parts(first.offset(low), length)),
            }
        };
        (reals, low.unsigned_abs())
    }
}

/// A table of whole numbers in C's order, with its memory's owner.
#[derive(Debug)]
pub(crate) struct IndexArray {
    owner: Py<PyAny>,
    /// Extents.
    pub shape: Vec<usize>,
    /// Bytes that were copied, 0 where the array is borrowed.
    pub bytes_copied: u64,
    /// Whether the numbers have 64 bits.
    pub is_wide: bool,
}

impl IndexArray {
    /// Borrows `values`, or copies them where they are not a native, contiguous array of 32- or 64-bit integers. `shape`
    /// has the extents that are expected; 0 stands for any.
    pub fn new(values: &Bound<PyAny>, shape: &[usize], name: &str) -> PyResult<Self> {
        let NumpyArray { array, mut bytes_copied } = NumpyArray::of(values)?;
        let extents = array.shape().to_vec();
        check_shape(extents.iter().copied(), shape, name)?;
        let dtype = array.dtype();
        if !matches!(dtype.kind(), b'i' | b'u') {
            return Err(argument(format!("{name}: an array of {dtype}, expected whole numbers")));
        }
        let is_as_is = array.is_c_contiguous() && array.is_aligned();
        let as_wide = |array: &Bound<PyUntypedArray>| {
            let is_narrow = array.cast::<PyArrayDyn<i32>>().is_ok();
            (is_narrow || array.cast::<PyArrayDyn<i64>>().is_ok()).then_some(!is_narrow)
        };
        let (owner, is_wide) = match as_wide(&array).filter(|_| is_as_is) {
            Some(is_wide) => (array, is_wide),
            None => {
                let is_wide = dtype.itemsize() > 4 || (dtype.itemsize() == 4 && dtype.kind() == b'u');
                let copied = converted(&array, if is_wide { "int64" } else { "int32" }, "C")?;
                bytes_copied = bytes_copied.max(bytes(&copied));
                (copied, is_wide)
            }
        };
        Ok(IndexArray { owner: owner.into_any().unbind(), shape: extents, bytes_copied, is_wide })
    }

    /// The array that has the memory.
    pub fn owner<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.owner.bind(py).clone()
    }

    /// All numbers, row by row.
    ///
    /// # Safety
    /// As [`RealArray::reals`].
    pub unsafe fn indices(&self, py: Python) -> Indices<'static> {
        let owner = self.owner.bind(py);
        // SAFETY: contiguous, as `new` has checked; the caller promises the rest.
        unsafe { if self.is_wide { Indices::I64(elements(owner)) } else { Indices::I32(elements(owner)) } }
    }
}

/// The elements of a contiguous array of this type.
///
/// # Safety
/// `array` is a contiguous and aligned array of `T`; as [`RealArray::reals`].
unsafe fn elements<T: Element>(array: &Bound<PyAny>) -> &'static [T] {
    let array = array.cast::<PyArrayDyn<T>>().expect("an array of this type");
    if array.len() == 0 {
        return &[];
    }
    // SAFETY: the caller's.
    unsafe { slice::from_raw_parts(array.data(), array.len()) }
}

/// A numpy array, and the bytes that were copied to make it one.
struct NumpyArray<'py> {
    array: Bound<'py, PyUntypedArray>,
    bytes_copied: u64,
}

impl<'py> NumpyArray<'py> {
    /// Masked entries become NaN. Wrappers of arrays (xarray's) are seen through, arrays of GPUs fetched.
    fn of(values: &Bound<'py, PyAny>) -> PyResult<Self> {
        let py = values.py();
        let numpy = py.import("numpy")?;
        if let Ok(array) = values.cast::<PyUntypedArray>() {
            let masked = numpy.getattr("ma")?;
            let is_masked = values.is_instance(masked.getattr("MaskedArray")?.cast::<PyType>()?)?;
            if !is_masked {
                return Ok(NumpyArray { array: array.clone(), bytes_copied: 0 });
            }
            let data = masked.call_method1("getdata", (values,))?.cast_into::<PyUntypedArray>()?;
            if !masked.call_method1("is_masked", (values,))?.is_truthy()? {
                return Ok(NumpyArray { array: data, bytes_copied: 0 });
            }
            let dtype = data.dtype();
            let target = real_type(dtype.kind(), dtype.itemsize())
                .ok_or_else(|| bad_field(format!("a masked array of {dtype}, expected real numbers")))?;
            let copied = converted(&data, target, "K")?;
            copied.set_item(masked.call_method1("getmaskarray", (values,))?, f64::NAN)?;
            let bytes_copied = bytes(&copied);
            return Ok(NumpyArray { array: copied, bytes_copied });
        }
        if values.hasattr("dims")? && values.hasattr("data")? {
            return Self::of(&values.getattr("data")?);
        }
        let fetched = if values.hasattr("__cuda_array_interface__")? && values.hasattr("get")? {
            values.call_method0("get")?
        } else {
            values.clone()
        };
        let shares_memory = values.hasattr("__array_interface__")? || is_buffer(values);
        let array = numpy.call_method1("asarray", (fetched,))?.cast_into::<PyUntypedArray>()?;
        let bytes_copied = if shares_memory { 0 } else { bytes(&array) };
        Ok(NumpyArray { array, bytes_copied })
    }
}

/// Whether numpy reads the memory of `values` in place.
fn is_buffer(values: &Bound<PyAny>) -> bool {
    let memoryview = values.py().import("builtins").and_then(|builtins| builtins.getattr("memoryview"));
    memoryview.is_ok_and(|memoryview| memoryview.call1((values,)).is_ok())
}

/// The type that holds numbers of another one: exactly, but for 64-bit integers and longer floats, which are rounded to
/// double precision. `None` for what are no real numbers.
fn real_type(kind: u8, size: usize) -> Option<&'static str> {
    match (kind, size) {
        (b'f', ..=4) | (b'i' | b'u', ..=2) | (b'b', _) => Some("float32"),
        (b'f' | b'i' | b'u', _) => Some("float64"),
        _ => None,
    }
}

/// A copy of an array in native numbers.
fn converted<'py>(
    array: &Bound<'py, PyUntypedArray>,
    dtype: &str,
    order: &str,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = array.py();
    let plain = py.import("numpy")?.call_method1("asarray", (array,))?;
    let how = dict!(py, { "order": order, "copy": true });
    Ok(plain.call_method("astype", (dtype,), Some(&how))?.cast_into::<PyUntypedArray>()?)
}

fn bytes(array: &Bound<PyUntypedArray>) -> u64 {
    (array.len() * array.dtype().itemsize()) as u64
}

/// Compares extents; 0 stands for any.
fn check_shape(found: impl Iterator<Item = usize>, expected: &[usize], name: &str) -> PyResult<()> {
    let found: Vec<usize> = found.collect();
    let is_fit = |(found, expected): (&usize, &usize)| *expected == 0 || found == expected;
    if found.len() == expected.len() && found.iter().zip(expected).all(is_fit) {
        return Ok(());
    }
    let turned: Vec<usize> = found.iter().rev().copied().collect();
    let is_turned = found.len() > 1 && turned.len() == expected.len() && turned.iter().zip(expected).all(is_fit);
    let hint = if is_turned { "; pass its transpose (.T)" } else { "" };
    let expected: Vec<String> =
        expected.iter().map(|extent| if *extent == 0 { "any".into() } else { extent.to_string() }).collect();
    Err(argument(format!("{name}: an array of shape {found:?}, expected ({}){hint}", expected.join(", "))))
}
