//! Native heights, and fields on different layers.

use crate::files::folder;
use crate::made::{HEIGHT_M, LAYERS, Made, RECORDS, Values};
use crate::run::{Folder, difference, has, says, scene, shows_something};
use std::ops::Range;

/// The same scene with native heights.
pub fn native(scene: &str) -> String {
    format!("heights = \"native\"\n{scene}")
}

/// Two volumes of the made fields, of which the first is `first`.
pub fn two(first: &str, second: &str) -> String {
    let volume = |field: &str, map: &str| {
        format!(
            "[[volumes]]\nfield = \"{field}\"\n[volumes.transfer]\nmap = \"{map}\"\nrange = [0, 42]\n\
             opacity = [[0, 0.0], [42, 0.8]]\n"
        )
    };
    let plain = scene("theta", 0.0, 42.0);
    let (_, view) = plain.split_once('\n').unwrap();
    let (view, _) = view.split_once("[transfer]").unwrap();
    format!("{view}{}{}", volume(first, "viridis"), volume(second, "magma"))
}

/// Heights that rise from column to column.
pub fn hills() -> Made {
    let mut made = Made::history();
    made.f32s("zgrid").iter_mut().enumerate().for_each(|(i, z)| *z += 100.0 * (i / (LAYERS + 1) % 7) as f32);
    made
}

#[test]
fn native_heights_are_read_where_a_view_asks_for_them() {
    let views = "[[views]]\nname = \"mean\"\n[[views]]\nname = \"own\"\nheights = \"native\"\nat_steps = [1]\n";
    let steep = scene("theta", 1000.0, 1042.0).replace("exaggeration = 50", "exaggeration = 400");
    let folder = folder(&hills(), &(steep + views));
    let text = folder.render("--time all -o out --size 48x48");
    let line = "heights   zgrid of each column\n";
    let own = "view      own\n";
    has(&text, &[&format!("{own}{line}")]);
    assert_eq!(text.matches(line).count(), 1, "{text}");
    let at = |name: &str| folder.at("out").join(name);
    says(&at("own_theta_000001.png"), &[("heights", "zgrid of each column")]);
    let apart = difference(&at("own_theta_000001.png"), &at("mean_theta_000001.png"));
    assert!(apart.mean > 0.4, "{apart:?}");
    // Each view by its own plan.
    let plan = folder.prints("plan made.nc --scene scene.toml");
    let (of_mean, of_own) = plan.split_once("view own:\n").unwrap();
    let bytes = 42 * (LAYERS + 1) * 4;
    has(of_mean, &["left out: native heights\n"]);
    has(of_own, &[&format!("read: zgrid of each column ({bytes} bytes once)\n")]);
    assert!(!of_mean.contains("zgrid") && !of_own.contains("native heights"), "{plan}");
}

/// Heights that change are those of each time: as where they are the only ones. Their means do not change.
#[test]
fn heights_that_change_are_read_at_each_time() {
    let ocean = |records: &[usize]| {
        let mut made = Made::history();
        made.variables.retain(|v| v.name != "zgrid");
        let thickness =
            records.iter().flat_map(|t| (0..42 * LAYERS).map(move |i| 200.0 + 150.0 * ((i / LAYERS + t) % 6) as f32));
        made.add("layerThickness", &["Time", "nCells", "nVertLevels"], Values::F32(thickness.collect()));
        made.add("bottomDepth", &["nCells"], Values::F64(vec![2000.0; 42]));
        made
    };
    assert_eq!(RECORDS, 3);
    let flat = scene("theta", 2000.0, 2042.0).replace("exaggeration = 50", "exaggeration = 400");
    let series = folder(&ocean(&[0, 1, 2]), &native(&flat));
    series.render("--time all -o . --size 32x32");
    let same = folder(&ocean(&[2, 2, 2]), &native(&flat));
    same.render("--time 2 -o . --size 32x32");
    let first = folder(&ocean(&[0, 0, 0]), &native(&flat));
    first.render("--time 2 -o . --size 32x32");
    let max = |other: &Folder| difference(&series.at("theta_000002.png"), &other.at("theta_000002.png")).max;
    assert_eq!(max(&same), 0, "heights are those of the time");
    assert!(max(&first) > 0, "they change");
    let read =
        "read: layerThickness of each column added up from the sea floor (bottomDepth), those of each time (672 bytes";
    has(&series.prints("plan made.nc --scene scene.toml"), &[read]);
}

