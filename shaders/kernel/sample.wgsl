// Mirrors kernel/sample.rs: values were normalised, in f64, when they were uploaded, and missing ones marked.
#import params
#import kernel/real

@group(0) @binding(10) var<storage, read> field: array<f32>;

fn samples_get(cell: u32, layer: u32) -> f32 {
    return field[cell * params.column_stride + layer * params.layer_stride];
}
