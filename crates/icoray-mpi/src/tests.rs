//! Bytes between real ranks: a test runs itself once more under mpirun.

use super::*;
use icoray::Team;
use icoray_test_support::{Need, has_tool, runs_long, skip};
use mpi::ffi;

/// Runs the test of that name on this number of ranks, and passes `work` a team of all of them.
///
/// # Panics
/// When a rank does, or the run takes too long.
fn on_ranks(sizes: &[usize], test: &str, work: fn(&mut Team)) {
    if std::env::var_os(RANK).is_some() {
        return within_mpi(work);
    }
    if !has_tool(Need::Mpi, "mpirun") {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    for size in sizes {
        let mut run = icoray_test_support::on_ranks("mpirun", *size, directory.path());
        run.env(RANK, "");
        run.arg(std::env::current_exe().unwrap()).args([&format!("tests::{test}"), "--exact"]);
        let output = run.output().unwrap();
        let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        let passed = text[0].matches("1 passed").count();
        assert!(output.status.success() && passed == *size, "{run:?}\n{}{}", text[0], text[1]);
    }
}

/// Set where a test is one of the ranks.
const RANK: &str = "ICORAY_TEST_RANK";

fn within_mpi(work: fn(&mut Team)) {
    // SAFETY: the program's only calls of these, around all others, on one thread.
    unsafe {
        ffi::MPI_Init(std::ptr::null_mut(), std::ptr::null_mut());
        work(&mut team(ffi::RSMPI_Comm_c2f(ffi::RSMPI_COMM_WORLD)).unwrap());
        ffi::MPI_Finalize();
    }
}

#[test]
fn each_rank_has_something_for_each() {
    on_ranks(&[1, 2, 3, 4], "each_rank_has_something_for_each", |team| {
        let letter = |length: usize, from: usize, to: usize| -> Vec<u8> {
            (0..length * (from + 2 * to)).map(|i| (i * 7 + 16 * from + to) as u8).collect()
        };
        let (rank, size) = (team.rank(), team.size());
        // Nothing at all, few bytes, and more than MPI sends without waiting for the other side.
        for length in [0, 3, 10, 70_001, 3_000_000] {
            let mine = (0..size).map(|to| (to, letter(length, rank, to))).collect();
            let received = team.exchange(mine).unwrap();
            for from in 0..size {
                let received = received.get(&from).map_or(&[][..], Vec::as_slice);
                assert!(*received == letter(length, from, rank), "{length} of {from} for {rank}");
            }
        }
        assert_eq!(team.exchange((0..size).map(|to| (to, vec![rank as u8])).collect()).unwrap().len(), size);
    });
}

/// Small messages and such as MPI does not send before the other side takes them, while rank 0 is away at times.
#[test]
fn messages_arrive_in_order_and_no_rank_blocks() {
    on_ranks(&[2, 3, 4], "messages_arrive_in_order_and_no_rank_blocks", |team| {
        const MESSAGES: usize = 200;
        let message = |rank: usize, i: usize| vec![(rank + i) as u8; if i.is_multiple_of(7) { 300_000 } else { i }];
        let (rank, size) = (team.rank(), team.size());
        for _ in 0..3 {
            if rank != 0 {
                (0..MESSAGES).for_each(|i| team.send(message(rank, i)).unwrap());
                while !team.is_sent().unwrap() {}
            } else {
                let mut next = vec![0; size];
                while next[1..].iter().any(|next| *next < MESSAGES) {
                    let Some((of, bytes)) = team.try_receive().unwrap() else {
                        std::thread::sleep(std::time::Duration::from_millis(1));
                        continue;
                    };
                    assert!(bytes == message(of, next[of]), "message {} of {of}", next[of]);
                    next[of] += 1;
                }
                assert!(team.try_receive().unwrap().is_none());
            }
            // The bytes of a broadcast are not taken for a message.
            assert_eq!(team.broadcast(vec![rank as u8; 5]).unwrap(), [0; 5]);
            assert_eq!(team.share(&[rank as u8]).unwrap().len(), size);
        }
    });
}

/// The messages of a rank in a collective call are sent when it returns: the model may then compute without a call.
#[test]
fn no_rank_waits_for_the_next_call_of_another() {
    on_ranks(&[2], "no_rank_waits_for_the_next_call_of_another", |team| {
        // Both have the same parent.
        let mark = std::env::temp_dir().join(format!("icoray_mpi_{}", std::os::unix::process::parent_id()));
        let bytes = team.broadcast(vec![7; 30_000_000 * (1 - team.rank())]).unwrap();
        assert!(bytes.len() == 30_000_000 && bytes.iter().all(|byte| *byte == 7));
        if team.rank() == 1 {
            return std::fs::write(mark, "").unwrap();
        }
        while !mark.exists() {
            std::thread::yield_now();
        }
        std::fs::remove_file(mark).unwrap();
    });
}

/// What `icoray-study scale` counts between threads is what MPI carries.
#[test]
fn messages_are_as_many_as_between_threads() {
    fn calls(team: &mut Team) -> icoray::ranks::Traffic {
        let (rank, size) = (team.rank(), team.size());
        team.share(&vec![1; 10 * rank]).unwrap();
        team.broadcast(vec![2; 1000]).unwrap();
        // To the next rank and to itself.
        let mine = [(rank, vec![3]), ((rank + 1) % size, vec![4; 100 * rank])].into();
        team.exchange(mine).unwrap();
        let group = team.find_group(rank / 3 * 3, 7).unwrap();
        assert_eq!(group.len(), 3.min(size - rank / 3 * 3));
        team.share_among(&group, vec![5; 20 * rank]).unwrap();
        team.traffic()
    }
    on_ranks(&[1, 2, 3, 16], "messages_are_as_many_as_between_threads", |team| {
        let local = icoray::ranks::on_local_nodes(&vec![0; team.size()], |mut team| calls(&mut team));
        let mine = calls(team);
        assert_eq!(mine, local[team.rank()]);
        assert!(team.size() == 1 || mine.messages > 2 && mine.bytes > 20, "{mine:?}");
    });
}

/// More than 2 GiB go from one rank to the other.
#[test]
fn lengths_may_need_more_than_32_bits() {
    if std::env::var_os(RANK).is_none() && (!runs_long() || !has_memory(6)) {
        return;
    }
    on_ranks(&[2], "lengths_may_need_more_than_32_bits", |team| {
        let lengths: [usize; 2] = [3, (1 << 31) + 12_345];
        let (rank, other) = (team.rank(), 1 - team.rank());
        let mine = (0..lengths[other]).map(|i| (i / 1000 + rank) as u8).collect();
        let received = team.exchange([(other, mine)].into()).unwrap();
        assert_eq!((received.len(), received[&other].len()), (1, lengths[rank]));
        assert!(received[&other].iter().enumerate().all(|(i, byte)| *byte == (i / 1000 + other) as u8));
    });
}

/// Whether this number of GB of memory is free. If not, skips the test.
fn has_memory(gigabytes: u64) -> bool {
    let meminfo = std::fs::read_to_string("/proc/meminfo").unwrap();
    let available = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:")).unwrap();
    let kilobytes: u64 = available.trim().trim_end_matches(" kB").parse().unwrap();
    let is_enough = kilobytes / 1_000_000 >= gigabytes;
    if !is_enough {
        skip(Need::Memory);
    }
    is_enough
}

/// Each rank writes its bytes to the node's memory, again and again, and reads all of them. The same where each is a
/// node of its own, as the environment can ask for.
#[test]
fn ranks_of_a_node_share_memory() {
    on_ranks(&[1, 2, 3, 4], "ranks_of_a_node_share_memory", |team| {
        const MINE: usize = 50_001;
        let (rank, size) = (team.rank(), team.size());
        assert_eq!((team.node_leader(), team.node_rank(), team.node_size()), (0, rank, size));
        let mut shared = Vec::new();
        // Two at a time, of which the first goes first.
        for more in [0, 7] {
            let bytes = size * MINE + more;
            let mut node = team.node(bytes).unwrap();
            assert_eq!((node.leader, node.is_refused_here), (0, false));
            for round in 0..5u8 {
                node.begin(Some(team)).unwrap();
                node.put(rank * MINE, &vec![round + 10 * rank as u8; MINE]);
                node.settle(Some(team)).unwrap();
                let all = node.bytes();
                assert!(all.len() >= bytes && all.as_ptr().align_offset(8) == 0);
                for (i, byte) in all[..size * MINE].iter().enumerate() {
                    assert_eq!(*byte, round + 10 * (i / MINE) as u8, "byte {i} in round {round}");
                }
            }
            shared.push(node);
        }
        shared.remove(0);
        assert_eq!(shared[0].bytes()[0], 4);
        drop(shared);
        // SAFETY: no other thread looks at the environment.
        unsafe { std::env::set_var("ICORAY_NODE_RANKS", "2") };
        let node = team.node(10).unwrap();
        assert_eq!((node.leader, node.is_refused_here), (rank / 2 * 2, false));
    });
}

#[test]
fn no_rank_waits_for_one_that_cannot_map_memory() {
    on_ranks(&[2, 3], "no_rank_waits_for_one_that_cannot_map_memory", |team| {
        // SAFETY: a number that is written, and read again; no other thread opens files.
        let limit = unsafe {
            let mut limit: libc::rlimit = std::mem::zeroed();
            libc::getrlimit(libc::RLIMIT_NOFILE, &mut limit);
            limit
        };
        let allowed = |files: libc::rlim_t| {
            let limit = libc::rlimit { rlim_cur: files, ..limit };
            // SAFETY: as above.
            assert_eq!(unsafe { libc::setrlimit(libc::RLIMIT_NOFILE, &limit) }, 0);
        };
        allowed(if team.rank() == 1 { 0 } else { limit.rlim_cur });
        let refused = team.node(1000).unwrap();
        allowed(limit.rlim_cur);
        assert!(refused.is_refused_here, "each rank has memory of its own");
        let node = team.node(1000).unwrap();
        assert!(!node.is_refused_here && node.bytes().len() >= 1000);
    });
}

/// Messages of any rank for any other, small ones and such as MPI does not send before the other side takes them, and a
/// meeting at which ranks arrive one after the other.
#[test]
fn messages_go_between_all_ranks_without_blocking() {
    on_ranks(&[1, 2, 4], "messages_go_between_all_ranks_without_blocking", |team| {
        const MESSAGES: usize = 40;
        let letter = |from: usize, to: usize, i: usize| {
            vec![(7 * from + 3 * to + i) as u8; if i.is_multiple_of(9) { 300_000 } else { i }]
        };
        let (rank, size) = (team.rank(), team.size());
        let now = || {
            let since = std::time::UNIX_EPOCH.elapsed().unwrap();
            since.as_nanos() as u64
        };
        let others = || (0..size).filter(|other| *other != rank);
        let mut messages = team.point_to_point().unwrap();
        assert!(!messages.is_gone());
        for round in 0..3 {
            for (i, to) in (0..MESSAGES).flat_map(|i| others().map(move |to| (i, to))) {
                messages.send(to, letter(rank, to, i + round)).unwrap();
            }
            let mut next = vec![0; size];
            while others().any(|from| next[from] < MESSAGES) {
                let Some((from, bytes)) = messages.try_receive().unwrap() else {
                    messages.is_sent().unwrap();
                    continue;
                };
                assert!(bytes == letter(from, rank, next[from] + round), "message {} of {from}", next[from]);
                next[from] += 1;
            }
            while !messages.is_sent().unwrap() {}
            // The last one keeps the others from going on.
            if rank == size - 1 {
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
            let arrived = now();
            while !messages.try_meet().unwrap() {}
            let left = now();
            for other in team.share(&arrived.to_le_bytes()).unwrap() {
                assert!(left >= u64::from_le_bytes(other.try_into().unwrap()), "rank {rank} left early");
            }
        }
        assert!(messages.try_receive().unwrap().is_none());
        // They are apart from the team's.
        assert_eq!(team.share(&[rank as u8]).unwrap().concat().len(), size);
        team.give_up();
        assert!(messages.is_gone());
    });
}
