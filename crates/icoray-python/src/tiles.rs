//! The number of drawn tiles of a picture.

use crate::interrupt::check_signals;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Numbers of tiles that are drawn, and of all: rendering threads count, the waiting thread reports.
#[derive(Debug, Default)]
pub(crate) struct Tiles {
    drawn: AtomicUsize,
    all: AtomicUsize,
}

impl Tiles {
    pub fn reset(&self) {
        self.drawn.store(0, Relaxed);
        self.all.store(0, Relaxed);
    }

    /// Calls come in no order.
    pub fn count(&self, drawn: usize, all: usize) {
        self.drawn.fetch_max(drawn, Relaxed);
        self.all.store(all, Relaxed);
    }

    /// Reports the numbers to a function of Python, and looks for signals.
    pub fn report(&self, progress: &Py<PyAny>) -> PyResult<()> {
        let (drawn, all) = (self.drawn.load(Relaxed), self.all.load(Relaxed));
        Python::attach(|py| if all > 0 { progress.call1(py, (drawn, all)).map(drop) } else { Ok(()) })?;
        check_signals()
    }
}
