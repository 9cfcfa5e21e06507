//! Files that are not NetCDF are refused, by name.

use crate::memory::expect;
use icoray::ErrorKind;

#[test]
fn files_that_are_not_netcdf_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.nc");
    expect(&icoray_netcdf::open(&path).unwrap_err(), ErrorKind::Io, &["notes.nc", "No such file"]);
    expect(&icoray_netcdf::open(folder.path()).unwrap_err(), ErrorKind::Io, &["not a file"]);
    for text in ["", "theta\n", "CDF", "CDF\x01", "CDF\x05 is a format of the classic kind, but this is text\n"] {
        std::fs::write(&path, text).unwrap();
        expect(&icoray_netcdf::open(&path).unwrap_err(), ErrorKind::Io, &["notes.nc"]);
    }
}

/// No server listens at port 1 of this machine.
#[test]
fn addresses_are_refused_in_the_words_of_the_library() {
    let address = "https://127.0.0.1:1/notes.nc";
    let parts = [address, "the NetCDF library cannot open this address: netcdf error(-"];
    expect(&icoray_netcdf::open(address).unwrap_err(), ErrorKind::Io, &parts);
    assert!(!icoray_netcdf::Outline::is_classic(address).unwrap());
}

#[test]
fn errors_name_other_formats_and_their_readers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("icon.grib2");
    std::fs::write(&path, b"GRIB\0\0\0\x02 and more").unwrap();
    let parts =
        ["icon.grib2: a file of GRIB 2", "cdo -f nc copy", "icon.grib2 NEW.nc` converts it", "xarray and cfgrib"];
    expect(&icoray_netcdf::open(&path).unwrap_err(), ErrorKind::Io, &parts);
}
