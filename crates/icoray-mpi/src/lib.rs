//! MPI as the transport of [`icoray::ranks`], over a communicator of the host.
//!
//! The host initialises MPI, at any thread level, and finalises it; this crate calls MPI only on the caller's thread.
//! The communicator is passed as Fortran's integer, which every language has, and duplicated, so that messages of the
//! host are not received here. Failures of MPI become errors: on the duplicate they do not end the process.
//!
//! A build is for one MPI. Handles of Open MPI and MPICH have different types, so a host that runs the other one is
//! refused before any handle is used.

mod communicator;
mod host;
#[cfg(test)]
mod tests;

pub use host::{World, rank_in_world, team, world_communicator};
