//! Which pictures are due, step by step.

use super::*;

const TEXT: &str = r#"field = "q"
[camera]
lon = 0
lat = 0
distance = 3
[transfer]
map = "viridis"
range = [0, 1]
opacity = [[0, 0.5]]
[[views]]
name = "often"
every = 2
[[views]]
name = "listed"
at_times = [0, 250, 260, 500]
[[views]]
name = "strong"
every = 1
when = ["max(w) > 3", "min(w) < 0"]
[[views]]
name = "swept"
at_steps = [3]
sweep.lon = [0, 90]
"#;

fn stamp(step: i64) -> Stamp {
    Stamp { step, time_s: 100.0 * step as f64, date: None }
}

/// Names of what is due at each of the steps, where the maximum of a field is the step's number.
fn due(steps: std::ops::Range<i64>) -> Vec<String> {
    let script = Script::parse(TEXT).unwrap();
    let mut before = None;
    let mut all = Vec::new();
    for step in steps {
        let mut statistic = |field: &str, statistic: Statistic| {
            assert_eq!(field, "w");
            Ok(Some(if statistic == Statistic::Max { step as f64 } else { -1.0 }))
        };
        let now = stamp(step);
        let due = script.scheduled(&now, before.as_ref()).filter(|view| view.holds(&mut statistic).unwrap());
        all.push(due.flat_map(|view| view.shots(&now)).map(|shot| shot.name).collect::<Vec<_>>().join(" "));
        before = Some(now);
    }
    all
}

#[test]
fn views_are_due_by_their_own_triggers() {
    assert_eq!(due(0..6), ["often listed", "", "often", "listed swept swept", "often strong", "listed strong"]);
    // As a run that is started again in the middle.
    assert_eq!(due(4..6), ["often strong", "listed strong"]);
    assert_eq!(due(3..4), ["listed swept swept"]);
}

#[test]
fn only_needed_statistics_are_requested() {
    let script = Script::parse(TEXT).unwrap();
    let mut asked = Vec::new();
    let mut statistic = |field: &str, statistic: Statistic| {
        asked.push(format!("{statistic}({field})"));
        Ok(Some(2.0))
    };
    script.views().iter().for_each(|view| assert_eq!(view.holds(&mut statistic).unwrap(), view.name() != "strong"));
    // The second condition need not be known where the first one fails.
    assert_eq!(asked, ["max(w)"]);
    let lost = |_: &str, _: Statistic| Err(Error::new(ErrorKind::Field, "there is no w"));
    let strong = &script.views()[2];
    assert_eq!(strong.holds(&mut { lost }).unwrap_err().context(), "there is no w");
    assert!(!strong.holds(&mut |_, _| Ok(None)).unwrap());
    let plain = Script::from(Scene { every: 3, ..strong.scene.clone() });
    let is_due = |step: &i64| plain.scheduled(&stamp(*step), None).count() == 1;
    assert_eq!((0..7).filter(is_due).collect::<Vec<_>>(), [0, 3, 6]);
}

#[test]
fn scenes_change_together_and_count_their_pictures() {
    let mut script = Script::parse(TEXT).unwrap();
    script.scenes_mut().for_each(|scene| scene.width = 7);
    let view = script.views().last().unwrap();
    assert_eq!(view.pictures(), 2);
    assert!(view.shots(&stamp(3)).all(|shot| shot.scene.width == 7));
    assert_eq!(script.model_fields(), ["q", "w"]);
}
