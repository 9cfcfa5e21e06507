//! Identifies the dimensions of a model's array: layers, columns, blocks.

use crate::error::{Error, ErrorKind, Result};
use crate::field::Location;
use crate::grid::Grid;
use crate::shape::Shape;

/// Maximum number of elements by which a dimension of columns may be longer than its grid: MPAS allocates one more,
/// rows end at a multiple of a cache line or a vector register. A halo that the grid does not have is no padding.
const MAX_PADDING: usize = 64;

/// One dimension of an array: its size, and the elements from one index to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimension {
    /// Number of indices.
    pub extent: usize,
    /// Elements from one index to the next; may be negative.
    pub stride: isize,
}

/// The number of columns of a field over a grid, and the other counts of the grid: an array of another length is
/// compared with these for the error message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColumnCount {
    /// Number of columns that are expected.
    pub columns: usize,
    /// Cells of the grid.
    pub cells: usize,
    /// Corners of the grid.
    pub corners: usize,
    /// Edges of the grid.
    pub edges: usize,
}

impl ColumnCount {
    /// The counts for a field at `location` that has all columns of `grid`.
    pub fn new(grid: &Grid, location: Location) -> Self {
        let (cells, corners) = (grid.cells(), grid.triangles());
        let columns = if location == Location::Center { cells } else { corners };
        ColumnCount { columns, cells, corners, edges: grid.tables().edges() }
    }

    /// Whether a dimension of `extent` indices contains the columns and at most padding. It may be any longer if it
    /// `is_block`, the only block of ICON's nproma columns.
    fn fits_in(&self, extent: usize, is_block: bool) -> bool {
        let Some(padding) = extent.checked_sub(self.columns) else { return false };
        padding <= 1 || (self.look_alike(extent).is_none() && (is_block || padding <= MAX_PADDING))
    }

    /// The other count of the grid that equals `extent` or `extent - 1` (MPAS allocates one more), and the advice for
    /// the user; `None` for the expected count.
    fn look_alike(&self, extent: usize) -> Option<(&'static str, &'static str)> {
        let is_like = |count: usize| count > 0 && count != self.columns && [count, count + 1].contains(&extent);
        if is_like(self.cells) {
            let is_of_corners = self.columns == self.corners;
            let advice = if is_of_corners { "set location = ICORAY_CENTER" } else { "expected this rank's columns" };
            return Some(("cells", advice));
        }
        if is_like(self.corners) {
            return Some(("corners", "set location = ICORAY_CORNER"));
        }
        is_like(self.edges).then_some(("edges", "fields at edges are not drawn; average them to cells"))
    }

    /// The count of the grid that `extent` matches instead of the expected one, as text; `None` if it matches none.
    pub fn explain(&self, extent: usize) -> Option<String> {
        if extent == self.columns {
            return None;
        }
        let (what, advice) = self.look_alike(extent)?;
        Some(format!("{extent} columns are the grid's {what}: {advice}"))
    }

    /// The error of a field called `name` that has `extent` columns, each of which is one for a `place`.
    pub fn error(&self, extent: usize, place: &str) -> Error {
        let why = self.explain(extent).map_or_else(String::new, |why| format!(" ({why})"));
        let message = format!("{extent} columns, expected {}, one {place}{why}", self.columns);
        Error::new(ErrorKind::Field, message)
    }
}

