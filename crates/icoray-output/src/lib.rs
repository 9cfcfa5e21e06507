//! The output of icoray: pictures as PNG and EXR with their labels, maps of their errors, `report.csv`, lists of
//! pictures, Cinema databases and animations. Each file is written completely or not at all.
#![forbid(unsafe_code)]

mod animation;
mod atomic;
mod error_map;
mod exr_file;
mod folder;
mod frame;
mod label;
mod lists;
pub mod outcomes;
mod png_file;
mod report;
mod write;
pub mod writer;

pub use animation::{Animated, write_animation};
pub use atomic::{Existing, write_text};
pub use error_map::write_error_map;
pub use exr_file::exr_bytes;
pub use frame::{
    CellsPerPixel, Certainty, Colors, DeviceReport, ErrorSummary, Frame, FrameReport, Legend, RanksReport,
    SamplingError, SamplingReport, Sharing, Timing, figures,
};
pub use label::printed_units;
pub use outcomes::{Outcome, Outcomes};
pub use png_file::{png_bytes, png_layers, rgba8};
pub use write::{write_color_maps, write_frame, write_picture, write_picture_with};
pub use writer::{Submitted, WhenFull, Writer, WriterOptions, Written};
