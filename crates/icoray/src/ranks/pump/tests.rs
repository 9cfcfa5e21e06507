//! Collective calls on one thread, their messages on another.

use super::*;
use crate::ranks::{Ranks, local_team, on_local_nodes};
use icoray_grid::ErrorKind;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread;

/// The results of `work` for each rank's team, while the rank's own thread moves messages from time to time.
fn on_pumped<R: Send>(size: usize, work: impl Fn(&mut Team) -> R + Sync) -> Vec<R> {
    on_local_nodes(&vec![0; size], |mut team| {
        let (mut pumped, mut pump) = team.pumped().unwrap();
        // Few children and short pieces, so that few ranks and bytes have many of them.
        (pumped.fan_out, pumped.pieces.most) = (2, 100);
        let is_done = AtomicBool::new(false);
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let made = work(&mut pumped);
                is_done.store(true, SeqCst);
                made
            });
            for _ in 0..3 {
                sleep(Duration::from_millis(1));
                pump.pump();
            }
            pump.finish(|| is_done.load(SeqCst));
            worker.join().unwrap()
        })
    })
}

/// Bytes that identify their sender, their receiver and their call; empty for some.
fn letter(round: usize, from: usize, to: usize) -> Vec<u8> {
    let length = (37 * (from + 1) * (round + to)) % 450;
    (0..length).map(|i| (i + 50 * from + 7 * to + round) as u8).collect()
}

#[test]
fn collective_calls_are_those_of_any_team() {
    for size in [1, 2, 3, 7, 12] {
        on_pumped(size, |team| {
            let rank = team.rank();
            for round in 0..4 {
                let shared = team.share(&letter(round, rank, 0)).unwrap();
                assert_eq!(shared, (0..size).map(|of| letter(round, of, 0)).collect::<Vec<_>>());
                let for_all = (0..size).map(|to| (to, letter(round, rank, to))).collect();
                let received = team.exchange(for_all).unwrap();
                let sent = (0..size).map(|from| (from, letter(round, from, rank)));
                assert_eq!(received, sent.filter(|(_, letter)| !letter.is_empty()).collect());
                if rank == 0 {
                    let mut next = vec![0; size];
                    while next[1..].iter().any(|next| *next < 5) {
                        match team.try_receive().unwrap() {
                            Some((of, bytes)) => {
                                assert_eq!(bytes, letter(next[of], of, round));
                                next[of] += 1;
                            }
                            None => team.wait().unwrap(),
                        }
                    }
                } else {
                    (0..5).for_each(|i| team.send(letter(i, rank, round)).unwrap());
                    assert!(team.is_sent().unwrap());
                }
                assert_eq!(team.broadcast(letter(round, rank, 1)).unwrap(), letter(round, 0, 1));
            }
        });
    }
}

/// A rank that leaves a frame by an error ends it on all, at whichever call they are, and the next frame is as if
/// nothing had been.
#[test]
fn a_frame_that_one_rank_leaves_ends_on_all() {
    for (size, odd) in [(2, 1), (7, 0), (7, 3), (7, 6)] {
        let said = on_pumped(size, |team| {
            let rank = team.rank();
            let mut frame = |is_left: bool| {
                team.begin_frame();
                let drawn = team.share(&[rank as u8]).and_then(|shared| {
                    if is_left && rank == odd {
                        return Err(Error::new(ErrorKind::Field, "out of luck"));
                    }
                    let received = team.exchange((0..size).map(|to| (to, vec![rank as u8])).collect())?;
                    let received: Vec<_> = received.into_values().collect();
                    let last = team.broadcast(vec![9])?;
                    Ok((shared, received, last))
                });
                drawn.inspect_err(|error| team.break_off(error))
            };
            let all: Vec<Vec<u8>> = (0..size).map(|rank| vec![rank as u8]).collect();
            [false, true, false, true, false].map(|is_left| {
                let drawn = frame(is_left);
                if !is_left {
                    assert_eq!(drawn.as_ref().unwrap(), &(all.clone(), all.clone(), vec![9]));
                }
                drawn.err().map(|error| error.to_string())
            })
        });
        let bad = Some("bad field: out of luck".to_string());
        for (rank, said) in said.into_iter().enumerate() {
            assert_eq!(said, [None, bad.clone(), None, bad.clone(), None], "rank {rank} of {size}");
        }
    }
}

#[test]
fn calls_fail_once_messages_are_cut_off() {
    let mut teams = local_team(2);
    let (mut team, mut pump) = teams[0].pumped().unwrap();
    let waiting = thread::spawn(move || {
        let error = team.share(&[1]).unwrap_err();
        (error.kind(), team.broadcast(vec![2]).unwrap_err().kind())
    });
    pump.pump();
    pump.cut();
    pump.pump();
    assert_eq!(waiting.join().unwrap(), (ErrorKind::Mpi, ErrorKind::Mpi));
    let mut has_asked = false;
    pump.finish(|| std::mem::replace(&mut has_asked, true));
    assert!(has_asked, "it ends when this rank is done, whatever others do");
}

#[test]
fn a_team_without_messages_of_its_own_is_an_error() {
    assert!(Ranks::alone().pumped().unwrap().is_none());
    let mut ranks = Ranks::new(local_team(1).remove(0));
    assert!(ranks.pumped().unwrap().is_some());
    let error = ranks.pumped().map(drop).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Mpi);
}
