//! Cells along a space-filling curve, and rows of tables.

use icoray_reference::shading::direction;

/// Morton code of a direction in the cube around the sphere, with 16 bits per axis.
pub(crate) fn morton(lon_rad: f64, lat_rad: f64) -> u64 {
    let at = direction(lon_rad, lat_rad).to_array().map(|x| ((x + 1.0) * 32767.5) as u64);
    let bits = (0..48).map(|bit| (at[bit % 3] >> (bit / 3) & 1) << bit);
    bits.sum()
}

/// The entries of rows of `width`.
pub(crate) fn rows<'a, V: Copy>(table: &'a [V], width: usize, kept: &'a [usize]) -> impl Iterator<Item = V> + 'a {
    kept.iter().flat_map(move |&row| table[row * width..(row + 1) * width].iter().copied())
}
