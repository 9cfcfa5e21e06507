//! The ranks of an MPI communicator, if the library was built with MPI, and agreement between them; the ranks that the
//! program was started as, and this one's share of the processors.

use crate::boundary::{Failure, Outcome};
use crate::types::icoray_status;
use icoray_core::Ranks;
use icoray_core::ranks::Vote;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::num::NonZero;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::available_parallelism;

/// Variables of launchers that say how many ranks there are, and which this one is: those of Open MPI, of MPICH and its
/// kin, of MVAPICH. That of Slurm's is set for programs of one process as well.
const VARIABLES: [[&str; 2]; 3] = [
    ["OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"],
    ["PMI_SIZE", "PMI_RANK"],
    ["MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"],
];

/// The ranks of a communicator, given as Fortran's integer.
#[cfg(feature = "mpi")]
pub(crate) fn of_communicator(fortran_comm: i32) -> Outcome<Ranks> {
    Ok(Ranks::new(icoray_mpi::team(fortran_comm)?))
}

/// Fails: this library was built without MPI.
#[cfg(not(feature = "mpi"))]
pub(crate) fn of_communicator(_fortran_comm: i32) -> Outcome<Ranks> {
    let message = "icoray_open: this library was built without MPI; build it with MPI (cargo build -p icoray-capi \
                   --features mpi), or call icoray_open_serial";
    Err(Failure::new(icoray_status::ICORAY_ERR_UNSUPPORTED, message))
}

/// The outcome of an agreement, with the message of rank 0.
pub(crate) struct Agreed<T, M> {
    pub outcome: Outcome<T>,
    pub root_message: M,
}

/// Agrees on the outcome of `call`: returns this rank's value, or the failure of any rank. `facts` must be equal on all
/// ranks. All ranks receive rank 0's `message` either way, or the default if rank 0 cannot be reached.
pub(crate) fn agree<T, M: Serialize + DeserializeOwned + Default>(
    ranks: &mut Ranks,
    mine: Outcome<T>,
    call: &'static str,
    facts: Vec<(&'static str, String)>,
    message: &M,
) -> Agreed<T, M> {
    let refusal = mine.as_ref().err().map(|failure| (failure.status as i32, failure.message.as_str()));
    // A model may close on the rank where something failed, and go on elsewhere.
    let leaves = call == "icoray_close";
    let facts = [("call", call.to_string())].into_iter().chain(facts).collect();
    let value = postcard::to_stdvec(message).expect("messages consist of numbers, texts and lists of known length");
    let agreement = match ranks.agree(&Vote { refusal, facts, value: &value, leaves }) {
        Ok(agreement) => agreement,
        // The other ranks cannot be reached; a failure of this rank takes precedence over that.
        Err(error) => return Agreed { outcome: mine.and_then(|_| Err(error.into())), root_message: M::default() },
    };
    let outcome = match agreement.refusal {
        None => mine,
        Some(refusal) => {
            let status = refusal.number.map_or(icoray_status::ICORAY_ERR_MPI, icoray_status::of_number);
            Err(Failure::new(status, refusal.message(ranks.size())))
        }
    };
    Agreed { outcome, root_message: postcard::from_bytes(&agreement.value).unwrap_or_default() }
}

/// Warns once, at rank 0, if this is one of several ranks.
pub(crate) fn warn_of_ranks(warn: impl FnOnce(&str)) {
    static IS_REPORTED: AtomicBool = AtomicBool::new(false);
    let launched = of_mpi().or_else(|| of_launcher(|name| std::env::var(name).ok()));
    let Some([0, size @ 2..=usize::MAX]) = launched else { return };
    if !IS_REPORTED.swap(true, Relaxed) {
        warn(&format!(
            "icoray_open_serial in a job of {size} ranks: each rank that calls it draws pictures of what it alone has, with a \
             thread for each processor; icoray_open draws one picture over all ranks"
        ));
    }
}

/// Rank and number of ranks from MPI, if it is linked and initialised.
#[cfg(feature = "mpi")]
fn of_mpi() -> Option<[usize; 2]> {
    icoray_mpi::rank_in_world()
}

#[cfg(not(feature = "mpi"))]
fn of_mpi() -> Option<[usize; 2]> {
    None
}

/// Rank and number of ranks from the launcher's environment.
fn of_launcher(variable: impl Fn(&str) -> Option<String>) -> Option<[usize; 2]> {
    let number = |name: &str| variable(name)?.parse().ok();
    VARIABLES.into_iter().find_map(|[size, rank]| Some([number(rank)?, number(size)?]))
}

/// The processors that this thread may run on, divided by the number of ranks of the node that share them; at least 1.
/// Collective.
pub(crate) fn share_of_processors(ranks: &mut Ranks) -> Outcome<usize> {
    let sharing = ranks.sharing_processors(&mask())?;
    // Beside the mask this respects the limits of containers.
    let mine = available_parallelism().map_or(1, NonZero::get);
    Ok((mine / sharing).max(1))
}

/// A bit for each processor that this thread may run on; empty where the system does not say.
#[cfg(target_os = "linux")]
fn mask() -> Vec<u8> {
    // SAFETY: a set of numbers, of which all zero is the empty one; it is as long as is said, and written by the call.
    let (code, set) = unsafe {
        let mut set: libc::cpu_set_t = std::mem::zeroed();
        (libc::sched_getaffinity(0, size_of_val(&set), &raw mut set), set)
    };
    let mut mask = vec![0u8; if code == 0 { size_of_val(&set) } else { 0 }];
    for (i, byte) in mask.iter_mut().enumerate() {
        // SAFETY: the set has a bit for each of these.
        let has = |bit: usize| unsafe { libc::CPU_ISSET(8 * i + bit, &set) };
        *byte = (0..8).map(|bit| u8::from(has(bit)) << bit).sum();
    }
    mask
}

#[cfg(not(target_os = "linux"))]
fn mask() -> Vec<u8> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_core::ranks::on_local_nodes;

    #[test]
    fn launchers_state_the_number_of_ranks() {
        let from_variables = |set: &[(&str, &str)]| {
            of_launcher(|name| set.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned()))
        };
        assert_eq!(from_variables(&[]), None);
        assert_eq!(from_variables(&[("SLURM_NTASKS", "4"), ("SLURM_PROCID", "0")]), None);
        for ([size, rank], expected) in VARIABLES.into_iter().zip([[3, 4], [0, 2], [0, 1]]) {
            let [rank_text, size_text] = expected.map(|number| number.to_string());
            assert_eq!(from_variables(&[(size, &size_text), (rank, &rank_text)]), Some(expected));
        }
        assert_eq!(from_variables(&[("PMI_SIZE", "two"), ("PMI_RANK", "0")]), None);
        assert_eq!(from_variables(&[("PMI_SIZE", "2")]), None);
    }

    #[test]
    fn ranks_of_a_node_share_its_processors() {
        let all = available_parallelism().unwrap().get();
        assert_eq!(share_of_processors(&mut Ranks::alone()).unwrap(), all);
        for size in [1, 2, 3, 2 * all] {
            let of_each = on_local_nodes(&vec![0; size], |team| share_of_processors(&mut Ranks::new(team)).unwrap());
            assert_eq!(of_each, vec![(all / size).max(1); size]);
        }
        let allowed: usize = mask().iter().map(|byte| byte.count_ones() as usize).sum();
        assert!(allowed >= all, "{allowed}, {all}");
    }
}
