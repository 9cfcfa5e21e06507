//! Values computed on first use: a picture drawn by a device alone computes none of them.

use icoray_grid::Result;
use std::fmt;
use std::sync::OnceLock;

/// A value that is computed once, by the first caller of [`Lazy::get`] or [`Lazy::try_get`].
pub(crate) struct Lazy<'f, V> {
    known: OnceLock<Result<V>>,
    compute: Box<dyn Fn() -> Result<V> + Send + Sync + 'f>,
}

impl<'f, V> Lazy<'f, V> {
    /// A value that `compute` returns, or an error.
    pub fn of(compute: impl Fn() -> Result<V> + Send + Sync + 'f) -> Self {
        Lazy { known: OnceLock::new(), compute: Box::new(compute) }
    }

    /// The value.
    ///
    /// # Panics
    /// If the computation fails.
    pub fn get(&self) -> &V {
        self.try_get().unwrap_or_else(|error| panic!("{error}"))
    }

    /// The value, or the error of its computation.
    pub fn try_get(&self) -> Result<&V> {
        self.known.get_or_init(&self.compute).as_ref().map_err(Clone::clone)
    }

    /// The value, to be modified.
    ///
    /// # Panics
    /// If the computation fails.
    pub fn get_mut(&mut self) -> &mut V {
        self.get();
        self.known.get_mut().and_then(|known| known.as_mut().ok()).expect("computed just now")
    }

    /// The value, if it has been computed.
    pub fn into_known(self) -> Option<V> {
        self.known.into_inner()?.ok()
    }
}

impl<V: fmt::Debug> fmt::Debug for Lazy<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lazy").field("known", &self.known).finish_non_exhaustive()
    }
}
