//! Only the requested times, layers and fields are read.

use crate::made::{LAYERS, Made, RECORDS, Values};
use crate::memory::expect;
use icoray::ErrorKind;
use icoray_netcdf::Outline;
use netcdf::Options;

/// A field without its other variables, times and layers: each of them is cut off, or ends in a hole.
#[test]
fn nothing_else_is_read() {
    let mut made = Made::history();
    // In a classic file records lie behind each other, so that only the first is whole.
    let records: Vec<_> = ["xtime", "theta", "w", "vorticity", "surface_pressure"].to_vec();
    made.variables.sort_by_key(|v| records.contains(&v.name));
    let (_folder, path) = made.write(Options::_64BIT_OFFSET);
    let whole = std::fs::read(&path).unwrap();
    let record: usize = 64 + 42 * (4 * LAYERS + 8 * (LAYERS + 1)) + 80 * 8 * LAYERS + 42 * 4;
    std::fs::write(&path, &whole[..whole.len() - (RECORDS - 1) * record]).unwrap();
    let file = icoray_netcdf::open(&path).unwrap();
    file.layers("theta").unwrap();
    for name in ["theta", "w", "vorticity", "rho"] {
        file.read_field(name, 0).unwrap();
    }
    let parts = ["made.nc", "variable theta ends at byte", "the file is cut off"];
    expect(&file.read_field("theta", 1).unwrap_err(), ErrorKind::Io, &parts);
    assert_eq!(file.times()[1..], [None, None]);
}

/// A few kilobytes that claim to hold gigabytes, none of which was written.
#[test]
fn files_that_claim_more_than_they_can_hold_are_refused() {
    let mut made = Made::history();
    made.remove_all(&["theta", "w", "vorticity", "rho", "levels", "zgrid", "surface_pressure"]);
    made.dimensions.iter_mut().find(|d| d.0 == "nVertLevels").unwrap().1 = 1 << 30;
    made.add("theta", &["Time", "nCells", "nVertLevels"], Values::F32(Vec::new()));
    let (_folder, path) = made.write(Options::NETCDF4);
    let error = icoray_netcdf::open(&path).unwrap().read_field("theta", 0).unwrap_err();
    let said = ["theta(Time = 3, nCells = 42, nVertLevels = 1073741824) of float", "more than a file of"];
    expect(&error, ErrorKind::Io, &said);
}

/// A file that a model is writing has a component of a vector at edges where it has the vector's variable.
#[test]
fn fields_at_edges_are_known_by_their_variables() {
    let mut made = Made::history();
    made.add("vn", &["Time", "nEdges"], Values::F64(vec![1.0; RECORDS * 120]));
    let (_folder, path) = made.write(Options::_64BIT_OFFSET);
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() - 8]).unwrap();
    let outline = Outline::read(&path).unwrap();
    let last = RECORDS - 1;
    for field in ["vn", "vn_zonal", "vn_meridional"] {
        assert!(outline.has_record(field, last - 1) && outline.promises(field, last), "{field}");
        assert!(!outline.has_record(field, last), "{field} is cut off");
    }
    assert!(!outline.has("vn_radial") && !outline.has("wind_zonal"));
    let fields = ["vn_zonal".to_owned()];
    Outline::try_reading(&path, &fields, last - 1).unwrap();
    expect(&Outline::try_reading(&path, &fields, last).unwrap_err(), ErrorKind::Io, &["vn", "cut off"]);
}
