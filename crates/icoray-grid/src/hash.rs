//! Hashes of tables and fields, by which ranks detect that their data differ, and steps that values have changed.

use rayon::prelude::*;

/// 2^64 over the golden ratio, rounded to an odd number: its multiples are spread evenly over 64 bits.
pub(crate) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Contribution of number `i` of a sequence to its hash, which is the sum of all: equal in any order and on any number
/// of threads. The mixing is that of SplitMix64 (Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195).
pub(crate) fn term(i: usize, number: u64) -> u64 {
    let mut bits = number ^ (i as u64 + 1).wrapping_mul(GOLDEN);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

/// The bits of a value; all NaN have the same bits, and -0 has those of 0.
pub(crate) fn bits(value: f64) -> u64 {
    (value + 0.0).to_bits()
}

/// Hash of `count` numbers, in parallel.
pub(crate) fn of(count: usize, number: impl Fn(usize) -> u64 + Sync + Send) -> u64 {
    let terms = (0..count).into_par_iter().with_min_len(1 << 16).map(|i| term(i, number(i)));
    terms.reduce(|| 0, u64::wrapping_add)
}

#[cfg(test)]
mod tests {
    use crate::{Field, Grid, GridTables, IcosahedralMesh, Location, Shape};

    #[test]
    fn a_field_has_the_hash_of_its_values() {
        let (columns, layers) = (500, 4);
        let level = Shape::level_fastest(columns, layers);
        let values: Vec<f64> = (0..columns * layers).map(|i| (i as f64 * 0.37).sin()).collect();
        let turned: Vec<f64> = (0..values.len()).map(|i| values[i % columns * layers + i / columns]).collect();
        for samples in [values.len(), 300] {
            let hash = |values: &[f64], shape: Shape| {
                Field::new(values.into(), shape, Location::Center, Some(7.0)).unwrap().hash_of_samples(samples)
            };
            let with = |first: f64| hash(&[&[first; 1000], &values[1000..]].concat(), level);
            assert_eq!(hash(&turned, Shape::cell_fastest(columns, layers)), hash(&values, level), "another layout");
            assert_ne!(hash(&values.iter().rev().copied().collect::<Vec<_>>(), level), hash(&values, level));
            assert_eq!(with(0.0), with(-0.0));
            let missing = [7.0, f64::from_bits(f64::NAN.to_bits() ^ 5), f64::INFINITY];
            assert_eq!(missing.map(with), [with(f64::NAN); 3]);
            assert_ne!(with(0.0), with(f64::NAN));
        }
    }

    #[test]
    fn each_table_has_a_hash_of_its_own() {
        let mesh = IcosahedralMesh::new(3).unwrap();
        let counts: Vec<i32> = (0..mesh.cells()).map(|cell| if cell < 12 { 5 } else { 6 }).collect();
        let hashes = |mesh: &IcosahedralMesh| {
            let tables = GridTables { cell_corner_count: Some(counts.as_slice().into()), ..mesh.tables() };
            *Grid::new(tables).unwrap().table_hashes()
        };
        let expected = hashes(&mesh);
        let wide: Vec<i64> = mesh.corner_cell.iter().map(|number| i64::from(*number)).collect();
        let tables = GridTables { corner_cell: wide.as_slice().into(), ..mesh.tables() };
        assert_eq!(Grid::new(tables).unwrap().table_hashes(), Grid::new(mesh.tables()).unwrap().table_hashes());
        type Change = fn(&mut IcosahedralMesh);
        let changes: [(Change, &[&str]); 6] = [
            (|mesh| mesh.lat_center_rad[9] += 1e-9, &["center"]),
            (|mesh| mesh.lon_corner_rad[9] += 1e-9, &["corner"]),
            (|mesh| mesh.cell_corner[120..126].rotate_left(1), &["cell_corner"]),
            (|mesh| mesh.corner_cell[30..33].rotate_left(1), &["corner_cell"]),
            (|mesh| mesh.edge_corner.swap(8, 9), &["edge_corner"]),
            // It does not count.
            (|mesh| mesh.cell_corner[5] = 99, &[]),
        ];
        for (change, tables) in changes {
            let mut mesh = mesh.clone();
            change(&mut mesh);
            let found = hashes(&mesh);
            let differ = found.iter().zip(&expected).filter(|(one, other)| one != other);
            assert_eq!(differ.map(|((name, _), _)| *name).collect::<Vec<_>>(), tables);
        }
    }
}
