//! The other ranks of the host, with which this library exchanges meshes.

use icoray::{Error, ErrorKind, Result, Team};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// All ranks of the host, or one process alone.
pub struct Peers(Option<Team>);

impl Peers {
    pub fn new(team: Option<Team>) -> Self {
        Peers(team)
    }

    pub fn rank(&self) -> usize {
        self.0.as_ref().map_or(0, Team::rank)
    }

    pub fn size(&self) -> usize {
        self.0.as_ref().map_or(1, Team::size)
    }

    /// The values of all ranks, in their order. Collective.
    pub fn share<T: Serialize + DeserializeOwned>(&mut self, mine: T) -> Result<Vec<T>> {
        let Some(team) = &mut self.0 else { return Ok(vec![mine]) };
        let failed = |e: postcard::Error| Error::new(ErrorKind::Mpi, format!("a message between ranks: {e}"));
        let bytes = postcard::to_stdvec(&mine).map_err(failed)?;
        drop(mine);
        team.share(&bytes)?.iter().map(|bytes| postcard::from_bytes(bytes).map_err(failed)).collect()
    }

    /// The result of `work` on this rank's data, if no rank fails. A panic is a failure, and no rank waits. Collective.
    pub fn agree<R>(&mut self, work: impl FnOnce() -> Result<R>) -> Result<R> {
        let mine = Error::of_panics(work);
        self.share_all(mine.as_ref().map(drop).map_err(Error::clone))?;
        mine
    }

    /// The values of all ranks, or the failure of the first one that failed, with its number. Collective.
    pub fn share_all<T: Serialize + DeserializeOwned>(&mut self, mine: Result<T>) -> Result<Vec<T>> {
        let all = self.share(mine.map_err(|e| e.to_string()))?;
        let is_alone = all.len() == 1;
        let rank_of = |rank: usize, message: String| {
            let message = if is_alone { message } else { format!("rank {rank}: {message}") };
            Error::new(ErrorKind::Argument, message)
        };
        all.into_iter().enumerate().map(|(rank, one)| one.map_err(|message| rank_of(rank, message))).collect()
    }
}

/// Two teams over the same ranks, one for the context and one for meshes; `None` for one process. `communicator` is
/// Fortran's integer, as hosts have it in `catalyst/mpi_comm`; without it all ranks of a host that has initialised MPI are
/// taken. Collective.
#[cfg(feature = "mpi")]
pub fn teams_of_host(communicator: Option<i64>) -> Result<Option<[Team; 2]>> {
    use icoray_mpi::{team, world_communicator};
    let Some(communicator) = communicator.or_else(|| world_communicator().map(i64::from)) else { return Ok(None) };
    // Handles of MPICH have the highest bit, which hosts may have made a sign of or not.
    let handle = i32::try_from(communicator).or_else(|_| u32::try_from(communicator).map(u32::cast_signed));
    let handle = handle.map_err(|_| {
        Error::new(ErrorKind::Mpi, format!("catalyst/mpi_comm is {communicator}, expected MPI_Comm_c2f(comm)"))
    })?;
    Ok(Some([team(handle)?, team(handle)?]))
}

/// One process: this library was built without MPI.
#[cfg(not(feature = "mpi"))]
pub fn teams_of_host(communicator: Option<i64>) -> Result<Option<[Team; 2]>> {
    match communicator {
        None => Ok(None),
        Some(_) => Err(Error::new(
            ErrorKind::Unsupported,
            "the host gives catalyst/mpi_comm, and this library was built without MPI: install it with --mpi",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::ranks::on_local_nodes;

    #[test]
    fn no_rank_waits_for_one_that_fails() {
        let failure = |work: fn(usize) -> Result<usize>| {
            on_local_nodes(&[0; 3], |team| {
                let mut peers = Peers::new(Some(team));
                let rank = peers.rank();
                peers.agree(|| work(rank)).map_err(|e| e.to_string())
            })
        };
        assert_eq!(failure(Ok), [Ok(0), Ok(1), Ok(2)]);
        let all = failure(|rank| if rank == 1 { Err(Error::new(ErrorKind::Grid, "no grid")) } else { Ok(rank) });
        assert!(all.iter().all(|one| one.as_ref().is_err_and(|e| e.contains("rank 1: bad grid: no grid"))), "{all:?}");
        let all = failure(|rank| Ok([7][rank / 2]));
        assert!(
            all.iter().all(|one| one.as_ref().is_err_and(|e| e.contains("rank 2: ") && e.contains("index"))),
            "{all:?}"
        );
    }
}
