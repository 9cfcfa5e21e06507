//! Who draws together: this process alone, or the ranks that mpirun started.

use crate::failure::Failure;
use icoray::{Ranks, Result};

/// The ranks of this run, which is over when this is dropped.
pub struct Ranked {
    // Dropped before MPI is finalised.
    ranks: Ranks,
    #[cfg(feature = "mpi")]
    _world: icoray_mpi::World,
}

impl Ranked {
    /// All that mpirun started, or this process alone.
    #[cfg(feature = "mpi")]
    pub fn new() -> Result<Self> {
        let (world, team) = icoray_mpi::World::new()?;
        let ranks = if icoray::Team::size(&team) > 1 { Ranks::new(Box::new(team)) } else { Ranks::alone() };
        Ok(Ranked { ranks, _world: world })
    }

    /// This process alone. Several, which would all write the same pictures, are refused.
    #[cfg(not(feature = "mpi"))]
    pub fn new() -> Result<Self> {
        // Of Open MPI, and of MPICH and its kin.
        let sizes = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"].into_iter().filter_map(std::env::var_os);
        if let Some(size) = sizes.filter_map(|size| size.to_str()?.parse::<u32>().ok()).find(|&size| size > 1)
        {
            let context = format!(
                "{size} ranks were started, and this icoray was built for one; build it with MPI (cargo build -p icoray-cli \
                 --features mpi)"
            );
            return Err(icoray::Error::new(icoray::ErrorKind::Unsupported, context));
        }
        Ok(Ranked { ranks: Ranks::alone() })
    }

    /// Them, to draw with.
    pub fn ranks(&mut self) -> &mut Ranks {
        &mut self.ranks
    }

    /// What this rank says of what came of the run: ranks fail together, and rank 0 says why.
    pub fn outcome<T>(self, done: std::result::Result<T, Failure>) -> std::result::Result<T, Failure> {
        done.map_err(|failure| if self.ranks.is_root() { failure } else { Failure::SaidElsewhere })
    }
}
