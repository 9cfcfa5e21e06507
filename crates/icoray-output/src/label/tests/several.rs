//! Labels of scenes that show several fields.

use super::*;
use icoray_scene::Opacity;
use std::collections::BTreeMap;

/// A surface and an isosurface, each with colours of its own.
const PAINTED: &str = "[[surfaces]]\nlayer = \"top\"\nfield = \"w\"\ntransfer = { map = \"plasma\", range = [-2, 2] }\n\
    [[isosurfaces]]\nfield = \"pv\"\nvalue = 2\ncolor_by = \"zeta\"\n\
    transfer = { map = \"turbo\", range = [1e-6, 1e-3], scale = \"log\" }\n";

/// Isosurfaces with distinguishable colours.
const PLAIN: &str = "[[isosurfaces]]\nfield = \"pv\"\nvalues = [2, 1e-4]\ncolors = [\"red\", \"blue\"]\n\
    [[isosurfaces]]\nfield = \"w\"\nvalue = -0.5\ncolor = \"lime\"\n";

/// The picture of a scene with labels and more things to show, their fields described.
fn drawn(width: u32, height: u32, labels: &str, more: &str) -> Canvas {
    picture(&scene(width, height, 8.0, &format!("{labels}\n{more}")))
}

fn picture(scene: &Scene) -> Canvas {
    labelled(&described_frame(scene))
}

/// The scene with its opacity determined by field `w`.
fn by_w(mut scene: Scene) -> Scene {
    scene.volumes[0].opacity = Some(Opacity { field: "w".into(), transfer: scene.volumes[0].transfer.clone() });
    scene
}

fn described_frame(scene: &Scene) -> Frame {
    let mut frame = frame(scene);
    frame.descriptions.extend([
        described("w", "vertical velocity", "m s-1"),
        described("zeta", "relative vorticity", "s-1"),
        described("pv", "potential vorticity", "K m2 kg-1 s-1"),
    ]);
    frame
}

/// [`spans`] that are longer than one.
fn long_spans(is: impl Iterator<Item = bool>) -> Vec<[i64; 2]> {
    spans(is).into_iter().filter(|[from, to]| to > from).collect()
}

/// Rows, or columns, in which something is coloured.
fn colored(canvas: &Canvas, are_rows: bool) -> Vec<[i64; 2]> {
    let [width, height] = [canvas.width, canvas.height].map(i64::from);
    let [along, across] = if are_rows { [height, width] } else { [width, height] };
    let at = |i: i64, j: i64| if are_rows { pixel(canvas, j, i) } else { pixel(canvas, i, j) };
    long_spans((0..along).map(|i| (0..across).any(|j| is_colored(at(i, j)))))
}

#[test]
fn several_bars_stand_one_after_the_other() {
    for (width, height) in [(512, 512), (1024, 768), (3840, 2160)] {
        let em = f64::from(width.min(height)) / 36.0;
        for (place, are_rows) in [("right", true), ("left", true), ("bottom", false)] {
            let canvas = drawn(width, height, &format!("place = \"{place}\""), PAINTED);
            let bars = colored(&canvas, are_rows);
            let lengths: Vec<f64> = bars.iter().map(|[from, to]| (to - from) as f64 / em).collect();
            assert!(bars.len() == 3 && lengths.iter().all(|length| *length > 6.0), "{place} {width}: {lengths:?}");
            // Between them there is room for the labels of their ends.
            assert!(bars.windows(2).all(|pair| (pair[1][0] - pair[0][1]) as f64 > 1.2 * em), "{place}: {bars:?}");
            // All of them are of one breadth, on one line.
            assert_eq!(colored(&canvas, !are_rows).len(), 1, "{place} {width}");
            // A title as it is of one bar, and notes: in corners of their own.
            assert!(count(&canvas, [0.0, 0.4], [0.0, 0.08], is_ink) > 50, "{place} {width}: no title");
        }
    }
}

#[test]
fn several_bars_leave_room_for_the_title() {
    for place in ["left", "right"] {
        let labels = format!("place = \"{place}\"\ntitle = \"a wave\\n{{time}}\\na third line\"");
        let canvas = drawn(512, 512, &labels, PAINTED);
        // A margin and three lines of 1.15 em.
        let title = (4.4 * 512.0 / 36.0) as i64;
        let inked = long_spans((0..title).map(|y| (60..100).any(|x| is_ink(pixel(&canvas, x, y)))));
        assert!(inked.len() > 1 && colored(&canvas, true)[0][0] > title, "{place}: {inked:?}");
    }
}

