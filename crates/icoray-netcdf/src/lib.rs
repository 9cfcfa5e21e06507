//! NetCDF files of models as [`Dataset`]s: classic ones (CDF-1, CDF-2, CDF-5) and NetCDF-4.
//!
//! The NetCDF library accepts one call at a time in the whole process; reading from several threads gains nothing.
//! A path may be an address (`https://`, `s3://`) that this library opens. Zarr stores of versions 2 and 3, in folders and
//! on web servers, are read without it. Variables in groups are named by their paths, `group/name`.
//!
//! Damaged classic files give errors. A damaged NetCDF-4 file may end the process inside the HDF5 library, or keep it
//! there for ever: [`watch_calls`] finds the latter. The command `icoray` therefore reads such files in a child
//! process.
//!
//! ```no_run
//! # fn main() -> icoray::Result<()> {
//! let file = icoray_netcdf::open("history.nc")?;
//! let grid = file.mesh().grid()?;
//! let theta = file.read_field("theta", 0)?;
//! let field = theta.field()?;
//! let layers = file.layers("theta")?;
//! assert_eq!(field.shape().columns, grid.cells());
//! assert_eq!(field.shape().layers, layers.count());
//! # Ok(())
//! # }
//! ```

mod classic;
mod filters;
mod guard;
mod nc_file;
mod outline;
mod sample_file;
mod zarr;

pub use guard::{end_process, watch_calls};
pub use icoray_dataset::Dataset;
pub use outline::Outline;
pub use sample_file::write_sample;

use icoray::Result;
use icoray_dataset::{Combined, DatasetOptions, Mesh, Source, Variable};
use nc_file::NcFile;
use std::path::Path;
use std::sync::Arc;
use zarr::ZarrStore;

/// Opens a file that holds the mesh and, mostly, fields; reads the mesh tables.
///
/// ```no_run
/// let file = icoray_netcdf::open("mpas_jw_10242.nc")?;
/// for field in file.fields() {
///     println!("{}: {} layers", field.name, field.layers);
/// }
/// let grid = file.mesh().grid()?;
/// let values = file.read_field("theta", 0)?;
/// let layers = file.layers("theta")?;
/// # Ok::<(), icoray::Error>(())
/// ```
///
/// # Errors
/// As [`Dataset::new`]; also [`ErrorKind::Io`](icoray::ErrorKind::Io) when the file is absent or not NetCDF.
pub fn open(path: impl AsRef<Path>) -> Result<Dataset> {
    open_all(&[path], &[] as &[&Path], None, DatasetOptions::default())
}

/// Opens files of one run, which are read as one ([`Combined::of`]), with others that have what these lack, and with
/// facts that all files lack.
///
/// # Errors
/// As [`open`], [`Combined::of`] and [`Dataset::new`].
pub fn open_all(
    paths: &[impl AsRef<Path>],
    others: &[impl AsRef<Path>],
    mesh: Option<Arc<Mesh>>,
    options: DatasetOptions,
) -> Result<Dataset> {
    Dataset::new(Combined::of(all_opened(paths)?)?, all_opened(others)?, mesh, options)
}

/// The variables of a file, whether or not it has a mesh: name, dimensions and type of each, with its long name and
/// units.
///
/// # Errors
/// [`ErrorKind::Io`](icoray::ErrorKind::Io) when the file is absent, not NetCDF or damaged.
pub fn contents(path: impl AsRef<Path>) -> Result<Vec<String>> {
    let opened = opened(path.as_ref())?;
    let source = &*opened;
    let line = |variable: &Variable| -> Result<String> {
        let text = |attribute: &str| source.text_of(&variable.name, attribute);
        let units = text("units")?.map(|units| format!("[{units}]"));
        let parts = [Some(variable.to_string()), text("long_name")?, units];
        Ok(parts.into_iter().flatten().collect::<Vec<_>>().join("  "))
    };
    source.variables().iter().map(line).collect()
}

fn all_opened(paths: &[impl AsRef<Path>]) -> Result<Vec<Box<dyn Source>>> {
    paths.iter().map(|path| opened(path.as_ref())).collect()
}

fn opened(path: &Path) -> Result<Box<dyn Source>> {
    Ok(match zarr::Location::of(path) {
        Some(location) => Box::new(ZarrStore::open(path, &location)?),
        None => Box::new(NcFile::open(path)?),
    })
}
