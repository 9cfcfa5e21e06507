//! Vectors of f64 with as many lanes as a vector of f32: two machine vectors side by side.

use crate::{Floats, Mask};
use fearless_simd::{Simd, prelude::*};
use std::ops::{Add, Div, Mul, Sub};

/// As many f64 as [`Floats`] has lanes: the lower half of the lanes, and the upper half.
#[derive(Debug, Clone, Copy)]
pub struct Wide<V: Simd>(pub V::f64s, pub V::f64s);

/// A mask of [`Wide`].
#[derive(Debug, Clone, Copy)]
pub struct WideMask<V: Simd>(pub V::mask64s, pub V::mask64s);

impl<V: Simd> WideMask<V> {
    /// As a mask of f32 lanes.
    #[inline(always)]
    pub fn narrow(self) -> Mask<V> {
        self.0.narrow(self.1)
    }
}

/// A mask of f32 lanes as one of f64 lanes.
#[inline(always)]
pub fn wide_mask<V: Simd>(mask: Mask<V>) -> WideMask<V> {
    let (low, high) = mask.widen();
    WideMask(low, high)
}

macro_rules! lane_by_lane {
    ($($trait:ident::$function:ident: $operator:tt;)*) => {$(
        impl<V: Simd> $trait for Wide<V> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Wide(self.0 $operator other.0, self.1 $operator other.1)
            }
        }
    )*};
}

lane_by_lane! {
    Add::add: +;
    Sub::sub: -;
    Mul::mul: *;
    Div::div: /;
}

impl<V: Simd> Wide<V> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: V, value: f64) -> Self {
        let half = <V::f64s as SimdBase<V>>::splat(simd, value);
        Wide(half, half)
    }

    /// The number in a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> f64 {
        let half = <V::f64s as SimdBase<V>>::LEN;
        if lane < half { self.0[lane] } else { self.1[lane - half] }
    }

    /// Puts a number into a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: f64) {
        let half = <V::f64s as SimdBase<V>>::LEN;
        if lane < half {
            self.0[lane] = value;
        } else {
            self.1[lane - half] = value;
        }
    }

    /// Rounded to f32.
    #[inline(always)]
    pub fn narrow(self) -> Floats<V> {
        self.0.narrow(self.1)
    }

    /// `self` in the lanes of `mask`, `other` in the rest.
    #[inline(always)]
    pub fn over(self, mask: WideMask<V>, other: Self) -> Self {
        Wide(mask.0.select(self.0, other.0), mask.1.select(self.1, other.1))
    }

    /// The lesser of two numbers; `other` where one of them is NaN.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Wide(self.0.simd_lt(other.0).select(self.0, other.0), self.1.simd_lt(other.1).select(self.1, other.1))
    }

    /// The greater of two numbers; `other` where one of them is NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Wide(self.0.simd_gt(other.0).select(self.0, other.0), self.1.simd_gt(other.1).select(self.1, other.1))
    }

    /// Lanes in which `self >= other`.
    #[inline(always)]
    pub fn ge(self, other: Self) -> WideMask<V> {
        WideMask(self.0.simd_ge(other.0), self.1.simd_ge(other.1))
    }

    /// Lanes in which `self <= other`.
    #[inline(always)]
    pub fn le(self, other: Self) -> WideMask<V> {
        WideMask(self.0.simd_le(other.0), self.1.simd_le(other.1))
    }

    /// Lanes in which `self < other`.
    #[inline(always)]
    pub fn lt(self, other: Self) -> WideMask<V> {
        WideMask(self.0.simd_lt(other.0), self.1.simd_lt(other.1))
    }

    /// Held between 0 and 1; NaN stays NaN.
    #[inline(always)]
    pub fn fraction(self, simd: V) -> Self {
        let (zero, one) = (Wide::splat(simd, 0.0), Wide::splat(simd, 1.0));
        let above = zero.over(self.lt(zero), self);
        one.over(one.lt(above), above)
    }
}

/// Widened to f64.
#[inline(always)]
pub fn wide<V: Simd>(numbers: Floats<V>) -> Wide<V> {
    let (low, high) = numbers.widen();
    Wide(low, high)
}