#[test]
fn missing_heights_are_an_error_before_the_first_ray() {
    let mut made = Made::history();
    made.variables.retain(|v| v.name != "zgrid");
    made.add("refBottomDepth", &["nVertLevels"], Values::F64(vec![10.0, 20.0, 30.0, 40.0]));
    let folder = folder(&made, &native(&scene("theta", 0.0, 42.0)));
    for command in ["render", "plan"] {
        let looked_for = "looked for zgrid(nCells, nVertLevelsP1), refBottomDepth(nVertLevels), and layerThickness";
        let parts = ["made.nc: theta has no native heights", looked_for];
        folder.fails(&format!("{command} made.nc --scene scene.toml"), 1, &parts);
    }
    assert!(!folder.at("theta_000000.png").exists());
}

/// theta lies between the interfaces on which w lies.
#[test]
fn fields_on_different_layers_are_drawn_at_native_heights() {
    let folder = folder(&hills(), &native(&two("w", "theta")));
    let text = folder.render("--time 0 --layers 1..4 -o out.png --size 48x48");
    has(&text, &["w at cells, 3 layers", "theta at cells, 2 layers", "heights   zgrid of each column\n"]);
    shows_something(&folder.at("out.png"), 48, 48);
    let parts = ["layers: 1..3 are layers of w", "theta has 1 between them, expected at least 2"];
    folder.render_fails("--layers 1..3", 1, &parts);
}

/// Whichever field comes first gives its layers, and ranges of these are those of the same heights: fields of one volume
/// each are those that a person would have moved by hand, over all layers and over some.
#[test]
fn fields_are_moved_between_levels_and_interfaces() {
    let middle = |level: usize| 0.5 * (HEIGHT_M[level] + HEIGHT_M[level + 1]);
    let wave = |column: usize| 5.0 * (column % 7) as f64;
    let theta = |column: usize, level: usize| wave(column) + 9.0 * level as f64;
    let w = |column: usize, height: f64| wave(column + 3) + 0.003 * height;
    // theta at interfaces, of which the levels around are `levels`: beyond these there is nothing to interpolate.
    let between = |column: usize, interface: usize, levels: Range<usize>| {
        if interface <= levels.start {
            return theta(column, levels.start);
        }
        if interface >= levels.end {
            return theta(column, levels.end - 1);
        }
        let [low, high] = [middle(interface - 1), middle(interface)];
        let part = (HEIGHT_M[interface] - low) / (high - low);
        (1.0 - part) * theta(column, interface - 1) + part * theta(column, interface)
    };
    for (first, second, layers, levels, counts) in [
        ("theta", "w", "0..", 0..LAYERS, [4, 5]),
        ("theta", "w", "1..3", 1..3, [2, 3]),
        ("w", "theta", "0..", 0..LAYERS, [5, 4]),
        ("w", "theta", "1..4", 1..3, [3, 2]),
    ] {
        let mut made = Made::history();
        let fill = |layers: usize, value: &dyn Fn(usize, usize) -> f64| {
            let each = (0..RECORDS * 42 * layers).map(|i| value(i / layers % 42, i % layers));
            Values::F64(each.collect())
        };
        made.variable("theta").values = fill(LAYERS, &theta);
        made.variable("w").values = fill(LAYERS + 1, &|column, i| w(column, HEIGHT_M[i]));
        made.add("w_moved", &["Time", "nCells", "nVertLevels"], fill(LAYERS, &|column, l| w(column, middle(l))));
        let moved = fill(LAYERS + 1, &|column, i| between(column, i, levels.clone()));
        made.add("theta_moved", &["Time", "nCells", "nVertLevelsP1"], moved);
        let folder = folder(&made, &two(first, second));
        folder.write("by_hand.toml", two(first, &format!("{second}_moved")));
        let text = folder.render(&format!("--layers {layers} -o out.png"));
        let drawn = [(first, counts[0]), (second, counts[1])].map(|(name, n)| format!("{name} at cells, {n} layers"));
        let note = format!("{second} lies on other layers than {first}: interpolated to these in height");
        has(&text, &[&drawn[0], &drawn[1], &note]);
        let text = folder.prints(&format!("made.nc --scene by_hand.toml -o by_hand.png --layers {layers}"));
        assert!(!text.contains("interpolated"), "{text}");
        let apart = difference(&folder.at("out.png"), &folder.at("by_hand.png"));
        assert!(apart.max <= 1 && apart.mean < 0.0075, "{first} {second} {layers}: {apart:?}");
        shows_something(&folder.at("out.png"), 96, 96);
    }
}
