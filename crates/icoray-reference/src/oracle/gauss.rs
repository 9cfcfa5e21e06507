//! Gauss-Legendre nodes on [0, 1] with the integration matrix of collocation (Kuntzmann 1961, Butcher 1964), computed in
//! double-double and rounded.

use crate::double_double::Dd;
use std::array::from_fn;

/// Number of nodes: the integral over a panel is exact for polynomials up to degree 15, up to a node for those of
/// degree 7.
pub(crate) const NODES: usize = 8;

/// Nodes, weights, and integrals from 0 to each node.
#[derive(Debug, Clone)]
pub(crate) struct Gauss {
    pub node: [f64; NODES],
    pub weight: [f64; NODES],
    /// `until[j][i]`: the weight of the value at node j in the integral from 0 to node i.
    pub until: [[f64; NODES]; NODES],
    /// Rows that give a function's last two Legendre coefficients from its values at the nodes.
    last: [[f64; NODES]; 2],
}

/// Legendre's polynomials of degrees `n - 1` and `n`, 1 at least, at `x`.
fn legendre(n: usize, x: Dd) -> [Dd; 2] {
    let (mut before, mut p) = (Dd::ONE, x);
    for k in 2..=n {
        let (k1, k2) = (Dd::from(2.0 * k as f64 - 1.0), Dd::from(k as f64 - 1.0));
        (before, p) = (p, (k1 * x * p - k2 * before) / k as f64);
    }
    [before, p]
}

/// The slope of the polynomial of degree [`NODES`] at `x`, from its value and that of the one before.
fn slope(x: Dd, [before, p]: [Dd; 2]) -> Dd {
    Dd::from(NODES as f64) * (x * p - before) / (x * x - Dd::ONE)
}

/// The polynomial that is 1 at node j and 0 at the others.
fn lagrange(node: &[Dd; NODES], j: usize, x: Dd) -> Dd {
    let others = (0..NODES).filter(|k| *k != j);
    others.fold(Dd::ONE, |p, k| p * (x - node[k]) / (node[j] - node[k]))
}

impl Gauss {
    /// Computes the rule by Newton's method.
    pub fn new() -> Self {
        let (mut node, mut weight) = ([Dd::ZERO; NODES], [Dd::ZERO; NODES]);
        for i in 0..NODES {
            let guess = (std::f64::consts::PI * (i as f64 + 0.75) / (NODES as f64 + 0.5)).cos();
            let mut x = Dd::from(-guess);
            for _ in 0..6 {
                let values = legendre(NODES, x);
                x = x - values[1] / slope(x, values);
            }
            let slope = slope(x, legendre(NODES, x));
            node[i] = Dd::from(0.5) * (Dd::ONE + x);
            weight[i] = Dd::ONE / ((Dd::ONE - x * x) * slope * slope);
        }
        let until = |j: usize, i: usize| {
            let inside = |k: usize| weight[k] * lagrange(&node, j, node[i] * node[k]);
            node[i] * (0..NODES).fold(Dd::ZERO, |sum, k| sum + inside(k))
        };
        let values = node.map(|x| legendre(NODES - 1, x + x - Dd::ONE));
        let coefficient = |k: usize, j: usize| {
            let degree = NODES - 2 + k;
            Dd::from((2 * degree + 1) as f64) * weight[j] * values[j][k]
        };
        Gauss {
            node: node.map(Dd::to_f64),
            weight: weight.map(Dd::to_f64),
            until: from_fn(|j| from_fn(|i| until(j, i).to_f64())),
            last: from_fn(|k| from_fn(|j| coefficient(k, j).to_f64())),
        }
    }

    /// How rough a function is, by its values at the nodes: the larger of its last two Legendre coefficients.
    pub fn roughness(&self, values: &[f64; NODES]) -> f64 {
        let coefficient = |row: &[f64; NODES]| row.iter().zip(values).map(|(r, v)| r * v).sum::<f64>().abs();
        coefficient(&self.last[0]).max(coefficient(&self.last[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_integrated_exactly() {
        let gauss = Gauss::new();
        for n in 0..2 * NODES as i32 {
            let sum: f64 = (0..NODES).map(|j| gauss.weight[j] * gauss.node[j].powi(n)).sum();
            assert!((sum - 1.0 / f64::from(n + 1)).abs() < 1e-15, "degree {n}");
            for i in (0..NODES).filter(|_| n < NODES as i32) {
                let sum: f64 = (0..NODES).map(|j| gauss.until[j][i] * gauss.node[j].powi(n)).sum();
                let exact = gauss.node[i].powi(n + 1) / f64::from(n + 1);
                assert!((sum - exact).abs() < 1e-15, "degree {n} up to node {i}");
            }
        }
    }

    #[test]
    fn roughness_is_what_low_degrees_lack() {
        let gauss = Gauss::new();
        assert!(gauss.roughness(&gauss.node.map(|x| x.powi(5))) < 1e-14);
        for k in [0, 1] {
            let polynomial = gauss.node.map(|x| legendre(7, Dd::from(2.0 * x - 1.0))[k].to_f64());
            assert!(gauss.roughness(&polynomial) > 0.999);
        }
    }
}
