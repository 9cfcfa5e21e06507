//! Vertex gradients in f64: the mean of the interpolant's gradient over the incident frusta (§3.5 of the paper).

use crate::job::PreparedJob;
use glam::DVec3;
use rayon::prelude::*;

/// Gradients at all vertices, per planet radius, level-fastest, layer 0 innermost; zero where no frustum is whole.
pub(crate) fn gradients(prepared: &PreparedJob) -> Vec<DVec3> {
    let layers = prepared.radius.len();
    let mut gradients = vec![DVec3::ZERO; prepared.grid.cells() * layers];
    gradients.par_chunks_exact_mut(layers).enumerate().for_each(|(cell, row)| column(prepared, cell as u32, row));
    gradients
}

/// At vertex A the gradient has the radial slope along A and the neighbours' differences along B - A and C - A: with
/// the dual basis of the three, `s eA + ((gB - gA) eB + (gC - gA) eC)/R`.
fn column(prepared: &PreparedJob, cell: u32, row: &mut [DVec3]) {
    let field = prepared.field();
    let mut count = vec![0u32; row.len()];
    let a = prepared.grid.direction(cell);
    for triangle in prepared.grid.corners_of(cell) {
        let cells = prepared.grid.triangle(triangle);
        let k = cells.iter().position(|&c| c == cell).expect("a cell is at its own corners");
        let others = [cells[(k + 1) % 3], cells[(k + 2) % 3]];
        let [b, c] = others.map(|o| prepared.grid.direction(o) - a);
        let volume = a.dot(b.cross(c));
        let dual = [b.cross(c) / volume, c.cross(a) / volume, a.cross(b) / volume];
        let value = |cell, layer| prepared.value(&field, cell, layer);
        let on = |layer| [value(cell, layer), value(others[0], layer), value(others[1], layer)];
        let mut low = on(0);
        for gap in 0..row.len() - 1 {
            let high = on(gap + 1);
            if !low.iter().chain(&high).any(|v| v.is_nan()) {
                let radial = dual[0] * ((high[0] - low[0]) / (prepared.radius[gap + 1] - prepared.radius[gap]));
                for (layer, at) in [(gap, &low), (gap + 1, &high)] {
                    let across = dual[1] * (at[1] - at[0]) + dual[2] * (at[2] - at[0]);
                    row[layer] += radial + across / prepared.radius[layer];
                    count[layer] += 1;
                }
            }
            low = high;
        }
    }
    for (gradient, count) in row.iter_mut().zip(count) {
        *gradient /= f64::from(count.max(1));
    }
}
