//! Variables packed by a filter that HDF5 does not find.

use crate::memory::expect;
use hdf5_metno_sys::{LOCK, h5d, h5f, h5i, h5p, h5s, h5t, h5z};
use icoray::ErrorKind;
use icoray_netcdf::Outline;
use std::ffi::{CString, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr::{from_ref, null};

/// A filter that leaves values as they are.
unsafe extern "C" fn unchanged(
    _flags: c_uint,
    _parameters: usize,
    _values: *const c_uint,
    bytes: usize,
    _room: *mut usize,
    _buffer: *mut *mut c_void,
) -> usize {
    bytes
}

/// Writes `v(3)` of floats, packed by a filter of that number, which is there only while this runs.
fn write(path: &Path, number: c_int) {
    let path = CString::new(path.to_str().unwrap()).unwrap();
    let filter = h5z::H5Z_class2_t {
        version: 1,
        id: number,
        encoder_present: 1,
        decoder_present: 1,
        name: c"unchanged".as_ptr(),
        can_apply: None,
        set_local: None,
        filter: Some(unchanged),
    };
    let values = [1.0f32, 2.0, 3.0];
    let _lock = LOCK.lock();
    // SAFETY: the lock is held; all that is pointed to lives until the calls return.
    unsafe {
        assert!(h5z::H5Zregister(from_ref(&filter).cast()) >= 0);
        let file = h5f::H5Fcreate(path.as_ptr(), h5f::H5F_ACC_TRUNC, h5p::H5P_DEFAULT, h5p::H5P_DEFAULT);
        let space = h5s::H5Screate_simple(1, &3, null());
        let list = h5p::H5Pcreate(*h5p::H5P_CLS_DATASET_CREATE);
        assert!(h5p::H5Pset_chunk(list, 1, &3) >= 0 && h5p::H5Pset_filter(list, number, 0, 0, null()) >= 0);
        let float = *h5t::H5T_NATIVE_FLOAT;
        let dataset = h5d::H5Dcreate2(file, c"v".as_ptr(), float, space, h5p::H5P_DEFAULT, list, h5p::H5P_DEFAULT);
        let all = h5s::H5S_ALL;
        assert!(h5d::H5Dwrite(dataset, float, all, all, h5p::H5P_DEFAULT, values.as_ptr().cast()) >= 0);
        for id in [dataset, list, space, file] {
            assert!(h5i::H5Idec_ref(id) >= 0);
        }
        assert!(h5z::H5Zunregister(number) >= 0);
    }
}

#[test]
fn a_filter_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("packed.nc");
    for (number, name) in [(32015, "zstd"), (32001, "blosc"), (300, "unknown")] {
        write(&path, number);
        let error = Outline::try_reading(&path, &[], 0).unwrap_err();
        let filter = format!("filter {number} ({name})");
        expect(&error, ErrorKind::Io, &["packed.nc: variable v", &filter, "HDF5_PLUGIN_PATH"]);
    }
}
