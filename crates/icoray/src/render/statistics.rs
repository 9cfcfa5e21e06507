//! Statistics of a field's values over all ranks.

use super::renderer::Renderer;
use crate::ranges::{added, both_ranges};
use crate::ranks::{Decomposition, Ranks};
use icoray_grid::{Field, Result};
use icoray_scene::{Statistic, Summary};
use serde::Serialize;
use serde::de::DeserializeOwned;

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
    /// The statistics `asked` of a field, bitwise equal on all ranks, and so are decisions based on them. With the
    /// decomposition `decomposition` they cover the values of all ranks, each once; if every rank has the whole field
    /// they are rank 0's. Collective.
    ///
    /// # Errors
    /// Equal on all ranks: [`ErrorKind::Field`](icoray_grid::ErrorKind::Field) if a field does not have the columns of
    /// its rank; [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when the transport fails.
    pub fn summary(
        &self,
        ranks: &mut Ranks,
        field: &Field,
        decomposition: Option<&Decomposition>,
        asked: &[Statistic],
    ) -> Result<Summary> {
        let of = |is_own: Option<IsOwn>| Summary::of(field, is_own, asked);
        self.reduce_columns(ranks, field, decomposition, Summary::NOTHING, of, Summary::joined)
    }

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
        let range = |is_own: Option<IsOwn>| field.range_over(is_own);
        let (range, missing) = self.reduce_columns(ranks, field, decomposition, (None, 0), range, both_ranges)?;
        let none = vec![0; bins];
        let Some(ends) = range else { return Ok(Histogram { range, counts: none, missing }) };
        let counts = |is_own: Option<IsOwn>| field.histogram_over(ends, bins, is_own);
        let counts = self.reduce_columns(ranks, field, decomposition, none, counts, added)?;
        Ok(Histogram { range, counts, missing })
    }

    /// What `of` returns for the own columns of all ranks, joined by `join`; rank 0's for all columns if every rank has
    /// the whole field. Collective.
    fn reduce_columns<T: Serialize + DeserializeOwned + Send>(
        &self,
        ranks: &mut Ranks,
        field: &Field,
        decomposition: Option<&Decomposition>,
        nothing: T,
        of: impl FnOnce(Option<IsOwn>) -> T + Send,
        join: impl Fn(T, T) -> T,
    ) -> Result<T> {
        let is_counted = decomposition.is_some() || ranks.is_root();
        let mine = || {
            let own = decomposition.map(|decomposition| decomposition.own_columns(field)).transpose()?;
            let is_own = own.as_ref().map(|own| |column: usize| own[column]);
            Ok(if is_counted { self.run(|| of(is_own.as_ref().map(|is_own| is_own as _))) } else { nothing })
        };
        ranks.reduce_work(mine, join)
    }
}

