//! Lines, the ground and what is cut away.

use super::*;
use crate::scenery::{Clip, HalfSpace, Level, Lines, LonLatBox, Pattern};

fn shown(text: &str) -> Scenery {
    parsed(&format!("field = \"q\"\n{CAMERA}{text}\n")).scenery
}

#[test]
fn lines_show_a_pattern_somewhere() {
    let lines = |keys: &str| {
        let scenery = shown(&format!("[[lines]]\n{keys}"));
        assert_eq!(scenery.lines.len(), 1);
        scenery.lines[0].clone()
    };
    let graticule = |spacing_deg: f64| Pattern::Graticule { spacing_deg };
    let (pattern, on) = (graticule(30.0), Level::Ground);
    let plain = Lines { pattern, on, color: [1.0; 3], width_px: 1.0, opacity: 1.0, region: None };
    for (keys, pattern) in [
        ("", graticule(30.0)),
        ("pattern = \"graticule\"\nspacing = 7.5", graticule(7.5)),
        ("pattern = \"cells\"", Pattern::Cells),
        ("pattern = \"triangles\"", Pattern::Triangles),
        ("pattern = \"coast\"", Pattern::Coast),
        ("pattern = \"borders\"", Pattern::Borders),
    ] {
        assert_eq!(lines(keys), Lines { pattern, ..plain.clone() }, "{keys}");
    }
    for (keys, on) in [
        ("on = \"ground\"", Level::Ground),
        ("on = \"top\"", Level::Top),
        ("on = \"bottom\"", Level::Layer(0)),
        ("on = 7", Level::Layer(7)),
        ("height_m = 1e4", Level::Height(1e4)),
    ] {
        assert_eq!(lines(keys), Lines { on, ..plain.clone() }, "{keys}");
    }
    let region = LonLatBox { lon_deg: [-10.0, 40.0], lat_deg: [30.0, 60.0] };
    let all = lines("color = \"red\"\nwidth = 0.1\nopacity = 0.75\nregion = { lon = [-10, 40], lat = [30, 60] }");
    let (color, region) = ([1.0, 0.0, 0.0], Some(region));
    assert_eq!(all, Lines { color, width_px: 0.1, opacity: 0.75, region, ..plain });
}

#[test]
fn outlines_are_those_of_a_file() {
    let path = std::env::temp_dir().join(format!("icoray-scene-{}.geojson", std::process::id()));
    let of = |coordinates: &str| {
        std::fs::write(&path, format!("{{\"type\": \"LineString\", \"coordinates\": {coordinates}}}")).unwrap();
        format!("field = \"q\"\n{CAMERA}[[lines]]\nfile = {path:?}\nwidth = 2\n")
    };
    let lines = parsed(&of("[[1, 2], [3, 4]]")).scenery.lines;
    let Pattern::Outlines(outlines) = &lines[0].pattern else { panic!("{lines:?}") };
    assert_eq!((outlines.runs(), lines[0].width_px), (&[vec![[1.0, 2.0], [3.0, 4.0]]][..], 2.0));
    let good = of("[[1, 2], [3, 4]]");
    refused(&[
        (format!("{good}pattern = \"coast\""), "line 9 | key lines.pattern: | either pattern or file"),
        (format!("{good}spacing = 3"), "line 9 | key lines.spacing: | graticule"),
    ]);
    refused(&[(of("[[1, 2], [3, 95]]"), "line 7 | key lines.file: | feature 0, coordinate 1: [3.0, 95.0]")]);
    std::fs::remove_file(&path).unwrap();
    refused(&[(
        format!("field = \"q\"\n{CAMERA}[[lines]]\nfile = {path:?}"),
        "line 7 | key lines.file: | No such file",
    )]);
}

#[test]
fn boxes_go_east_from_west() {
    let lon = |ends: &str| {
        shown(&format!("[[lines]]\npattern = \"coast\"\nregion = {{ lon = {ends} }}")).lines[0].region.unwrap()
    };
    for (ends, lon_deg) in [
        ("[-10, 40]", [-10.0, 40.0]),
        ("[170, 190]", [170.0, 190.0]),
        ("[170, -170]", [170.0, 190.0]),
        ("[0, 360]", [0.0, 360.0]),
        ("[180, -180]", [180.0, 540.0]),
        ("[700, -300]", [700.0, 780.0]),
        ("[-350, 10]", [-350.0, 10.0]),
    ] {
        assert_eq!(lon(ends), LonLatBox { lon_deg, lat_deg: [-90.0, 90.0] }, "{ends}");
    }
    let lat = shown("[[lines]]\npattern = \"coast\"\nregion = { lat = [-90, 5] }").lines[0].region.unwrap();
    assert_eq!(lat, LonLatBox { lon_deg: [-180.0, 180.0], lat_deg: [-90.0, 5.0] });
}

#[test]
fn the_ground_has_land_and_sea() {
    let ground = |keys: &str| shown(&format!("[ground]\n{keys}")).ground;
    assert_eq!(ground("land = \"red\"").land, Some([1.0, 0.0, 0.0]));
    assert_eq!(ground("land = \"red\"").ocean, None);
    let both = ground("land = \"red\"\nocean = \"blue\"");
    assert_eq!((both.land, both.ocean), (Some([1.0, 0.0, 0.0]), Some([0.0, 0.0, 1.0])));
}

