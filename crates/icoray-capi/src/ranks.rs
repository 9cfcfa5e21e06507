//! Who draws together: the ranks of an MPI communicator, where the library was built with MPI.

use crate::boundary::{Failure, Outcome};
use crate::types::icoray_status;
use icoray_core::Ranks;
use icoray_core::ranks::Word;

/// The ranks of a communicator, as Fortran numbers it.
#[cfg(feature = "mpi")]
pub(crate) fn of_communicator(fortran_comm: i32) -> Outcome<Ranks> {
    Ok(Ranks::new(Box::new(icoray_mpi::MpiTeam::new(fortran_comm)?)))
}

/// Refuses: there is no MPI in this library.
#[cfg(not(feature = "mpi"))]
pub(crate) fn of_communicator(_fortran_comm: i32) -> Outcome<Ranks> {
    let message = "icoray_open: this library was built without MPI; build it with MPI (cargo build -p icoray-capi \
                   --features mpi), or call icoray_open_serial";
    Err(Failure::new(icoray_status::ICORAY_ERR_UNSUPPORTED, message))
}

/// What rank 0 has to say beside its own outcome, at each agreement.
pub(crate) struct Said(pub Vec<u8>);

/// What all ranks make of their outcomes of `call`: this rank's own value, or the failure of whichever has one. `facts`
/// must be the same on all. Rank 0's `value` is heard either way.
pub(crate) fn agree<T>(
    ranks: &mut Ranks,
    mine: Outcome<T>,
    call: &'static str,
    facts: Vec<(&'static str, String)>,
    value: &[u8],
) -> (Outcome<T>, Said) {
    let refusal = mine.as_ref().err().map(|failure| (failure.status as i32, failure.message.as_str()));
    // A model may close on the rank where something failed, and go on elsewhere.
    let leaves = call == "icoray_close";
    let facts = [("call", call.to_string())].into_iter().chain(facts).collect();
    let agreement = match ranks.agree(&Word { refusal, facts, value, leaves }) {
        Ok(agreement) => agreement,
        // The others cannot be reached; what is wrong here is still worth more than that.
        Err(error) => return (mine.and_then(|_| Err(error.into())), Said(Vec::new())),
    };
    let outcome = match agreement.refusal {
        None => mine,
        Some(refusal) => {
            let status = refusal.number.map_or(icoray_status::ICORAY_ERR_MPI, icoray_status::of_number);
            Err(Failure::new(status, refusal.told(ranks.size())))
        }
    };
    (outcome, Said(agreement.value))
}
