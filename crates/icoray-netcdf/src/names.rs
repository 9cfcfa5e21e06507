//! Names of files: addresses, which the NetCDF library opens, and local files. Errors for GRIB name its readers.

use icoray::{Error, ErrorKind, Result};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The address that the NetCDF library opens: a name that is one (`https://`, `s3://`), or that of a file whose name is
/// followed by `#mode=`; `None` for other local files.
pub(crate) fn address(path: &Path) -> Option<PathBuf> {
    let text = path.to_string_lossy();
    let of_file = |file: &Path, mode: &str| {
        let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        PathBuf::from(format!("file://{}#mode={mode}", absolute.display()))
    };
    match text.split_once("#mode=") {
        _ if path.exists() => None,
        _ if text.contains("://") => Some(path.to_owned()),
        Some((file, mode)) => Some(of_file(file.as_ref(), mode)),
        None => None,
    }
}

/// Fails where a local file is absent or none, and says what to do with GRIB.
pub(crate) fn expect_netcdf(path: &Path) -> Result<()> {
    let shown = path.display();
    let error = |what: String| Error::new(ErrorKind::Io, format!("{shown}: {what}"));
    let io = |e: std::io::Error| error(e.to_string());
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