#[test]
fn clips_hold_where_all_their_conditions_do() {
    let clip = |keys: &str| {
        let clips = shown(&format!("[[lines]]\npattern = \"coast\"\n[[clip]]\n{keys}")).clips;
        assert_eq!(clips.len(), 1);
        clips[0].clone()
    };
    let none = Clip { cuts_inside: true, region: None, layers: None, height_m: None, half_space: None };
    let region = Some(LonLatBox { lon_deg: [350.0, 370.0], lat_deg: [-90.0, 90.0] });
    assert_eq!(clip("cut = \"inside\"\nlon = [350, 10]"), Clip { region, ..none.clone() });
    let region = Some(LonLatBox { lon_deg: [-180.0, 180.0], lat_deg: [0.0, 90.0] });
    let outside = Clip { cuts_inside: false, region, ..none.clone() };
    assert_eq!(clip("cut = \"outside\"\nlat = [0, 90]"), outside);
    let region = Some(LonLatBox { lon_deg: [0.0, 90.0], lat_deg: [10.0, 20.0] });
    let half_space = Some(HalfSpace { towards_deg: [30.0, -60.0], distance: -0.5 });
    let all = "cut = \"inside\"\nlon = [0, 90]\nlat = [10, 20]\nlayers = [2, 5]\nheight_m = [-10, 1e4]\n\
               half_space = { towards = [30, -60], distance = -0.5 }";
    let (layers, height_m) = (Some([2, 5]), Some([-10.0, 1e4]));
    assert_eq!(clip(all), Clip { region, layers, height_m, half_space, ..none.clone() });
    let half_space = Some(HalfSpace { towards_deg: [30.0, 0.0], distance: 0.0 });
    assert_eq!(clip("cut = \"inside\"\nhalf_space = { towards = [30, 0] }"), Clip { half_space, ..none.clone() });
    assert_eq!(clip("cut = \"inside\"\nlayers = [3, 3]"), Clip { layers: Some([3, 3]), ..none });
}

#[test]
fn bad_lines_are_named() {
    let of = |keys: &str| format!("field = \"q\"\n{CAMERA}[[lines]]\n{keys}\n");
    let coast = |keys: &str| of(&format!("pattern = \"coast\"\n{keys}"));
    let hollow = |keys: &str| format!("core = \"transparent\"\n{}", coast(keys));
    refused(&[
        (coast("on = \"sea\""), "line 8 | key lines.on: \"sea\" | \"ground\", \"top\", \"bottom\""),
        (coast("on = -2"), "line 8 | key lines.on: -2"),
        (coast("on = 2\nheight_m = 3"), "line 8 | key lines.on: | either on or height_m"),
        (coast("color = \"transparent\""), "line 8 | key lines.color: | opaque"),
        (coast("spacing = 10"), "line 8 | key lines.spacing: | graticule"),
        (coast("region = {}"), "line 8 | key lines.region: | lon, lat or both"),
        (coast("region = { lon = [5, 5] }"), "line 8 | key lines.region.lon: [5, 5] | western"),
        (coast("region = { lon = [-180, 181] }"), "line 8 | key lines.region.lon: [-180, 181] | 360"),
        (coast("region = { lon = [0, inf] }"), "line 8 | key lines.region.lon: [0, inf]"),
        (coast("region = { lat = [9, 3] }"), "line 8 | key lines.region.lat: [9, 3] | southern"),
        (coast("region = { lat = [nan, 3] }"), "line 8 | key lines.region.lat: [NaN, 3]"),
        (hollow(""), "line 7 | key lines.on: | opaque core"),
        (hollow("on = \"ground\""), "line 9 | key lines.on: | opaque core"),
    ]);
    assert!(Scene::parse(&hollow("on = \"bottom\"")).is_ok());
}

#[test]
fn bad_ground_and_clips_are_named() {
    let ground = |keys: &str| format!("field = \"q\"\n{CAMERA}[ground]\n{keys}\n");
    let clip = |keys: &str| format!("field = \"q\"\n{CAMERA}[ground]\nland = \"red\"\n[[clip]]\n{keys}\n");
    let inside = |keys: &str| clip(&format!("cut = \"inside\"\n{keys}"));
    refused(&[
        (ground("land = \"gras\""), "line 7 | key ground.land: | gras"),
        (ground("ocean = 3"), "line 7 | ocean"),
        (format!("core = \"transparent\"\n{}", ground("land = \"red\"")), "line 7 | key ground: | opaque core"),
        (inside(""), "line 8 | key clip: | half_space"),
        (inside("lon = [5, 5]"), "line 10 | key clip.lon:"),
        (inside("lat = [5, 95]"), "line 10 | key clip.lat: [5, 95]"),
        (inside("layers = [3, 2]"), "line 10 | key clip.layers: [3, 2] | lower first"),
        (inside("layers = [-1, 2]"), "line 10 | key clip.layers: [-1, 2] | from 0"),
        (inside("height_m = [5, 5]"), "line 10 | key clip.height_m: [5, 5] | lower first"),
        (inside("height_m = [5, inf]"), "line 10 | key clip.height_m: [5, inf] | finite"),
        (
            inside("half_space = { towards = [400, 0] }"),
            "line 10 | key clip.half_space.towards: [400, 0] | -360 to 360",
        ),
        (inside("half_space = { towards = [0, nan] }"), "line 10 | clip.half_space.towards: [0, NaN]"),
        (inside("half_space = { distance = 0 }"), "line 10 | towards"),
        (inside("half_space = { towards = [0, 0], distance = nan }"), "line 10 | key clip.half_space.distance: NaN"),
    ]);
}
