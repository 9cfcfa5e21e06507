//! The C ABI of icoray. `include/icoray.h` is generated from this crate.
//!
//! Layout: [`types`] the structs of the ABI; [`borrow`] slices from their pointers (all assumptions about foreign
//! memory); [`boundary`] statuses, messages and panics; [`host`] the host's floating-point state and signals;
//! [`memory`] allocation counters; [`handle`] locks of a context; [`context`] inputs and calls of a context;
//! [`drawing`] rendering and writing of frames; [`message`] the length of messages; [`ranks`] MPI communicators,
//! agreement, the ranks that a program was started as, and the default number of threads; [`viewer_message`] requests
//! of viewers for all ranks; [`policy`] options of the writer and the answer to failed frames; [`log`] the host's log.
//! Exported functions are in [`open`], [`inputs`], [`frames`], [`mesh`] and [`log`].
//!
//! Modules are public for bindings of other languages, which build these sources as a Rust library (`context` beside
//! them); these call the methods of [`icoray_ctx`] in [`bindings`] and [`open`], and [`boundary::protected`].

pub mod bindings;
mod borrow;
pub mod boundary;
mod context;
mod drawing;
pub mod frames;
mod handle;
mod host;
pub mod inputs;
pub mod log;
mod memory;
mod mesh;
mod message;
pub mod open;
mod policy;
mod ranks;
pub mod types;
mod viewer_message;

pub use handle::icoray_ctx;
