//! Tests across crates, in one program: pictures against references, the C ABI, Fortran, MPI.

mod abi;
mod catalyst;
mod comin;
mod errors;
mod fortran;
#[cfg(feature = "gpu")]
mod gpu;
mod host;
mod instructions;
mod layouts;
mod live;
mod mpas;
mod mpi;
mod pictures;
mod recipes;
mod shallow_water;
mod tracer;
