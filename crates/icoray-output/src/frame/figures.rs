//! The figures of a frame's report, each declared once: its name, its type in C, its meaning and its value.
//!
//! [`FIGURES`] determines everything that states figures: the columns of `report.csv`, the texts of pictures, the
//! structs of C and Fortran, the dicts of Python and their types, and the table in `docs/src/reports.md`.
//! `tests/header` compares and writes the generated files that are checked in.

use super::{Certainty, Colors, DeviceReport, FrameReport};
use icoray_grid::numbers;
use icoray_scene::Scheme;
use icoray_scene::name::Stamp;
use std::fmt;

/// A figure of a frame.
#[derive(Debug)]
pub struct Figure {
    /// Its name, with its unit if it has one: `_s` is seconds, `bytes` are bytes.
    pub name: &'static str,
    /// Its description, in lines that end with a newline each.
    pub meaning: &'static str,
    /// The places that state it.
    pub scope: Scope,
    /// Its type in words.
    pub kind: FigureType,
    /// Its type in C, by Rust's name; `None` if the struct of C does not have it.
    pub c_type: Option<&'static str>,
    value: fn(&FigureSource) -> Value,
}

/// The places that state a figure; each scope includes the previous ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// In the structs of C and Fortran and by `Context.report()` of Python: a figure of a model's calls.
    Host,
    /// In `report.csv` and in `Image.report` of Python too: a figure of one frame.
    Frame,
    /// In the texts of picture files too: a figure of the picture's contents, independent of its cost.
    Picture,
}

/// Type of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FigureType {
    /// Its type in Python.
    pub python: &'static str,
    /// The words for the numbers in C, from 0; empty if numbers stand for themselves.
    pub words: &'static [&'static str],
}

/// The value of a figure; it is displayed as in `report.csv`.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// No value.
    None,
    /// True or false.
    Flag(bool),
    /// An integer.
    Integer(i64),
    /// A float.
    Float(f64),
    /// A text or a word.
    Text(String),
    /// Texts.
    Texts(Vec<String>),
    /// Colour maps with their ranges.
    ColorMaps(Vec<Colors>),
}

/// The data from which figures are read.
struct FigureSource<'a> {
    stamp: &'a Stamp,
    report: &'a FrameReport,
    host: &'a CFrameReport,
}

