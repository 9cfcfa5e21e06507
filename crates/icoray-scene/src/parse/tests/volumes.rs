//! Volumes, coloured layers and isosurfaces.

use super::*;
use crate::color::ColorMap;
use crate::scenery::{Isosurface, Level, Opacity, Paint, Surface, Volume};
use crate::transfer::Knot;

const TRANSFER: &str = "map = \"viridis\"\nrange = [250, 400]\nopacity = [[300, 0.0], [350, 0.8]]\n";

#[test]
fn a_list_of_one_volume_is_the_short_form() {
    let short = parsed(&format!("field = \"q\"\n{CAMERA}[transfer]\n{TRANSFER}"));
    let list = format!("{CAMERA}[[volumes]]\nfield = \"q\"\n[volumes.transfer]\n{TRANSFER}");
    assert_eq!(short, parsed(&list));
    assert_eq!((short.field(), &short.scenery), ("q", &Scenery::default()));
    let by = "field = \"w\"\nvalues = [[0, 0.0], [2, 0.5]]\nunit_length = 0.25\n";
    let colors = "map = \"viridis\"\nrange = [250, 400]\n";
    let short = parsed(&format!("field = \"q\"\n{CAMERA}[transfer]\n{colors}[opacity]\n{by}"));
    let list = format!("{CAMERA}[[volumes]]\nfield = \"q\"\n[volumes.transfer]\n{colors}[volumes.opacity]\n{by}");
    assert_eq!(short, parsed(&list));
    let knot = |value: f64, extinction: f64| Knot { value, color: [0.0; 3], extinction };
    let transfer = TransferFunction { knots: vec![knot(0.0, 0.0), knot(2.0, 2f64.ln())], unit_length: Some(0.25) };
    let volume = &short.volumes[0];
    assert_eq!(volume.opacity, Some(Opacity { field: "w".into(), transfer }));
    assert_eq!(short.shown_fields(), ["q", "w"]);
    // All of the map is there, though no opacity of its own says where it is seen.
    let count = ColorMap::named("viridis").unwrap().places().count();
    assert_eq!((volume.transfer.range(), volume.transfer.knots.len()), ([250.0, 400.0], count));
    assert!(volume.transfer.knots.iter().all(|knot| knot.extinction > 0.0));
}

#[test]
fn more_volumes_stand_beside_the_first() {
    let both = parsed(&format!(
        "{CAMERA}[[volumes]]\nfield = \"q\"\n[volumes.transfer]\n{TRANSFER}\
         [[volumes]]\nfield = \"w\"\n[volumes.transfer]\nknots = [{{ value = 1, color = \"red\" }}]\n\
         [volumes.opacity]\nfield = \"v\"\nvalues = [[5, 0.5]]\n\
         [[volumes]]\nfield = \"q\"\n[volumes.transfer]\nknots = [{{ value = 1, color = \"red\", extinction = 2 }}]\n"
    ));
    assert_eq!(both.field(), "q");
    assert!(both.volumes[0].opacity.is_none() && !both.has_one_field_of_volume());
    let [_, Volume { field, transfer, coloring, opacity }, third] = &both.volumes[..] else {
        panic!("{:?}", both.volumes)
    };
    assert_eq!((field.as_str(), transfer.knots[0].color, coloring), ("w", [1.0, 0.0, 0.0], &None));
    assert_eq!(opacity.as_ref().map(|opacity| opacity.field.as_str()), Some("v"));
    assert_eq!((third.field.as_str(), third.transfer.knots[0].extinction), ("q", 2.0));
    assert_eq!(both.shown_fields(), ["q", "w", "v"]);
}

