//! HEALPix without coordinates: the centres of pixels from their numbers.
//!
//! Ring i from the north pole, and place j in it from 0, have z = 1 - i²/(3 n²) in the polar cap, z = 4/3 - 2 i/(3 n)
//! in the belt, and φ = π/2 (j + s/2)/r, where n is the number of pixels along a side of the 12 base pixels, r = min(i,
//! n) the length of a quarter of the ring, and s is 1 in the cap and (i - n + 1) mod 2 in the belt. The south mirrors
//! this. Equations 2 to 13 of K. M. Górski et al., 2005, HEALPix, ApJ 622, 759,
//! [doi:10.1086/427976](https://doi.org/10.1086/427976). Format: CF conventions 1.13, appendix F; older attributes
//! `healpix_nside` and `healpix_order`.

use super::columns::of_points;
use super::tables::{Mesh, Positions};
use crate::source::{Source, SourceVariable, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, OwnedReals, Result, memory};
use std::f64::consts::FRAC_PI_2;

/// Largest refinement level of which numbers of pixels are exact in double precision.
const MAX_LEVEL: f64 = 24.0;
/// Largest number of pixels of which triangles can be numbered.
const MAX_PIXELS: u64 = i32::MAX as u64 / 6;

/// The variable that describes the pixels in any of the files.
pub(super) fn find(sources: &Sources) -> Option<SourceVariable<'_>> {
    let is_healpix =
        |found: &SourceVariable| found.text("grid_mapping_name").ok().flatten().is_some_and(|name| name == "healpix");
    sources.all().flat_map(|source| source.each_variable()).find(is_healpix)
}

pub(super) fn read(sources: &Sources, mapping: SourceVariable) -> Result<Mesh> {
    let number = |name: &str| mapping.numbers(name).map(|numbers| numbers.first().copied());
    let bad = |what: String| mapping.error(ErrorKind::Grid, format_args!("{}: {what}", mapping.name()));
    let scheme = mapping.text("indexing_scheme")?.or(mapping.text("healpix_order")?).unwrap_or_default();
    let (is_nested, place): (bool, fn(u64, u64) -> Place) = match scheme.to_ascii_lowercase().as_str() {
        "nest" | "nested" => (true, Place::of_nested),
        "ring" => (false, Place::of_ring),
        _ => return Err(bad(format!("indexing_scheme or healpix_order {scheme:?}, expected nested or ring"))),
    };
    let side = number("refinement_level")?.map(f64::exp2).or(number("healpix_nside")?);
    let is_side = |side: &f64| side.fract() == 0.0 && (1.0..=MAX_LEVEL.exp2()).contains(side);
    let side = side.filter(is_side).map(|side| side as u64).filter(|side| !is_nested || side.is_power_of_two());
    let side = side.ok_or_else(|| {
        bad(format!("expected refinement_level from 0 to {MAX_LEVEL}, or healpix_nside, if nested a power of two"))
    })?;
    let pixels = 12 * side * side;
    let numbers = match sources.all().find_map(numbers_of_pixels) {
        Some(numbers) => numbers.all_numbers()?,
        None if sources.fields().variables().iter().flat_map(|v| &v.dimensions).any(|d| d.len as u64 == pixels) => {
            if pixels > MAX_PIXELS {
                return Err(bad(format!("{pixels} pixels of the whole sphere, expected at most {MAX_PIXELS}")));
            }
            memory::require("places of pixels", 24 * pixels, None)?;
            (0..pixels).map(|pixel| pixel as f64).collect()
        }
        None => {
            let what =
                format!("no dimension has its {pixels} pixels, and no variable cell the numbers of some of them");
            return Err(bad(what));
        }
    };
    let is_pixel = |number: &f64| number.fract() == 0.0 && (0.0..pixels as f64).contains(number);
    if let Some(i) = numbers.iter().position(|number| !is_pixel(number)) {
        return Err(bad(format!("pixel {} of column {i}, expected 0 to {}", numbers[i], pixels - 1)));
    }
    let angle = |k: usize| numbers.iter().map(|number| place(side, *number as u64).angles()[k]).collect();
    let [lon, lat] = [0, 1].map(|k| OwnedReals::F64(angle(k)));
    of_points(mapping.source.path(), Positions { lon, lat }, mapping.name())
}

