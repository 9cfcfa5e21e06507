//! Agreements of ranks before collective actions.

use super::*;
use icoray_test_support::Random;

#[test]
fn the_error_of_the_lowest_rank_is_returned_beside_the_answer_of_rank_0() {
    let heard = on_ranks(4, |ranks| {
        let rank = ranks.rank();
        let value = format!("from {rank}").into_bytes();
        let refusal = [None, None, Some((13, "off")), Some((3, "bad"))][rank];
        let facts = vec![("step", rank.to_string())];
        ranks.agree(&Vote { refusal, facts, value: &value, leaves: false }).unwrap()
    });
    for Agreement { refusal, value } in heard {
        let expected = Refusal { number: Some(13), rank: 2, sentence: "off".into() };
        assert_eq!((refusal, value.as_slice()), (Some(expected), &b"from 0"[..]));
    }
}

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

/// Votes are joined on the way to rank 0, over ranks whose parent is not rank 0 too.
#[test]
fn the_outcome_of_an_agreement_is_that_of_all_votes_in_order() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let size = 1 + random.below(80);
        // Few ranks differ, so that often the lowest of them is below a rank that does not.
        let steps: Vec<usize> = (0..size).map(|_| [0, 1, 2].get(random.below(80)).copied().unwrap_or(0)).collect();
        let refuses: Vec<bool> = (0..size).map(|_| random.below(200) == 0).collect();
        let leaves: Vec<bool> = (0..size).map(|_| random.below(100) == 0).collect();
        let outcomes = on_ranks(size, |ranks| {
            let rank = ranks.rank();
            let refusal = refuses[rank].then_some((3, "bad"));
            let facts = vec![("field", "q".into()), ("step", steps[rank].to_string())];
            let agreed = ranks.agree(&Vote { refusal, facts, value: &[9], leaves: leaves[rank] }).unwrap();
            assert_eq!((agreed.value, ranks.is_gone()), (vec![9], leaves.contains(&true) && leaves.contains(&false)));
            agreed.refusal.map(|refusal| (refusal.rank, refusal.number))
        });
        let refusing = refuses.iter().position(|refuses| *refuses).map(|rank| (rank, Some(3)));
        let differing = steps.iter().position(|step| *step != steps[0]).map(|rank| (rank, None));
        assert!(outcomes.iter().all(|outcome| *outcome == refusing.or(differing)), "seed {seed}: {outcomes:?}");
    }
}

#[test]
fn no_rank_waits_for_one_that_has_left() {
    let leave = |leaves: &'static [bool]| {
        on_ranks(3, move |ranks| {
            let word = Vote { leaves: leaves[ranks.rank()], ..Vote::default() };
            ranks.agree(&word).unwrap();
            let is_gone = ranks.is_gone();
            (is_gone, ranks.rank() > 0 && is_gone && ranks.agree(&Vote::default()).is_err())
        })
    };
    assert_eq!(leave(&[true, false, false]), [(true, false), (true, true), (true, true)]);
    assert_eq!(leave(&[true, true, true]), [(false, false); 3]);
    assert_eq!(leave(&[false, false, false]), [(false, false); 3]);
}
