//! The ranks of an MPI communicator, if the library was built with MPI, and agreement between them.

use crate::boundary::{Failure, Outcome};
use crate::types::icoray_status;
use icoray_core::Ranks;
use icoray_core::ranks::Vote;
use serde::Serialize;
use serde::de::DeserializeOwned;

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
