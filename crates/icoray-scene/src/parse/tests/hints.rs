//! Hints of errors for near misses, and their form of long numbers.

use super::assert_says;
use crate::script::Script;
use icoray_grid::ErrorKind;

#[test]
fn near_misses_get_a_hint_at_the_known_word_and_keys_in_the_wrong_table_at_theirs() {
    for (text, words) in [
        ("background = \"none\"", "\"none\" (did you mean \"transparent\"?), expected an opaque CSS colour"),
        ("background = \"Transparent\"", "did you mean \"transparent\"?"),
        ("core = \"off\"", "\"off\" (did you mean \"transparent\"?), expected | or \"transparent\""),
        ("[labels]\ncolor = \"atuo\"", "\"atuo\" (did you mean \"auto\"?), expected | or \"auto\""),
        ("feild = \"q\"", "unknown field `feild` (did you mean `field`?), expected one of `field`, `every`"),
        ("backend = \"gpuu\"", "unknown variant `gpuu` | did you mean `gpu`?"),
        ("[camera]\nlongitude = 3\nalt = 3", "unknown field | `lon`, `lat`"),
        ("[camera]\norbt = 3", "did you mean `orbit`?"),
        ("veiws = 3", "did you mean `views`?"),
        (
            "image = { background = \"white\" }",
            "unknown field `background` | `background` is a key of the scene itself",
        ),
        ("field = \"q\"\nlat = 3", "unknown field `lat` | `lat` is a key of `camera`"),
        ("[transfer]\nmap = \"virdis\"", "\"virdis\" (did you mean \"viridis\"?), expected one of"),
        ("[transfer]\nscale = \"logarithmic\"", "expected \"linear\", \"log\" or \"symlog\""),
        ("[transfer]\nscale = \"lin\"\n[light]\nkind = \"head\"", "\"lin\", expected"),
        ("[light]\nkind = \"headligth\"", "(did you mean \"headlight\"?), expected \"headlight\", "),
    ] {
        assert_says(&Script::parse(text).expect_err(text), words, text);
    }
    for text in ["background = \"mauvish\"", "xyzzy = 3"] {
        let error = Script::parse(text).expect_err(text).to_string();
        assert!(!error.contains("did you mean"), "{error}");
    }
}

#[test]
fn types_are_named_in_words_and_composed_texts_by_their_keys() {
    for (text, expected) in [
        ("transfer = 3", "key transfer: invalid type: integer `3`, expected a table"),
        ("[transfer]\nmap = 3", "key transfer.map: invalid type: integer `3`, expected a string"),
        ("tolerance = \"x\"", "key tolerance: invalid type: string \"x\", expected a number"),
        ("samples = [1]", "key samples: invalid type: list, expected an integer"),
        ("isosurfaces = { value = 1 }", "key isosurfaces: invalid type: table, expected a list"),
        ("[[isosurfaces]]\nvalue = \"x\"", "key isosurfaces.value: invalid type: string \"x\", expected a number"),
        ("[[isosurfaces]]\nvalues = [\"x\"]", "key isosurfaces.values: invalid type: string \"x\", expected a number"),
        ("[camera]\nlat = 91", "key camera.lat: 91, expected a number from -90 to 90"),
    ] {
        assert_eq!(Script::parse_composed(text).expect_err(text).context(), expected);
        let (_, what) = expected.split_once(": ").unwrap();
        assert_says(&Script::parse(text).expect_err(text), &format!("line | {what}"), text);
    }
}

#[test]
fn composed_texts_that_are_no_toml_are_refused() {
    for text in ["# \u{1b}", "field = ", "[camera"] {
        assert_eq!(Script::parse_composed(text).expect_err(text).kind(), ErrorKind::Scene);
    }
}

#[test]
fn long_numbers_are_short_in_messages() {
    for text in [
        "exaggeration = 1e300",
        "tolerance = 1e-300",
        "camera.distance = 1e305",
        "[transfer]\nrange = [1e300, -1e300]",
        "[transfer]\nrange = { percentile = [1e300, 2e300] }",
        "[transfer]\nrange = { union = [1, 2], hysteresis = 1e300 }",
        "[transfer]\nopacity = [[1e300, 0.1], [-1e300, 0.1]]",
        "[transfer]\nopacity = [[0, 1e300]]",
        "[transfer]\ncenter = 1e305",
        "[[clip]]\nlon = [1e300, 2e300]",
        "[[clip]]\nlat = [1e300, 2e300]",
        "[[clip]]\nhalf_space = { towards = [1e300, 0] }",
        "[[surfaces]]\nheight_m = 1e300",
        "[[surfaces]]\nopacity = 1e300",
        "[sweep]\nlat = [1e300]",
        "at_times = [1e300]\n[camera]\nlat = 1e300",
        "device = 1e300",
        "when = \"max(q) > 1e300\"\n[camera]\nlat = 1e300",
    ] {
        let error = Script::parse(text).expect_err(text).to_string();
        assert!(!error.contains("00000000") && error.len() < 400, "{error}");
        assert!(error.contains("e30") || error.contains("e-300"), "{error}");
    }
}
