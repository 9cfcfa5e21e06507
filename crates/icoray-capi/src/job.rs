//! The ranks that this program was started as, for a context that does not draw over them.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Variables of launchers that say how many ranks there are, and which this one is: those of Open MPI, of MPICH and its
/// kin, of MVAPICH. That of Slurm's is set for programs of one process as well.
const VARIABLES: [[&str; 2]; 3] = [
    ["OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"],
    ["PMI_SIZE", "PMI_RANK"],
    ["MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"],
];

/// Which rank this is, and of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    rank: usize,
    size: usize,
}

/// Warns once, at rank 0, where this is one of several ranks.
pub(crate) fn warn_of_ranks(warn: impl FnOnce(&str)) {
    static IS_TOLD: AtomicBool = AtomicBool::new(false);
    let place = of_mpi().or_else(|| of_launcher(|name| std::env::var(name).ok()));
    let Some(Place { rank: 0, size: size @ 2.. }) = place else { return };
    if !IS_TOLD.swap(true, Relaxed) {
        warn(&format!(
            "icoray_open_serial in a job of {size} ranks: each rank that calls it draws pictures of what it alone has, with a \
             thread for each processor; icoray_open draws one picture over all ranks"
        ));
    }
}

/// As MPI says, where it is there and runs.
#[cfg(feature = "mpi")]
fn of_mpi() -> Option<Place> {
    icoray_mpi::place_in_world().map(|[rank, size]| Place { rank, size })
}

#[cfg(not(feature = "mpi"))]
fn of_mpi() -> Option<Place> {
    None
}

/// As the launcher's environment says.
fn of_launcher(variable: impl Fn(&str) -> Option<String>) -> Option<Place> {
    let number = |name: &str| variable(name)?.parse().ok();
    VARIABLES.into_iter().find_map(|[size, rank]| Some(Place { size: number(size)?, rank: number(rank)? }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn launchers_say_how_many_ranks_there_are() {
        let said = |set: &[(&str, &str)]| {
            of_launcher(|name| set.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned()))
        };
        let place = |rank, size| Some(Place { rank, size });
        assert_eq!(said(&[]), None);
        assert_eq!(said(&[("SLURM_NTASKS", "4"), ("SLURM_PROCID", "0")]), None);
        assert_eq!(said(&[("OMPI_COMM_WORLD_SIZE", "4"), ("OMPI_COMM_WORLD_RANK", "3")]), place(3, 4));
        assert_eq!(said(&[("PMI_SIZE", "2"), ("PMI_RANK", "0")]), place(0, 2));
        assert_eq!(said(&[("MV2_COMM_WORLD_SIZE", "1"), ("MV2_COMM_WORLD_RANK", "0")]), place(0, 1));
        assert_eq!(said(&[("PMI_SIZE", "two"), ("PMI_RANK", "0")]), None);
        assert_eq!(said(&[("PMI_SIZE", "2")]), None);
    }
}
