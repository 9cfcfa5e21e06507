//! Only the requested data are read.

use crate::made::{LAYERS, Made, RECORDS, Values, value};
use crate::memory::{expect, open};
use icoray::ErrorKind;

#[test]
fn some_layers_are_those_of_all() {
    let file = open(&Made::history());
    for (name, columns) in [("theta", 42), ("w", 42), ("vorticity", 80)] {
        let owned = file.read_layers(name, 2, 1..3).unwrap();
        let field = owned.field().unwrap();
        assert_eq!((field.shape().layers, owned.values().len()), (2, 2 * columns));
        for (column, layer) in [(0, 0), (5, 1), (columns - 1, 1)] {
            assert_eq!(field.value(column, layer), value(2, column, layer + 1), "{name}");
        }
    }
    for layers in [0..LAYERS + 1, 2..2, LAYERS..LAYERS + 1] {
        let error = file.read_layers("theta", 0, layers).unwrap_err();
        expect(&error, ErrorKind::Field, &["theta: layers ", "expected some of 0..4"]);
    }
}

#[test]
fn layers_of_an_ocean_have_its_floor() {
    let file = open(&Made::ocean());
    for (name, from) in [("theta", 1), ("w", 2)] {
        let (all, some) = (file.read_field(name, 0).unwrap(), file.read_layers(name, 0, from..4).unwrap());
        let (all, some) = (all.field().unwrap(), some.field().unwrap());
        for (cell, layer) in (0..42).flat_map(|c| (0..4 - from).map(move |l| (c, l))) {
            let pair = [all.value(cell, layer + from), some.value(cell, layer)];
            assert_eq!(pair[0].to_bits(), pair[1].to_bits(), "{name} {cell} {layer}");
        }
    }
}

#[test]
fn dates_are_those_of_the_file() {
    let dates = |made: &Made| open(made).times().to_vec();
    let mut made = Made::history();
    made.remove("xtime");
    assert_eq!(dates(&made), vec![None; RECORDS]);
    // A mean over a month says when it began.
    let text = |day: usize| format!("{:<64}", format!("0001-{day:02}-01_00:00:00")).into_bytes();
    let begins: Vec<u8> = (1..=RECORDS).flat_map(text).collect();
    made.add("xtime_startMonthly", &["Time", "StrLen"], Values::Text(begins));
    assert_eq!(dates(&made)[2].as_deref(), Some("0001-03-01_00:00:00"));
    made.remove("xtime_startMonthly");
    made.add("Time", &["Time"], Values::I32(vec![0, 59, 365]));
    made.last().attributes = vec![("units", "days since 2000-01-01".into()), ("calendar", "noleap".into())];
    let expected = ["2000-01-01_00:00:00", "2000-03-01_00:00:00", "2001-01-01_00:00:00"];
    assert_eq!(dates(&made), expected.map(|date| Some(date.to_owned())));
    made.last().attributes = vec![("units", "months since 2000-01-01".into())];
    assert_eq!(dates(&made), vec![None; RECORDS]);
}
