// Mirrors kernel/sample.rs: values were normalised, in f64, when they were uploaded, and missing ones marked.
#import pages
#import kernel/real

// Where the values over `cell` begin, for `samples_get`.
fn samples_base(cell: u32) -> Base {
    return pages_base(cell);
}

fn samples_bases(cells: vec3u) -> array<Base, 3> {
    return array(samples_base(cells.x), samples_base(cells.y), samples_base(cells.z));
}

fn samples_get(base: Base, layer: u32) -> f32 {
    return pages_get(base, layer);
}