#[test]
fn a_scene_without_a_volume_has_the_layers_of_its_surfaces() {
    let surface = "[[surfaces]]\nlayer = 1\nfield = \"w\"\n[surfaces.transfer]\nrange = [0, 1]\n";
    let isosurface = "[[isosurfaces]]\nfield = \"q\"\nvalue = 1\ncolor = \"red\"\n";
    for (text, field) in [
        (format!("{CAMERA}{isosurface}{surface}"), "w"),
        (format!("{CAMERA}{isosurface}"), "q"),
        (format!("field = \"z\"\n{CAMERA}{isosurface}"), "z"),
        (format!("field = \"z\"\n{CAMERA}[[lines]]\npattern = \"coast\"\n"), "z"),
        (format!("field = \"z\"\n{CAMERA}[ground]\nland = \"green\"\n"), "z"),
    ] {
        let scene = parsed(&text);
        assert_eq!((scene.shown_fields()[0], &scene.volumes), (field, &vec![Volume::clear(field.into())]));
    }
    let scene = parsed(&format!("{CAMERA}{isosurface}[[lines]]\npattern = \"cells\"\non = \"top\"\n"));
    assert_eq!((scene.shown_fields(), scene.scenery.lines[0].on), (vec!["q"], Level::Top));
}

#[test]
fn missing_and_superfluous_keys_are_named() {
    let list = format!("[[volumes]]\nfield = \"q\"\n[volumes.transfer]\n{TRANSFER}");
    let by = "[volumes.opacity]\nfield = \"w\"\nvalues = [[0, 0.0], [2, 0.5]]\n";
    let colors = "[[volumes]]\nfield = \"q\"\n[volumes.transfer]\nmap = \"vik\"\nrange = [0, 1]\n";
    let knots = |more: &str| {
        format!("[[volumes]]\nfield = \"q\"\n[volumes.transfer]\nknots = [{{ value = 1, color = \"red\"{more} }}]\n")
    };
    let top = |line: &str, rest: &str| format!("{line}\n{CAMERA}{rest}");
    // Opacity by another field, with a text replaced by another.
    let changed = |old: &str, new: &str| format!("{CAMERA}{colors}{by}").replacen(old, new, 1);
    let values = "values = [[0, 0.0], [2, 0.5]]\n";
    refused(&[
        (top("field = \"q\"", &list), "line 1 | key field: | not both"),
        (format!("{CAMERA}{list}[transfer]\n{TRANSFER}"), "line 11 | key transfer: | not both"),
        (format!("{CAMERA}{list}{}", by.replace("volumes.", "")), "line 11 | key opacity: | not both"),
        (format!("{CAMERA}{}", list.replace("\"q\"", "\"\"")), "line 6 | key volumes.field: | empty"),
        (format!("{CAMERA}{list}").replace("[250, 400]", "[400, 250]"), "line 9 | key volumes.transfer.range: | 400"),
        (format!("{CAMERA}{list}{by}"), "line 10 | key volumes.transfer.opacity: | another field"),
        (
            format!("{CAMERA}{colors}unit_length = 1\n{by}"),
            "line 10 | key volumes.transfer.unit_length: | another field",
        ),
        (
            format!("{CAMERA}{colors}opacity_in = \"range\"\n{by}"),
            "line 10 | key volumes.transfer.opacity_in: | another field",
        ),
        (
            format!("{CAMERA}{}{by}", knots(", opacity = 0.5")),
            "line 8 | key volumes.transfer.knots.opacity: | another field",
        ),
        (
            format!("{CAMERA}{}{by}", knots(", extinction = 0.5")),
            "line 8 | key volumes.transfer.knots.extinction: | another field",
        ),
        (format!("{CAMERA}{}", knots("")), "line 8 | key volumes.transfer.knots: | either opacity"),
        (changed("[2, 0.5]", "[-2, 0.5]"), "line 12 | key volumes.opacity.values: | -2 after 0 | rise"),
        (changed("[2, 0.5]", "[2, 1.0]"), "line 12 | key volumes.opacity.values: | opacity 1 | below 1"),
        (changed("[2, 0.5]", "[nan, 0.5]"), "line 12 | key volumes.opacity.values: | NaN"),
        (changed("\"w\"", "\"\""), "line 11 | opacity.field: | empty"),
        (changed(values, ""), "line 10 | key volumes.opacity.values: | pairs [value, opacity]"),
    ]);
}

