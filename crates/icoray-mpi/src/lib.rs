//! Ranks of MPI: a communicator of the host's, over which [`icoray::ranks`] talk.
//!
//! The host has initialised MPI, at whatever thread level, and finalises it; here MPI is only called on the thread that
//! calls. The communicator comes as Fortran's integer, which every language can give, and is duplicated, so that no message
//! of the host's is taken for one of these. MPI's failures become errors: on the duplicate they do not end the process.
//!
//! A build is for one MPI. What stands in for handles differs between Open MPI and MPICH, so a host that runs the other one
//! is refused before any handle is touched.

mod bytes;
mod exchange;
mod host;
mod messages;
mod post;
#[cfg(test)]
mod tests;
mod window;
mod world;

pub use host::{MpiTeam, place_in_world};
pub use world::World;
