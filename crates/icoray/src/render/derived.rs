//! What is made of a field, computed when somebody first asks: who draws nothing on the CPU asks for none of it.

use std::fmt;
use std::sync::OnceLock;

/// A value that is computed once, on the threads of whoever asks first.
pub(crate) struct Derived<'f, V> {
    known: OnceLock<V>,
    compute: Box<dyn Fn() -> V + Send + Sync + 'f>,
}

impl<'f, V> Derived<'f, V> {
    /// What `compute` gives.
    pub fn of(compute: impl Fn() -> V + Send + Sync + 'f) -> Self {
        Derived { known: OnceLock::new(), compute: Box::new(compute) }
    }

    pub fn get(&self) -> &V {
        self.known.get_or_init(&self.compute)
    }

    /// To be completed by others.
    pub fn get_mut(&mut self) -> &mut V {
        self.get();
        self.known.get_mut().expect("computed just now")
    }

    /// What it is, if anybody has asked.
    pub fn known(&self) -> Option<&V> {
        self.known.get()
    }

    /// The same, to be kept.
    pub fn into_known(self) -> Option<V> {
        self.known.into_inner()
    }
}

impl<V: fmt::Debug> fmt::Debug for Derived<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Derived").field("known", &self.known).finish_non_exhaustive()
    }
}
