//! Which dimension of a model's array is which: layers, columns, blocks.

use crate::error::{Error, ErrorKind, Result};
use crate::shape::Shape;

/// One dimension of an array: its size, and the elements from one index to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimension {
    /// Number of indices.
    pub extent: usize,
    /// Elements from one index to the next; may be negative.
    pub stride: isize,
}

impl Shape {
    /// Finds the layers and columns among `dimensions` of an array for a field with one of `columns` and on `layers`
    /// interfaces or full levels, or midway between them (one fewer).
    ///
    /// Dimensions of extent 1 do not count. Of one dimension, rows of layers follow one another. Of two, one holds the
    /// layers, the other the columns. Of three, one holds the layers, and the others, in order, the columns of a block and
    /// the blocks, none of which is empty. Where several readings fit, that with as many layers as `layers` comes before that with one fewer, then
    /// layers in the second of three or the first of two before others. The dimension of columns may be longer than needed.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] names the extents and what was expected.
    pub fn of_dimensions(dimensions: &[Dimension], columns: usize, layers: usize) -> Result<Self> {
        let kept: Vec<Dimension> = dimensions.iter().copied().filter(|d| d.extent != 1).collect();
        let counts = [Some(layers), layers.checked_sub(1).filter(|n| *n > 1)];
        let fits = counts.into_iter().flatten().find_map(|layers| read(&kept, columns, layers));
        fits.ok_or_else(|| {
            let extents: Vec<usize> = dimensions.iter().map(|d| d.extent).collect();
            let fewer = counts[1].map_or_else(String::new, |n| format!(" or {n} (midway between them)"));
            let message = format!(
                "an array of extents {extents:?}, expected one dimension of {layers} layers{fewer} and one or two \
                 others that hold {columns} columns"
            );
            Error::new(ErrorKind::Field, message)
        })
    }
}

