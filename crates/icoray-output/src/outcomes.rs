//! Outcomes of frames that another thread handles, stored until the caller takes them.

use icoray_grid::Error;

/// Outcomes since the caller's last request, the oldest first.
///
/// At most [`Outcomes::KEPT`] are stored, so that a caller who never takes them costs no memory; the rest are counted.
/// Failures displace successes: the first failures are stored in any case.
#[derive(Debug, Clone)]
pub struct Outcomes<T> {
    /// The stored outcomes, oldest first.
    pub kept: Vec<T>,
    /// Number of successful frames that are not in `kept`.
    pub more_done: u64,
    /// Number of failed frames that are not in `kept`.
    pub more_failed: u64,
}

/// An outcome that [`Outcomes`] can store: a success or a failure.
pub trait Outcome {
    /// The error of a failure.
    fn error(&self) -> Option<&Error>;
}

impl<T> Default for Outcomes<T> {
    fn default() -> Self {
        Outcomes { kept: Vec::new(), more_done: 0, more_failed: 0 }
    }
}

impl<T: Outcome> Outcomes<T> {
    /// Maximum number of stored outcomes.
    pub const KEPT: usize = 256;

    /// Adds the latest outcome.
    pub fn push(&mut self, outcome: T) {
        if self.kept.len() < Self::KEPT {
            self.kept.push(outcome);
            return;
        }
        if outcome.error().is_none() {
            self.more_done += 1;
            return;
        }
        match self.kept.iter().rposition(|o| o.error().is_none()) {
            Some(last_done) => {
                self.kept.remove(last_done);
                self.kept.push(outcome);
                self.more_done += 1;
            }
            None => self.more_failed += 1,
        }
    }

    /// Number of successful frames.
    pub fn done(&self) -> u64 {
        self.kept.iter().filter(|o| o.error().is_none()).count() as u64 + self.more_done
    }

    /// Number of failed frames.
    pub fn failed(&self) -> u64 {
        self.errors().count() as u64 + self.more_failed
    }

    /// The stored failures, the first one first.
    pub fn errors(&self) -> impl Iterator<Item = &Error> {
        self.kept.iter().filter_map(Outcome::error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_grid::ErrorKind;

    struct Numbered(usize, Option<Error>);

    impl Outcome for Numbered {
        fn error(&self) -> Option<&Error> {
            self.1.as_ref()
        }
    }

    /// Outcomes of frames 0 to `count`; those for which `fails` returns true are failures.
    fn of(count: usize, fails: impl Fn(usize) -> bool) -> Outcomes<Numbered> {
        let mut outcomes = Outcomes::default();
        let error = |i| fails(i).then(|| Error::new(ErrorKind::Io, format!("frame {i}")));
        (0..count).for_each(|i| outcomes.push(Numbered(i, error(i))));
        outcomes
    }

    #[test]
    fn few_are_kept_all_and_in_order() {
        let outcomes = of(256, |i| i % 3 == 0);
        assert!(outcomes.kept.iter().map(|o| o.0).eq(0..256));
        assert_eq!((outcomes.more_done, outcomes.more_failed), (0, 0));
    }

    #[test]
    fn of_many_the_first_failures_are_kept_and_none_is_uncounted() {
        let late = of(2000, |i| i >= 1000);
        assert_eq!((late.kept.len(), late.done(), late.failed()), (256, 1000, 1000));
        assert!(late.kept.iter().map(|o| o.0).eq(1000..1256));
        let rare = of(2000, |i| i % 500 == 7);
        assert_eq!((rare.kept.len(), rare.done(), rare.failed(), rare.more_failed), (256, 1996, 4, 0));
        let said: Vec<_> = rare.errors().map(Error::context).collect();
        assert_eq!(said, ["frame 7", "frame 507", "frame 1007", "frame 1507"]);
        assert!(rare.kept.is_sorted_by_key(|o| o.0));
    }
}
