//! The options of `icoray-study vtk`.

use std::path::PathBuf;

/// Options of the comparison.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron, one size after another.
    #[arg(long, value_delimiter = ',', default_value = "4,5")]
    pub levels: Vec<u32>,
    /// Layers.
    #[arg(long, default_value_t = 20)]
    pub layers: usize,
    /// Width and height of the picture.
    #[arg(long, default_value_t = 512)]
    pub size: u32,
    /// Transfer functions: dense, lobes, thin, opaque.
    #[arg(long, value_delimiter = ',', default_value = "dense,lobes")]
    pub transfers: Vec<String>,
    /// VTK's renderers: bunyk and projected-tetrahedra are given tetrahedra, zsweep wedges.
    #[arg(long, value_delimiter = ',', default_value = "bunyk,zsweep,projected-tetrahedra")]
    pub renderers: Vec<String>,
    /// Tolerance of icoray's pictures.
    #[arg(long, default_value_t = 1e-3)]
    pub tolerance: f64,
    /// Threads; VTK's z-sweep has one.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Frames of the same values and of new ones; the first one of VTK sorts and splits, the least of the others is
    /// reported.
    #[arg(long, default_value_t = 3)]
    pub frames: usize,
    /// GiB that a VTK process may have; where it does not fit, that is reported.
    #[arg(long, default_value_t = 12.0)]
    pub memory: f64,
    /// Seconds that a VTK process may take.
    #[arg(long, default_value_t = 600)]
    pub patience: u64,
    /// The Python that makes VTK's environment.
    #[arg(long, default_value = "python3")]
    pub python: PathBuf,
    /// Directory for VTK's environment, vtk.csv, vtk.md and the pictures.
    #[arg(long, default_value = "out/vtk")]
    pub out: PathBuf,
    /// A file in which the tables take the place of those between its lines `<!-- icoray-study vtk -->` and
    /// `<!-- end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}
