//! The compute shaders of [icoray](https://docs.rs/icoray) in WGSL, as `icoray-gpu` composes them.
//!
//! `kernel/X.wgsl` mirrors `X.rs` of the crate `icoray-kernel` function by function. The shaders are not WGSL as they
//! stand: `icoray_gpu::shader` resolves their lines `#import`, `#each`, `#scene` and `#volume`.
#![forbid(unsafe_code)]

macro_rules! sources {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!($name, ".wgsl")))),*]
    };
}

/// All shaders: name (path without its ending) and text.
pub const SOURCES: [(&str, &str); 37] = sources! {
    "gradient" "gradients" "grid" "kernel/column" "kernel/general/blend" "kernel/general/clips" "kernel/general/frustum"
    "kernel/general/isosurfaces" "kernel/general/maps" "kernel/general/native" "kernel/general/several"
    "kernel/general/single" "kernel/general/surfaces" "kernel/lit" "kernel/piece" "kernel/plane" "kernel/ray" "kernel/ray/concentric"
    "kernel/ray/fragment"
    "kernel/real" "kernel/roundoff" "kernel/sample" "kernel/segment" "kernel/shade" "kernel/signature" "kernel/transfer"
    "kernel/turn" "kernel/walk" "kernel/wide" "measure/multiply" "measure/stream" "pages" "params" "parts" "picture"
    "pieces" "scenery"
};
