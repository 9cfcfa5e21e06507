// Mirrors kernel/general/surfaces.rs.
#import params
#import scenery
#import kernel/column
#import kernel/shade
#import kernel/transfer

// A colour, if it exists, and its rounding error.
struct SurfaceColor {
    color: vec3f,
    off: f32,
    is_there: bool,
}

// The colour of a value in these spans; `reach` is the rounding error of the value.
fn spans_color(first: u32, count: u32, value: f32, reach: f32) -> SurfaceColor {
    var k = first;
    let last = first + count - 1u;
    while k < last && spans[k + 1u].low <= value {
        k++;
    }
    let color = max(span_color(spans[k], value), vec3f(0.0));
    return SurfaceColor(color, reach * spans[k].steepest, !is_missing(value));
}

// The colour at which a ray crosses a layer, at the fraction `tau` of a column.
fn material_on_layer(material: Material, column: Column, layer: u32, tau: f32) -> SurfaceColor {
    if material.kind == MATERIAL_PLAIN {
        return SurfaceColor(material.color, 0.0, true);
    }
    let values = vec3f(
        surface_values[material.first_value + column.cells.x],
        surface_values[material.first_value + column.cells.y],
        surface_values[material.first_value + column.cells.z],
    );
    var value: f32;
    var reach: f32;
    if material.kind == MATERIAL_CELLS {
        value = values[column_nearest(column, tau)];
        reach = ROUNDING * abs(value);
    } else {
#concentric         let chord = chord_over(values, column.entry.weight, column.exit.weight);
#native         let weights = native_weights(column, layer, tau);
#native         let chord = chord_over(values, weights, weights);
        value = select(chord_at(chord, tau), ENDLESS, chord.is_void);
        let size = abs(values);
        reach = 4.0 * ROUNDING * (size.x + size.y + size.z);
    }
    return spans_color(material.first_span, material.span_count, value, reach);
}

// The vertex whose direction is nearest to that of a place: its Voronoi cell contains the place.
fn column_nearest(column: Column, tau: f32) -> u32 {
    let weight = column.entry.weight + tau * (column.exit.weight - column.entry.weight);
    let a = grid_direction(column.cells.x);
    let b = grid_direction(column.cells.y);
    let c = grid_direction(column.cells.z);
    // Differences, which keep the digits of f32: the place from the first vertex, and the vertices from each other.
    let to_b = wide3_add(b, wide3_neg(a)).hi;
    let to_c = wide3_add(c, wide3_neg(a)).hi;
    let at = weight.x * to_b + weight.y * to_c;
    // 2 at·v = at² + 1 - |at - v|², all vectors of length 1: the nearest of the three to a place in their plane.
    let far = vec3f(dot(at, at), dot(at - to_b, at - to_b), dot(at - to_c, at - to_c));
    var nearest = 0u;
    if far.y <= far.x {
        nearest = 1u;
    }
    if far.z <= min(far.x, far.y) {
        nearest = 2u;
    }
    return nearest;
}

// The factor that lighting gives to the colour of a surface with this normal; a headlight lights the visible side.
fn surface_body(s: RayShading, normal: vec3f) -> f32 {
    if lighting.is_headlight != 0u {
        return s.ambient + s.diffuse * abs(dot(normal, s.light));
    }
    return ray_shading_solid(s, normal);
}
