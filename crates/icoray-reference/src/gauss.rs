//! Gauss-Legendre nodes on [0, 1] with their weights, and the weights of integrals that end at a node.

use crate::double_double::Dd;
use std::array::from_fn;

/// The rule of `N` nodes: exact for polynomials of degree `2N - 1`, and up to a node for those of degree `N - 1`.
#[derive(Debug, Clone)]
pub(crate) struct Gauss<const N: usize> {
    /// Where the integrand is evaluated, in (0, 1).
    pub node: [Dd; N],
    /// Weights of the integral over [0, 1].
    pub weight: [Dd; N],
    /// `partial[i][j]`: weight of node j in the integral over [0, `node[i]`].
    pub partial: [[Dd; N]; N],
}

/// Legendre's polynomials of degrees `n - 1` and `n`, 1 at least, at `x`.
pub(crate) fn legendre(n: usize, x: Dd) -> [Dd; 2] {
    let (mut before, mut p) = (Dd::ONE, x);
    for k in 2..=n {
        let (k1, k2) = (Dd::from(2.0 * k as f64 - 1.0), Dd::from(k as f64 - 1.0));
        (before, p) = (p, (k1 * x * p - k2 * before) / k as f64);
    }
    [before, p]
}

impl<const N: usize> Gauss<N> {
    /// Computes the rule by Newton's method.
    pub fn rule() -> Self {
        let half = Dd::from(0.5);
        let mut rule = Gauss { node: [Dd::ZERO; N], weight: [Dd::ZERO; N], partial: [[Dd::ZERO; N]; N] };
        let slope = |x: Dd, [before, p]: [Dd; 2]| Dd::from(N as f64) * (x * p - before) / (x * x - Dd::ONE);
        for i in 0..N {
            let guess = (std::f64::consts::PI * (i as f64 + 0.75) / (N as f64 + 0.5)).cos();
            let mut x = Dd::from(-guess);
            for _ in 0..6 {
                let values = legendre(N, x);
                x = x - values[1] / slope(x, values);
            }
            let slope = slope(x, legendre(N, x));
            rule.node[i] = half * (Dd::ONE + x);
            rule.weight[i] = Dd::ONE / ((Dd::ONE - x * x) * slope * slope);
        }
        let inside = |i: usize, j: usize, k: usize| rule.weight[k] * rule.lagrange(j, rule.node[i] * rule.node[k]);
        let sum = |i: usize, j: usize| (0..N).fold(Dd::ZERO, |sum, k| sum + inside(i, j, k));
        let partial = from_fn(|i| from_fn(|j| rule.node[i] * sum(i, j)));
        Gauss { partial, ..rule }
    }

    /// The polynomial that is 1 at node j and 0 at the others.
    fn lagrange(&self, j: usize, x: Dd) -> Dd {
        let others = (0..N).filter(|k| *k != j);
        others.fold(Dd::ONE, |p, k| p * (x - self.node[k]) / (self.node[j] - self.node[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn powers_are_integrated<const N: usize>() {
        let rule = Gauss::<N>::rule();
        let power = |x: Dd, n: usize| (0..n).fold(Dd::ONE, |p, _| p * x);
        for n in 0..2 * N {
            let sum = (0..N).fold(Dd::ZERO, |s, i| s + rule.weight[i] * power(rule.node[i], n));
            assert!((sum - Dd::ONE / (n as f64 + 1.0)).abs().to_f64() < 1e-30, "degree {n}");
        }
        for n in 0..N {
            for i in 0..N {
                let sum = (0..N).fold(Dd::ZERO, |s, j| s + rule.partial[i][j] * power(rule.node[j], n));
                let exact = power(rule.node[i], n + 1) / (n as f64 + 1.0);
                assert!((sum - exact).abs().to_f64() < 1e-29, "degree {n} up to node {i}");
            }
        }
    }

    #[test]
    fn powers_are_integrated_exactly() {
        powers_are_integrated::<8>();
        powers_are_integrated::<12>();
    }
}
