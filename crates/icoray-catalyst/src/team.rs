//! The ranks of the communicator that the host gives.

use icoray::{Error, ErrorKind, Result, Team};

/// Two teams over the same ranks, one for the context and one for meshes; `None` for one process. `communicator` is
/// Fortran's integer, as hosts have it in `catalyst/mpi_comm`; without it all ranks of a host that has initialised MPI are
/// taken. Collective.
///
/// # Errors
/// [`ErrorKind::Mpi`] for integers that are no communicator.
#[cfg(feature = "mpi")]
pub fn of_host(communicator: Option<i64>) -> Result<Option<[Box<dyn Team>; 2]>> {
    use icoray_mpi::{team, world_communicator};
    let Some(communicator) = communicator.or_else(|| world_communicator().map(i64::from)) else { return Ok(None) };
    // Handles of MPICH have the highest bit, which hosts may have made a sign of or not.
    let handle = i32::try_from(communicator).or_else(|_| u32::try_from(communicator).map(u32::cast_signed));
    let handle = handle.map_err(|_| {
        Error::new(ErrorKind::Mpi, format!("catalyst/mpi_comm is {communicator}, expected MPI_Comm_c2f(comm)"))
    })?;
    Ok(Some([Box::new(team(handle)?), Box::new(team(handle)?)]))
}

/// One process: this library was built without MPI.
///
/// # Errors
/// [`ErrorKind::Unsupported`] where the host gives a communicator.
#[cfg(not(feature = "mpi"))]
pub fn of_host(communicator: Option<i64>) -> Result<Option<[Box<dyn Team>; 2]>> {
    match communicator {
        None => Ok(None),
        Some(_) => Err(Error::new(
            ErrorKind::Unsupported,
            "the host gives catalyst/mpi_comm, and this library was built without MPI: install it with --mpi",
        )),
    }
}
