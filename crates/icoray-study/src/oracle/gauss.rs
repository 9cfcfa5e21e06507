//! Gauss-Legendre nodes on [0, 1] with the integration matrix of collocation (Kuntzmann 1961, Butcher 1964).

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

/// Legendre's polynomials up to `degree` at `x`.
fn legendre(x: f64) -> [f64; NODES + 2] {
    let mut p = [1.0; NODES + 2];
    p[1] = x;
    for n in 1..=NODES {
        let m = n as f64;
        p[n + 1] = ((2.0 * m + 1.0) * x * p[n] - m * p[n - 1]) / (m + 1.0);
    }
    p
}

impl Gauss {
    pub fn new() -> Self {
        let mut gauss = Gauss {
            node: [0.0; NODES],
            weight: [0.0; NODES],
            until: [[0.0; NODES]; NODES],
            last: [[0.0; NODES]; 2],
        };
        let count = NODES as f64;
        let mut at = [0.0; NODES];
        for (i, x) in at.iter_mut().enumerate() {
            *x = -(std::f64::consts::PI * (i as f64 + 0.75) / (count + 0.5)).cos();
            for _ in 0..10 {
                let p = legendre(*x);
                let slope = count * (*x * p[NODES] - p[NODES - 1]) / (*x * *x - 1.0);
                *x -= p[NODES] / slope;
            }
            let before = legendre(*x)[NODES - 1];
            gauss.node[i] = 0.5 * (1.0 + *x);
            gauss.weight[i] = (1.0 - *x * *x) / (count * before).powi(2);
        }
        // A function's expansion in Legendre's polynomials follows from its values at the nodes, and
        // the integral of P_n from -1 is (P_{n+1} - P_{n-1})/(2n + 1).
        for j in 0..NODES {
            let values = legendre(at[j]);
            for (row, n) in [NODES - 2, NODES - 1].into_iter().enumerate() {
                gauss.last[row][j] = (2 * n + 1) as f64 * gauss.weight[j] * values[n];
            }
            for (i, x) in at.into_iter().enumerate() {
                let p = legendre(x);
                let integral = |n: usize| match n {
                    0 => p[1] + 1.0,
                    _ => (p[n + 1] - p[n - 1]) / (2 * n + 1) as f64,
                };
                let sum: f64 = (0..NODES).map(|n| (2 * n + 1) as f64 * values[n] * integral(n)).sum();
                gauss.until[j][i] = 0.5 * gauss.weight[j] * sum;
            }
        }
        gauss
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
        assert!(gauss.roughness(&gauss.node.map(|x| legendre(2.0 * x - 1.0)[7])) > 0.999);
        assert!(gauss.roughness(&gauss.node.map(|x| legendre(2.0 * x - 1.0)[6])) > 0.999);
    }

    #[test]
    fn polynomials_are_integrated_exactly() {
        let gauss = Gauss::new();
        for degree in 0..16 {
            let power = gauss.node.map(|x| x.powi(degree));
            let whole: f64 = power.iter().zip(&gauss.weight).map(|(f, w)| f * w).sum();
            assert!((whole - 1.0 / f64::from(degree + 1)).abs() < 4e-15, "{degree}: {whole}");
            for i in 0..NODES {
                let part: f64 = (0..NODES).map(|j| power[j] * gauss.until[j][i]).sum();
                let expected = gauss.node[i].powi(degree + 1) / f64::from(degree + 1);
                assert!(degree > 7 || (part - expected).abs() < 4e-15, "{degree} {i}: {part} {expected}");
            }
        }
    }
}
