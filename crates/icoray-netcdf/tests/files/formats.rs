//! Files of every format are read as the datasets in memory that they were written from.

use crate::made::{Made, Values, value};
use crate::made_icon::Angles;
use crate::memory;
use crate::written::formats;
use icoray_dataset::Dataset;

/// All that is read of a dataset, in words.
fn contents(file: &Dataset) -> Vec<String> {
    let grid = file.mesh().grid().unwrap();
    let mut all = vec![format!("{:?}", (file.sphere_radius_m(), file.times(), file.seconds(), file.fields()))];
    for info in file.fields() {
        let name = &info.name;
        all.push(format!("{:?}", file.layer_heights(name).ok()));
        for time in 0..file.times().len() {
            all.push(format!("{:?}", file.read_field(name, time).unwrap()));
            all.push(format!("{:?}", file.read_layers(name, time, info.layers / 2..info.layers).unwrap()));
            all.push(format!("{:?}", file.native_heights(&grid, name, time).ok()));
        }
    }
    all
}

/// A history with attributes of every type, a packed field, a scalar, and times as integers.
fn with_attributes() -> Made {
    let mut made = Made::history();
    made.variable("rho").attributes = vec![
        ("_FillValue", (value(0, 0, 1) as f32).into()),
        ("missing_value", value(0, 0, 2).into()),
        ("valid_range", Values::F32(vec![1.0, 30.0])),
    ];
    made.i32s("levels")[..2].copy_from_slice(&[-32767, 9]);
    made.variable("levels").attributes = vec![
        ("scale_factor", 0.5.into()),
        ("add_offset", 270.0.into()),
        ("_FillValue", (-32767).into()),
        ("valid_range", Values::I32(vec![0, 8])),
        ("units", "  K ".into()),
    ];
    // Real ends are of unpacked values.
    let mut other = made.variable("levels").clone();
    other.name = "other_levels";
    other.attributes[3].1 = Values::F64(vec![273.0, 274.0]);
    made.variables.push(other);
    made.add("crs", &[], Values::I32(vec![0])).attributes = vec![("cf_role", "none".into())];
    made.remove("xtime");
    made.add("Time", &["Time"], Values::I32(vec![0, 59, 365]));
    made.last().attributes = vec![("units", "days since 2000-01-01".into()), ("calendar", "noleap".into())];
    made
}

#[test]
fn every_format_gives_the_same_grid_and_fields() {
    let thickness = ["Time", "nCells", "nVertLevels"];
    for made in [
        Made::mesh(false),
        Made::history(),
        with_attributes(),
        Made::ocean().with_thickness("layerThickness", &thickness),
        Made::icon_grid(),
        Made::icon_data(Angles::Radians),
        Made::icon_data(Angles::Degrees),
        Made::icon_data(Angles::Degrees32),
        Made::dynamico(Angles::Degrees),
    ] {
        let expected = memory::open(&made);
        for (format, options) in formats() {
            let (_folder, path) = made.write(options);
            let file = icoray_netcdf::open(&path).unwrap();
            assert!(file.mesh().is_same(expected.mesh()), "{format}");
            for (found, expected) in contents(&file).iter().zip(contents(&expected)) {
                assert_eq!(*found, expected, "{format}");
            }
        }
    }
}