impl Shape {
    /// Finds the layers and columns among `dimensions` of an array for a field with `expected.columns` columns and on
    /// `layers` interfaces or full levels, or midway between them (one fewer).
    ///
    /// Dimensions of extent 1 are ignored. With one dimension, rows of layers follow one another. With two, one
    /// contains the layers, the other the columns. With three, one contains the layers, and the others, in order, the
    /// columns of a block and the blocks, none of which is empty. An array with only columns is a 2D field, of one
    /// layer. If several readings fit, that with as many layers as `layers` precedes that with one fewer, then layers
    /// in the second of three or the first of two precede others.
    ///
    /// The dimension of columns may be longer by padding, at most 64, but not as long as the grid has corners or edges
    /// (or cells, for a field at corners), or one more. If a dimension of extent 1 comes after the first, as the only
    /// block of `(nproma, layers, 1)`, it may be any longer.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] names the extents, the expected ones, and the grid's count that the array's columns match.
    pub fn of_dimensions(dimensions: &[Dimension], expected: &ColumnCount, layers: usize) -> Result<Self> {
        let is_block = dimensions.iter().skip(1).any(|d| d.extent == 1);
        let kept: Vec<Dimension> = dimensions.iter().copied().filter(|d| d.extent != 1).collect();
        let counts = [Some(layers), layers.checked_sub(1).filter(|n| *n > 1)];
        let counts = || counts.into_iter().flatten();
        let fits = counts().find_map(|layers| read(&kept, expected, layers, is_block));
        let of_one_layer = |columns| read(&[Dimension { extent: 1, stride: 0 }, columns], expected, 1, is_block);
        let fits = fits.or_else(|| of_one_layer(*kept.first().filter(|_| kept.len() == 1)?));
        fits.ok_or_else(|| {
            let extents: Vec<usize> = dimensions.iter().map(|d| d.extent).collect();
            let seen = counts().find_map(|layers| other_columns(&kept, expected, layers));
            let message = seen.map_or_else(
                || {
                    let columns = expected.columns;
                    let fewer = counts().nth(1).map_or_else(String::new, |n| format!(" or {n} (midway between them)"));
                    format!(
                        "an array of extents {extents:?}, expected one dimension of {layers} layers{fewer} and one or \
                         two others that hold {columns} columns"
                    )
                },
                |seen| format!("an array of extents {extents:?}: {seen}"),
            );
            Error::new(ErrorKind::Field, message)
        })
    }
}

/// Explains the number of columns of an array that has `layers` layers but not the expected columns.
fn other_columns(dimensions: &[Dimension], expected: &ColumnCount, layers: usize) -> Option<String> {
    let extent = match *dimensions {
        [all] if all.extent % layers == 0 => all.extent / layers,
        [a, b] if a.extent == layers => b.extent,
        [a, b] if b.extent == layers => a.extent,
        _ => return None,
    };
    let columns = expected.columns;
    let too_long = || {
        let is_too_long = dimensions.len() == 2 && extent > columns;
        is_too_long.then(|| {
            format!(
                "{extent} columns, expected {columns} and at most {MAX_PADDING} of padding; pass a section of {columns} \
                 columns, or set the grid (and part) with all columns of the halo"
            )
        })
    };
    expected.explain(extent).or_else(too_long)
}

