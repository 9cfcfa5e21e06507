//! Fields made of others.

use super::*;
use crate::scenery::{Derivation, How};

const SHOWN: &str = "[transfer]\nrange = [0, 1]\nopacity = [[0, 0.5]]\n";

fn derived(text: &str) -> Scene {
    parsed(&format!("field = \"a\"\n{CAMERA}{SHOWN}{text}\n"))
}

#[test]
fn fields_are_made_of_others() {
    let how = |keys: &str| {
        let derived = derived(&format!("[[derive]]\nname = \"a\"\n{keys}")).scenery.derived;
        let [Derivation { name, how }] = &derived[..] else { panic!("{derived:?}") };
        assert_eq!(name, "a");
        how.clone()
    };
    let name = |name: &str| name.to_owned();
    assert_eq!(how("magnitude = [\"u\", \"v\"]"), How::Magnitude(vec![name("u"), name("v")]));
    // In the file's order, not in the alphabet's.
    let terms = vec![(1.0, name("w")), (-2.5, name("u")), (1e-3, name("v"))];
    assert_eq!(how("sum = { w = 1, u = -2.5, v = 1e-3 }"), How::Combination(terms));
    let zonal = |band_deg: f64| How::FromZonalMean { field: name("t"), band_deg };
    assert_eq!(how("anomaly = \"t\"\nfrom = \"zonal mean\""), zonal(2.0));
    assert_eq!(how("anomaly = \"t\"\nfrom = \"zonal mean\"\nband = 0.5"), zonal(0.5));
    assert_eq!(how("anomaly = \"t\"\nfrom = \"first\""), How::FromFirst(name("t")));
}

#[test]
fn derived_fields_may_be_made_of_those_above() {
    let scene = derived(
        "[[derive]]\nname = \"speed\"\nmagnitude = [\"u\", \"v\"]\n\
         [[derive]]\nname = \"a\"\nanomaly = \"speed\"\nfrom = \"first\"\n\
         [[derive]]\nname = \"unused\"\nsum = { q = 1 }",
    );
    assert_eq!(scene.shown_fields(), ["a"]);
    assert_eq!(scene.model_fields(), ["u", "v"]);
    // The model's own field where the derived one of that name comes later.
    let mut turned = scene.clone();
    turned.scenery.derived.swap(0, 1);
    assert_eq!(turned.model_fields(), ["speed"]);
}

#[test]
fn bad_derivations_are_named() {
    let of = |keys: &str| format!("field = \"a\"\n{CAMERA}{SHOWN}[[derive]]\n{keys}\n");
    let a = |keys: &str| of(&format!("name = \"a\"\n{keys}"));
    refused(&[
        (of("magnitude = [\"u\", \"v\"]"), "line 9 | name"),
        (of("name = \"\"\nsum = { u = 1 }"), "line 10 | key derive.name: | empty"),
        (a(""), "line 9 | key derive.name: | magnitude, sum and anomaly"),
        (a("magnitude = [\"u\", \"v\"]\nsum = { u = 1 }"), "line 9 | one of magnitude, sum"),
        (a("magnitude = [\"u\", \"\"]"), "line 11 | key derive.magnitude: | empty"),
        (a("sum = {}"), "line 11 | key derive.sum: no fields"),
        (a("sum = { u = nan }"), "line 11 | key derive.sum: NaN | finite"),
        (a("sum = { \"\" = 1 }"), "line 11 | key derive.sum: | empty"),
        (a("sum = { u = 1 }\nband = 2"), "line 12 | key derive.band: | anomaly"),
        (a("magnitude = [\"u\", \"v\"]\nfrom = \"first\""), "line 12 | key derive.from: | anomaly"),
        (a("anomaly = \"t\""), "line 11 | key derive.anomaly: | zonal mean"),
        (a("anomaly = \"\"\nfrom = \"first\""), "line 11 | key derive.anomaly: | empty"),
        (a("anomaly = \"t\"\nfrom = \"first\"\nband = 2"), "line 13 | key derive.band: | zonal mean"),
        (a("sum = { a = 2 }"), "line 10 | key derive.name: \"a\" | what it is made of"),
        (
            a("sum = { u = 2 }\n[[derive]]\nname = \"a\"\nsum = { u = 3 }"),
            "line 13 | key derive.name: \"a\" | derived above already",
        ),
        (
            a("sum = { b = 2 }\n[[derive]]\nname = \"b\"\nsum = { u = 3 }"),
            "line 10 | key derive.name: \"a\" | \"b\" | derived below",
        ),
    ]);
}
