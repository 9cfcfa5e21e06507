//! Agreements of ranks before collective actions.

use super::*;
use icoray_test_support::Random;

#[test]
fn ranks_at_different_steps_or_calls_do_not_agree() {
    for (other, expected) in [
        (vec![("step", "7")], "step 7, but 6 on rank 0; ranks that draw one picture must have the same"),
        (vec![("wait", "")], "is in another call than rank 0"),
        (vec![], "is in another call than rank 0"),
    ] {
        let refusals = on_ranks(3, |ranks| {
            let facts = if ranks.rank() == 1 { other.clone() } else { vec![("step", "6")] };
            let facts = facts.into_iter().map(|(name, fact)| (name, fact.to_string())).collect();
            ranks.agree(&Vote { facts, ..Vote::default() }).unwrap().refusal.unwrap()
        });
        for refusal in refusals {
            assert_eq!((refusal.number, refusal.rank, refusal.sentence.as_str()), (None, 1, expected));
            assert_eq!(refusal.error(3).kind(), ErrorKind::Mpi);
        }
    }
}

/// Votes are joined on the way to rank 0, over ranks whose parent is not rank 0 too. No rank waits for one that has left.
#[test]
fn the_outcome_of_an_agreement_is_that_of_all_votes_in_order() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let size = 1 + random.below(80);
        // Few ranks differ, so that often the lowest of them is below a rank that does not.
        let steps: Vec<usize> = (0..size).map(|_| [0, 1, 2].get(random.below(80)).copied().unwrap_or(0)).collect();
        let refuses: Vec<bool> = (0..size).map(|_| random.below(200) == 0).collect();
        let leaves: Vec<bool> = (0..size).map(|_| random.below(100) == 0 || seed % 10 == 9).collect();
        let outcomes = on_ranks(size, |ranks| {
            let rank = ranks.rank();
            let refusal = refuses[rank].then_some((rank as i32 + 1, "bad"));
            let facts = vec![("field", "q".into()), ("step", steps[rank].to_string())];
            let agreed = ranks.agree(&Vote { refusal, facts, value: &[rank as u8], leaves: leaves[rank] }).unwrap();
            assert_eq!((agreed.value, ranks.is_gone()), (vec![0], leaves.contains(&true) && leaves.contains(&false)));
            assert!(!ranks.is_gone() || ranks.agree(&Vote::default()).is_err());
            agreed.refusal.map(|refusal| {
                assert!(refusal.number.is_none() || refusal.sentence == "bad");
                (refusal.rank, refusal.number)
            })
        });
        let refusing = refuses.iter().position(|refuses| *refuses).map(|rank| (rank, Some(rank as i32 + 1)));
        let differing = steps.iter().position(|step| *step != steps[0]).map(|rank| (rank, None));
        assert!(outcomes.iter().all(|outcome| *outcome == refusing.or(differing)), "seed {seed}: {outcomes:?}");
    }
}
