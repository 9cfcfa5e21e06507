//! Gauss-Legendre nodes on [0, 1] with their weights, and the weights of integrals that end at a node.

use super::dd::Dd;

/// Number of nodes.
pub const NODES: usize = 12;

/// The rule: exact for polynomials of degree 23, and up to a node for those of degree 11.
#[derive(Debug, Clone)]
pub struct Gauss {
    /// Where the integrand is asked for, in (0, 1).
    pub node: [Dd; NODES],
    /// Weights of the integral over [0, 1].
    pub weight: [Dd; NODES],
    /// `partial[i][j]`: weight of node j in the integral over [0, `node[i]`].
    pub partial: [[Dd; NODES]; NODES],
}

/// Legendre's polynomial of degree [`NODES`] and its derivative at `x` in (-1, 1).
fn legendre(x: Dd) -> (Dd, Dd) {
    let (mut before, mut p) = (Dd::ONE, x);
    for k in 2..=NODES {
        let (k1, k2) = (Dd::from(2.0 * k as f64 - 1.0), Dd::from(k as f64 - 1.0));
        (before, p) = (p, (k1 * x * p - k2 * before) / k as f64);
    }
    let slope = Dd::from(NODES as f64) * (x * p - before) / (x * x - Dd::ONE);
    (p, slope)
}

impl Gauss {
    /// Computes the rule by Newton's method.
    pub fn rule() -> Self {
        let half = Dd::from(0.5);
        let mut rule =
            Gauss { node: [Dd::ZERO; NODES], weight: [Dd::ZERO; NODES], partial: [[Dd::ZERO; NODES]; NODES] };
        for i in 0..NODES {
            let guess = (std::f64::consts::PI * (i as f64 + 0.75) / (NODES as f64 + 0.5)).cos();
            let mut x = Dd::from(-guess);
            for _ in 0..6 {
                let (p, slope) = legendre(x);
                x = x - p / slope;
            }
            let slope = legendre(x).1;
            rule.node[i] = half * (Dd::ONE + x);
            rule.weight[i] = Dd::ONE / ((Dd::ONE - x * x) * slope * slope);
        }
        for i in 0..NODES {
            for j in 0..NODES {
                let end = rule.node[i];
                let inside = |k: usize| rule.weight[k] * rule.lagrange(j, end * rule.node[k]);
                rule.partial[i][j] = end * (0..NODES).fold(Dd::ZERO, |sum, k| sum + inside(k));
            }
        }
        rule
    }

    /// The polynomial that is 1 at node j and 0 at the others.
    fn lagrange(&self, j: usize, x: Dd) -> Dd {
        let others = (0..NODES).filter(|k| *k != j);
        others.fold(Dd::ONE, |p, k| p * (x - self.node[k]) / (self.node[j] - self.node[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_integrated_exactly() {
        let rule = Gauss::rule();
        let power = |x: Dd, n: usize| (0..n).fold(Dd::ONE, |p, _| p * x);
        for n in 0..24 {
            let sum = (0..NODES).fold(Dd::ZERO, |s, i| s + rule.weight[i] * power(rule.node[i], n));
            assert!((sum - Dd::ONE / (n as f64 + 1.0)).abs().to_f64() < 1e-30, "degree {n}");
        }
        for n in 0..12 {
            for i in 0..NODES {
                let sum = (0..NODES).fold(Dd::ZERO, |s, j| s + rule.partial[i][j] * power(rule.node[j], n));
                let exact = power(rule.node[i], n + 1) / (n as f64 + 1.0);
                assert!((sum - exact).abs().to_f64() < 1e-29, "degree {n} up to node {i}");
            }
        }
    }
}
