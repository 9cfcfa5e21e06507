//! The number of ranks that this program was started with, for a context that does not render over them.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Variables of launchers that say how many ranks there are, and which this one is: those of Open MPI, of MPICH and its
/// kin, of MVAPICH. That of Slurm's is set for programs of one process as well.
const VARIABLES: [[&str; 2]; 3] = [
    ["OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"],
    ["PMI_SIZE", "PMI_RANK"],
    ["MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"],
];

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
