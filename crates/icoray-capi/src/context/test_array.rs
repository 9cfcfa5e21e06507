//! Arrays of hosts, for tests.

use crate::types::{ICORAY_CENTER, ICORAY_F64, icoray_array};
use std::ptr;

/// Values at cell centres, level-fastest.
pub fn centers(values: &[f64], layers: usize) -> icoray_array {
    icoray_array {
        struct_size: size_of::<icoray_array>(),
        data: values.as_ptr().cast(),
        r#type: ICORAY_F64,
        location: ICORAY_CENTER,
        columns: (values.len() / layers) as i64,
        layers: layers as i64,
        column_stride: layers as i64,
        layer_stride: 1,
        block: 0,
        block_stride: 0,
        has_fill: 0,
        fill_value: 0.0,
        grid_name: ptr::null(),
        layers_name: ptr::null(),
    }
}
