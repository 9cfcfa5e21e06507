//! Programs under mpirun, and over GPUs.

#[cfg(feature = "gpu")]
mod gpu;
mod mpi;
