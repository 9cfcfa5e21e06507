//! The time budget of pictures of the viewers' scene.
//!
//! Each such picture has the scene's budget, or a multiple of the time of the last picture of the model's own scene.
//! Time beyond a budget is subtracted from the budgets of later pictures, and no change is drawn until it is recovered.
//! So viewers cost a model no more than the budgets of its pictures, except for one picture.

use crate::drawing::PictureCost;
use icoray_core::Script;
use std::collections::BTreeMap;

/// Pictures of viewers' scene may take so many times what those of the model's own take.
const SHARE: f64 = 2.0;
/// The smallest budget, as that of a scene.
const LEAST_MS: f64 = 1.0;

/// Allowed and measured times of pictures.
#[derive(Debug)]
pub(super) struct TimeBudget {
    /// `live.time_budget_ms`.
    given_ms: Option<f64>,
    /// Milliseconds of the last picture of each view of the model's own scene.
    own_ms: BTreeMap<String, f64>,
    /// Milliseconds beyond budgets that are not recovered yet.
    debt_ms: f64,
    /// Whether the scene is viewers', and the step since which that holds.
    is_steered: bool,
    since: i64,
}

impl TimeBudget {
    pub fn new(given_ms: Option<f64>) -> Self {
        TimeBudget { given_ms, own_ms: BTreeMap::new(), debt_ms: 0.0, is_steered: false, since: i64::MIN }
    }

    /// The whole budget of a picture; `None` until the model's own scene was drawn. A view that was not drawn has that
    /// of the fastest one.
    fn whole_ms(&self, view: &str) -> Option<f64> {
        let fastest = || self.own_ms.values().copied().reduce(f64::min);
        self.given_ms.or_else(|| Some(SHARE * self.own_ms.get(view).copied().or_else(fastest)?))
    }

    /// Whether changes of viewers may be drawn now.
    pub fn is_open(&self) -> bool {
        self.is_steered || (self.debt_ms <= 0.0 && self.whole_ms("").is_some())
    }

    /// Time budget of a picture of each view, milliseconds.
    pub fn of_views(&self, script: &Script) -> BTreeMap<String, f64> {
        let left_ms = |view: &str| (self.whole_ms(view).unwrap_or_default() - self.debt_ms).max(LEAST_MS);
        script.views().iter().map(|view| (view.name().to_owned(), left_ms(view.name()))).collect()
    }

    /// The scene is viewers' from this step on, or the model's own.
    pub fn begin(&mut self, is_steered: bool, step: i64) {
        if self.is_steered != is_steered {
            self.is_steered = is_steered;
            self.since = step;
        }
    }

    /// Counts a picture. Returns why its scene cannot be drawn any more, if that cannot be made cheap enough.
    pub fn count(&mut self, picture: PictureCost) -> Option<String> {
        let PictureCost { view, step, ms, is_coarsest } = picture;
        if step < self.since {
            return None;
        }
        if !self.is_steered {
            self.own_ms.insert(view.clone(), ms);
            self.debt_ms = (self.debt_ms - self.whole_ms(&view)?).max(0.0);
            return None;
        }
        let whole_ms = self.whole_ms(&view)?;
        self.debt_ms = (self.debt_ms + ms - whole_ms).max(0.0);
        let why = || {
            format!(
                "a picture of the fewest pixels took {ms:.0} ms, expected at most {whole_ms:.0} ms; the model's own \
                 scene is drawn again: show less, or set live.time_budget_ms in the model's scene"
            )
        };
        (is_coarsest && ms > whole_ms).then(why)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "field = 'q'\n[live]\n[[views]]\nname = 'a'\n[[views]]\nname = 'b'\n";

    fn drawn(budget: &mut TimeBudget, step: i64, ms: f64, is_coarsest: bool) -> Option<String> {
        budget.count(PictureCost { view: "a".to_owned(), step, ms, is_coarsest })
    }

    #[test]
    fn budgets_follow_the_models_own_pictures() {
        let script = Script::parse(TEXT).unwrap();
        let mut budget = TimeBudget::new(None);
        assert!(!budget.is_open(), "nothing was measured");
        for (step, ms) in [(1, 900.0), (2, 100.0)] {
            assert_eq!(drawn(&mut budget, step, ms, false), None);
        }
        let all = |ms: f64| BTreeMap::from([("a".to_owned(), ms), ("b".to_owned(), ms)]);
        assert!(budget.is_open());
        assert_eq!(budget.of_views(&script), all(200.0));
        budget.begin(true, 3);
        // A picture that the background had begun before.
        assert_eq!(drawn(&mut budget, 2, 5000.0, true), None);
        assert_eq!(drawn(&mut budget, 3, 150.0, false), None);
        assert_eq!(budget.of_views(&script), all(200.0), "what is saved is not spent later");
        assert_eq!(TimeBudget::new(Some(7.0)).of_views(&script), all(7.0));
        assert!(TimeBudget::new(Some(7.0)).is_open());
    }

    #[test]
    fn time_beyond_the_budget_is_subtracted_from_later_pictures() {
        let script = Script::parse(TEXT).unwrap();
        let mut budget = TimeBudget::new(Some(100.0));
        budget.begin(true, 3);
        assert_eq!(drawn(&mut budget, 3, 180.0, false), None, "it can be made coarser");
        assert_eq!(budget.of_views(&script)["a"], 20.0);
        assert_eq!(drawn(&mut budget, 4, 60.0, true), None);
        assert_eq!(budget.of_views(&script)["a"], 60.0);
        let why = drawn(&mut budget, 5, 380.0, true).unwrap();
        assert!(why.contains("took 380 ms, expected at most 100 ms"), "{why}");
        assert_eq!(budget.of_views(&script)["a"], LEAST_MS);
        budget.begin(false, 6);
        for step in 6..10 {
            assert!(!budget.is_open(), "step {step}");
            drawn(&mut budget, step, 5000.0, false);
        }
        assert!(budget.is_open(), "320 ms are made up for");
    }
}
