//! The C ABI of icoray. `include/icoray.h` is generated from this crate.
//!
//! Layout: [`types`] the structs that cross the boundary, [`borrow`] from their pointers to slices (all of the crate's
//! assumptions about foreign memory), [`context`] what lies behind a handle, [`boundary`] statuses, messages and
//! panics, [`calls`] the exported functions, [`mesh`] the exported generator.

mod borrow;
mod boundary;
mod calls;
mod context;
mod mesh;
mod types;
