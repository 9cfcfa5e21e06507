//! Arrays of real numbers in single or double precision, in the model's memory.

/// A borrowed array of real numbers in either precision.
#[derive(Debug, Clone, Copy)]
pub enum Reals<'a> {
    /// Single precision.
    F32(&'a [f32]),
    /// Double precision.
    F64(&'a [f64]),
}

impl Reals<'_> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Reals::F32(v) => v.len(),
            Reals::F64(v) => v.len(),
        }
    }

    /// Whether there is no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Element `i`, widened.
    ///
    /// # Panics
    /// When `i` is out of range.
    #[inline]
    pub fn get(&self, i: usize) -> f64 {
        match self {
            Reals::F32(v) => f64::from(v[i]),
            Reals::F64(v) => v[i],
        }
    }
}

impl<'a> From<&'a [f32]> for Reals<'a> {
    fn from(v: &'a [f32]) -> Self {
        Reals::F32(v)
    }
}

impl<'a> From<&'a [f64]> for Reals<'a> {
    fn from(v: &'a [f64]) -> Self {
        Reals::F64(v)
    }
}

impl<'a> From<&'a Vec<f32>> for Reals<'a> {
    fn from(v: &'a Vec<f32>) -> Self {
        Reals::F32(v)
    }
}

impl<'a> From<&'a Vec<f64>> for Reals<'a> {
    fn from(v: &'a Vec<f64>) -> Self {
        Reals::F64(v)
    }
}

/// An owned array of real numbers in either precision.
#[derive(Debug, Clone, PartialEq)]
pub enum OwnedReals {
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

impl OwnedReals {
    /// A buffer of the precision of `like`: `memory` with its old values if it has that precision, else an empty array.
    pub fn buffer(like: Reals, memory: Option<Self>) -> Self {
        match (like, memory) {
            (Reals::F32(_), Some(OwnedReals::F32(memory))) => OwnedReals::F32(memory),
            (Reals::F64(_), Some(OwnedReals::F64(memory))) => OwnedReals::F64(memory),
            (Reals::F32(_), _) => OwnedReals::F32(Vec::new()),
            (Reals::F64(_), _) => OwnedReals::F64(Vec::new()),
        }
    }

    /// The array, borrowed.
    pub fn as_reals(&self) -> Reals<'_> {
        match self {
            OwnedReals::F32(v) => Reals::F32(v),
            OwnedReals::F64(v) => Reals::F64(v),
        }
    }

    /// The elements as bytes.
    pub fn as_bytes(&self) -> &[u8] {
        match self {
            OwnedReals::F32(v) => bytemuck::cast_slice(v),
            OwnedReals::F64(v) => bytemuck::cast_slice(v),
        }
    }

    /// Bytes of the elements.
    pub fn bytes(&self) -> usize {
        self.as_bytes().len()
    }
}

/// Resizes `memory` to `count` values; their old values stay.
pub(crate) fn resized<S: Copy + Default>(mut memory: Vec<S>, count: usize) -> Vec<S> {
    memory.reserve_exact(count.saturating_sub(memory.len()));
    memory.resize(count, S::default());
    memory
}
