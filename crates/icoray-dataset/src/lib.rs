//! Reads datasets of models on geodesic grids as grids, layers and fields: MPAS-Atmosphere, MPAS-Ocean, MPAS-Seaice,
//! ICON, FESOM2, FVCOM, DYNAMICO.
//!
//! A [`Source`] is an open file, or a dataset in memory: variables with dimensions and attributes. [`Dataset`] finds
//! the mesh, the heights of layers and the fields in it, by the conventions of the models; a field is read on demand,
//! one time record at a time, all layers or some, in the source's order and precision, and without a copy if it is in
//! memory.
//!
//! MPAS's datasets follow the MPAS mesh specification 1.0
//! (<https://mpas-dev.github.io/files/documents/MPAS-MeshSpec.pdf>). ICON's triangles are corners of the hexagons
//! around their points, so its fields are at corners; if a dataset has no tables they are rebuilt from the triangles'
//! bounds. DYNAMICO's hexagons and SCRIP's polygons are rebuilt from theirs. Columns with only longitudes and latitudes
//! are joined by Delaunay triangles, and corners of more than three polygons are cut into triangles. Tables of MPAS
//! that a dataset lacks are derived from the others if these determine them. Fields at edges become fields at centres.
//!
//! [`SceneFields`] finds the data that a scene needs, [`Series`] reads them time by time, [`Drawing`] draws them, and
//! with the feature `live` the module `view` answers the live page.
//!
//! [`Sample`] is a small dataset to try these on.
//!
//! A 2D field, such as surface pressure, has the same values on any number of layers, and takes the memory of one.
#![forbid(unsafe_code)]

mod calendar;
mod combined;
mod dataset;
mod drawing;
mod edges;
mod field;
mod heights;
mod joined;
mod layering;
mod likely_fields;
mod mesh;
mod raster;
mod sample;
mod scene_fields;
mod sea;
mod series;
mod source;
mod sources;
mod standard_atmosphere;
mod stored;
mod suggest;
mod time_selection;
mod times;
mod values;
#[cfg(feature = "live")]
pub mod view;

pub use combined::Combined;
pub use dataset::Dataset;
pub use drawing::{Drawing, NativeHeightCache};
pub use edges::variable_at_edges;
pub use field::{FieldInfo, OwnedField};
pub use heights::LayerHeights;
pub use heights::native::{NativeHeights, NativeInfo};
pub use layering::{LayerSelection, Layering};
pub use mesh::{DistinctPoints, Mesh, MeshLayout};
pub use sample::{Sample, SampleValues, SampleVariable};
pub use scene_fields::{Key, SceneField, SceneFields};
pub use series::{FieldCache, Series};
pub use source::{Attribute, Dimension, Kind, Source, Variable};
pub use sources::DatasetOptions;
pub use time_selection::TimeSelection;
pub use times::Times;
pub use values::{AssumedMark, Memory, Values};
