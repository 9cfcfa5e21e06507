//! Files of models on geodesic grids as grids, layers and fields: MPAS-Atmosphere, MPAS-Ocean, MPAS-Seaice, ICON,
//! DYNAMICO.
//!
//! [`ModelFile::open`] reads the mesh tables and lists the fields; a field is read on demand, one time record at a
//! time, all layers or some, in the file's order and precision. Classic NetCDF (CDF-1, CDF-2, CDF-5) and NetCDF-4 are
//! read.
//!
//! MPAS's files follow the MPAS mesh specification 1.0 (<https://mpas-dev.github.io/files/documents/MPAS-MeshSpec.pdf>).
//! ICON's triangles are corners of the hexagons around their points, so that its fields are at corners; where a file
//! has no tables they are rebuilt from the triangles' bounds. DYNAMICO's hexagons are rebuilt from theirs. Tables of
//! MPAS that a file lacks are made of the others where these determine them.
//!
//! A 2D field, such as surface pressure, has the same values on as many layers as are asked for, and costs the memory
//! of one.
//!
//! ```no_run
//! # fn main() -> icoray::Result<()> {
//! let file = icoray_netcdf::ModelFile::open("history.nc")?;
//! let grid = file.mesh().grid()?;
//! let theta = file.read_field("theta", 0)?;
//! let field = theta.field()?;
//! let layers = file.layers("theta")?;
//! assert_eq!(field.shape().columns, grid.cells());
//! assert_eq!(field.shape().layers, layers.count());
//! # Ok(())
//! # }
//! ```

mod calendar;
mod classic;
mod field;
mod file;
mod floor;
mod hdf5_errors;
mod heights;
mod joined;
mod likely_fields;
mod mesh;
mod nc_file;
mod nc_files;
mod outline;
mod reals;
mod sea;
mod standard_atmosphere;
mod times;

pub use field::{FieldInfo, OwnedField, Precision};
pub use file::ModelFile;
pub use heights::LayerHeights;
pub use heights::native::{NativeHeights, NativeInfo};
pub use mesh::{Convention, Mesh};
pub use outline::Outline;
