//! Some of a file's times, and some of its layers.

use crate::files::{folder, render};
use crate::made::Made;
use crate::run::{has, says, scene};
use std::fs;

/// The numbers of the pictures in a folder.
fn pictures(folder: &std::path::Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut numbers: Vec<String> =
        names.filter_map(|n| Some(n.strip_prefix("theta_")?.strip_suffix(".png")?.to_owned())).collect();
    numbers.sort();
    numbers
}

#[test]
fn times_are_chosen_by_number_date_and_range() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 2042.0));
    for (time, expected) in [
        ("2013-10-26T00", &["000001"][..]),
        ("2013-10", &["000000", "000001", "000002"]),
        ("1..3", &["000001", "000002"]),
        ("-2..", &["000001", "000002"]),
        ("2013-10-25..2013-10-27", &["000000", "000001"]),
    ] {
        let to = format!("pictures {time}/");
        let text = render(folder.path(), &[&format!("--time={time}"), "-o", &to, "--size", "16x16"]);
        assert_eq!(text.matches("picture ").count(), expected.len(), "{time}: {text}");
        assert_eq!(pictures(&folder.path().join(&to)), expected, "{time}");
    }
    // One time may have a name of its own.
    render(folder.path(), &["--time", "2013-10-27", "-o", "one.png", "--size", "16x16"]);
    says(&folder.path().join("one.png"), &[("step", "2"), ("date", "2013-10-27_00:00:00")]);
}

#[test]
fn layers_are_read_and_drawn_as_asked_for() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    let text = render(folder.path(), &["--time", "0", "--layers", "1..3", "-o", "some.png"]);
    has(&text, &["field     theta at cells, 2 layers, time 0", "range     0.125 to 41.25 K"]);
    let all = render(folder.path(), &["--time", "0", "--layers", "0..", "-o", "all.exr"]);
    has(&all, &["4 layers", "range     0 to 41.375 K"]);
    render(folder.path(), &["--time", "0", "-o", "plain.exr"]);
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("all.exr") == bytes("plain.exr"), "all layers are all layers");
}
