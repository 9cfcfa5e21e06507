//! Filters of HDF5 that a variable needs and that are not installed. The errors of the NetCDF library do not name them.

use hdf5_metno_sys::{LOCK, h5d, h5f, h5i, h5p, h5z};
use std::ffi::{CString, c_int};
use std::path::Path;

/// Numbers and names of filters with which models' files are packed.
/// Source: <https://github.com/HDFGroup/hdf5_plugins/blob/master/docs/RegisteredFilterPlugins.md>.
const NAMES: [(c_int, &str); 7] = [
    (307, "bzip2"),
    (32001, "blosc"),
    (32004, "lz4"),
    (32013, "zfp"),
    (32015, "zstd"),
    (32026, "blosc2"),
    (32028, "sperr"),
];

/// An identifier of HDF5, closed at its end; negative where a call failed.
struct Id(h5i::hid_t);

impl Drop for Id {
    fn drop(&mut self) {
        if self.0 >= 0 {
            // SAFETY: an identifier that this owns; `missing` holds the lock.
            unsafe { h5i::H5Idec_ref(self.0) };
        }
    }
}

/// The filter that the variable of a NetCDF-4 file needs and that HDF5 does not find, in words; `None` where it has
/// all, or where the file is none of HDF5's.
pub(crate) fn missing(path: &Path, variable: &str) -> Option<String> {
    let (path, variable) = (CString::new(path.to_str()?).ok()?, CString::new(variable).ok()?);
    let _lock = LOCK.lock();
    // SAFETY: the lock is held; names end with a zero and live until the calls return; negative identifiers, of calls
    // that failed, make the next call fail; null pointers with no room for parameters and name are allowed.
    let absent = unsafe {
        let file = Id(h5f::H5Fopen(path.as_ptr(), h5f::H5F_ACC_RDONLY, h5p::H5P_DEFAULT));
        let dataset = Id(h5d::H5Dopen2(file.0, variable.as_ptr(), h5p::H5P_DEFAULT));
        let list = Id(h5d::H5Dget_create_plist(dataset.0));
        let filters = 0..u32::try_from(h5p::H5Pget_nfilters(list.0)).ok()?;
        let mut numbers = filters.map(|index| {
            let (mut flags, mut parameters, none) = (0, 0, std::ptr::null_mut());
            h5p::H5Pget_filter2(list.0, index, &mut flags, &mut parameters, none, 0, std::ptr::null_mut(), none)
        });
        numbers.find(|&number| number >= 0 && h5z::H5Zfilter_avail(number) == 0)?
    };
    let name = NAMES.iter().find(|(number, _)| *number == absent).map_or("unknown", |(_, name)| *name);
    Some(format!(
        "HDF5 lacks its filter {absent} ({name}): install that plugin, as of `pip install hdf5plugin`, and set \
         HDF5_PLUGIN_PATH to its folder"
    ))
}
