//! A rank's result of a finished picture.

use icoray_output::{Frame, FrameReport};

/// A rank's result of a finished picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Rendered {
    /// The picture, on rank 0.
    Here(Frame),
    /// The picture's report; the pixels are at rank 0. Errors, counts and the gathering are those of the whole picture;
    /// seconds, threads and tiles are this rank's.
    AtRoot(FrameReport),
}

impl Rendered {
    pub(super) fn report_mut(&mut self) -> &mut FrameReport {
        match self {
            Rendered::Here(frame) => &mut frame.report,
            Rendered::AtRoot(report) => report,
        }
    }
}
