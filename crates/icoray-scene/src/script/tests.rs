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
        let shots = script.due(&stamp(step), before.as_ref(), &mut statistic).unwrap();
        all.push(shots.iter().map(|shot| shot.name.as_str()).collect::<Vec<_>>().join(" "));
        before = Some(stamp(step));
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
    script.due(&stamp(1), Some(&stamp(0)), &mut statistic).unwrap();
    // The second condition need not be known where the first one fails.
    assert_eq!(asked, ["max(w)"]);
    let lost = |_: &str, _: Statistic| Err(Error::new(ErrorKind::Field, "there is no w"));
    let error = script.due(&stamp(1), None, &mut { lost }).unwrap_err();
    assert_eq!(error.context(), "there is no w");
    let none = script.due(&stamp(1), Some(&stamp(0)), &mut |_, _| Ok(None)).unwrap();
    assert_eq!(none, []);
    assert!(script.may_be_due(1));
    let plain = Script::from(Scene { every: 3, ..script.views()[0].scene.clone() });
    assert_eq!((0..7).filter(|step| plain.may_be_due(*step)).collect::<Vec<_>>(), [0, 3, 6]);
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
