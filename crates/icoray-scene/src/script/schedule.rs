//! The steps at which a view is drawn.

use crate::name::Stamp;

/// Steps that match any of these criteria; all steps if none is given.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Schedule {
    /// Multiples of this number, 0 and negative ones included.
    pub every: Option<u32>,
    /// These steps.
    pub steps: Vec<i64>,
    /// The first step that reaches each of these times, in seconds.
    pub times_s: Vec<f64>,
}

/// Whether a clock, which accumulates rounding errors, has reached a time.
fn has_reached(clock_s: f64, time_s: f64) -> bool {
    clock_s >= time_s - 1e-9 * time_s.abs()
}

impl Schedule {
    pub fn is_due(&self, now: &Stamp, before: Option<&Stamp>) -> bool {
        let Schedule { every, steps, times_s } = self;
        let before_s = match before {
            Some(before) => before.time_s,
            // Of equal steps from 0; what lies farther back is the run's that this one goes on with.
            None if now.step > 1 => now.time_s - now.time_s / now.step as f64,
            None => f64::NEG_INFINITY,
        };
        let is_everything = every.is_none() && steps.is_empty() && times_s.is_empty();
        is_everything
            || every.is_some_and(|every| now.step % i64::from(every.max(1)) == 0)
            || steps.contains(&now.step)
            || times_s.iter().any(|&time| has_reached(now.time_s, time) && !has_reached(before_s, time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(step: i64, time_s: f64) -> Stamp {
        Stamp { step, time_s, date: None }
    }

    /// The steps that are due among steps with these times, numbered from `first`.
    fn due(schedule: &Schedule, first: i64, times: &[f64]) -> Vec<i64> {
        let steps: Vec<Stamp> = (first..).zip(times).map(|(step, time)| stamp(step, *time)).collect();
        let before = std::iter::once(None).chain(steps.iter().map(Some));
        let due = steps.iter().zip(before).filter(|(now, before)| schedule.is_due(now, *before));
        due.map(|(now, _)| now.step).collect()
    }

    fn at_times(times_s: &[f64]) -> Schedule {
        Schedule { times_s: times_s.into(), ..Schedule::default() }
    }

    #[test]
    fn any_of_the_lists_names_a_step_and_none_names_all() {
        assert_eq!(due(&Schedule::default(), -2, &[0.0; 5]), [-2, -1, 0, 1, 2]);
        let schedule = Schedule { every: Some(3), steps: vec![4, -2], times_s: vec![50.0] };
        assert_eq!(due(&schedule, -3, &[0., 10., 20., 30., 40., 50., 60., 70., 80.]), [-3, -2, 0, 2, 3, 4]);
        assert!(!schedule.is_due(&stamp(i64::MIN, 0.0), Some(&stamp(0, 0.0))));
    }

    #[test]
    fn a_time_belongs_to_the_first_step_that_reaches_it() {
        let schedule = at_times(&[0.0, 25.0, 27.0, 40.0]);
        assert_eq!(due(&schedule, 0, &[0.0, 10.0, 20.0, 30.0, 40.0, 50.0]), [0, 3, 4]);
        // Sums of a tenth: 0.30000000000000004 - 1e-17 and its like.
        let sums: Vec<f64> = (0..50).scan(0.0, |sum, _| Some(std::mem::replace(sum, *sum + 0.1))).collect();
        assert!(sums[10] < 1.0);
        assert_eq!(due(&at_times(&[1.0]), 0, &sums), [10]);
    }

    #[test]
    fn a_restarted_run_does_not_repeat_pictures() {
        let schedule = at_times(&[0.0, 25.0, 95.0, 110.0]);
        // From the beginning, whether the model's first step is 0 or 1.
        assert_eq!(due(&schedule, 0, &[0.0, 10.0]), [0]);
        assert_eq!(due(&schedule, 1, &[10.0, 20.0, 30.0]), [1, 3]);
        // From the middle: 95 lies within the step to 100, 25 does not.
        assert_eq!(due(&schedule, 10, &[100.0, 110.0]), [10, 11]);
        assert_eq!(due(&schedule, 9, &[90.0, 100.0, 110.0]), [10, 11]);
        assert_eq!(due(&schedule, 12, &[120.0, 130.0]), [0; 0]);
    }
}
