//! Heights at corners, which are averaged to cells like fields at corners.

use super::{check_column, check_shape};
use crate::error::Result;
use crate::field::{Field, Location};
use crate::grid::Grid;
use crate::layers::Layers;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Checks `heights` at corners, in metres above the planet's surface: one column for each corner of `grid`, as many
/// layers as `layers`. Checks the columns that enter the averages
/// ([`ComputedField::average`](crate::ComputedField::average)) of cells for which `owns` is true. Averages of heights that
/// pass do not decrease upwards either: all or no heights of each column are averaged. Parallel.
///
/// # Errors
/// [`ErrorKind::Layers`](crate::ErrorKind::Layers) if they have another shape or place, or names the first column of
/// which some heights but not all are missing, or decrease upwards.
pub fn check_corners(grid: &Grid, heights: &Field, layers: &Layers, owns: impl Fn(usize) -> bool + Sync) -> Result<()> {
    // Other columns may not have been computed by any rank.
    let is_read: Vec<AtomicBool> = (0..grid.triangles()).map(|_| AtomicBool::new(false)).collect();
    (0..grid.cells()).into_par_iter().with_min_len(256).filter(|cell| owns(*cell)).for_each(|cell| {
        grid.corners_of(cell as u32).for_each(|corner| is_read[corner as usize].store(true, Ordering::Relaxed));
    });
    check_corner_columns(grid, heights, layers, |corner| is_read[corner].load(Ordering::Relaxed))
}

/// [`check_corners`] of the columns of the corners for which `is_read` is true.
///
/// # Errors
/// As [`check_corners`].
pub fn check_corner_columns(
    grid: &Grid,
    heights: &Field,
    layers: &Layers,
    is_read: impl Fn(usize) -> bool + Sync,
) -> Result<()> {
    let corners = grid.triangles();
    check_shape(heights, layers, corners, Location::Corner)?;
    let (count, base) = (layers.count(), grid.tables().index_base);
    let given = |layer: usize| if layers.is_falling() { count - 1 - layer } else { layer };
    let name = |corner: usize| format!("corner {} (counted from {base})", corner as i64 + i64::from(base));
    let error = (0..corners).into_par_iter().with_min_len(256).find_map_first(|corner| {
        let height = |layer| heights.value(corner, given(layer));
        is_read(corner).then(|| check_column(layers, height, || name(corner)).err()).flatten()
    });
    error.map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorKind;
    use crate::field::ComputedField;
    use crate::grid::icosahedral_grid;
    use crate::heights::Heights;
    use crate::shape::Shape;

    const LAYERS: usize = 3;
    const FILL: f64 = -9999.0;

    fn layers(falling: bool) -> Layers {
        let mean = if falling { [9e3, 2e3, 0.0] } else { [0.0, 2e3, 9e3] };
        Layers::from_heights(&mean, 6.4e6).unwrap()
    }

    /// Steep columns, a third of which have no thickness between two layers.
    fn values(corners: usize) -> Vec<f64> {
        let column = |corner: usize| {
            let ground = (corner * 37 % 500) as f64;
            [ground, if corner.is_multiple_of(3) { ground } else { 2e3 + ground / 3.0 }, 9e3 + ground / 7.0]
        };
        (0..corners).flat_map(column).collect()
    }

    fn field(values: &[f64]) -> Field<'_> {
        let shape = Shape::level_fastest(values.len() / LAYERS, LAYERS);
        Field::new(values.into(), shape, Location::Corner, Some(FILL)).unwrap()
    }

    fn refusal(grid: &Grid, values: &[f64], falling: bool, owns: impl Fn(usize) -> bool + Sync) -> String {
        let error = check_corners(grid, &field(values), &layers(falling), owns).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Layers);
        error.context().to_owned()
    }

    #[test]
    fn bad_heights_are_named_by_the_first_corner_that_is_read() {
        let grid = icosahedral_grid(2);
        let good = values(grid.triangles());
        check_corners(&grid, &field(&good), &layers(false), |_| true).unwrap();
        let mut bad = good.clone();
        bad[3 * 9 + 1] = -5e3;
        bad[3 * 7 + 2] = -1e3;
        let all = refusal(&grid, &bad, false, |_| true);
        assert!(
            all.starts_with("heights: corner 7 (counted from 0), layers 3 and 2 of 3: -1000 m lies below "),
            "{all}"
        );
        // Averages of other cells do not read corner 7.
        let around = grid.triangle(7);
        let others = refusal(&grid, &bad, false, |cell| !around.contains(&(cell as u32)));
        assert!(others.starts_with("heights: corner 9 (counted from 0), layers 2 and 1 of 3: -5000 m"), "{others}");
        for mark in [FILL, f64::NAN, f64::INFINITY] {
            let mut bad = good.clone();
            bad[3 * 4 + 1] = mark;
            let text = refusal(&grid, &bad, true, |_| true);
            assert!(text.contains("corner 0 (counted from 0), layers 2 and 3 of 3"), "they rise: {text}");
            bad.chunks_exact_mut(LAYERS).for_each(<[f64]>::reverse);
            let text = refusal(&grid, &bad, true, |_| true);
            assert!(text.starts_with("heights: corner 4 (counted from 0), layer 2 of 3: missing, but "), "{text}");
        }
    }

    /// Whichever columns have no heights: an average is of whole columns.
    #[test]
    fn averages_of_valid_heights_are_valid() {
        let grid = icosahedral_grid(2);
        for every in [2, 3, 5, usize::MAX] {
            let mut values = values(grid.triangles());
            for (corner, column) in values.chunks_exact_mut(LAYERS).enumerate() {
                if corner % every == 1 || grid.corners_of(17).any(|c| c as usize == corner) {
                    column.fill(FILL);
                }
            }
            check_corners(&grid, &field(&values), &layers(false), |_| true).unwrap();
            let average = ComputedField::average(&grid, &field(&values)).unwrap();
            let heights = Heights::new(&average.field(), &layers(false), &grid, LAYERS, 50.0).unwrap();
            let mean = layers(false).shell(50.0).unwrap();
            assert_eq!([0, 1, 2].map(|layer| heights.radius(17, layer)), mean[..], "it has no heights around it");
        }
    }

    #[test]
    fn heights_of_another_shape_or_place_are_refused() {
        let grid = icosahedral_grid(1);
        let values = vec![0.0; 100 * LAYERS];
        for (columns, count, place) in
            [(79, LAYERS, Location::Corner), (80, LAYERS - 1, Location::Corner), (80, LAYERS, Location::Center)]
        {
            let field = Field::new(values[..].into(), Shape::level_fastest(columns, count), place, None).unwrap();
            let error = check_corners(&grid, &field, &layers(false), |_| true).unwrap_err();
            let expected =
                format!("heights: {columns} columns of {count} layers at {place:?}, expected 80 of 3 at Corner");
            assert_eq!((error.kind(), error.context()), (ErrorKind::Layers, expected.as_str()));
        }
    }
}
