//! Scenes of viewers that take too long or too much memory.

use super::model::Watched;
use super::viewer::Json;
use super::{LIVE, SCENE, drawn};
use icoray_test_support::PATIENCE;
use icoray_tests::native::text;
use std::time::Instant;

/// Isosurfaces as a viewer sets them, so many of them.
fn isosurfaces(count: u32) -> String {
    let all = (0..count).map(|k| format!(r#"{{"value":{},"color":"red","opacity":0.2}}"#, 0.1 * f64::from(k)));
    format!(r#"{{"path":["isosurfaces"],"value":[{}]}}"#, all.collect::<Vec<_>>().join(","))
}

/// A picture of eight isosurfaces among 1.3 million values takes more than a millisecond, however few pixels it has.
#[test]
fn slow_scenes_of_viewers_get_coarser_and_end() {
    let Watched { folder: _kept, to, mut model, viewer } =
        Watched::start("large", &format!("{SCENE}[live]\ntime_budget_ms = 1\n"));
    assert_eq!(viewer.set(&isosurfaces(8)).status, 200);
    model.draw();
    let (facts, shown) = viewer.picture(1);
    assert!(facts["quality"].as_str().is_some_and(|quality| quality.contains("one of 32 x 32 pixels")), "{facts}");
    assert!(shown == drawn(&to, 1) && shown != drawn(&to, 0));
    model.draw();
    let (facts, _) = viewer.picture(2);
    let why = facts["refused"].as_str().unwrap_or_default();
    assert!(why.contains("expected at most 1 ms; the model's own scene is drawn again"), "{facts}");
    assert!(drawn(&to, 2) == drawn(&to, 0), "the model's own scene is drawn, with all of its pixels");
    // Nothing else is drawn until the time is made up for.
    let answer = viewer.set(r#"{"path":["camera","lon"],"value":-70}"#);
    let revision = answer.json()["revision"].as_u64();
    model.draw();
    assert!(drawn(&to, 3) == drawn(&to, 0));
    let start = Instant::now();
    while viewer.picture(u64::from(model.step) - 1).0["revision"].as_u64() != revision {
        assert!(start.elapsed() < PATIENCE, "it is never made up for");
        model.draw();
    }
    let log = model.end();
    assert!(log.contains("step 1: the viewers' scene takes too long: a picture of the fewest pixels took"), "{log}");
}

/// Eight lit volumes and isosurfaces, where the model's own scene shows one without light.
#[test]
fn scenes_beyond_the_memory_budget_are_refused_with_the_bytes() {
    let Watched { folder: _kept, to, mut model, viewer } = Watched::start("large", &format!("{SCENE}{LIVE}"));
    let volumes = [r#"{"field":"f"}"#; 8].join(",");
    let changes = format!(
        r#"{{"path":["field"]}},{{"path":["transfer"]}},{{"path":["volumes"],"value":[{volumes}]}},{},
           {{"path":["light"],"value":{{"kind":"headlight"}}}}"#,
        isosurfaces(8)
    );
    let answer = viewer.set(&changes);
    assert_eq!(answer.status, 200, "{}", text(&answer.body));
    model.draw();
    let (facts, _) = viewer.picture(1);
    let why = facts["refused"].as_str().unwrap_or_default();
    assert!(why.contains("bytes of memory, expected at most") && why.contains("4 times"), "{facts}");
    assert!(drawn(&to, 1) == drawn(&to, 0));
    model.end();
}
