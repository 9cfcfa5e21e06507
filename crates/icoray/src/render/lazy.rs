//! Values computed on first use: a picture drawn by a device alone computes none of them.

use std::fmt;
use std::sync::OnceLock;

/// A value that is computed once, by the first caller of [`Lazy::get`].
pub(crate) struct Lazy<'f, V> {
    known: OnceLock<V>,
    compute: Box<dyn Fn() -> V + Send + Sync + 'f>,
}

impl<'f, V> Lazy<'f, V> {
    /// A value that `compute` returns.
    pub fn of(compute: impl Fn() -> V + Send + Sync + 'f) -> Self {
        Lazy { known: OnceLock::new(), compute: Box::new(compute) }
    }

    pub fn get(&self) -> &V {
        self.known.get_or_init(&self.compute)
    }

    /// The value, to be modified.
    pub fn get_mut(&mut self) -> &mut V {
        self.get();
        self.known.get_mut().expect("computed just now")
    }

    /// The value, if it was computed.
    pub fn known(&self) -> Option<&V> {
        self.known.get()
    }

    /// As [`Self::known`], by value.
    pub fn into_known(self) -> Option<V> {
        self.known.into_inner()
    }
}

impl<V: fmt::Debug> fmt::Debug for Lazy<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Derived").field("known", &self.known).finish_non_exhaustive()
    }
}
