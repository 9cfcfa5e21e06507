// Mirrors kernel/signature.rs.

struct BoundarySignature {
    order: u32,
    nearness: f32,
}

const BOUNDARY_CORE: u32 = 1u;
const BOUNDARY_CUT_FACE: u32 = 2u;

// The surface layer `k`, and the bits of the materials that are painted there.
fn boundary_surface_layer(k: u32, materials: u32) -> u32 {
    return (k * 0x00200203u) ^ (materials << 2u);
}

const SIGNATURE_HASH: u32 = 0xFFFFFFu;
const SIGNATURE_BASE: u32 = 0x9E3779u;

// Adds the next boundary, by its number, at `distance` from the eye.
fn signature_push(signature: BoundarySignature, boundary: u32, distance: f32) -> BoundarySignature {
    var number = boundary * 0x85EBCA6Bu;
    number = ((number ^ (number >> 13u)) * 0xC2B2AE35u) >> 8u;
    let hash = (signature.order * SIGNATURE_BASE + number) & SIGNATURE_HASH;
    let count = min((signature.order >> 24u) + 1u, 255u);
    return BoundarySignature((count << 24u) | hash, signature.nearness + 1.0 / distance);
}
