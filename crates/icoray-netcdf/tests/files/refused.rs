//! Files that are not NetCDF are refused, by name.

use crate::memory::expect;
use icoray::ErrorKind;

#[test]
fn what_is_no_netcdf_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.nc");
    expect(&icoray_netcdf::open(&path).unwrap_err(), ErrorKind::Io, &["notes.nc", "No such file"]);
    expect(&icoray_netcdf::open(folder.path()).unwrap_err(), ErrorKind::Io, &["not a file"]);
    for text in ["", "theta\n", "CDF", "CDF\x01", "CDF\x05 is a format of the classic kind, but this is text\n"] {
        std::fs::write(&path, text).unwrap();
        expect(&icoray_netcdf::open(&path).unwrap_err(), ErrorKind::Io, &["notes.nc"]);
    }
    expect(&icoray_netcdf::open("https://example.org/notes.nc").unwrap_err(), ErrorKind::Io, &["No such file"]);
}