/// The reading with just `layers` layers, if there is one.
fn read(dimensions: &[Dimension], columns: usize, layers: usize) -> Option<Shape> {
    let flat =
        Shape { columns, layers, offset: 0, column_stride: 0, layer_stride: 0, block: 0, block_stride: 0 };
    match *dimensions {
        [all] => {
            // Of no columns, the one beyond the last that MPAS's arrays have.
            let is_spare = columns == 0 && all.extent == layers;
            (is_spare || all.extent == columns.checked_mul(layers)?).then_some(Shape {
                column_stride: all.stride.checked_mul(isize::try_from(layers).ok()?)?,
                layer_stride: all.stride,
                ..flat
            })
        }
        [a, b] => {
            let reading = |level: Dimension, column: Dimension| {
                (level.extent == layers && column.extent >= columns).then_some(Shape {
                    column_stride: column.stride,
                    layer_stride: level.stride,
                    ..flat
                })
            };
            reading(a, b).or_else(|| reading(b, a))
        }
        [a, b, c] => {
            let reading = |level: Dimension, column: Dimension, block: Dimension| {
                // Each block is needed: otherwise the two are something else, such as tracers or time levels and cells.
                let full = block.extent.saturating_sub(1);
                let holds = column.extent.checked_mul(block.extent)? >= columns
                    && (block.extent == 0 || column.extent.checked_mul(full)? < columns);
                (level.extent == layers && holds).then_some(Shape {
                    column_stride: column.stride,
                    layer_stride: level.stride,
                    block: column.extent,
                    block_stride: block.stride,
                    ..flat
                })
            };
            reading(b, a, c).or_else(|| reading(a, b, c)).or_else(|| reading(c, a, b))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A whole Fortran array: the first dimension is the fastest.
    fn fortran(extents: &[usize]) -> Vec<Dimension> {
        let mut stride = 1;
        extents
            .iter()
            .map(|&extent| {
                let dimension = Dimension { extent, stride };
                stride *= extent as isize;
                dimension
            })
            .collect()
    }

    /// Element of value (column, layer).
    fn element(s: &Shape, column: usize, layer: usize) -> isize {
        let (inner, outer) = if s.block == 0 { (column, 0) } else { (column % s.block, column / s.block) };
        inner as isize * s.column_stride + outer as isize * s.block_stride + layer as isize * s.layer_stride
    }

    #[test]
    fn the_layouts_of_models_are_found() {
        let (columns, layers) = (42, 5);
        let shape = |extents: &[usize]| Shape::of_dimensions(&fortran(extents), columns, layers).unwrap();
        let level_fastest = |c: usize, l: usize| (c * 5 + l) as isize;
        for (extents, expected) in [
            (vec![5, 42], &level_fastest as &dyn Fn(usize, usize) -> isize),
            (vec![5, 43], &level_fastest),
            (vec![1, 5, 43, 1], &level_fastest),
            (vec![210], &level_fastest),
            (vec![42, 5], &|c, l| (l * 42 + c) as isize),
            (vec![50, 5], &|c, l| (l * 50 + c) as isize),
            (vec![16, 5, 3], &|c, l| (c % 16 + 16 * l + 80 * (c / 16)) as isize),
            (vec![5, 16, 3], &|c, l| (l + 5 * (c % 16) + 80 * (c / 16)) as isize),
            (vec![16, 3, 5], &|c, l| (c % 16 + 16 * (c / 16) + 48 * l) as isize),
        ] {
            let shape = shape(&extents);
            assert_eq!((shape.columns, shape.layers), (42, 5), "{extents:?}");
            for (c, l) in [(0, 0), (1, 0), (0, 1), (17, 3), (41, 4)] {
                assert_eq!(element(&shape, c, l), expected(c, l), "{extents:?} {c} {l}");
            }
        }
        assert_eq!(shape(&[4, 42]).layers, 4, "midway between the layers");
        // Both readings fit a small grid: as many layers as given come first, then the first dimension.
        let both = |extents: &[usize]| Shape::of_dimensions(&fortran(extents), 4, 5).unwrap();
        assert_eq!((both(&[4, 5]).layers, both(&[4, 5]).layer_stride), (5, 4));
        assert_eq!((both(&[5, 5]).layers, both(&[5, 5]).layer_stride), (5, 1));
    }

    #[test]
    fn strides_are_kept_as_they_are() {
        let section = [Dimension { extent: 5, stride: -3 }, Dimension { extent: 42, stride: 700 }];
        let shape = Shape::of_dimensions(&section, 42, 5).unwrap();
        assert_eq!((shape.layer_stride, shape.column_stride, shape.block), (-3, 700, 0));
    }

    #[test]
    fn a_rank_without_cells_has_arrays_without_columns() {
        for extents in
            [vec![5, 0], vec![5, 1], vec![0, 5], vec![0], vec![16, 5, 0], vec![5, 16, 0], vec![0, 5, 0]]
        {
            let shape = Shape::of_dimensions(&fortran(&extents), 0, 5).unwrap();
            assert_eq!((shape.columns, shape.layers), (0, 5), "{extents:?}");
        }
        assert!(Shape::of_dimensions(&fortran(&[16, 5, 2]), 0, 5).is_err());
        assert!(Shape::of_dimensions(&fortran(&[16, 5, 0]), 42, 5).is_err());
    }

    #[test]
    fn what_fits_no_reading_is_refused_with_its_extents() {
        for extents in [
            // Tracers or time levels beside: a section of them is a field.
            vec![3, 5, 42],
            vec![5, 42, 2],
            vec![42, 5, 3],
            vec![],
            vec![41, 5],
            vec![3, 42],
            vec![209],
            vec![16, 5, 2],
            vec![2, 5, 3, 7],
            vec![1, 1],
        ] {
            let error = Shape::of_dimensions(&fortran(&extents), 42, 5).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Field);
            let text = error.to_string();
            assert!(text.contains(&format!("{extents:?}")) && text.contains("42 columns"), "{text}");
        }
        let overflow = [Dimension { extent: usize::MAX, stride: 1 }, Dimension { extent: 5, stride: 1 }];
        assert!(Shape::of_dimensions(&[overflow[0], overflow[1], overflow[0]], 42, 5).is_err());
    }
}
