//! The ranks that render together: this process alone, or those that mpirun started.

use crate::failure::{CommandResult, Failure};
use icoray::{Ranks, Result};

/// The ranks of this run; MPI is finalised on drop.
pub struct RankTeam {
    // Dropped before MPI is finalised.
    ranks: Ranks,
    #[cfg(feature = "mpi")]
    _world: icoray_mpi::World,
}

impl RankTeam {
    /// All ranks that mpirun started, or this process alone.
    #[cfg(feature = "mpi")]
    pub fn new() -> Result<Self> {
        let (world, team) = icoray_mpi::World::new()?;
        let ranks = if team.size() > 1 { Ranks::new(team) } else { Ranks::alone() };
        Ok(RankTeam { ranks, _world: world })
    }

    /// This process alone. Fails in a job of several ranks, which would all write the same pictures.
    #[cfg(not(feature = "mpi"))]
    pub fn new() -> Result<Self> {
        // Of Open MPI, and of MPICH and its kin.
        let sizes = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"].into_iter().filter_map(std::env::var_os);
        if let Some(size) = sizes.filter_map(|size| size.to_str()?.parse::<u32>().ok()).find(|&size| size > 1) {
            let context = format!(
                "{size} ranks were started, and this icoray was built for one; build it with MPI (cargo build -p icoray-cli \
                 --features mpi)"
            );
            return Err(icoray::Error::new(icoray::ErrorKind::Unsupported, context));
        }
        Ok(RankTeam { ranks: Ranks::alone() })
    }

    pub fn ranks(&mut self) -> &mut Ranks {
        &mut self.ranks
    }

    /// The outcome of this rank: all ranks fail together, and rank 0 reports the error.
    pub fn outcome<T>(self, done: CommandResult<T>) -> CommandResult<T> {
        done.map_err(|failure| if self.ranks.is_root() { failure } else { Failure::ReportedByRoot })
    }
}
