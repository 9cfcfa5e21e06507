//! MPAS files as grids, layers and fields.
//!
//! [`MpasFile::open`] reads the mesh tables and lists the fields; a field is read on demand, one time record at a time, in
//! the precision stored. Classic NetCDF (CDF-1, CDF-2, CDF-5) and NetCDF-4 are read. Layouts are those of the MPAS mesh
//! specification 1.0 (<https://mpas-dev.github.io/files/documents/MPAS-MeshSpec.pdf>).
//!
//! ```no_run
//! # fn main() -> icoray::Result<()> {
//! let file = icoray_netcdf::MpasFile::open("history.nc")?;
//! let grid = file.mesh().grid()?;
//! let theta = file.read_field("theta", 0)?;
//! let field = theta.field()?;
//! let layers = file.layers()?.for_field(theta.info().layers)?;
//! assert_eq!(field.shape().columns, grid.cells());
//! assert_eq!(field.shape().layers, layers.count());
//! # Ok(())
//! # }
//! ```

mod classic;
mod field;
mod file;
mod heights;
mod mesh;
mod quiet;
mod reals;
mod source;

pub use field::{FieldInfo, OwnedField, Precision};
pub use file::MpasFile;
pub use heights::LayerHeights;
pub use mesh::MpasMesh;
