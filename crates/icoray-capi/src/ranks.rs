//! The ranks of an MPI communicator, if the library was built with MPI, and agreement between them.

use crate::boundary::{Failure, Outcome};
use crate::types::icoray_status;
use icoray_core::Ranks;
use icoray_core::ranks::Vote;

/// The ranks of a communicator, given as Fortran's integer.
#[cfg(feature = "mpi")]
pub(crate) fn of_communicator(fortran_comm: i32) -> Outcome<Ranks> {
    Ok(Ranks::new(Box::new(icoray_mpi::team(fortran_comm)?)))
}

/// Fails: this library was built without MPI.
#[cfg(not(feature = "mpi"))]
pub(crate) fn of_communicator(_fortran_comm: i32) -> Outcome<Ranks> {
    let message = "icoray_open: this library was built without MPI; build it with MPI (cargo build -p icoray-capi \
                   --features mpi), or call icoray_open_serial";
    Err(Failure::new(icoray_status::ICORAY_ERR_UNSUPPORTED, message))
}

/// The bytes that rank 0 sends with each agreement.
pub(crate) struct RootMessage(pub Vec<u8>);

/// Agrees on the outcome of `call`: returns this rank's value, or the failure of any rank. `facts` must be equal on all
/// ranks. All ranks receive rank 0's `value` either way.
pub(crate) fn agree<T>(
    ranks: &mut Ranks,
    mine: Outcome<T>,
    call: &'static str,
    facts: Vec<(&'static str, String)>,
    value: &[u8],
) -> (Outcome<T>, RootMessage) {
    let refusal = mine.as_ref().err().map(|failure| (failure.status as i32, failure.message.as_str()));
    // A model may close on the rank where something failed, and go on elsewhere.
    let leaves = call == "icoray_close";
    let facts = [("call", call.to_string())].into_iter().chain(facts).collect();
    let agreement = match ranks.agree(&Vote { refusal, facts, value, leaves }) {
        Ok(agreement) => agreement,
        // The other ranks cannot be reached; a failure of this rank takes precedence over that.
        Err(error) => return (mine.and_then(|_| Err(error.into())), RootMessage(Vec::new())),
    };
    let outcome = match agreement.refusal {
        None => mine,
        Some(refusal) => {
            let status = refusal.number.map_or(icoray_status::ICORAY_ERR_MPI, icoray_status::of_number);
            Err(Failure::new(status, refusal.message(ranks.size())))
        }
    };
    (outcome, RootMessage(agreement.value))
}
