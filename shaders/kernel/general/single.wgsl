// The only volume of a scene, which kernel/ray.wgsl integrates. kernel/general/several.wgsl has the same functions.
#import params
#import kernel/lit
#import kernel/ray
#import kernel/general/isosurfaces

// Whether a frustum without values of the volume's field shows nothing.
fn volumes_skip(is_void: bool) -> bool {
    return is_void && scenery.isosurface_count + scenery.sphere_count == 0u;
}

// Enters a frustum that is not cut away as a whole; returns true if it has no volume.
fn volumes_enter(column: Column, way: GapWay, own: FieldSegment) -> bool {
    return !own.is_there;
}

// Whether the volume may be visible between two layers.
fn volumes_are_visible(column: Column, bases: array<Base, 3>, gap: u32, own: FieldSegment) -> bool {
    if !own.is_there {
        return false;
    }
    let range = samples_range(bases, gap);
    if range.x == range.y {
        let span = spans[spans_search(range.x)];
        return span.is_clear == 0u && span_extinction(span, range.x) != 0.0;
    }
    for (var k = 0u; k < params.spans; k++) {
        if spans[k].is_clear == 0u && spans[k].high > range.x && spans[k].low < range.y {
            return true;
        }
    }
    return false;
}

// Extinction at a place of the frustum.
fn volumes_extinction(own: FieldSegment, u: f32) -> f32 {
    if !own.is_there {
        return 0.0;
    }
    let f = segment_place(own.segment, u).y;
    return span_extinction(spans[spans_search(f)], f);
}

// Integrates the volume over a part of the frustum; returns true if the ray ends.
fn volumes_light(ray: ptr<function, Ray>, light: ptr<function, Radiance>, own: FieldSegment, part: FrustumPart) -> bool {
    if !own.is_there {
        return false;
    }
    var shown = own.segment;
    var course = own.interpolant;
    if part.from_ > 0.0 || part.to < 1.0 {
        shown = segment_part(shown, segment_place(shown, part.from_), segment_place(shown, part.to));
        if IS_LIT {
            course = frustum_interpolant_part(course, part.from_, part.to);
        }
    }
    return frustum(ray, light, shown, course);
}

// The gradient along a part of a frustum.
fn frustum_interpolant_part(whole: FrustumInterpolant, from_: f32, to: f32) -> FrustumInterpolant {
    let r0 = 1.0 + whole.eps * from_;
    let r1 = 1.0 + whole.eps * to;
    let du = to - from_;
    return FrustumInterpolant(
        frustum_interpolant_gradient(whole, from_),
        frustum_interpolant_gradient(whole, to),
        whole.kappa * (du * du * (1.0 + whole.eps) / (r0 * r0 * r1)),
        whole.eps * du / r0,
        whole.size,
    );
}
