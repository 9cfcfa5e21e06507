//! A signature of the surfaces that a ray meets, in order, with their distances: if neighbouring rays differ in it, the
//! edge of a surface passes between them.

use glam::DVec3;

/// A boundary that a ray may meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Boundary {
    /// The opaque core.
    Core,
    /// Visible matter behind a cut.
    CutFace,
    /// The isosurface of this number.
    Isosurface(usize),
    /// The surface layer of this number; the bits of the materials that are painted there.
    SurfaceLayer(usize, u32),
}

impl Boundary {
    #[inline]
    fn number(self) -> u32 {
        match self {
            Boundary::Core => 1,
            Boundary::CutFace => 2,
            Boundary::Isosurface(k) => (k as u32) << 2 | 3,
            Boundary::SurfaceLayer(k, materials) => (k as u32).wrapping_mul(0x0020_0203) ^ materials << 2,
        }
    }
}

/// The boundaries that a ray meets until it ends; the default is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BoundarySignature {
    /// Upper 8 bits: the number of boundaries, at most 255. Lower bits: a polynomial hash of their numbers in order.
    order: u32,
    /// The sum of 1 / distance from the eye over them, per planet radius.
    nearness: f32,
}

const HASH_BITS: u32 = 24;
const HASH: u32 = (1 << HASH_BITS) - 1;
/// The base of the polynomial: any odd number.
const BASE: u32 = 0x9E_3779;

impl BoundarySignature {
    /// Adds the next boundary, at `distance` from the eye.
    #[inline]
    pub fn push(&mut self, boundary: Boundary, distance: f64) {
        // Numbers are small: their bits are spread before summing.
        let number = boundary.number().wrapping_mul(0x85EB_CA6B);
        let number = (number ^ number >> 13).wrapping_mul(0xC2B2_AE35) >> 8;
        self.then(&BoundarySignature { order: 1 << HASH_BITS | number, nearness: distance.recip() as f32 });
    }

    /// Adds the boundaries of a part of the ray behind.
    #[inline]
    pub fn then(&mut self, behind: &BoundarySignature) {
        let hash = self.order.wrapping_mul(BASE.wrapping_pow(behind.order >> HASH_BITS));
        let count = (self.order >> HASH_BITS) + (behind.order >> HASH_BITS);
        self.order = count.min(0xFF) << HASH_BITS | hash.wrapping_add(behind.order) & HASH;
        self.nearness += behind.nearness;
    }

    /// Whether two rays meet the same boundaries in the same order.
    #[inline]
    pub fn is_alike(&self, other: &BoundarySignature) -> bool {
        self.order == other.order
    }

    /// Second difference of the nearness over three adjacent rays, relative to the middle ray's: zero for flat
    /// surfaces, since the nearness of a plane is linear in the picture.
    #[inline]
    pub fn bend(&self, before: &BoundarySignature, behind: &BoundarySignature) -> f32 {
        (before.nearness - 2.0 * self.nearness + behind.nearness).abs() / self.nearness.max(f32::MIN_POSITIVE)
    }

    /// The signature as two values, to be sent to another rank.
    #[inline]
    pub fn values(&self) -> [f32; 2] {
        [f32::from_bits(self.order), self.nearness]
    }

    /// The signature with these [`Self::values`].
    #[inline]
    pub fn of_values([order, nearness]: [f32; 2]) -> Self {
        BoundarySignature { order: order.to_bits(), nearness }
    }
}

/// Converts distances along a ray, which are measured from its point closest to the centre, to distances from the eye.
#[derive(Debug, Clone, Copy)]
pub struct EyeDistance(f64);

impl EyeDistance {
    /// The conversion for a ray from `eye` along the unit vector `dir`.
    #[inline]
    pub fn new(eye: DVec3, dir: DVec3) -> Self {
        EyeDistance(eye.dot(dir))
    }

    /// Distance from the eye of the point at `t`.
    #[inline]
    pub fn distance(&self, t: f64) -> f64 {
        t - self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(boundaries: &[(Boundary, f64)]) -> BoundarySignature {
        let mut all = BoundarySignature::default();
        boundaries.iter().for_each(|(boundary, distance)| all.push(*boundary, *distance));
        all
    }

    #[test]
    fn signatures_distinguish_boundaries_and_their_order() {
        let all = [
            Boundary::Core,
            Boundary::CutFace,
            Boundary::Isosurface(0),
            Boundary::Isosurface(1),
            Boundary::SurfaceLayer(0, 1),
            Boundary::SurfaceLayer(0, 3),
            Boundary::SurfaceLayer(1, 1),
        ];
        let mut known = vec![of(&[])];
        for a in all {
            known.push(of(&[(a, 1.0)]));
            for b in all {
                known.push(of(&[(a, 1.0), (b, 2.0)]));
                known.extend(all.map(|c| of(&[(a, 1.0), (b, 2.0), (c, 3.0)])));
            }
        }
        for (i, one) in known.iter().enumerate() {
            assert!(known[..i].iter().all(|other| !other.is_alike(one)), "{i}");
            assert_eq!(BoundarySignature::of_values(one.values()), *one);
        }
    }

    #[test]
    fn parts_of_a_ray_add_up_to_the_whole() {
        let all: Vec<_> = (0..200).map(|i| (Boundary::Isosurface(i % 5), 1.0 + i as f64)).collect();
        for at in [0, 1, 7, 100, 200] {
            let mut sum = of(&all[..at]);
            sum.then(&of(&all[at..]));
            assert!(sum.is_alike(&of(&all)));
            assert!((sum.nearness - of(&all).nearness).abs() < 1e-5);
        }
    }

    #[test]
    fn planes_have_no_bend_and_steps_have() {
        // A plane at an angle: its distance along rays 1e-3 apart.
        let seen = |x: f64| of(&[(Boundary::Core, 2.0 / (1.0 + 3.0 * x))]);
        let [a, b, c] = [-1e-3, 0.0, 1e-3].map(seen);
        assert!(b.bend(&a, &c) < 1e-6);
        let behind = of(&[(Boundary::Core, 2.02)]);
        assert!((b.bend(&a, &behind) - 0.013).abs() < 1e-3);
    }
}
