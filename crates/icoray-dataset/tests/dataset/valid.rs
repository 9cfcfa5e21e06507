//! Values that attributes declare invalid.

use crate::made::{Made, Values};
use crate::memory::open;

type Attributes = Vec<(&'static str, Values)>;

/// The range and the number of missing values of `rho`, which holds 0.1, 1, 2, ... 167, with attributes.
fn rho(attributes: Attributes) -> ([f64; 2], u64) {
    let mut made = Made::history();
    let rho = made.variable("rho");
    let Values::F32(values) = &mut rho.values else { panic!("rho is f32") };
    values.iter_mut().enumerate().for_each(|(i, value)| *value = if i == 0 { 0.1 } else { i as f32 });
    rho.attributes = attributes;
    let owned = open(&made).read_field("rho", 0).unwrap();
    let (range, missing) = owned.field().unwrap().range();
    (range.unwrap(), missing)
}

#[test]
fn values_outside_the_valid_range_are_missing() {
    let range = |ends: [f32; 2]| ("valid_range", Values::F32(ends.to_vec()));
    assert_eq!(rho(vec![range([10.0, 100.0])]), ([10.0, 100.0], 168 - 91));
    assert_eq!(rho(vec![("valid_min", 5.0f32.into())]), ([5.0, 167.0], 5));
    assert_eq!(rho(vec![("valid_max", 20i32.into())]), ([f64::from(0.1f32), 20.0], 147));
    // Both, of which CF wants one: the narrower counts.
    assert_eq!(rho(vec![range([10.0, 100.0]), ("valid_max", 50.0f32.into())]), ([10.0, 50.0], 168 - 41));
    // 0.1 in double precision is below 0.1 in single, and above what it is rounded to.
    assert_eq!(rho(vec![("valid_min", 0.1f64.into())]), ([f64::from(0.1f32), 167.0], 0));
}

#[test]
fn ends_are_of_packed_values_unless_they_are_real() {
    let packed = |valid: Attributes| {
        let mut made = Made::history();
        let levels = made.variable("levels");
        levels.values = Values::I32((0..168).collect());
        levels.attributes = vec![("scale_factor", 0.5f64.into()), ("add_offset", 100.0f64.into())];
        levels.attributes.extend(valid);
        let owned = open(&made).read_field("levels", 0).unwrap();
        let (range, missing) = owned.field().unwrap().range();
        (range.unwrap(), missing)
    };
    assert_eq!(packed(Vec::new()), ([100.0, 183.5], 0));
    let stored = Values::I32(vec![10, 19]);
    assert_eq!(packed(vec![("valid_range", stored)]), ([105.0, 109.5], 158));
    assert_eq!(packed(vec![("valid_max", 19i32.into())]), ([100.0, 109.5], 148));
    let unpacked = Values::F64(vec![105.0, 109.5]);
    assert_eq!(packed(vec![("valid_range", unpacked)]), ([105.0, 109.5], 158));
}
