//! The default number of threads: this rank's share of the processors.

use crate::boundary::Outcome;
use icoray_core::Ranks;
use std::num::NonZero;
use std::thread::available_parallelism;

/// The processors that this thread may run on, divided by the number of ranks of the node that share them; at least 1.
/// Collective.
pub(crate) fn share(ranks: &mut Ranks) -> Outcome<usize> {
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
    fn ranks_of_a_node_share_its_processors() {
        let all = available_parallelism().unwrap().get();
        assert_eq!(share(&mut Ranks::alone()).unwrap(), all);
        for size in [1, 2, 3, 2 * all] {
            let of_each = on_local_nodes(&vec![0; size], |team| share(&mut Ranks::new(Box::new(team))).unwrap());
            assert_eq!(of_each, vec![(all / size).max(1); size]);
        }
        let allowed: usize = mask().iter().map(|byte| byte.count_ones() as usize).sum();
        assert!(allowed >= all, "{allowed}, {all}");
    }
}