#[test]
fn bars_below_are_side_by_side_where_there_is_room() {
    let wide = drawn(1600, 512, "place = \"below\"", PAINTED);
    assert_eq!((colored(&wide, true).len(), colored(&wide, false).len()), (1, 3));
    let narrow = drawn(512, 512, "place = \"below\"", PAINTED);
    assert_eq!((colored(&narrow, true).len(), colored(&narrow, false).len()), (3, 1));
    assert!(colored(&narrow, true)[0][0] > 512 && narrow.height < 800, "{}", narrow.height);
    assert_eq!(narrow.rgba.len(), 4 * 512 * narrow.height as usize);
}

#[test]
fn bars_that_do_not_fit_are_not_drawn_and_small_pictures_are_drawn_all_the_same() {
    let one = |name: &str| {
        format!("[[surfaces]]\nlayer = 0\nfield = \"{name}\"\ntransfer = {{ map = \"plasma\", range = [0, 1] }}\n")
    };
    let many: String = (0..20).map(|i| one(&format!("f{i}"))).collect();
    let bars = colored(&drawn(512, 512, "place = \"left\"", &many), true);
    assert!((4..8).contains(&bars.len()), "{bars:?}");
    for (width, height) in [(1, 1), (3, 200), (200, 3), (40, 40)] {
        for place in ["auto", "right", "left", "bottom", "below"] {
            for more in ["", &format!("{many}{PLAIN}")] {
                let labels = format!("place = \"{place}\"\ntitle = \"{{name}} {{step}}\"\n{more}");
                let canvas = picture(&scene(width, height, 3.0, &labels));
                assert_eq!(canvas.rgba.len(), 4 * (canvas.width * canvas.height) as usize);
            }
        }
    }
}

/// The fields, and the fields of opacities, of a scene's bars.
fn bars(scene: &Scene) -> Vec<(String, Option<String>)> {
    let bars = bar::Bar::all(scene);
    bars.iter().map(|bar| (bar.field.to_owned(), bar.opacity_by.map(str::to_owned))).collect()
}

#[test]
fn there_is_a_bar_for_all_that_values_colour() {
    let of = |names: &[&str]| names.iter().map(|name| ((*name).to_owned(), None)).collect::<Vec<_>>();
    let bars_of = |more: &str| bars(&scene(64, 64, 8.0, more));
    assert_eq!(bars_of(PAINTED), of(&["theta", "w", "zeta"]));
    assert_eq!(bars_of(PLAIN), of(&["theta"]));
    assert_eq!(bars_of(&format!("{PAINTED}{PAINTED}")), of(&["theta", "w", "zeta"]));
    // Isosurfaces by knots have one for all their values.
    let knots = "{ knots = [{ value = 0, color = \"red\" }, { value = 1, color = \"blue\" }] }";
    let values = "[[isosurfaces]]\nfield = \"pv\"\nvalues = [1, 2, 3]\ncolor_by = \"w\"\ntransfer = ";
    assert_eq!(bars_of(&format!("{values}{knots}")), of(&["theta", "w"]));
    // The legend has the colours that isosurfaces have of their own field.
    let values = "[[isosurfaces]]\nfield = \"w\"\nvalues = [0, 1]\ntransfer = ";
    let own = scene(64, 64, 8.0, &format!("{values}{knots}"));
    assert_eq!(bars(&own), of(&["theta"]));
    let keys = words::keys(&described_frame(&own), &Legend::of(&own, &[1.0]).unwrap());
    let colors: Vec<_> = keys[0].values.iter().map(|(_, color)| *color).collect();
    assert_eq!(colors, [Some([1.0, 0.0, 0.0]), Some([0.0, 0.0, 1.0])]);
    // A surface in the volume's colours needs no bar of its own; one in others does.
    let like = |map: &str| {
        let transfer = format!("{{ map = \"{map}\", range = [0, 10] }}");
        format!("[[surfaces]]\nlayer = 0\nfield = \"theta\"\ntransfer = {transfer}\n")
    };
    assert_eq!(bars_of(&like("viridis")), of(&["theta"]));
    assert_eq!(bars_of(&like("plasma")), of(&["theta", "theta"]));
    let by = bars(&by_w(scene(64, 64, 8.0, "")));
    assert_eq!(by, [("theta".into(), Some("w".into()))]);
}

