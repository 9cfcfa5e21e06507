//! Control characters of files, paths and scenes reach no terminal.

use crate::made::{Made, Values};
use crate::run::{Folder, has, icoray, scene, texts};
use netcdf::Options;
use std::fs;

/// What a terminal would obey, and what would begin a line of its own.
const HOSTILE: &str = "\u{1b}[31mK\u{7}\nmesh \u{9b}2J";
const ESCAPED: &str = r"\u{1b}[31mK\u{7}\nmesh \u{9b}2J";

#[track_caller]
fn is_printable(text: &str) {
    assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{text:?}");
}

#[test]
fn nothing_that_is_printed_or_written_has_control_characters() {
    let mut made = Made::history();
    made.variable("theta").attributes = ["units", "long_name"].map(|name| (name, HOSTILE.into())).into();
    let Values::Text(dates) = &mut made.variable("xtime").values else { panic!("dates are text") };
    dates[0] = 0x1b;
    let folder = Folder::new();
    let hostile = folder.at("a\u{1b}[31m");
    fs::create_dir(&hostile).unwrap();
    made.write_to(&hostile.join("made.nc"), Options::_64BIT_OFFSET);
    folder.write("scene.toml", scene("theta", 0.0, 42.0));
    let file = "a\u{1b}[31m/made.nc";
    for (words, expected) in [
        (vec!["info", file, "--ranges"], ESCAPED),
        (vec!["plan", file], "picture: theta_"),
        (vec!["render", file, "--scene", "scene.toml", "--time", "0"], ESCAPED),
        (vec!["render", file, "--field", "\u{1b}[2J"], r"\u{1b}[2J"),
        (vec!["info", "b\u{1b}[31m.nc"], r"\u{1b}[31m"),
    ] {
        let output = icoray(folder.path()).args(words).output().unwrap();
        let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
        is_printable(&printed);
        has(&printed, &[expected]);
    }
    let report = folder.text("report.csv");
    is_printable(&report);
    has(&report, &[r"\u{1b}013-10-25"]);
    let texts = texts(&folder.at("theta_000000.png"));
    texts.iter().for_each(|(_, text)| is_printable(text));
    assert!(texts.contains(&("units".into(), ESCAPED.into())), "{texts:?}");
}
