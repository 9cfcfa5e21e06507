//! Symbols of the process, also of libraries that were loaded for one module alone, such as those of Python.

use std::ffi::{CStr, CString, c_int, c_void};

/// Where symbols are looked for.
pub struct Symbols {
    /// Handles of libcatalyst and libconduit, as far as they are loaded; never closed, as these stay.
    libraries: Vec<*mut c_void>,
}

impl Symbols {
    /// Everything that the process has loaded.
    pub fn of_process() -> Self {
        let mut names: Vec<CString> = Vec::new();
        // SAFETY: the callback gets the vector that lives until the call returns.
        unsafe { libc::dl_iterate_phdr(Some(take_name), (&raw mut names).cast()) };
        // SAFETY: names of libraries that are loaded; nothing is loaded anew.
        let open = |name: &CString| unsafe { libc::dlopen(name.as_ptr(), libc::RTLD_LAZY | libc::RTLD_NOLOAD) };
        Symbols { libraries: names.iter().map(open).filter(|handle| !handle.is_null()).collect() }
    }

    /// The address of `prefix` and `name`.
    pub fn find(&self, name: &str, prefix: &str) -> Option<*mut c_void> {
        let name = CString::new(format!("{prefix}{name}")).ok()?;
        let places = std::iter::once(libc::RTLD_DEFAULT).chain(self.libraries.iter().copied());
        // SAFETY: handles of loaded libraries, and a string.
        places.map(|place| unsafe { libc::dlsym(place, name.as_ptr()) }).find(|address| !address.is_null())
    }
}

/// Adds a loaded library's path to a vector, if it is one of those that may have Conduit.
unsafe extern "C" fn take_name(info: *mut libc::dl_phdr_info, _size: usize, names: *mut c_void) -> c_int {
    // SAFETY: dl_iterate_phdr gives a filled-in struct and the pointer of `of_process`.
    unsafe {
        let path = (*info).dlpi_name;
        if !path.is_null() {
            let path = CStr::from_ptr(path);
            let text = path.to_string_lossy();
            let file = text.rsplit('/').next().unwrap_or_default();
            if ["libcatalyst.", "libconduit"].iter().any(|start| file.starts_with(start)) {
                (*names.cast::<Vec<CString>>()).push(path.to_owned());
            }
        }
    }
    0
}
