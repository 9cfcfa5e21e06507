//! Collective calls between threads.

use super::*;

#[test]
fn each_rank_has_something_for_each() {
    // From `from` for `to` in each round: nothing to some, and to oneself too.
    let letter = |round: usize, from: usize, to: usize| vec![(16 * from + to) as u8; round * from * (to % 3)];
    for size in [1, 2, 3, 5] {
        on_ranks(size, |ranks| {
            let (mine, team) = (ranks.rank(), ranks.team.as_mut().unwrap());
            for round in 0..4 {
                let for_all = (0..size).map(|to| (to, letter(round, mine, to))).collect();
                let received = team.exchange(for_all).unwrap();
                let sent = (0..size).map(|from| (from, letter(round, from, mine)));
                assert_eq!(received, sent.filter(|(_, letter)| !letter.is_empty()).collect());
            }
        });
    }
}

#[test]
fn the_members_of_a_group_have_the_bytes_of_all() {
    for size in 1..20 {
        for groups in 1..=size.min(4) {
            let shared = on_ranks(size, |ranks| {
                let rank = ranks.rank();
                let members = ranks.team.as_mut().unwrap().find_group(rank % groups, 3).unwrap();
                assert!(members.iter().copied().eq((rank % groups..size).step_by(groups)));
                let others = ranks.share_among(&members, vec![rank as u8; rank]).unwrap();
                others == members.iter().map(|member| vec![*member as u8; *member]).collect::<Vec<_>>()
            });
            assert!(shared.into_iter().all(|is_right| is_right), "{groups} groups of {size} ranks");
        }
    }
}
