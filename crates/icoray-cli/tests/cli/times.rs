//! Some of a file's times, and some of its layers.

use crate::files::folder;
use crate::made::Made;
use crate::run::{has, pictures, says, scene};

#[test]
fn times_are_chosen_by_number_date_and_range() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 2042.0));
    for (time, expected) in [
        ("2013-10-26T00", &["000001"][..]),
        ("2013-10", &["000000", "000001", "000002"]),
        ("-2..", &["000001", "000002"]),
        ("2013-10-25..2013-10-27", &["000000", "000001"]),
    ] {
        let to = format!("pictures_{time}/");
        let text = folder.render(&format!("--time={time} -o {to} --size 16x16"));
        assert_eq!(text.matches("picture ").count(), expected.len(), "{time}: {text}");
        let names = expected.iter().map(|number| format!("theta_{number}.png")).collect::<Vec<_>>();
        assert_eq!(pictures(&folder.at(&to)), names, "{time}");
    }
    // One time may have a name of its own.
    folder.render("--time 2013-10-27 -o one.png --size 16x16");
    says(&folder.at("one.png"), &[("step", "2"), ("date", "2013-10-27_00:00:00")]);
}

#[test]
fn requested_layers_are_read_and_drawn() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    let parts = ["field     theta at cells, 2 layers, time 0", "range     0.125 to 41.25 K"];
    has(&folder.render("--time 0 --layers 1..3 -o some.png"), &parts);
    let all = folder.render("--time 0 --layers 0.. -o all.exr");
    has(&all, &["4 layers", "range     0 to 41.375 K"]);
    folder.render("--time 0 -o plain.exr");
    assert!(folder.bytes("all.exr") == folder.bytes("plain.exr"), "all layers are all layers");
}
