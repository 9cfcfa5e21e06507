//! Keeps the HDF5 library from printing to the standard error output.

use hdf5_metno_sys::{LOCK, h5e};
use std::cell::Cell;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Turns HDF5's own error reports off in this thread.
///
/// The NetCDF library looks for optional attributes by asking HDF5 and failing, and hands real failures on as its own. It
/// turns the reports off too, but only in the thread in which it starts; HDF5 keeps the setting per thread.
pub(crate) fn hdf5() {
    if QUIET.replace(true) {
        return;
    }
    let _lock = LOCK.lock();
    // SAFETY: the lock is the one that the NetCDF binding takes; no callback is set, so no data are used.
    unsafe {
        h5e::H5Eset_auto2(h5e::H5E_DEFAULT, None, std::ptr::null_mut());
    }
}
