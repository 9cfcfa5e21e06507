//! Options for opening a dataset.

/// Facts that the files of a dataset lack, and entries of dimensions that are neither columns, layers nor time.
#[derive(Debug, Clone, Default)]
pub struct DatasetOptions {
    /// Name of a dimension, and the entry along it, from 0, that is read for every variable.
    pub at: Vec<(String, usize)>,
    /// Heights above the sphere of the first and of the last layer of every field with layers, metres; those between
    /// are evenly spaced. They replace the heights of files.
    pub heights_m: Option<[f64; 2]>,
    /// Radius of the sphere, metres; it replaces that of files.
    pub radius_m: Option<f64>,
    /// Values that mark missing samples of every field, beside those of attributes.
    pub missing: Vec<f64>,
}
