//! Double-double numbers: the unevaluated sum of two f64, about 31 decimal digits.
//!
//! The algorithms are those of Joldes, Muller and Popescu, "Tight and rigorous error bounds for basic building blocks
//! of double-word arithmetic" (2017). The crate `twofloat` 0.8 has them too, but its division is good to 1e-16 only
//! (the residual is formed without a fused multiply-add) and its exponential to 2e-11.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `hi + lo` with `|lo|` at most half a unit in the last place of `hi`. Finite numbers only.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct Dd {
    hi: f64,
    lo: f64,
}

impl Dd {
    pub const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };
    pub const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };

    /// The exact product of two doubles.
    pub fn product(a: f64, b: f64) -> Dd {
        let hi = a * b;
        Dd { hi, lo: a.mul_add(b, -hi) }
    }

    /// The exact sum of two doubles.
    fn sum(a: f64, b: f64) -> Dd {
        let hi = a + b;
        let b_seen = hi - a;
        Dd { hi, lo: (a - (hi - b_seen)) + (b - b_seen) }
    }

    /// The same for `|a| >= |b|`.
    fn quick_sum(a: f64, b: f64) -> Dd {
        let hi = a + b;
        Dd { hi, lo: b - (hi - a) }
    }

    pub fn to_f64(self) -> f64 {
        self.hi
    }

    pub fn min(self, other: Dd) -> Dd {
        if other < self { other } else { self }
    }

    pub fn max(self, other: Dd) -> Dd {
        if other > self { other } else { self }
    }

    /// Square root of a number that is not negative.
    pub fn sqrt(self) -> Dd {
        if self.hi <= 0.0 {
            return Dd::ZERO;
        }
        let root = self.hi.sqrt();
        let rest = self - Dd::product(root, root);
        Dd::quick_sum(root, rest.hi / (2.0 * root))
    }
}

impl From<f64> for Dd {
    fn from(hi: f64) -> Dd {
        Dd { hi, lo: 0.0 }
    }
}

impl Neg for Dd {
    type Output = Dd;
    fn neg(self) -> Dd {
        Dd { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Dd {
    type Output = Dd;
    fn add(self, other: Dd) -> Dd {
        let (high, low) = (Dd::sum(self.hi, other.hi), Dd::sum(self.lo, other.lo));
        let first = Dd::quick_sum(high.hi, high.lo + low.hi);
        Dd::quick_sum(first.hi, low.lo + first.lo)
    }
}

impl Sub for Dd {
    type Output = Dd;
    fn sub(self, other: Dd) -> Dd {
        self + -other
    }
}

impl Mul for Dd {
    type Output = Dd;
    fn mul(self, other: Dd) -> Dd {
        let high = Dd::product(self.hi, other.hi);
        let cross = self.hi.mul_add(other.lo, self.lo * other.hi);
        Dd::quick_sum(high.hi, high.lo + cross)
    }
}

impl Div for Dd {
    type Output = Dd;
    /// Long division, three digits of 53 bits.
    fn div(self, other: Dd) -> Dd {
        let first = self.hi / other.hi;
        let rest = self - other * Dd::from(first);
        let second = rest.hi / other.hi;
        let third = (rest - other * Dd::from(second)).hi / other.hi;
        Dd::quick_sum(first, second) + Dd::from(third)
    }
}

impl Div<f64> for Dd {
    type Output = Dd;
    fn div(self, other: f64) -> Dd {
        self / Dd::from(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Dd, b: Dd) -> bool {
        (a - b).to_f64().abs() <= 2e-31 * b.to_f64().abs()
    }

    #[test]
    fn arithmetic_is_good_to_31_digits() {
        let mut x = Dd::from(0.7) / 3.0;
        for i in 1..500 {
            let y = Dd::from(f64::from(i)).sqrt() + Dd::from(1e-18);
            assert!(close(x / y * y, x), "{x:?} over {y:?}");
            assert!(close(y.sqrt() * y.sqrt(), y));
            let pixel_error = (x + y) * (x - y) - (x * x - y * y);
            assert!(pixel_error.to_f64().abs() < 2e-31 * (x * x + y * y).to_f64());
            x = x * Dd::from(1.01) + Dd::from(1e-3) / 7.0;
        }
    }
}
