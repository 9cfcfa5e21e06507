//! Arrays of hosts, for tests.

use crate::types::{ICORAY_CENTER, ICORAY_F64, icoray_array};

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
        ..Default::default()
    }
}
