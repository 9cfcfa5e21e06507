//! Detects arrays that hold an old time level: of models that swap pointers and set a field only once.
//!
//! With two time levels such an array changes at every second step, with three at every third, while the model's state
//! changes at each. A field is reported, once, after one period of this pattern if another field of the pictures
//! changed at the other steps, else after two. Fields that never change, change at each step or irregularly, or are set
//! for each picture are not reported.
//!
//! A field that is set for each picture and keeps its values while the others change is one that the model computes at
//! some steps only: it is reported once, unless it has never changed.

use std::collections::BTreeMap;

/// Maximum number of values of a field that are compared.
pub(super) const SAMPLES: usize = 1024;

/// Numbers of time levels of models.
const LEVELS: [usize; 2] = [2, 3];

/// Pattern of a field's values over the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pattern {
    /// One of so many time levels.
    TimeLevel(usize),
    /// Those of the pictures before: computed at some steps only.
    Unchanged,
}

/// Changes of the fields of pictures over the last steps.
#[derive(Debug, Default)]
pub(super) struct TimeLevels {
    step: Option<i64>,
    fields: BTreeMap<String, Track>,
}

#[derive(Debug, Default)]
struct Track {
    /// Hash of the values at the last step.
    hash: u64,
    /// Whether the array was set after that.
    is_new: bool,
    is_reported: bool,
    /// Whether the values have ever changed, and at how many pictures they have not since.
    varies: bool,
    repeats: usize,
    /// Changes at the last successive steps.
    events: Vec<Event>,
}

/// Changes from one step to the next.
#[derive(Debug, Clone, Copy)]
struct Event {
    has_changed: bool,
    /// Whether another field has changed.
    others_changed: bool,
}

impl TimeLevels {
    /// Records that the model has set the field again.
    pub fn given(&mut self, name: &str) {
        if let Some(track) = self.fields.get_mut(name) {
            track.is_new = true;
        }
    }

    /// Records the hashes of the fields that a step's pictures read; returns the names of fields that look like old
    /// values, each once, with what they look like.
    pub fn step(&mut self, step: i64, hashes: &[(String, u64)]) -> Vec<(String, Pattern)> {
        let is_next = self.step.is_some_and(|before| before.checked_add(1) == Some(step));
        self.step = Some(step);
        let has_changed = |(name, hash): &(String, u64)| self.fields.get(name).map(|track| track.hash != *hash);
        let changes: Vec<Option<bool>> = hashes.iter().map(has_changed).collect();
        let changed = changes.iter().filter(|change| **change == Some(true)).count();
        let mut found = Vec::new();
        for ((name, hash), change) in hashes.iter().zip(changes) {
            let track = self.fields.entry(name.clone()).or_default();
            track.hash = *hash;
            match change {
                Some(true) => (track.varies, track.repeats) = (true, 0),
                Some(false) => track.repeats += 1,
                None => {}
            }
            let is_kept = track.repeats > usize::from(changed == 0) && track.varies;
            if track.is_new && is_kept && !std::mem::replace(&mut track.is_reported, true) {
                found.push((name.clone(), Pattern::Unchanged));
            }
            let Some(has_changed) = change.filter(|_| is_next && !track.is_new) else {
                track.events.clear();
                track.is_new = false;
                continue;
            };
            let others_changed = changed > usize::from(has_changed);
            track.events.push(Event { has_changed, others_changed });
            let levels = LEVELS.into_iter().find(|levels| is_old_level(&track.events, *levels));
            if let (Some(levels), false) = (levels, track.is_reported) {
                track.is_reported = true;
                found.push((name.clone(), Pattern::TimeLevel(levels)));
            }
            let max = 2 * LEVELS[1] + 1;
            track.events.drain(..track.events.len().saturating_sub(max));
        }
        // Fields that these pictures do not read have no previous step at the next one.
        for (name, track) in &mut self.fields {
            track.is_new |= hashes.iter().all(|(read, _)| read != name);
        }
        found
    }
}

/// Whether values changed at every `levels`-th step only.
fn is_old_level(events: &[Event], levels: usize) -> bool {
    let around = |times: usize| {
        let last = events.len().checked_sub(times * levels + 1).map(|from| &events[from..]);
        last.filter(|last| last.iter().enumerate().all(|(i, event)| event.has_changed == (i % levels == 0)))
    };
    let others_changed =
        |last: &[Event]| last.iter().filter(|event| !event.has_changed).all(|event| event.others_changed);
    around(1).is_some_and(others_changed) || around(2).is_some()
}

#[cfg(test)]
mod tests {
    use super::Pattern::{TimeLevel, Unchanged};
    use super::*;

    /// Which fields are pointed out, and when: of each step the values, and whether the arrays are given anew.
    fn reports(steps: impl Iterator<Item = (i64, Vec<(&'static str, u64, bool)>)>) -> Vec<(i64, String, Pattern)> {
        let mut levels = TimeLevels::default();
        let mut reports = Vec::new();
        for (step, fields) in steps {
            for (name, _, is_given) in &fields {
                if *is_given {
                    levels.given(name);
                }
            }
            let hashes: Vec<_> = fields.iter().map(|(name, hash, _)| ((*name).to_owned(), *hash)).collect();
            reports.extend(levels.step(step, &hashes).into_iter().map(|(name, of)| (step, name, of)));
        }
        reports
    }

    /// The step whose values one of so many time levels has.
    fn level(step: i64, levels: i64) -> u64 {
        (step / levels * levels) as u64
    }

    #[test]
    fn levels_of_fields_that_change_together_are_pointed_out_after_twice_around() {
        let both = reports((1..20).map(|s| (s, vec![("a", level(s, 2), false), ("b", level(s, 2), false)])));
        assert_eq!(both, [(6, "a".to_owned(), TimeLevel(2)), (6, "b".to_owned(), TimeLevel(2))]);
    }

    #[test]
    fn correct_fields_are_not_reported_as_old_time_levels() {
        let quiet = |value: fn(i64) -> u64, is_given: bool| {
            let steps = (0..40).map(|s| (s, vec![("a", value(s), is_given), ("b", s as u64, false)]));
            assert_eq!(reports(steps), []);
        };
        quiet(|_| 7, false);
        quiet(|s| s as u64, false);
        quiet(|s| s as u64, true);
        // Radiation.
        quiet(|s| level(s, 10), false);
        quiet(|_| 7, true);
        // Seen now and then: nothing can be said of the steps between.
        let seldom = (0..40).map(|s| (10 * s, vec![("a", level(s, 2), false), ("b", s as u64, false)]));
        assert_eq!(reports(seldom), []);
        let at_times = |s: i64| {
            let a = (s % 3 != 2).then_some(("a", level(s, 2), false));
            (s, a.into_iter().chain([("b", s as u64, false)]).collect())
        };
        assert_eq!(reports((0..40).map(at_times)), []);
    }

    /// A diagnostic that a model computes for its output, seen by pictures in between.
    #[test]
    fn fields_that_are_computed_at_some_steps_are_reported_once() {
        let both = reports((0..40).map(|s| (5 * s, vec![("a", level(s, 4), true), ("b", s as u64, true)])));
        assert_eq!(both, [(25, "a".to_owned(), Unchanged)]);
        let alone = reports((0..40).map(|s| (5 * s, vec![("a", level(s, 4), true)])));
        assert_eq!(alone, [(30, "a".to_owned(), Unchanged)]);
    }
}