/// The variable with the numbers of pixels, if the source has one.
fn numbers_of_pixels(source: &dyn Source) -> Option<SourceVariable<'_>> {
    let is_index =
        |found: &SourceVariable| found.text("standard_name").ok().flatten().as_deref() == Some("healpix_index");
    let is_column = |v: &Variable| v.kind.is_number() && v.after_time().len() == 1;
    let mut columns = source.each_variable().filter(|found| is_column(found.variable));
    columns.find(|found| found.own_name() == "cell" || is_index(found))
}

/// The place of a pixel's centre.
struct Place {
    side: u64,
    /// From 1 at the north pole.
    ring: u64,
    /// j + s/2.
    along: f64,
}

impl Place {
    /// Of a pixel that is numbered along rings.
    fn of_ring(side: u64, pixel: u64) -> Self {
        let (cap, pixels) = (2 * side * (side - 1), 12 * side * side);
        // Ring and place in a cap, of which i - 1 rings have 2 i (i - 1) pixels.
        let in_cap = |pixel: u64| {
            let ring = (1 + 2 * pixel).isqrt().div_ceil(2);
            (ring, pixel - 2 * ring * (ring - 1))
        };
        let (ring, place) = match pixel {
            north if north < cap => in_cap(north),
            belt if belt < pixels - cap => (side + (belt - cap) / (4 * side), (belt - cap) % (4 * side)),
            south => {
                let (ring, from_end) = in_cap(pixels - 1 - south);
                (4 * side - ring, 4 * ring - 1 - from_end)
            }
        };
        let is_shifted = !(side..=3 * side).contains(&ring) || (ring + side).is_multiple_of(2);
        Place { side, ring, along: place as f64 + if is_shifted { 0.5 } else { 0.0 } }
    }

    /// Of a pixel that is numbered within each base pixel along a curve.
    fn of_nested(side: u64, pixel: u64) -> Self {
        let (base, within) = (pixel / (side * side), pixel % (side * side));
        let every_other = |bits: u64| (0..32).fold(0, |number, k| number | (bits >> (2 * k) & 1) << k);
        let (x, y) = (every_other(within), every_other(within >> 1));
        let ring = (base / 4 + 2) * side - x - y - 1;
        // The middle of the base pixel, counted in eighths of a turn.
        let eighth = 2 * (base % 4) + u64::from(base / 4 != 1);
        let length = ring.min(4 * side - ring).min(side);
        Place { side, ring, along: 0.5 * ((eighth * length) as f64 + x as f64 - y as f64) }
    }

    /// Longitude and latitude, radians.
    fn angles(&self) -> [f64; 2] {
        let Place { side, ring, along } = *self;
        let [n, i, r] = [side, ring, ring.min(4 * side - ring).min(side)].map(|number| number as f64);
        let in_cap = (1.0 - r * r / (3.0 * n * n)).copysign(2.0 * n - i);
        let z = if r < n { in_cap } else { 4.0 / 3.0 - 2.0 * i / (3.0 * n) };
        [FRAC_PI_2 * along / r, z.asin()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Degrees of longitude and latitude, as healpy 1.20.1 has them.
    #[test]
    fn centres_are_where_healpy_has_them() {
        for (is_nested, side, pixel, expected) in [
            (false, 1, 11, [315.0, -41.810314896]),
            (false, 2, 0, [45.0, 66.443535691]),
            (false, 8, 100, [212.142857143, 48.141207794]),
            (false, 8, 400, [0.0, -4.780191847]),
            (false, 64, 49000, [285.0, -83.417689086]),
            (false, 1024, 9000000, [275.625, -25.489046763]),
            (true, 1, 4, [0.0, 0.0]),
            (true, 2, 13, [337.5, 41.810314896]),
            (true, 8, 767, [315.0, -4.780191847]),
            (true, 64, 12345, [314.296875, 7.180755781]),
            (true, 1024, 9000000, [43.921078921, -42.958813723]),
        ] {
            let place = if is_nested { Place::of_nested(side, pixel) } else { Place::of_ring(side, pixel) };
            let at = place.angles().map(f64::to_degrees);
            let off = [(at[0] - expected[0] + 180.0).rem_euclid(360.0) - 180.0, at[1] - expected[1]];
            assert!(off.iter().all(|off| off.abs() < 1e-8), "{side} {pixel}: {at:?}, expected {expected:?}");
        }
    }
}
