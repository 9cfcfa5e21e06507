//! Volumes: one in short, several in a list, opacity by another field, and none at all.

use super::*;
use crate::color::ColorMap;
use crate::scenery::{Level, Opacity, Volume};
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
