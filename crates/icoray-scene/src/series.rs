//! Index files of a run's pictures.

/// The index files that are written; none by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// A list of the pictures that ffmpeg reads.
    pub concat: Option<Concat>,
    /// A database of the pictures by their parameters.
    pub cinema: Option<Cinema>,
}

/// A list of pictures for ffmpeg's demuxer `concat`.
#[derive(Debug, Clone, PartialEq)]
pub struct Concat {
    /// Its file, relative to the directory of the pictures.
    pub file: String,
    /// Pictures per second, positive.
    pub fps: f64,
}

/// A Cinema database (specification D): a folder with pictures and `data.csv`, which has a row of parameters for each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cinema {
    /// Its folder, relative to the directory of the pictures; the pictures lie in it.
    pub folder: String,
    /// Names and values of the picture's parameters beside step and time, in order.
    pub parameters: Vec<(&'static str, String)>,
}
