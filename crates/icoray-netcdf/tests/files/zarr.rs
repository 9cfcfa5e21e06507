//! Zarr stores and addresses, which the NetCDF library opens.

use crate::made::{Made, RECORDS, Values};
use crate::memory::{self, expect};
use icoray::ErrorKind;
use icoray_test_support::{Need, skip};
use netcdf::Options;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// Writes a history as a store of Zarr alone, as xarray does. Where the library has no Zarr, checks the error of opening,
/// and skips the test.
fn write(made: &Made) -> Option<(TempDir, PathBuf)> {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("made.zarr");
    let address = format!("file://{}#mode=zarr,file", store.display());
    if let Err(error) = netcdf::create_with(&address, Options::NETCDF4) {
        expect(&icoray_netcdf::open(&address).unwrap_err(), ErrorKind::Io, &[&address, &error.to_string()]);
        skip(Need::Zarr);
        return None;
    }
    made.write_to(address.as_ref(), Options::NETCDF4);
    Some((folder, store))
}

/// A history whose times are numbers and not unlimited, which not every version of NCZarr has.
fn history() -> Made {
    let mut made = Made::history();
    made.dimensions.iter_mut().filter(|(name, _)| *name == "Time").for_each(|(_, len)| *len = RECORDS);
    made.remove("xtime");
    made.add("Time", &["Time"], Values::F64(vec![0.0, 1.0, 2.0])).attributes =
        vec![("units", "days since 2000-01-01".into())];
    made
}

#[test]
fn stores_are_read_by_their_folders_and_by_their_addresses() {
    let made = history();
    let Some((_folder, store)) = write(&made) else { return };
    let expected = memory::open(&made);
    let name = store.display().to_string();
    for name in [name.clone(), format!("{name}#mode=zarr,file"), format!("file://{name}#mode=nczarr,file")] {
        assert!(!icoray_netcdf::Outline::is_classic(&name).unwrap(), "a process of its own reads it");
        let file = icoray_netcdf::open(&name).unwrap();
        assert!(file.mesh().is_same(expected.mesh()), "{name}");
        assert_eq!(file.times(), expected.times());
        for field in ["theta", "rho"] {
            let [found, expected] = [&file, &expected].map(|dataset| dataset.read_field(field, 1).unwrap());
            assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{name}: {field}");
        }
    }
}

/// Where the library has a filter's plugin the values are of the store, else nothing is read as if it were not packed.
#[test]
fn packed_values_and_other_versions_are_refused_with_their_readers() {
    let Some((_folder, store)) = write(&history()) else { return };
    let name = store.display().to_string();
    let parts = ["made.zarr", &format!("in Python `icoray.open(\"{name}\")` reads it with xarray and zarr")];
    let metadata = store.join("rho/.zarray");
    let plain = fs::read_to_string(&metadata).unwrap();
    for (key, value) in [
        ("compressor", r#"{"id": "none of the filters"}"#),
        ("filters", r#"[{"id": "none of the filters"}]"#),
        ("dtype", r#""<U8""#),
    ] {
        let mut changed: serde_json::Value = serde_json::from_str(&plain).unwrap();
        changed[key] = serde_json::from_str(value).unwrap();
        fs::write(&metadata, changed.to_string()).unwrap();
        for name in [name.clone(), format!("file://{name}#mode=nczarr,file")] {
            let read = icoray_netcdf::open(&name).and_then(|file| file.read_field("rho", 0));
            expect(&read.unwrap_err(), ErrorKind::Io, &parts);
        }
    }
    fs::write(store.join("zarr.json"), "{}").unwrap();
    expect(&icoray_netcdf::open(&store).unwrap_err(), ErrorKind::Io, &parts);
    expect(&icoray_netcdf::open(&store).unwrap_err(), ErrorKind::Io, &["Zarr of version 3, expected version 2"]);
}
