//! Histograms of a field's values over all ranks.

use super::renderer::Renderer;
use crate::ranges::union;
use crate::ranks::{Decomposition, Ranks};
use icoray_grid::{Field, Result};

/// The distribution of a field's values.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Least and greatest value; `None` where all are missing.
    pub range: Option<[f64; 2]>,
    /// Numbers of values in equal parts of the range.
    pub counts: Vec<u64>,
    /// Number of values that are NaN, infinite or the fill value.
    pub missing: u64,
}

impl Renderer {
    /// The histogram of a field's values in `bins` parts of their range, equal on all ranks. With the decomposition
    /// `decomposition` it counts the values of all ranks, each once; if every rank has the whole field it is rank 0's.
    /// Collective.
    ///
    /// # Errors
    /// Equal on all ranks: [`ErrorKind::Field`](icoray_grid::ErrorKind::Field) if a field does not have the columns of
    /// its rank; [`ErrorKind::Internal`](icoray_grid::ErrorKind::Internal) if one of several ranks panicked;
    /// [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when the transport fails.
    pub fn histogram(
        &self,
        ranks: &mut Ranks,
        field: &Field,
        decomposition: Option<&Decomposition>,
        bins: usize,
    ) -> Result<Histogram> {
        let own = ranks.attempt(|| decomposition.map(|decomposition| decomposition.own_columns(field)).transpose());
        let own = ranks.collective(own)?;
        let is_own = own.as_ref().map(|own| |column: usize| own[column]);
        let counts = is_own.as_ref().map(|is_own| is_own as _);
        // Rank 0's own if it has the whole field, else those of the own columns of all ranks.
        let is_counted = decomposition.is_some() || ranks.is_root();
        let mine = || Ok(if is_counted { self.run(|| field.range_over(counts)) } else { (None, 0) });
        let (range, missing) = ranks.reduce_work(mine, |(a, missing), (b, others)| (union(a, b), missing + others))?;
        let Some(range) = range else {
            return Ok(Histogram { range, counts: vec![0; bins], missing });
        };
        let mine =
            || Ok(if is_counted { self.run(|| field.histogram_over(range, bins, counts)) } else { vec![0; bins] });
        let counts = ranks.reduce_work(mine, |mut counts: Vec<u64>, others| {
            counts.iter_mut().zip(others).for_each(|(count, other)| *count += other);
            counts
        })?;
        Ok(Histogram { range: Some(range), counts, missing })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranks::tests::on_ranks;
    use crate::ranks::{Owned, PartCells};
    use icoray_grid::{Error, ErrorKind, Grid, IcosahedralMesh, Location};

    #[test]
    fn each_value_counts_once_on_any_number_of_ranks() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        let (cells, layers) = (grid.cells(), 3);
        let value = |cell: usize, layer: usize| match (cell + layer) % 7 {
            0 => f32::NAN,
            rest => (rest * 100 + cell) as f32,
        };
        let values: Vec<f32> = (0..cells * layers).map(|at| value(at / layers, at % layers)).collect();
        let field = Field::level_fastest(&values, layers, Location::Center).unwrap();
        let renderer = Renderer::new(1).unwrap();
        let alone = renderer.histogram(&mut Ranks::alone(), &field, None, 16).unwrap();
        let known = values.iter().filter(|value| !value.is_nan()).count() as u64;
        assert_eq!((alone.counts.iter().sum::<u64>(), alone.missing), (known, (cells * layers) as u64 - known));
        assert!(alone.counts[0] > 0 && alone.counts[15] > 0);

        let global: Vec<i64> = (0..cells as i64).collect();
        let over = |is_decomposed: bool| {
            on_ranks(3, |ranks| {
                let is_own = |cell: usize| cell * ranks.size() / cells == ranks.rank();
                let marks: Vec<i32> = (0..cells).map(|cell| is_own(cell).into()).collect();
                let said = PartCells { global: global.as_slice().into(), owned: Owned::Marked(&marks) };
                let decomposition = is_decomposed.then(|| Decomposition::new(ranks, &grid, &said).unwrap());
                renderer.histogram(ranks, &field, decomposition.as_ref(), 16).unwrap()
            })
        };
        for is_decomposed in [false, true] {
            assert!(over(is_decomposed).iter().all(|found| *found == alone), "{is_decomposed}");
        }
    }

    /// Without any bin, values cannot be counted.
    #[test]
    fn a_panic_of_one_rank_is_the_error_of_all() {
        let field = Field::level_fastest(&[1.0f32, 2.0][..], 2, Location::Center).unwrap();
        let renderer = Renderer::new(1).unwrap();
        let found = on_ranks(2, |ranks| {
            let found = Error::of_panics(|| renderer.histogram(ranks, &field, None, 16 * ranks.rank()));
            // A rank that has an error alone would leave the other one waiting: the test is to fail, not to wait.
            if found.as_ref().is_err_and(|error| !error.context().starts_with("rank ")) {
                ranks.reduce_values(Vec::<u64>::new(), |a, _| a).unwrap();
            }
            found
        });
        for error in found.into_iter().map(Result::unwrap_err) {
            assert_eq!(error.kind(), ErrorKind::Internal);
            assert!(error.context().starts_with("rank 0: "), "{error}");
        }
    }
}