/// Whether a column is this rank's own.
type IsOwn<'c> = &'c (dyn Fn(usize) -> bool + Sync);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::{icosahedral, level_fastest, on_ranks, over_columns};
    use crate::spread::Rows;
    use icoray_grid::{Error, ErrorKind, Grid, Location};

    const ASKED: [Statistic; 3] = [Statistic::Min, Statistic::Max, Statistic::Mean];
    const LAYERS: usize = 3;

    /// Results of `make` on each of some ranks; each has a part or some columns of a field, or the whole of it.
    fn over<T: Send>(ranks: usize, make: impl Fn(&mut Ranks, &Grid) -> T + Sync) -> Vec<T> {
        let (_, grid) = icosahedral(2);
        on_ranks(ranks, |ranks| make(ranks, &grid))
    }

    /// A rank's number in each of its own columns, and what must not count in the others.
    fn values(columns: usize, rank: usize, is_own: impl Fn(usize) -> bool) -> Vec<f32> {
        over_columns(columns, LAYERS, |column, _| if is_own(column) { rank as f32 } else { 1e9 })
    }

    fn summary_of(
        ranks: &mut Ranks,
        values: &[f32],
        at: Location,
        decomposition: Option<&Decomposition>,
    ) -> Result<Summary> {
        let field = level_fastest(values, LAYERS, at);
        Renderer::new(1).unwrap().summary(ranks, &field, decomposition, &ASKED)
    }

    /// Parts of the whole grid, of stretches of its cells.
    fn parts(ranks: &mut Ranks, grid: &Grid) -> Decomposition {
        let is_own = |cell: usize| cell * ranks.size() / grid.cells() == ranks.rank();
        let rows = Rows::new((0..grid.cells()).collect(), |cell| cell as i64, is_own);
        Decomposition::new(ranks, grid, &rows.cells()).unwrap()
    }

    fn numbers(summaries: Vec<Result<Summary>>) -> [f64; 3] {
        let all: Vec<Summary> = summaries.into_iter().map(Result::unwrap).collect();
        assert!(all.iter().all(|summary| *summary == all[0]), "the same on all ranks");
        ASKED.map(|statistic| all[0].get(statistic).unwrap())
    }

    #[test]
    fn values_of_several_ranks_count_once() {
        for location in [Location::Center, Location::Corner] {
            let found = over(3, |ranks, grid| {
                let decomposition = parts(ranks, grid);
                let columns = if location == Location::Center { grid.cells() } else { grid.triangles() };
                let number = ranks.rank();
                let zeros = vec![0.0f32; columns];
                let is_own = decomposition.own_columns(&level_fastest(&zeros, 1, location)).unwrap();
                let values = values(columns, number, |column| is_own[column]);
                let own = values.iter().filter(|value| **value < 1e9).count();
                ([own, own * number], summary_of(ranks, &values, location, Some(&decomposition)))
            });
            let (sums, found): (Vec<_>, Vec<_>) = found.into_iter().unzip();
            let [count, sum] = [0, 1].map(|k| sums.iter().map(|sums: &[usize; 2]| sums[k] as f64).sum::<f64>());
            let [low, high, mean] = numbers(found);
            assert_eq!((low, high), (0.0, 2.0));
            assert!((mean - sum / count).abs() < 1e-12, "{location:?}: {mean}");
        }
    }

    #[test]
    fn columns_count_where_they_are_own() {
        let found = over(2, |ranks, grid| {
            // All but one of the columns on rank 0, with one that is not its own, and that one on rank 1.
            let rank = ranks.rank();
            let cells = if rank == 0 { (0..grid.cells()).collect() } else { vec![4] };
            let rows = Rows::new(cells, |cell| cell as i64, |cell| (cell == 4) == (rank == 1));
            let decomposition = Decomposition::new(ranks, grid, &rows.cells()).unwrap();
            assert!(matches!(decomposition, Decomposition::Columns(_)));
            let values = values(rows.rows.len(), 7 * rank, |column| rows.owned[column] == 1);
            summary_of(ranks, &values, Location::Center, Some(&decomposition))
        });
        let cells = 10.0 * 16.0 + 2.0;
        assert_eq!(numbers(found), [0.0, 7.0, 7.0 / cells]);
    }

    #[test]
    fn all_ranks_have_the_summary_of_rank_0() {
        // Every rank continues after any outcome on the others.
        let found = over(3, |ranks, _| {
            let values = values(4, ranks.rank() + 1, |_| true);
            summary_of(ranks, &values, Location::Center, None)
        });
        assert_eq!(numbers(found), [1.0; 3]);
    }

    #[test]
    fn a_field_that_does_not_fit_on_one_rank_is_refused_on_all() {
        let found = over(3, |ranks, grid| {
            let decomposition = parts(ranks, grid);
            let columns = grid.cells() - ranks.rank() / 2;
            let values = values(columns, 1, |_| true);
            summary_of(ranks, &values, Location::Center, Some(&decomposition))
        });
        for error in found.into_iter().map(Result::unwrap_err) {
            assert_eq!(error.kind(), ErrorKind::Field);
            assert_eq!(error.context(), "rank 2: 161 columns, expected 162, as many as this rank has");
        }
    }

    #[test]
    fn each_value_counts_once_on_any_number_of_ranks() {
        let cells = 162;
        let value = |cell: usize, layer: usize| match (cell + layer) % 7 {
            0 => f32::NAN,
            rest => (rest * 100 + cell) as f32,
        };
        let values = over_columns(cells, LAYERS, value);
        let field = level_fastest(&values, LAYERS, Location::Center);
        let renderer = Renderer::new(1).unwrap();
        let alone = renderer.histogram(&mut Ranks::alone(), &field, None, 16).unwrap();
        let known = values.iter().filter(|value| !value.is_nan()).count() as u64;
        assert_eq!((alone.counts.iter().sum::<u64>(), alone.missing), (known, (cells * LAYERS) as u64 - known));
        assert!(alone.counts[0] > 0 && alone.counts[15] > 0);

        for is_decomposed in [false, true] {
            let found = over(3, |ranks, grid| {
                let decomposition = is_decomposed.then(|| parts(ranks, grid));
                renderer.histogram(ranks, &field, decomposition.as_ref(), 16).unwrap()
            });
            assert!(found.iter().all(|found| *found == alone), "{is_decomposed}");
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
