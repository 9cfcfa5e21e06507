//! A team over a communicator of the host's MPI, checks that MPI may be called, and MPI for programs without a host
//! that initialises it.

use crate::communicator::{MpiCommunicator, check, failed, flag, is_finalized, rank_in};
use icoray::{Error, ErrorKind, Result, Team};
use mpi::environment::Universe;
use mpi::traits::AsRaw;
use mpi::{Threading, ffi};
use std::ffi::c_char;
use std::mem::size_of;
use std::sync::Arc;

/// The ranks of `fortran_comm`: `MPI_Comm_c2f(comm)` in C, `comm` in Fortran's `mpi`, `comm%MPI_VAL` in `mpi_f08`.
/// The communicator is duplicated and the duplicate freed on drop, unless MPI was finalised or a rank has left before
/// the others. Both are collective over it.
///
/// # Errors
/// [`ErrorKind::Mpi`] if MPI is not initialised or already finalised, if it may not be called on this thread, and if
/// the integer is no communicator of one group; [`ErrorKind::Unsupported`] if the host runs another MPI than this was
/// built for.
pub fn team(fortran_comm: i32) -> Result<Team> {
    refuse_other_mpi()?;
    if !flag(ffi::MPI_Initialized) {
        return Err(failed("MPI is not initialised; call MPI_Init before icoray_open".into()));
    }
    if is_finalized() {
        return Err(failed("MPI is finalised already; call icoray_open before MPI_Finalize".into()));
    }
    refuse_other_thread()?;
    // SAFETY: MPI is initialised; any integer may be asked for.
    let given = unsafe { ffi::RSMPI_Comm_f2c(fortran_comm) };
    // SAFETY: a handle is an integer or a pointer, for both of which zero is a value: what f2c gives for no handle.
    let (none, null) = unsafe { (std::mem::zeroed(), ffi::RSMPI_COMM_NULL) };
    if given == null || given == none {
        return Err(failed(format!(
            "{fortran_comm} is no communicator; expected MPI_Comm_c2f(comm), comm or comm%MPI_VAL"
        )));
    }
    let mut inter = 0;
    // SAFETY: a communicator of the host's, and a number to be written.
    check("MPI_Comm_test_inter", unsafe { ffi::MPI_Comm_test_inter(given, &mut inter) })?;
    if inter != 0 {
        return Err(failed("the communicator is between two groups; expected one of one group".into()));
    }
    Team::over(MpiCommunicator::of_duplicate(given, Arc::default())?)
}

/// Rank and size of this process in MPI_COMM_WORLD; `None` if MPI is not initialised or may not be called on this
/// thread.
pub fn rank_in_world() -> Option<[usize; 2]> {
    if !flag(ffi::MPI_Initialized) || is_finalized() {
        return None;
    }
    refuse_other_mpi().and_then(|()| refuse_other_thread()).ok()?;
    // SAFETY: MPI runs, and it is the one that this was built for.
    rank_in(unsafe { ffi::RSMPI_COMM_WORLD }).ok()
}

/// Fortran's integer of MPI_COMM_WORLD; `None` as [`rank_in_world`].
pub fn world_communicator() -> Option<i32> {
    rank_in_world()?;
    // SAFETY: MPI runs, and it is the one that this was built for.
    Some(unsafe { ffi::RSMPI_Comm_c2f(ffi::RSMPI_COMM_WORLD) })
}

/// Handles are pointers in Open MPI and integers in MPICH and its relatives: a build for one must not accept the
/// other's.
fn refuse_other_mpi() -> Result<()> {
    let mut text = [0u8; 8192];
    let mut length = 0;
    // SAFETY: may be called at any time; the buffer is as long as the longest version string that is known (MPICH's).
    unsafe { ffi::MPI_Get_library_version(text.as_mut_ptr().cast::<c_char>(), &mut length) };
    let text = String::from_utf8_lossy(&text[..usize::try_from(length).unwrap_or(0).min(text.len())]);
    let is_open_mpi = text.contains("Open MPI");
    let is_built_for_open_mpi = size_of::<ffi::MPI_Comm>() == size_of::<*const ()>();
    if is_open_mpi == is_built_for_open_mpi {
        return Ok(());
    }
    let built_for = if is_built_for_open_mpi { "Open MPI" } else { "MPICH" };
    let runs = text.lines().next().unwrap_or_default();
    let message = format!("this library was built for {built_for}, and the program runs {runs:?}");
    Err(Error::new(ErrorKind::Unsupported, message))
}

/// Below MPI_THREAD_SERIALIZED only the thread that initialised MPI may call it.
fn refuse_other_thread() -> Result<()> {
    let (mut level, mut is_main) = (0, 0);
    // SAFETY: MPI is initialised; both write a number.
    unsafe {
        check("MPI_Query_thread", ffi::MPI_Query_thread(&mut level))?;
        check("MPI_Is_thread_main", ffi::MPI_Is_thread_main(&mut is_main))?;
        if level < ffi::RSMPI_THREAD_SERIALIZED && is_main == 0 {
            let message = "MPI is initialised for one thread, and this is another; ask for MPI_THREAD_SERIALIZED or call \
                           icoray where MPI_Init was called";
            return Err(failed(message.into()));
        }
    }
    Ok(())
}

/// MPI, initialised by this program and finalised on drop; teams must be dropped before.
pub struct World {
    _universe: Universe,
}

impl World {
    /// Initialises MPI, for calls on this thread, and returns the team of all ranks. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`] where MPI was initialised before; as [`team`].
    pub fn new() -> Result<(Self, Team)> {
        let Some((universe, _)) = mpi::initialize_with_threading(Threading::Funneled) else {
            return Err(failed("MPI was initialised before".into()));
        };
        let world = universe.world();
        // SAFETY: MPI is initialised, and the handle is that of the world.
        let comm = unsafe { ffi::RSMPI_Comm_c2f(world.as_raw()) };
        Ok((World { _universe: universe }, team(comm)?))
    }
}
