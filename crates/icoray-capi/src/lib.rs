//! The C ABI of icoray. `include/icoray.h` is generated from this crate.
//!
//! Layout: [`types`] the structs that cross the boundary; [`borrow`] from their pointers to slices (all of the crate's
//! assumptions about foreign memory); [`boundary`] statuses, messages and panics; [`host`] the host's floating-point state
//! and signals; [`memory`] what icoray holds; [`handle`] who may enter a context; [`context`] what the model has given;
//! [`drawing`] frames on their way; [`message`] how long a message may be; [`ranks`] who draws together; [`job`] the ranks
//! that a program was started as; [`processors`] threads by default; [`policy`] what failures lead to; [`log`] the host's
//! log. Exported functions are in
//! [`open`], [`inputs`], [`frames`], [`mesh`] and [`log`].

mod borrow;
mod boundary;
mod context;
mod drawing;
mod frames;
mod handle;
mod host;
mod inputs;
mod job;
mod log;
mod memory;
mod mesh;
mod message;
mod open;
mod policy;
mod processors;
mod ranks;
mod types;
