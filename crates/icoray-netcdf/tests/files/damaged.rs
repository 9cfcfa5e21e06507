//! Files that are cut off, damaged or not NetCDF give errors that name them, never values that were not stored.

use crate::made::{Made, RECORDS, value};
use crate::memory::expect;
use crate::written::formats;
use icoray::{ErrorKind, Result};
use netcdf::Options;
use std::path::Path;

/// Reads all there is; values must be those that were written, where they are given at all.
fn read_all(path: &Path) -> Result<()> {
    let file = icoray_netcdf::open(path)?;
    file.mesh().grid()?;
    file.layers("theta")?;
    for info in file.fields().iter().filter(|f| f.name != "zgrid") {
        for time in 0..RECORDS {
            let owned = file.read_field(&info.name, time)?;
            let (column, layer) = (info.columns - 1, info.layers - 1);
            let record = if info.time_dependent { time } else { 0 };
            assert_eq!(owned.field()?.value(column, layer), value(record, column, layer), "{}", info.name);
        }
    }
    Ok(())
}

#[test]
fn a_file_cut_off_anywhere_is_an_error() {
    for (format, options) in formats() {
        let (folder, path) = Made::history().write(options);
        read_all(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let cut = folder.path().join("cut.nc");
        // At every part, and just before the end; the records end with surface_pressure, which is no field.
        let unread = 4 * 42 + 8;
        for length in (0..whole.len() - unread).step_by(397).chain([whole.len() - unread]) {
            std::fs::write(&cut, &whole[..length]).unwrap();
            let error = read_all(&cut).expect_err(&format!("{format} cut to {length} of {} bytes", whole.len()));
            assert!(error.to_string().contains("cut.nc"), "{error}");
        }
    }
}

/// The only record variable of a classic file is packed without padding: its records must be found all the same.
#[test]
fn a_lone_record_variable_is_found() {
    let mut made = Made::mesh(false);
    made.dimensions.extend([("nVertLevels", 2), ("Time", 0), ("StrLen", 19)]);
    made.add("xtime", &["Time", "StrLen"], crate::made::Values::Text(b"2013-10-25_00:00:00".repeat(5)));
    for (format, options) in formats() {
        let (_folder, path) = made.write(options);
        let times = icoray_netcdf::open(&path).unwrap().times().to_vec();
        assert_eq!(times, vec![Some("2013-10-25_00:00:00".to_owned()); 5], "{format}");
    }
}

#[test]
fn a_header_that_lies_is_an_error() {
    let (_folder, path) = Made::history().write(Options::_64BIT_OFFSET);
    let whole = std::fs::read(&path).unwrap();
    // The length of nCells follows its name in the list of dimensions.
    let at = whole.windows(6).position(|w| w == b"nCells").unwrap() + 8;
    let mut bytes = whole.clone();
    bytes[at..at + 4].copy_from_slice(&0x0400_0000u32.to_be_bytes());
    std::fs::write(&path, &bytes).unwrap();
    expect(&icoray_netcdf::open(&path).unwrap_err(), ErrorKind::Io, &["made.nc"]);
}

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