#[test]
fn captions_are_of_the_bars_own_fields() {
    let scene = scene(64, 64, 8.0, &format!("name = \"first\"\nunits = \"1\"\n{PAINTED}"));
    let frame = described_frame(&scene);
    let legend = frame.legend.as_ref().unwrap();
    let captions: Vec<_> = bar::Bar::all(&scene).iter().map(|bar| words::caption(&frame, legend, bar, 0)).collect();
    assert_eq!(captions, [["first"], ["vertical velocity (m s⁻¹)"], ["relative vorticity (s⁻¹)"]]);
    let unknown = Frame { descriptions: BTreeMap::new(), ..frame.clone() };
    assert_eq!(words::caption(&unknown, legend, &bar::Bar::all(&scene)[1], 0), ["w"]);
    let by = by_w(super::scene(64, 64, 8.0, ""));
    let frame = described_frame(&by);
    let caption = words::caption(&frame, frame.legend.as_ref().unwrap(), &bar::Bar::all(&by)[0], -3);
    assert_eq!(caption, ["temperature (10⁻³ K)", "opacity by vertical velocity"]);
}

#[test]
fn opacity_is_shown_in_a_volumes_own_bar_only() {
    // Colours of a lying bar's first column, from the far side to the ticks.
    let column = |scene: &Scene| {
        let canvas = picture(scene);
        let [left, _, top, bottom] = outline(&canvas);
        (top + 1..bottom).map(|y| pixel(&canvas, left + 1, y)).collect::<Vec<_>>()
    };
    let alike = |column: &[[u8; 3]]| column.iter().all(|color| *color == column[0]);
    let own = scene(512, 512, 8.0, "place = \"bottom\"");
    assert!(!alike(&column(&own)));
    assert!(alike(&column(&by_w(own))));
}

#[test]
fn isosurfaces_are_named_with_their_colours() {
    let scene = scene(64, 64, 8.0, &format!("{PLAIN}{PAINTED}"));
    let frame = described_frame(&scene);
    let keys = words::keys(&frame, frame.legend.as_ref().unwrap());
    let [pv, w] = &keys[..] else { panic!("{}", keys.len()) };
    let value = |text: &str, color| (text.to_owned(), color);
    let (red, blue, lime) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    assert_eq!((pv.name.as_str(), w.name.as_str()), ("potential vorticity", "vertical velocity"));
    // The last one is painted by another field, and has a bar for that.
    assert_eq!(pv.values, [value("2", Some(red)), value("10⁻⁴", Some(blue)), value("2 K m² kg⁻¹ s⁻¹", None)]);
    assert_eq!(w.values, [value("−0.5 m s⁻¹", Some(lime))]);
    for (width, height) in [(512, 512), (3840, 2160)] {
        let canvas = drawn(width, height, "place = \"right\"\nerror = false\nscale = false", PLAIN);
        let em = f64::from(width.min(height)) / 36.0;
        for color in [[255, 0, 0], [0, 0, 255], [0, 255, 0]] {
            let inside = count(&canvas, [0.0, 0.5], [0.85, 1.0], |pixel| pixel == color) as f64;
            assert!((0.15..0.45).contains(&(inside / em / em)), "{color:?}: {inside}");
        }
        let below = drawn(width, height, "place = \"below\"", PLAIN);
        assert!(count(&below, [0.0, 1.0], [0.8, 1.0], |pixel| pixel == [255, 0, 0]) > 0);
    }
}

#[test]
fn without_bars_there_are_no_keys_either() {
    let off = "title = \"\"\nscale = false\nerror = false\nbar = false";
    for place in ["auto", "left"] {
        let canvas = drawn(512, 512, &format!("place = \"{place}\"\n{off}"), &format!("{PLAIN}{PAINTED}"));
        assert_eq!(count(&canvas, [0.0, 1.0], [0.0, 1.0], |pixel| pixel != [0; 3]), 0);
    }
}
