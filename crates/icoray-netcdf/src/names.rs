//! Names of files: addresses, which the NetCDF library opens, and local files. Errors for Zarr and GRIB name their
//! readers.

use icoray::{Error, ErrorKind, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Entries of a directory of which one is in each Zarr store: of version 2, consolidated, and of version 3.
const ZARR: [&str; 4] = [".zgroup", ".zarray", ".zmetadata", "zarr.json"];

/// Whether a name is an address (`https://`, `s3://`, NCZarr's `file://`), not a local file.
pub(crate) fn is_address(path: &Path) -> bool {
    path.to_string_lossy().contains("://") && !path.exists()
}

/// Fails where a local file is absent or none, and says what to do with a Zarr store and with GRIB.
pub(crate) fn expect_netcdf(path: &Path) -> Result<()> {
    let shown = path.display();
    let error = |what: String| Error::new(ErrorKind::Io, format!("{shown}: {what}"));
    let io = |e: std::io::Error| error(e.to_string());
    if ZARR.iter().any(|name| path.join(name).exists()) {
        return Err(error(format!(
            "a Zarr store, expected a NetCDF file: in Python `icoray.open(\"{shown}\")` reads it with xarray and zarr"
        )));
    }
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Err(error("not a file".to_owned()));
    }
    let mut begin = Vec::new();
    File::open(path).and_then(|file| file.take(8).read_to_end(&mut begin)).map_err(io)?;
    match begin[..] {
        [b'G', b'R', b'I', b'B', _, _, _, edition] => Err(error(format!(
            "a file of GRIB {edition}, expected NetCDF: `cdo -f nc copy {shown} NEW.nc` converts it; in Python \
             `icoray.open(\"{shown}\")` reads it with xarray and cfgrib"
        ))),
        _ => Ok(()),
    }
}
