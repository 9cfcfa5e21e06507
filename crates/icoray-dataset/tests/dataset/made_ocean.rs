//! Synthetic files of MPAS-Ocean.

use crate::made::{LAYERS, Made, RECORDS, Values};

/// Depth of each layer's bottom where the ocean is deep enough.
pub const DEPTH_M: [f64; LAYERS] = [10.0, 30.0, 100.0, 500.0];

/// How many layers a cell has: all, or fewer where the sea is shallow, or none.
pub fn levels(cell: usize) -> usize {
    match cell {
        7 => 0,
        cell if cell % 5 == 0 => 2,
        _ => LAYERS,
    }
}

impl Made {
    /// A history of temperature, salinity at interfaces and vorticity at corners; below the sea floor all hold -1e34,
    /// which no attribute declares. The shallow cells' last layer is 1 m thinner.
    pub fn ocean() -> Self {
        let mut made = Made::history();
        made.remove("zgrid");
        let cells = made.dimension("nCells");
        for name in ["theta", "rho", "w", "vorticity"] {
            let variable = made.variable(name);
            variable.attributes.clear();
            let row = if name == "w" { LAYERS + 1 } else { LAYERS };
            let is_dry = |i: usize| {
                let (cell, layer) = (i / row % cells, i % row);
                name != "vorticity" && (levels(cell) == 0 || layer >= levels(cell) + usize::from(name == "w"))
            };
            match &mut variable.values {
                Values::F32(v) => (0..v.len()).filter(|&i| is_dry(i)).for_each(|i| v[i] = -1e34),
                Values::F64(v) => (0..v.len()).filter(|&i| is_dry(i)).for_each(|i| v[i] = -1e34),
                _ => panic!("{name} is real"),
            }
        }
        made.add("maxLevelCell", &["nCells"], Values::I32((0..cells).map(|c| levels(c) as i32).collect()));
        made
    }

    pub fn with_thickness(mut self, name: &'static str, dimensions: &[&'static str]) -> Self {
        let cells = self.dimension("nCells");
        let thickness = |cell: usize, layer: usize| {
            let full = DEPTH_M[layer] - if layer == 0 { 0.0 } else { DEPTH_M[layer - 1] };
            let is_last = levels(cell) < LAYERS && layer + 1 == levels(cell);
            if layer >= levels(cell) { -1e34 } else { full - f64::from(u8::from(is_last)) }
        };
        let one = (0..cells).flat_map(|c| (0..LAYERS).map(move |l| thickness(c, l)));
        let records = if dimensions.len() == 3 { RECORDS } else { 1 };
        let all: Vec<f64> = std::iter::repeat_n(one.collect::<Vec<_>>(), records).flatten().collect();
        self.add(name, dimensions, Values::F64(all));
        let depth = (0..cells).map(|cell| (0..levels(cell)).map(|layer| thickness(cell, layer)).sum());
        self.add("bottomDepth", &["nCells"], Values::F64(depth.collect()));
        self
    }
}
