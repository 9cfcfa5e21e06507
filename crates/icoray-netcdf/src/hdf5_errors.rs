//! Disables HDF5's error output on stderr.

use hdf5_metno_sys::{LOCK, h5e};
use std::cell::Cell;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Disables HDF5's error reports in this thread.
///
/// The NetCDF library queries optional attributes, which fail in HDF5, and returns real failures itself. It disables
/// the reports only in the thread that initialises it; HDF5 keeps the setting per thread.
pub(crate) fn silence() {
    if QUIET.replace(true) {
        return;
    }
    let _lock = LOCK.lock();
    // SAFETY: the lock is the one that the NetCDF binding takes; no callback is set, so no data are used.
    unsafe {
        h5e::H5Eset_auto2(h5e::H5E_DEFAULT, None, std::ptr::null_mut());
    }
}
