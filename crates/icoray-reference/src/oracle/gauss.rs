//! Gauss-Legendre nodes on [0, 1] with the integration matrix of collocation (Kuntzmann 1961, Butcher 1964).

use crate::double_double::Dd;
use crate::gauss::{self, legendre};
use std::array::from_fn;

/// Number of nodes: the integral over a panel is exact for polynomials up to degree 15.
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

impl Gauss {
    /// The rule of double-double, rounded.
    pub fn new() -> Self {
        let rule = gauss::Gauss::<NODES>::rule();
        let values = rule.node.map(|x| legendre(NODES - 1, x + x - Dd::ONE));
        let coefficient = |k: usize, j: usize| {
            let degree = NODES - 2 + k;
            Dd::from((2 * degree + 1) as f64) * rule.weight[j] * values[j][k]
        };
        Gauss {
            node: rule.node.map(Dd::to_f64),
            weight: rule.weight.map(Dd::to_f64),
            until: from_fn(|j| from_fn(|i| rule.partial[i][j].to_f64())),
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
    fn roughness_is_what_low_degrees_lack() {
        let gauss = Gauss::new();
        assert!(gauss.roughness(&gauss.node.map(|x| x.powi(5))) < 1e-14);
        for k in [0, 1] {
            let polynomial = gauss.node.map(|x| legendre(7, Dd::from(2.0 * x - 1.0))[k].to_f64());
            assert!(gauss.roughness(&polynomial) > 0.999);
        }
    }
}