const SMOOTH: &str = "[[surfaces]]\nlayer = 3\nfield = \"w\"\nopacity = 0.5\n[surfaces.transfer]\nmap = \"vik\"\n\
                      range = { percentile = [1, 99] }\ncenter = 0\nscale = \"symlog\"\nthreshold = 0.1\n";

fn surfaces(text: &str) -> Vec<Surface> {
    parsed(&format!("field = \"q\"\n{CAMERA}{text}")).scenery.surfaces
}

fn isosurfaces(text: &str) -> Vec<Isosurface> {
    parsed(&format!("{CAMERA}{text}")).scenery.isosurfaces
}

#[test]
fn surfaces_lie_on_layers_or_at_heights() {
    for (place, at) in [
        ("layer = 0", Level::Layer(0)),
        ("layer = 3", Level::Layer(3)),
        ("layer = \"top\"", Level::Top),
        ("layer = \"bottom\"", Level::Layer(0)),
        ("height_m = -5000", Level::Height(-5000.0)),
    ] {
        let expected = Surface { at, paint: Paint::Plain([1.0, 0.0, 0.0]), opacity: 1.0 };
        assert_eq!(surfaces(&format!("[[surfaces]]\n{place}\ncolor = \"red\"\n")), [expected], "{place}");
    }
}

#[test]
fn surfaces_are_painted_by_fields() {
    let painted = |text: &str| {
        let [Surface { at: Level::Layer(3), paint, opacity }] = &surfaces(text)[..] else { panic!("{text}") };
        let Paint::Field { field, transfer, coloring, by_cell } = paint.clone() else { panic!("{text}") };
        assert_eq!((field.as_str(), *opacity), ("w", 0.5));
        (transfer, coloring, by_cell)
    };
    let (transfer, coloring, by_cell) = painted(SMOOTH);
    let words = "vik, symlog beyond 0.1, centred on 0, percentiles 1 to 99 of the first frame";
    assert_eq!((coloring.unwrap().describe().as_str(), by_cell), (words, false));
    // A stand-in with all of the map's colours.
    assert!(transfer.range() == [-1.0, 1.0] && transfer.knots.len() > 10);
    let cells = SMOOTH.replacen("opacity", "shading = \"cells\"\nopacity", 1);
    assert!(painted(&cells).2 && !painted(&cells.replace("cells", "smooth")).2);
    let (before, _) = SMOOTH.split_once("map").unwrap();
    let knots = "knots = [{ value = 1, color = \"red\" }, { value = 2, color = \"blue\" }]\n";
    let (transfer, coloring, _) = painted(&format!("{before}{knots}"));
    assert_eq!((transfer.at(2.0).0, coloring), ([0.0, 0.0, 1.0], None));
}

#[test]
fn each_value_is_a_surface() {
    let plain = |value: f64, color: [f64; 3]| Isosurface {
        field: "q".into(),
        value,
        paint: Paint::Plain(color),
        opacity: 0.25,
    };
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let with = |keys: &str| isosurfaces(&format!("[[isosurfaces]]\nfield = \"q\"\nopacity = 0.25\n{keys}\n"));
    assert_eq!(with("value = -1\ncolor = \"red\""), [plain(-1.0, red)]);
    assert_eq!(with("values = [3, 2.5]\ncolor = \"red\""), [plain(3.0, red), plain(2.5, red)]);
    let several = with("values = [3, 2.5]\ncolors = [\"red\", \"blue\"]");
    assert_eq!(several, [plain(3.0, red), plain(2.5, blue)]);
    let painted = with("values = [3, 2]\ncolor_by = \"w\"\ntransfer = { range = [0, 1] }");
    let Paint::Field { field, by_cell: false, .. } = &painted[1].paint else { panic!("{painted:?}") };
    assert!(field == "w" && painted[0].paint == painted[1].paint && painted[0].value == 3.0);
    let two = "[[isosurfaces]]\nfield = \"w\"\nvalues = [1, 2]\ncolor = \"red\"\n\
               [[isosurfaces]]\nfield = \"v\"\nvalue = 3\ncolor = \"blue\"\n";
    let found: Vec<_> = isosurfaces(two).into_iter().map(|s| (s.field, s.value, s.opacity)).collect();
    assert_eq!(found, [("w".into(), 1.0, 1.0), ("w".into(), 2.0, 1.0), ("v".into(), 3.0, 1.0)]);
}

