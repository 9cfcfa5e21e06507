//! Initialises MPI, for programs without a host that does.

use crate::error::failed;
use crate::{MpiTeam, team};
use icoray::Result;
use mpi::environment::Universe;
use mpi::traits::AsRaw;
use mpi::{Threading, ffi};

/// MPI, initialised by this program and finalised on drop; teams must be dropped before.
pub struct World {
    _universe: Universe,
}

impl World {
    /// Initialises MPI, for calls on this thread, and returns the team of all ranks. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`](icoray::ErrorKind::Mpi) where MPI was initialised before; as [`team`].
    pub fn new() -> Result<(Self, MpiTeam)> {
        let Some((universe, _)) = mpi::initialize_with_threading(Threading::Funneled) else {
            return Err(failed("MPI was initialised before".into()));
        };
        let world = universe.world();
        // SAFETY: MPI is initialised, and the handle is that of the world.
        let comm = unsafe { ffi::RSMPI_Comm_c2f(world.as_raw()) };
        Ok((World { _universe: universe }, team(comm)?))
    }
}
