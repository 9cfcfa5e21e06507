//! The precision of the inner loop: f32 or f64.

/// A floating-point type that the kernel is instantiated with.
pub trait Real: num_traits::Float + Send + Sync + 'static {
    /// Half a unit of the last digit of 1.
    const ROUNDING: f64;
    /// Optical depth beyond which a piece is a surface.
    const SURFACE: f64;
    /// Normalised field values are clamped to ± this, so that products of two of them stay finite.
    const LARGEST: f64;

    /// Rounds a double.
    fn of(value: f64) -> Self;
    /// Widens.
    fn wide(self) -> f64;
    /// `1 - e^-x` for `x >= 0`, to rounding also for tiny x: the light that optical depth x absorbs.
    fn absorbed_by(self) -> Self;
    /// `x^y` for `0 <= x <= 1` and `y >= 0`, in f32 without a branch: there to 2e-6 of it if it exceeds 1e-6.
    fn power(self, exponent: Self) -> Self;
}

impl Real for f32 {
    const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;
    const SURFACE: f64 = 1e12;
    const LARGEST: f64 = 1e15;

    #[inline]
    fn of(value: f64) -> Self {
        value as f32
    }

    #[inline]
    fn wide(self) -> f64 {
        f64::from(self)
    }

    /// Up to 1/2, where almost all pieces lie, the series up to x⁸: the first omitted term is 1e-8 of the sum.
    #[inline]
    fn absorbed_by(self) -> f32 {
        let x = self;
        if x > 0.5 {
            return 1.0 - (-x).exp();
        }
        const C: [f32; 8] =
            [1.0, -1.0 / 2.0, 1.0 / 6.0, -1.0 / 24.0, 1.0 / 120.0, -1.0 / 720.0, 1.0 / 5040.0, -1.0 / 40320.0];
        let (x2, x4) = (x * x, x * x * x * x);
        let low = (C[0] + x * C[1]) + x2 * (C[2] + x * C[3]);
        let high = (C[4] + x * C[5]) + x2 * (C[6] + x * C[7]);
        x * (low + x4 * high)
    }

    /// As `2^(y log2 x)`, both by Cephes's polynomials.
    #[inline(always)]
    fn power(self, exponent: f32) -> f32 {
        // Numbers of this size have no fraction: added and subtracted again, it rounds to the nearest whole number.
        const ROUNDS: f32 = 12_582_912.0;
        const ONE: u32 = 0x3f80_0000;
        let power = (exponent * log2(self)).clamp(-126.0, 0.0);
        let rounded = power + ROUNDS;
        let fraction = power - (rounded - ROUNDS);
        let whole = rounded.to_bits().wrapping_sub(ROUNDS.to_bits());
        exp2(fraction) * f32::from_bits((whole << 23).wrapping_add(ONE))
    }
}

/// The binary logarithm of a positive normal number; of zero a large negative number.
#[inline(always)]
fn log2(x: f32) -> f32 {
    const HALF: u32 = 0x3f35_04f3;
    const C: [f32; 9] = [
        3.333_333e-1,
        -2.499_999_4e-1,
        2.000_071_5e-1,
        -1.666_805_8e-1,
        1.424_932_3e-1,
        -1.242_014_1e-1,
        1.167_699_9e-1,
        -1.151_461e-1,
        7.037_683_6e-2,
    ];
    // The exponent that leaves a mantissa from the root of 1/2 to that of 2.
    let above = x.to_bits().wrapping_sub(HALF);
    let exponent = (above as i32) >> 23;
    let f = f32::from_bits((above & 0x007f_ffff).wrapping_add(HALF)) - 1.0;
    let f2 = f * f;
    let f4 = f2 * f2;
    let pair = |k: usize| C[k] + f * C[k + 1];
    let series = (pair(0) + f2 * pair(2)) + f4 * ((pair(4) + f2 * pair(6)) + f4 * C[8]);
    let log = f - f2 * (0.5 - f * series);
    exponent as f32 + log * std::f32::consts::LOG2_E
}

/// `2^x` for `|x| <= 1/2`.
#[inline(always)]
fn exp2(x: f32) -> f32 {
    const C: [f32; 7] =
        [1.0, 6.931_472e-1, 2.402_264_8e-1, 5.550_332_5e-2, 9.618_437e-3, 1.339_887_4e-3, 1.535_336_2e-4];
    let x2 = x * x;
    let pair = |k: usize| C[k] + x * C[k + 1];
    (pair(0) + x2 * pair(2)) + x2 * x2 * (pair(4) + x2 * C[6])
}

impl Real for f64 {
    const ROUNDING: f64 = f64::EPSILON / 2.0;
    const SURFACE: f64 = 1e16;
    const LARGEST: f64 = 1e100;

    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    #[inline]
    fn wide(self) -> f64 {
        self
    }

    #[inline]
    fn absorbed_by(self) -> f64 {
        -(-self).exp_m1()
    }

    #[inline]
    fn power(self, exponent: f64) -> f64 {
        self.powf(exponent)
    }
}

/// `a + w·(b - a)`: exactly `a` at `w = 0` and if `a = b`.
#[inline]
pub fn lerp<T: Real>(a: T, b: T, w: T) -> T {
    a + w * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absorption_is_exact_to_rounding_in_f32() {
        for i in -400..100 {
            let x = 1.2f32.powi(i);
            let exact = f64::from(x).absorbed_by();
            let error = (f64::from(x.absorbed_by()) - exact).abs() / exact;
            assert!(error < 2e-7, "{x}: {error}");
        }
        assert_eq!(0.0f32.absorbed_by(), 0.0);
        assert_eq!(f32::INFINITY.absorbed_by(), 1.0);
    }

    #[test]
    fn powers_are_exact_enough_for_highlights() {
        for exponent in [0.0f32, 0.5, 1.0, 7.3, 24.0, 200.0, 5e3] {
            for i in 1..=20_000 {
                let x = i as f32 / 20_000.0;
                let exact = f64::from(x).powf(f64::from(exponent));
                let error = (f64::from(x.power(exponent)) - exact).abs();
                assert!(error <= 2e-6 * exact + 2e-12, "{x}^{exponent}: {error:e} of {exact:e}");
            }
            assert_eq!(1.0f32.power(exponent), 1.0);
        }
        assert!(0.0f32.power(2.0) < 1e-30);
    }
}