#[test]
fn bad_surfaces_are_named() {
    let of = |lines: &str| format!("{CAMERA}[[surfaces]]\n{lines}\n");
    let red = |lines: &str| of(&format!("color = \"red\"\n{lines}"));
    let smooth = |old: &str, new: &str| format!("{CAMERA}{}", SMOOTH.replacen(old, new, 1));
    refused(&[
        (red("layer = 1\nheight_m = 5"), "line 7 | key surfaces.layer: | either layer or height_m"),
        (red("layer = -1"), "line 7 | key surfaces.layer: | -1 | number from 0"),
        (red("layer = \"ground\""), "line 7 | key surfaces.layer: \"ground\" | \"top\", \"bottom\""),
        (red("layer = 1.5"), "line 7"),
        (red("height_m = nan"), "line 7 | key surfaces.height_m: NaN"),
        (red("layer = 1\nopacity = nan"), "line 8 | key surfaces.opacity: NaN"),
        (red("layer = 1\nfield = \"w\""), "line 6 | key surfaces.color: | either color, or field"),
        (red("layer = 1\ntransfer = { range = [0, 1] }"), "line 6 | surfaces.color: | either color"),
        (red("layer = 1\nshading = \"cells\""), "line 8 | key surfaces.shading: | field"),
        (of("layer = 1\ncolor = \"rde\""), "line 7 | key surfaces.color: | rde | CSS"),
        (smooth("\"w\"", "\"\""), "line 7 | key surfaces.field: | empty"),
        (smooth("vik", "vic"), "line 10 | key surfaces.transfer.map: | vic | vik"),
        (
            smooth("center = 0", "opacity = [[0, 0.5]]"),
            "line 12 | key surfaces.transfer.opacity: | colours alone | a surface has",
        ),
        (smooth("center = 0", "unit_length = 1"), "line 12 | surfaces.transfer.unit_length: | a surface"),
    ]);
}

#[test]
fn bad_isosurfaces_are_named() {
    let of = |lines: &str| format!("{CAMERA}[[isosurfaces]]\nfield = \"q\"\n{lines}\n");
    let red = |lines: &str| of(&format!("value = 1\ncolor = \"red\"\n{lines}"));
    let by = |field: &str, range| of(&format!("value = 1\ncolor_by = \"{field}\"\ntransfer = {{ range = {range} }}"));
    refused(&[
        (of("color = \"red\""), "line 5 | key isosurfaces.value: | either value or values"),
        (of("value = 1\nvalues = [1]"), "line 5 | key isosurfaces.value: | either value or values"),
        (of("value = inf\ncolor = \"red\""), "line 7 | key isosurfaces.value: inf | finite"),
        (of("values = [1,\n nan]\ncolor = \"red\""), "line 8 | key isosurfaces.values: NaN | finite"),
        (of("values = [1, 2]\ncolors = [\"red\"]"), "line 8 | key isosurfaces.colors: 1 colours | expected 2"),
        (of("values = [1]\ncolors = [\"re\"]"), "line 8 | key isosurfaces.colors: | re | CSS"),
        (
            of("values = [1]\ncolors = [\"red\"]\ncolor = \"red\""),
            "line 8 | key isosurfaces.colors: | one of color, colors and color_by",
        ),
        (
            red("color_by = \"w\"\ntransfer = { range = [0, 1] }"),
            "line 8 | key isosurfaces.color: | either color, or color_by",
        ),
        (by("", "[0, 1]"), "line 8 | key isosurfaces.color_by: | empty"),
        (by("w", "[1, 0]"), "line 9 | key isosurfaces.transfer.range:"),
        (of("value = 1\ncolor = \"red\"").replace("\"q\"", "\"\""), "line 6 | isosurfaces.field: | empty"),
    ]);
}