/// The reading with exactly `layers` layers, if there is one.
fn read(dimensions: &[Dimension], expected: &ColumnCount, layers: usize, is_block: bool) -> Option<Shape> {
    let columns = expected.columns;
    let flat = Shape { columns, layers, offset: 0, column_stride: 0, layer_stride: 0, block: 0, block_stride: 0 };
    match *dimensions {
        [all] => {
            // An array without columns may have MPAS's extra one behind the last.
            let is_extra_column = columns == 0 && all.extent == layers;
            (is_extra_column || all.extent == columns.checked_mul(layers)?).then_some(Shape {
                column_stride: all.stride.checked_mul(isize::try_from(layers).ok()?)?,
                layer_stride: all.stride,
                ..flat
            })
        }
        [a, b] => {
            let reading = |level: Dimension, column: Dimension| {
                (level.extent == layers && expected.fits_in(column.extent, is_block)).then_some(Shape {
                    column_stride: column.stride,
                    layer_stride: level.stride,
                    ..flat
                })
            };
            reading(a, b).or_else(|| reading(b, a))
        }
        [a, b, c] => {
            let reading = |level: Dimension, column: Dimension, block: Dimension| {
                // Each block is needed: otherwise the two are other dimensions, such as tracers or time levels and
                // cells.
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

    /// The counts of a closed mesh of `columns` cells, for a field at their centres.
    fn cells(columns: usize) -> ColumnCount {
        let (corners, edges) = ((2 * columns).saturating_sub(4), (3 * columns).saturating_sub(6));
        ColumnCount { columns, cells: columns, corners, edges }
    }

    /// Element of value (column, layer).
    fn element(s: &Shape, column: usize, layer: usize) -> isize {
        let (inner, outer) = if s.block == 0 { (column, 0) } else { (column % s.block, column / s.block) };
        inner as isize * s.column_stride + outer as isize * s.block_stride + layer as isize * s.layer_stride
    }

    #[test]
    fn the_layouts_of_models_are_found() {
        let (columns, layers) = (42, 5);
        let shape = |extents: &[usize]| Shape::of_dimensions(&fortran(extents), &cells(columns), layers).unwrap();
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
        let both = |extents: &[usize]| Shape::of_dimensions(&fortran(extents), &cells(4), 5).unwrap();
        assert_eq!((both(&[4, 5]).layers, both(&[4, 5]).layer_stride), (5, 4));
        assert_eq!((both(&[5, 5]).layers, both(&[5, 5]).layer_stride), (5, 1));
    }

    #[test]
    fn strides_are_kept_as_they_are() {
        let section = [Dimension { extent: 5, stride: -3 }, Dimension { extent: 42, stride: 700 }];
        let shape = Shape::of_dimensions(&section, &cells(42), 5).unwrap();
        assert_eq!((shape.layer_stride, shape.column_stride, shape.block), (-3, 700, 0));
    }

    #[test]
    fn a_rank_without_cells_has_arrays_without_columns() {
        for extents in [vec![5, 0], vec![5, 1], vec![0, 5], vec![0], vec![16, 5, 0], vec![5, 16, 0], vec![0, 5, 0]] {
            let shape = Shape::of_dimensions(&fortran(&extents), &cells(0), 5).unwrap();
            assert_eq!((shape.columns, shape.layers), (0, 5), "{extents:?}");
        }
        assert!(Shape::of_dimensions(&fortran(&[16, 5, 2]), &cells(0), 5).is_err());
        assert!(Shape::of_dimensions(&fortran(&[16, 5, 0]), &cells(42), 5).is_err());
    }

    #[test]
    fn arrays_of_no_known_layout_are_refused_with_their_extents() {
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
            let error = Shape::of_dimensions(&fortran(&extents), &cells(42), 5).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Field);
            let text = error.to_string();
            assert!(text.contains(&format!("{extents:?}")) && text.contains("42 columns"), "{text}");
        }
        let overflow = [Dimension { extent: usize::MAX, stride: 1 }, Dimension { extent: 5, stride: 1 }];
        assert!(Shape::of_dimensions(&[overflow[0], overflow[1], overflow[0]], &cells(42), 5).is_err());
    }

    /// The grid has 42 cells, 80 corners and 120 edges.
    #[test]
    fn arrays_at_another_location_are_refused_with_a_hint() {
        let of = |extents: &[usize], expected: &ColumnCount| {
            Shape::of_dimensions(&fortran(extents), expected, 5).map_err(|e| e.to_string())
        };
        let centers = cells(42);
        let corners = ColumnCount { columns: 80, ..centers };
        for (extents, said) in [
            (vec![5, 80], "[5, 80]: 80 columns are the grid's corners: set location = ICORAY_CORNER"),
            (vec![5, 81], "81 columns are the grid's corners"),
            (vec![80, 5], "80 columns are the grid's corners"),
            (vec![4, 81], "81 columns are the grid's corners"),
            (vec![5, 81, 1], "81 columns are the grid's corners"),
            (vec![400], "80 columns are the grid's corners"),
            (vec![5, 120], "the grid's edges: fields at edges are not drawn; average them to cells"),
            (vec![121, 5], "121 columns are the grid's edges"),
            (vec![5, 107], "107 columns, expected 42 and at most 64 of padding; pass a section of 42 columns"),
        ] {
            let error = of(&extents, &centers).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        for (extents, said) in [
            (vec![5, 42], "42 columns are the grid's cells: set location = ICORAY_CENTER"),
            (vec![5, 43], "43 columns are the grid's cells"),
            (vec![5, 120], "120 columns are the grid's edges"),
            (vec![5, 79], "expected one dimension of 5 layers"),
        ] {
            let error = of(&extents, &corners).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        for extents in [vec![5, 42], vec![5, 43], vec![64, 5], vec![5, 106], vec![1000, 5, 1], vec![5, 1000, 1]] {
            assert!(of(&extents, &centers).is_ok(), "{extents:?}");
        }
        assert!(of(&[5, 81], &corners).is_ok() && of(&[5, 128], &corners).is_ok());
        // The columns of a rank over the whole grid's tables.
        let some = ColumnCount { columns: 10, ..centers };
        assert!(of(&[5, 42], &some).unwrap_err().contains("42 columns are the grid's cells"));
        assert!(of(&[5, 11], &some).is_ok());
        // A rank's three cells around one corner, and four cells with five corners: what is declared comes first.
        let tiny = ColumnCount { columns: 4, cells: 4, corners: 5, edges: 9 };
        assert!(of(&[5, 5], &tiny).is_ok() && of(&[5, 6], &tiny).is_err());
    }
}
