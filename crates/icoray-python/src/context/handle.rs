//! The handle of a context, and what it borrows.

use super::config::Config;
use super::{c_string, closed};
use crate::error::{class, of_class};
use crate::field::Field;
use crate::grid::Grid;
use crate::mpi;
use icoray::ErrorKind;
use icoray_context::boundary::Failure;
use icoray_context::icoray_ctx;
use icoray_context::types::{icoray_config, icoray_status};
use pyo3::exceptions::PyResourceWarning;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, TryLockError, TryLockResult};

/// An open context, until it is closed.
pub(super) struct Handle {
    /// Calls that have begun share it; close takes it away.
    context: RwLock<Option<Arc<icoray_ctx>>>,
    is_shared: bool,
    /// Locked while the context takes an address and its array is kept.
    giving: Mutex<()>,
    kept: Mutex<Kept>,
}

/// Objects that the context reads, alive until they are replaced or the context is closed.
#[derive(Default)]
pub(super) struct Kept {
    pub grids: BTreeMap<String, Py<Grid>>,
    fields: BTreeMap<String, Py<Field>>,
    pub heights: Option<Py<Field>>,
    /// Bytes copied since the last frame.
    copied: u64,
    /// Bytes copied for the last frame.
    pub frame_copied: u64,
}

impl Kept {
    /// Keeps a field; returns the one before.
    pub fn keep_field(&mut self, name: &str, field: Bound<Field>) -> Option<Py<Field>> {
        self.copied += field.get().array.bytes_copied;
        self.fields.insert(name.to_owned(), field.unbind())
    }

    /// Keeps heights; returns those before.
    pub fn keep_heights(&mut self, heights: Bound<Field>) -> Option<Py<Field>> {
        self.copied += heights.get().array.bytes_copied;
        self.heights.replace(heights.unbind())
    }

    /// A frame begins: what was copied is of this frame.
    pub fn count_copies(&mut self) {
        self.frame_copied = std::mem::take(&mut self.copied);
    }
}

impl Handle {
    /// Opens a context, over the ranks of `comm` if there is one. Collective over these.
    pub fn open(
        py: Python,
        output_dir: Option<PathBuf>,
        settings: icoray_config,
        comm: Option<&Bound<PyAny>>,
    ) -> PyResult<Self> {
        let directory = output_dir.map(|path| c_string(&path.to_string_lossy(), "output_dir")).transpose()?;
        let config = Config::new(settings, directory.as_ref());
        let team = comm.map(mpi::team).transpose()?;
        let is_shared = team.is_some();
        // SAFETY: a config whose string lives until the call returns.
        let opened = py.detach(move || unsafe { icoray_ctx::open(config.get(), team) });
        let context = RwLock::new(Some(opened.map_err(raised)?.into()));
        Ok(Handle { context, is_shared, giving: Mutex::default(), kept: Mutex::default() })
    }

    /// Makes a call on the context with Python's lock released.
    pub fn call<R: Send>(
        &self,
        py: Python,
        call: impl FnOnce(&icoray_ctx) -> Result<R, Failure> + Send,
    ) -> PyResult<R> {
        let context = locked(self.context.try_read())?.clone().ok_or_else(closed)?;
        py.detach(move || call(&context)).map_err(raised)
    }

    /// Makes a call that gives the context an address, and keeps what owns the memory there: both or none, so that of
    /// two threads one is refused. What `keep` returns is dropped without a lock, as arrays may have destructors.
    pub fn give<R>(
        &self,
        py: Python,
        call: impl FnOnce(&icoray_ctx) -> Result<(), Failure> + Send,
        keep: impl FnOnce(&mut Kept) -> R,
    ) -> PyResult<R> {
        let _giving = locked(self.giving.try_lock())?;
        self.call(py, call)?;
        Ok(keep(&mut self.kept()))
    }

    /// Records in the context that arguments were refused; returns their `error`.
    pub fn refuse(&self, py: Python, call: &str, name: &str, error: PyErr) -> PyErr {
        let why = error.value(py).to_string();
        // The error is what was found before, whatever the state of the context.
        let _ = self.call(py, |context| {
            context.refuse(call, name, &why);
            Ok(())
        });
        error
    }

    pub fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn is_closed(&self) -> bool {
        self.context.try_read().is_ok_and(|open| open.is_none())
    }

    /// Closes the context. Collective over its ranks.
    pub fn close(&self, py: Python) -> PyResult<()> {
        let _giving = locked(self.giving.try_lock())?;
        let mut open = locked(self.context.try_write())?;
        let Some(context) = open.clone() else { return Ok(()) };
        let closed = py.detach(|| context.close());
        let is_open = closed.as_ref().is_err_and(|failure| failure.status == icoray_status::ICORAY_ERR_BUSY);
        if context.is_forked() {
            std::mem::forget(open.take());
        }
        let _closed = (!is_open).then(|| (open.take(), std::mem::take(&mut *self.kept())));
        closed.map_err(raised)
    }
}

impl Drop for Handle {
    /// Python's ResourceWarning for a context that was not closed. One over ranks stays open then, as closing it is
    /// collective and ranks drop it at different times.
    fn drop(&mut self) {
        if self.is_closed() {
            return;
        }
        let _ = Python::try_attach(|py| {
            let category = py.get_type::<PyResourceWarning>();
            let warned = PyErr::warn(py, &category, c"icoray.Context was not closed", 1);
            let closed = if self.is_shared { Ok(()) } else { self.close(py) };
            if let Err(error) = warned.and(closed) {
                error.write_unraisable(py, None);
            }
        });
        if self.is_shared {
            // The context may still read what it borrows.
            std::mem::forget(std::mem::take(&mut *self.kept()));
        }
        // One that could not be closed stays open, also where Python has ended.
        std::mem::forget(self.context.get_mut().unwrap_or_else(PoisonError::into_inner).take());
    }
}

/// The guard of a lock, unless another call has it.
fn locked<G>(lock: TryLockResult<G>) -> PyResult<G> {
    match lock {
        Ok(guard) => Ok(guard),
        Err(TryLockError::Poisoned(guard)) => Ok(guard.into_inner()),
        Err(TryLockError::WouldBlock) => {
            Err(of_class("BusyError", "another call on this context has not returned yet".into()))
        }
    }
}

/// A message of the C interface, with the names that its members and functions have here.
pub(super) fn in_python(message: &str) -> String {
    let members = ["config.", "grid.", "part.", "layers.", "ndarray."].map(|of| (of, ""));
    let methods = ["grid_set", "part_set", "layers_set", "heights_set", "field_set", "scene_load", "scene_text"];
    let others = ["wants", "execute", "wait", "close", "layers"].map(|name| (name, name));
    let names = members.into_iter().chain(methods.map(|name| (name, name))).chain(others);
    names.fold(message.replace("_set_ndarray", "_set"), |text, (c, here)| text.replace(&format!("icoray_{c}"), here))
}

/// The error of a failed call.
fn raised(Failure { status, message }: Failure) -> PyErr {
    use icoray_status::*;
    let class = match status {
        ICORAY_ERR_NULL | ICORAY_ERR_STRUCT_SIZE => "ArgumentError",
        ICORAY_ERR_DISABLED => "DisabledError",
        ICORAY_ERR_BUSY => "BusyError",
        ICORAY_ERR_FORKED => "ForkedError",
        // The others have the numbers of kinds of errors.
        kind => class(ErrorKind::of_number(kind as i32)),
    };
    of_class(class, in_python(&message))
}
