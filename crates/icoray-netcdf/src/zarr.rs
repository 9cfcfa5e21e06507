//! Zarr stores, of which the NetCDF library reads those of version 2.
//!
//! Library versions before 4.9.1, such as that of Debian 12, return packed values of a store as they are packed, and
//! end the process at types that NetCDF lacks. So the metadata of arrays are read here before.
//! Format: <https://zarr-specs.readthedocs.io/en/latest/v2/v2.0.html>.

use icoray::{Error, ErrorKind, Result};
use serde_json::Value;
use std::ffi::CStr;
use std::fs;
use std::io;
use std::path::Path;

/// Entries of a folder of which one is in each store: of version 2, consolidated, and of version 3.
const MARKS: [&str; 3] = [".zgroup", ".zmetadata", "zarr.json"];

/// The first version of the NetCDF library that returns an error for what it cannot read.
const SAFE: [u32; 3] = [4, 9, 1];

/// Types that earlier versions read, without the byte order; NCZarr's own arrays may also have texts of one byte.
const TYPES: [&str; 10] = ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8"];

/// Whether a folder is a Zarr store.
pub(crate) fn is_folder(path: &Path) -> bool {
    MARKS.iter().any(|name| path.join(name).exists())
}

/// Whether the mode of an address, which the NetCDF library has behind `#`, is that of a store.
fn is_address(name: &str) -> bool {
    name.split_once('#').is_some_and(|(_, mode)| mode.contains("zarr"))
}

/// How a store is read that the NetCDF library cannot read.
fn advice(path: &Path) -> String {
    let shown = path.to_string_lossy();
    let store = shown.split('#').next().unwrap_or_default().trim_start_matches("file://");
    format!("in Python `icoray.open(\"{store}\")` reads it with xarray and zarr")
}

/// An error of the library, for a store with the advice.
pub(crate) fn advised(path: &Path, error: netcdf::Error) -> netcdf::Error {
    if is_folder(path) || is_address(&path.to_string_lossy()) {
        format!("{error}; {}", advice(path)).into()
    } else {
        error
    }
}

/// Fails if an address is that of a store of version 3, or of one of version 2 that this version of the NetCDF library
/// would misread.
pub(crate) fn expect_readable(path: &Path, address: &Path) -> Result<()> {
    let address = address.to_string_lossy();
    if !is_address(&address) {
        return Ok(());
    }
    let error = |what: String| Err(Error::new(ErrorKind::Io, format!("{}: {what}: {}", path.display(), advice(path))));
    let folder = address.strip_prefix("file://").and_then(|name| name.split('#').next()).map(Path::new);
    let (version, numbers) = library_version();
    if folder.is_some_and(|folder| folder.join("zarr.json").exists()) {
        return error("Zarr of version 3, expected version 2".to_owned());
    }
    if numbers >= SAFE {
        return Ok(());
    }
    let found = folder.map_or_else(|| Err(io::Error::other("it is not a local folder")), obstacle);
    match found {
        Ok(None) => Ok(()),
        Ok(Some(what)) => error(format!("{what}, which the NetCDF library {version} cannot read")),
        Err(e) if folder.is_some() && e.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(e) => {
            error(format!("whether values are packed, which the NetCDF library {version} misreads, is not known ({e})"))
        }
    }
}

/// What a version before [`SAFE`] cannot read of the arrays in a folder and of those in its groups.
fn obstacle(folder: &Path) -> io::Result<Option<String>> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let found = match path.join(".zarray") {
            _ if !path.is_dir() => None,
            metadata if metadata.exists() => of_array(&path, &serde_json::from_slice(&fs::read(metadata)?)?),
            _ => obstacle(&path)?,
        };
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

/// What a version before [`SAFE`] cannot read of an array with these metadata.
fn of_array(path: &Path, metadata: &Value) -> Option<String> {
    let name = path.file_name()?.to_string_lossy();
    let mut codecs = metadata["filters"].as_array().into_iter().flatten().chain([&metadata["compressor"]]);
    if let Some(codec) = codecs.find(|codec| !codec.is_null()) {
        return Some(format!("variable {name} is packed by {}", codec["id"].as_str().unwrap_or("an unknown codec")));
    }
    let kind = metadata["dtype"].as_str().unwrap_or("a structure");
    let is_read = TYPES.contains(&kind.trim_start_matches(['<', '>', '|']));
    let is_text_of_nczarr = kind.ends_with("S1") && path.join(".nczarray").exists();
    (!is_read && !is_text_of_nczarr).then(|| format!("variable {name} is of Zarr's type {kind}"))
}

/// The version of the NetCDF library, as text and as numbers.
fn library_version() -> (String, [u32; 3]) {
    // SAFETY: the function returns a static string that ends with a zero.
    let text = unsafe { CStr::from_ptr(netcdf_sys::nc_inq_libvers()) }.to_string_lossy();
    let version = text.split(' ').next().unwrap_or_default();
    let mut numbers = version.split(|c: char| !c.is_ascii_digit()).map(|number| number.parse().unwrap_or(0));
    (version.to_owned(), [0; 3].map(|_: u32| numbers.next().unwrap_or(0)))
}
