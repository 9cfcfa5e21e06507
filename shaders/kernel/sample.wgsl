// Mirrors kernel/sample.rs: values were normalised, in f64, and missing ones marked, when they were uploaded.
#import pages
#import kernel/real

// Offset of the values over `cell`, for `samples_get`.
fn samples_base(cell: u32) -> Base {
    return pages_base(cell);
}

fn samples_bases(cells: vec3u) -> array<Base, 3> {
    return array(samples_base(cells.x), samples_base(cells.y), samples_base(cells.z));
}

fn samples_get(base: Base, layer: u32) -> f32 {
    return pages_get(base, layer);
}