/// Declares figures: `Scope name: type FigureType = value`, after the description as a doc comment; those in C in the
/// order of the struct there, with their types there, and then the others.
macro_rules! figures {
    (
        $(#[doc = $about:literal])*
        struct { $($(#[doc = $doc:literal])* $scope:ident $name:ident: $type:ident $kind:ident = $value:expr,)* }
        others {
            $($(#[doc = $other_doc:literal])* $other_scope:ident $other:ident: $other_kind:ident
                = $other_value:expr,)*
        }
    ) => {
        /// Description of the structs of C and Fortran, in lines that end with a newline each.
        pub const ABOUT: &str = concat!($($about, "\n"),*);

        /// All figures, those in C first.
        pub const FIGURES: &[Figure] = &[
            $(Figure {
                name: stringify!($name),
                meaning: concat!($($doc, "\n"),*),
                scope: Scope::$scope,
                kind: $kind,
                c_type: Some(stringify!($type)),
                value: |source| {
                    let value: fn(&FigureSource) -> $type = $value;
                    value(source).into()
                },
            },)*
            $(Figure {
                name: stringify!($other),
                meaning: concat!($($other_doc, "\n"),*),
                scope: Scope::$other_scope,
                kind: $other_kind,
                c_type: None,
                value: $other_value,
            },)*
        ];

        $(#[doc = $about])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, Default)]
        pub struct CFrameReport {
            /// Size of this struct, bytes.
            pub struct_size: usize,
            $($(#[doc = $doc])* pub $name: $type,)*
        }

        impl CFrameReport {
            /// Names and offsets of the figures, in bytes.
            pub const OFFSETS: &[(&str, usize)] =
                &[$((stringify!($name), std::mem::offset_of!(CFrameReport, $name)),)*];

            /// The report of a frame; figures of a model's calls are those of `host`.
            pub fn of(stamp: &Stamp, report: &FrameReport, host: &CFrameReport) -> Self {
                let source = FigureSource { stamp, report, host };
                CFrameReport {
                    struct_size: size_of::<CFrameReport>(),
                    $($name: {
                        let value: fn(&FigureSource) -> $type = $value;
                        value(&source)
                    },)*
                }
            }

            /// The figures with their values.
            pub fn figures(&self) -> impl Iterator<Item = (&'static Figure, Value)> {
                let values = [$(Value::from(self.$name)),*];
                FIGURES.iter().zip(values).map(|(figure, value)| (figure, figure.kind.read(value)))
            }
        }
    };
}

const INTEGER: FigureType = FigureType { python: "int", words: &[] };
const FLOAT: FigureType = FigureType { python: "float", words: &[] };
const OPTIONAL_FLOAT: FigureType = FigureType { python: "float | None", words: &[] };
const OPTIONAL_TEXT: FigureType = FigureType { python: "str | None", words: &[] };
const TEXTS: FigureType = FigureType { python: "list[str]", words: &[] };
const COLOR_MAPS: FigureType = FigureType { python: "list[_Colors]", words: &[] };
const FLAG: FigureType = FigureType { python: "bool", words: &["false", "true"] };
/// [`Lights`](icoray_scene::Lights) by number.
const LIGHTS: FigureType = FigureType { python: "str", words: &["off", "coarse", "full"] };
/// `ICORAY_ALONE` and so on.
const SCHEMES: FigureType = FigureType { python: "str", words: &["alone", "tiles", "fragments"] };
/// `ICORAY_CPU` and so on.
const PROCESSORS: FigureType = FigureType { python: "str", words: &["cpu", "gpu", "gpu and cpu"] };

figures! {
    /// Cost and error of the last rendered frame, and counts of all frames so far. Seconds are wall-clock time.
    ///
    /// If one call of icoray_execute rendered several frames, host_s, waited_s, copy_s and bytes_copied are sums over
    /// them, `frames` is their number, and all other members are of the last one. With async_render the report is of
    /// the frame that was finished last; icoray_wait waits for the one in progress.
    ///
    /// The error of a pixel is the largest error of its channels (premultiplied, linear, 0 to 1) against the exact
    /// integral of the interpolated field along its ray. It does not include the error of the interpolation between
    /// cells and layers. A pixel that was not traced (pixel_step) has an error of 1, or of the brightest that the scene
    /// may show.
    struct {
        /// Step passed to icoray_execute.
        Picture step: i64 INTEGER = |f| f.stamp.step,
        /// Time passed to icoray_execute, seconds.
        Picture time_s: f64 FLOAT = |f| f.stamp.time_s,
        /// Seconds that the call of icoray_execute took.
        Host host_s: f64 FLOAT = |f| f.host.host_s,
        /// Part of host_s: waiting for a full queue or for earlier frames.
        Frame waited_s: f64 FLOAT = |f| f.host.waited_s,
        /// Part of host_s: copying fields (async_render; fields distributed over ranks, including waiting for other
        /// ranks).
        Frame copy_s: f64 FLOAT = |f| f.host.copy_s,
        /// Seconds for value range, averages of corner fields, and gradients.
        Frame prepare_s: f64 FLOAT = |f| f.report.timing.prepare_s,
        /// Seconds for tracing rays.
        Frame render_s: f64 FLOAT = |f| f.report.timing.render_s,
        /// Seconds for encoding and writing the frame that was written last, on the writing thread.
        Frame write_s: f64 FLOAT = |f| f.host.write_s,
        /// Rays that meet the shell.
        Frame rays: u64 INTEGER = |f| f.report.counts.rays,
        /// Columns that these rays cross.
        Frame columns: u64 INTEGER = |f| f.report.counts.columns,
        /// Frusta that these rays cross and read.
        Frame frusta: u64 INTEGER = |f| f.report.counts.frusta,
        /// Frusta among these that are empty because of a missing value.
        Frame void_frusta: u64 INTEGER = |f| f.report.counts.void_frusta,
        /// Smallest value of the field; NaN if all values are missing.
        Picture value_min: f64 OPTIONAL_FLOAT = |f| f.report.value_range.map_or(f64::NAN, |[low, _]| low),
        /// Largest value of the field; NaN if all values are missing.
        Picture value_max: f64 OPTIONAL_FLOAT = |f| f.report.value_range.map_or(f64::NAN, |[_, high]| high),
        /// Number of values that are NaN, infinite or equal to fill_value.
        Frame missing_values: u64 INTEGER = |f| f.report.missing_values,
        /// Bytes of fields that were copied: 0, or those of the fields with async_render. For columns distributed over
        /// ranks: bytes of columns that this rank wrote to the memory of its node.
        Frame bytes_copied: u64 INTEGER = |f| f.host.bytes_copied,
        /// Bytes derived from the field: averages of corner fields, gradients; averages that this rank wrote to the
        /// memory of its node count here. One rank of each node counts what else its ranks share: gradients, visible
        /// blocks, fields made of others and, with parts, the tables of the node's mesh.
        Frame bytes_derived: u64 INTEGER = |f| f.report.bytes_derived as u64,
        /// Largest number of bytes that icoray has held at once in this process, over all contexts and meshes; without
        /// memory that the ranks of a node share.
        Host bytes_peak: u64 INTEGER = |f| f.host.bytes_peak,
        /// Largest error of a pixel.
        Picture error_max: f64 FLOAT = |f| f.report.error.max,
        /// Mean error of the pixels with an error above 0; 0 if there are none.
        Picture error_mean: f64 FLOAT = |f| f.report.error.mean,
        /// 99.9th percentile of the errors above 0; 0 if there are none.
        Picture error_p999: f64 FLOAT = |f| f.report.error.p999,
        /// Largest error allowed in a traced pixel: the scene's tolerance, or a larger one to keep its time_budget_ms.
        Picture tolerance: f64 FLOAT = |f| f.report.quality.tolerance,
        /// 1 if the errors are bounds (unlit, f64), 0 if they are estimates.
        Picture error_is_bound: i32 FLAG = |f| (f.report.error.certainty == Certainty::Bound).into(),
        /// Every how many pixels one is traced, in both directions, the others being interpolated: 1, or more to keep
        /// the scene's time_budget_ms.
        Picture pixel_step: i32 INTEGER = |f| f.report.quality.pixel_step as i32,
        /// Light: 0 off, 1 coarse (to keep the time budget), 2 full.
        Picture lights: i32 LIGHTS = |f| f.report.quality.lights as i32,
        /// Number of rendering threads.
        Frame threads: i32 INTEGER = |f| f.report.threads as i32,
        /// Frames written so far.
        Host frames_written: u64 INTEGER = |f| f.host.frames_written,
        /// Frames so far that could not be rendered or written; without those refused with ICORAY_ERR_EXISTS.
        Host frames_failed: u64 INTEGER = |f| f.host.frames_failed,
        /// Frames dropped so far because the queue was full (ICORAY_DROP_OLDEST).
        Host frames_dropped: u64 INTEGER = |f| f.host.frames_dropped,
        /// Seconds inside icoray_execute so far.
        Host host_total_s: f64 FLOAT = |f| f.host.host_total_s,
        /// Seconds for encoding and writing so far.
        Host write_total_s: f64 FLOAT = |f| f.host.write_total_s,
        /// Number of ranks that rendered the frame: 1, or those of icoray_open. With several, errors, rays, columns,
        /// frusta, values, fragments, gather_s, balance and bytes_received are of the whole picture and equal on all
        /// ranks; other seconds and bytes, threads and tiles are of this rank; files are written and counted at rank 0.
        Frame ranks: i32 INTEGER = |f| f.report.ranks.count as i32,
        /// Tiles of the picture that this rank rendered, or composed of fragments.
        Frame tiles: i32 INTEGER = |f| f.report.ranks.tiles as i32,
        /// Seconds in which rank 0 waited for and received tiles of the other ranks.
        Frame gather_s: f64 FLOAT = |f| f.report.ranks.gather_s,
        /// Load balance: mean over maximum of the seconds that ranks rendered; 1 is even.
        Frame balance: f64 FLOAT = |f| f.report.ranks.balance,
        /// Bytes of tiles that rank 0 received.
        Frame bytes_received: u64 INTEGER = |f| f.report.ranks.bytes_received,
        /// How ranks shared the picture: ICORAY_ALONE, ICORAY_TILES or ICORAY_FRAGMENTS.
        Frame scheme: i32 SCHEMES =
            |f| f.report.ranks.sharing.map_or(0, |s| if s.scheme == Scheme::Fragments { 2 } else { 1 }),
        /// Fragments of which rays were composed (ICORAY_FRAGMENTS), of all ranks.
        Frame fragments: u64 INTEGER = |f| f.report.counts.fragments,
        /// Bytes of fragments that ranks sent each other.
        Frame fragment_bytes: u64 INTEGER = |f| f.report.counts.fragment_bytes,
        /// Seconds in which this rank composed rays of fragments.
        Frame compose_s: f64 FLOAT = |f| f.report.ranks.compose_s,
        /// Devices that traced this rank's rays: ICORAY_CPU, ICORAY_GPU, or ICORAY_GPU_AND_CPU. The log names the GPU
        /// and the reason for using the CPU, each once.
        Frame drawn_on: i32 PROCESSORS = |f| match &f.report.device {
            DeviceReport { name: None, .. } => 0,
            DeviceReport { left_to_cpu: None, .. } => 1,
            _ => 2,
        },
        /// Part of render_s before rays could start on the GPU: preparing and uploading data, seconds.
        Frame upload_s: f64 FLOAT = |f| f.report.device.upload_s,
        /// Seconds for rays by the GPU's clock; NaN if there is none.
        Frame device_s: f64 OPTIONAL_FLOAT = |f| f.report.device.device_s.unwrap_or(f64::NAN),
        /// Bytes uploaded to the GPU.
        Frame bytes_uploaded: u64 INTEGER = |f| f.report.device.bytes_uploaded,
        /// Number of frames that the call of icoray_execute rendered; this report is of the last one.
        Host frames: u64 INTEGER = |f| f.host.frames,
        /// Number of pixels with the edge of a surface in them, each drawn as the mean of 8 rays or more; 0 with
        /// antialias = false in the scene. rays and the numbers after it include the rays of these pixels.
        Picture edge_pixels: u64 INTEGER = |f| f.report.edge_pixels,
        /// Number of pixels of the picture whose error is above `tolerance`. The log warns of them once per view.
        Picture pixels_over_tolerance: u64 INTEGER = |f| f.report.error.pixels_over_tolerance,
        /// Mean number of rays of the pixels that may show the shell: 1, or up to the scene's `samples`; below 1 where
        /// not every pixel was traced.
        Picture rays_per_pixel: f64 FLOAT = |f| f.report.sampling.rays_per_pixel,
        /// Largest estimated sampling error of a pixel: how far the mean of its rays may be from the mean over its
        /// area, not counting the errors of the rays' integrals; with pixel_step above 1, how far a pixel that was not
        /// traced may be from its ray. NaN where pixels are one ray each.
        Picture sampling_error_max: f64 OPTIONAL_FLOAT =
            |f| f.report.sampling.error.map_or(f64::NAN, |error| error.max),
        /// Mean of the estimated sampling errors; NaN where pixels are one ray each.
        Picture sampling_error_mean: f64 OPTIONAL_FLOAT =
            |f| f.report.sampling.error.map_or(f64::NAN, |error| error.mean),
        /// Largest number of cells that fall into a pixel where its ray meets the shell, of up to 16 x 16 pixels at
        /// equal distances.
        Picture cells_per_pixel_max: f64 FLOAT = |f| f.report.sampling.cells_per_pixel.max,
        /// Mean number of cells that fall into these pixels. From 4 on, with samples = 1, the log has a hint once per
        /// view.
        Picture cells_per_pixel_mean: f64 FLOAT = |f| f.report.sampling.cells_per_pixel.mean,
        /// The coarser grid on which rays were traced: 0 is the model's own, and larger ones have fewer cells.
        Picture level: i32 INTEGER = |f| f.report.quality.level as i32,
    }
    others {
        /// Date passed to icoray_execute, or that of the file's time.
        Picture date: OPTIONAL_TEXT = |f| f.stamp.date.clone().map_or(Value::None, Value::Text),
        /// Name of the device that traced rays on this rank, on rank 0 in report.csv; none if the CPU traced them.
        Picture device: OPTIONAL_TEXT = |f| f.report.device.name.clone().map_or(Value::None, Value::Text),
        /// Why the CPU traced all or some rays although the scene allows a device; else none.
        Frame left_to_cpu: OPTIONAL_TEXT =
            |f| f.report.device.left_to_cpu.clone().map_or(Value::None, Value::Text),
        /// How several ranks shared out the picture, and why; else none.
        Frame sharing: OPTIONAL_TEXT =
            |f| f.report.ranks.sharing.map_or(Value::None, |sharing| Value::Text(sharing.to_string())),
        /// Pieces of rays that were integrated one by one, not in vectors.
        Frame scalar_pieces: INTEGER = |f| f.report.counts.scalar_pieces.into(),
        /// Most rays that a pixel may take: the scene's `samples`.
        Picture samples: INTEGER = |f| u64::from(f.report.sampling.samples).into(),
        /// First value of the colour map, of several the first one's; none if colours are given as knots.
        Picture color_min: OPTIONAL_FLOAT =
            |f| f.report.colors.first().map_or(Value::None, |colors| colors.range[0].into()),
        /// Last value of that colour map.
        Picture color_max: OPTIONAL_FLOAT =
            |f| f.report.colors.first().map_or(Value::None, |colors| colors.range[1].into()),
        /// Of each colour map the field, the map with its scale and how its range came to be, and the range.
        Picture colors: COLOR_MAPS = |f| Value::ColorMaps(f.report.colors.clone()),
        /// Data that the plan left out.
        Frame left_out: TEXTS = |f| Value::Texts(f.report.left_out.clone()),
    }
}

impl FigureType {
    /// The value of a number in C.
    fn read(self, value: Value) -> Value {
        match value {
            Value::Integer(number) if self == FLAG => Value::Flag(number != 0),
            Value::Integer(number) if !self.words.is_empty() => Value::Text(self.words[number as usize].into()),
            other => other,
        }
    }
}

impl CFrameReport {
    /// Begins the sums over the frames of a call.
    pub fn begin_call(&mut self) {
        self.frames = 0;
        self.waited_s = 0.0;
        self.copy_s = 0.0;
        self.bytes_copied = 0;
    }

    /// Adds a frame to the sums.
    pub fn add(&mut self, report: &FrameReport) {
        self.frames += 1;
        self.waited_s += report.timing.waited_s;
        self.copy_s += report.timing.copy_s;
        self.bytes_copied += report.bytes_copied;
    }
}

impl Figure {
    /// Its value for a frame without a host.
    pub(crate) fn of(&self, stamp: &Stamp, report: &FrameReport) -> Value {
        let mut host = CFrameReport { write_s: report.timing.write_s, ..CFrameReport::default() };
        host.add(report);
        self.kind.read((self.value)(&FigureSource { stamp, report, host: &host }))
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        if number.is_nan() { Value::None } else { Value::Float(number) }
    }
}

macro_rules! from_integers {
    ($($type:ty)*) => {$(impl From<$type> for Value {
        fn from(number: $type) -> Self {
            Value::Integer(number as i64)
        }
    })*};
}
from_integers!(i32 i64 u64);

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::None => Ok(()),
            Value::Flag(flag) => write!(f, "{flag}"),
            Value::Integer(number) => write!(f, "{number}"),
            Value::Float(number) => f.write_str(&numbers::text(*number)),
            Value::Text(text) => f.write_str(text),
            Value::Texts(texts) => f.write_str(&texts.join("; ")),
            Value::ColorMaps(maps) => f.write_str(&maps.iter().map(Colors::to_string).collect::<Vec<_>>().join("; ")),
        }
    }
}
