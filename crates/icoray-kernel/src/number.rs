//! The numbers of formulas that single rays and packets share: one number, or one in each lane of a vector.

use fearless_simd::prelude::*;
use icoray_grid::real::Real;
use icoray_simd::{Floats, Machine, Mask, power};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

/// A number, or several of which each has the operation. A comparison has an outcome for each.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// The outcome of a comparison.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;
    /// Half a unit of the last digit of 1.
    const ROUNDING: f64;

    /// `value`, in as many lanes as this has.
    fn like(self, value: f64) -> Self;
    /// The smallest positive normal number.
    fn least(self) -> Self;
    /// `self · factor + term`, rounded once where the machine does so at no cost.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The larger one; any, if one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller one; any, if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The smaller one; `other`, if this is NaN.
    fn min_or(self, other: Self) -> Self;
    /// Whether this is larger.
    fn exceeds(self, other: Self) -> Self::Mask;
    /// This where `mask` is true, `other` elsewhere.
    fn where_else(self, mask: Self::Mask, other: Self) -> Self;
    /// Whether `mask` is true for any.
    fn is_any(mask: Self::Mask) -> bool;
    /// `self^exponent` for `0 <= self <= 1` and `exponent >= 0`.
    fn power(self, exponent: Self) -> Self;
}

impl<T: Real> Number for T {
    type Mask = bool;
    const ROUNDING: f64 = <T as Real>::ROUNDING;

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        T::of(value)
    }

    #[inline(always)]
    fn least(self) -> Self {
        T::min_positive_value()
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn min_or(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn where_else(self, mask: bool, other: Self) -> Self {
        if mask { self } else { other }
    }

    #[inline(always)]
    fn is_any(mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn power(self, exponent: Self) -> Self {
        Real::power(self, exponent)
    }
}

/// A number in each lane.
#[derive(Clone, Copy)]
pub(crate) struct Vector<V: Machine> {
    pub simd: V,
    pub lanes: Floats<V>,
}

impl<V: Machine> Vector<V> {
    #[inline(always)]
    pub fn new(simd: V, lanes: Floats<V>) -> Self {
        Vector { simd, lanes }
    }
}

impl<V: Machine> Add for Vector<V> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.simd, self.lanes + other.lanes)
    }
}

impl<V: Machine> Sub for Vector<V> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.simd, self.lanes - other.lanes)
    }
}

impl<V: Machine> Mul for Vector<V> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(self.simd, self.lanes * other.lanes)
    }
}

impl<V: Machine> Div for Vector<V> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self::new(self.simd, self.lanes / other.lanes)
    }
}

impl<V: Machine> Number for Vector<V> {
    type Mask = Mask<V>;
    const ROUNDING: f64 = <f32 as Real>::ROUNDING;

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::new(self.simd, Floats::<V>::splat(self.simd, value as f32))
    }

    #[inline(always)]
    fn least(self) -> Self {
        Self::new(self.simd, Floats::<V>::splat(self.simd, f32::MIN_POSITIVE))
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self::new(self.simd, self.lanes.mul_add(factor.lanes, term.lanes))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::new(self.simd, self.lanes.abs())
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::new(self.simd, self.lanes.sqrt())
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::new(self.simd, self.lanes.max(other.lanes))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::new(self.simd, self.lanes.min(other.lanes))
    }

    #[inline(always)]
    fn min_or(self, other: Self) -> Self {
        Self::new(self.simd, self.lanes.min_precise(other.lanes))
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> Mask<V> {
        self.lanes.simd_gt(other.lanes)
    }

    #[inline(always)]
    fn where_else(self, mask: Mask<V>, other: Self) -> Self {
        Self::new(self.simd, mask.select(self.lanes, other.lanes))
    }

    #[inline(always)]
    fn is_any(mask: Mask<V>) -> bool {
        mask.any_true()
    }

    #[inline(always)]
    fn power(self, exponent: Self) -> Self {
        Self::new(self.simd, power(self.simd, self.lanes, exponent.lanes))
    }
}
