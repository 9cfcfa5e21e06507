//! Eight-bit sRGB.

/// sRGB's transfer curve (IEC 61966-2-1): linear light in [0, 1] to a byte.
pub(crate) fn srgb_byte(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}
