//! The processor's vector instructions, as far as rays are compiled for them.

use fearless_simd::Level;

/// AVX2 (processors since 2013), AVX-512 or NEON, if the processor has them. Other processors trace rays one at a time.
#[inline(always)] // so that a `dispatch!` of the result has no code for other instructions
pub fn packets() -> Option<Level> {
    match Level::new() {
        #[cfg(target_arch = "x86_64")]
        level @ (Level::Avx512(_) | Level::Avx2(_)) => Some(level),
        #[cfg(target_arch = "aarch64")]
        level @ Level::Neon(_) => Some(level),
        _ => None,
    }
}
