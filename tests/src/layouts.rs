//! One field in every layout that models have: where each model's own indexing puts a value, beside the [`Shape`] that
//! has to find it there. The two are written down independently.

use icoray::Shape;

/// Columns per block: leaves a last block that is filled in part, at the cells and at the corners of every mesh here.
pub const NPROMA: usize = 50;

/// A layout of `columns` times `layers` values.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Whose it is.
    pub name: &'static str,
    /// Its description for the library, from columns and layers.
    pub shape: fn(usize, usize) -> Shape,
    /// Length of the array, from columns and layers.
    pub len: fn(usize, usize) -> usize,
    /// Where the model puts a value, from column, layer, columns and layers.
    pub place: fn(usize, usize, usize, usize) -> usize,
}

fn blocks(columns: usize, block: usize) -> usize {
    columns.div_ceil(block)
}

/// Every layout; the first is the plain one.
pub const LAYOUTS: &[Layout] = &[
    Layout {
        name: "level-fastest",
        shape: Shape::level_fastest,
        len: |c, l| c * l,
        place: |c, l, _, layers| c * layers + l,
    },
    Layout {
        name: "cell-fastest",
        shape: Shape::cell_fastest,
        len: |c, l| c * l,
        place: |c, l, columns, _| l * columns + c,
    },
    Layout {
        name: "blocked (nproma, nlev, nblks), last block in part",
        shape: |c, l| Shape::blocked(c, l, NPROMA),
        len: |c, l| blocks(c, NPROMA) * l * NPROMA,
        place: |c, l, _, layers| ((c / NPROMA) * layers + l) * NPROMA + c % NPROMA,
    },
    Layout {
        name: "blocked, the array ends with the last value",
        shape: |c, l| Shape::blocked(c, l, NPROMA),
        len: |c, l| ((c - 1) / NPROMA * l + l - 1) * NPROMA + (c - 1) % NPROMA + 1,
        place: |c, l, _, layers| ((c / NPROMA) * layers + l) * NPROMA + c % NPROMA,
    },
    Layout {
        name: "blocked, layers fastest (nlev, nproma, nblks)",
        shape: |c, l| Shape { column_stride: l as isize, layer_stride: 1, ..Shape::blocked(c, l, NPROMA) },
        len: |c, l| blocks(c, NPROMA) * l * NPROMA,
        place: |c, l, _, layers| ((c / NPROMA) * NPROMA + c % NPROMA) * layers + l,
    },
    Layout {
        name: "blocked, a halo of 2 around 16",
        shape: |c, l| Shape { offset: 2, layer_stride: 20, block_stride: 20 * l as isize, ..Shape::blocked(c, l, 16) },
        len: |c, l| blocks(c, 16) * l * 20,
        place: |c, l, _, layers| ((c / 16) * layers + l) * 20 + 2 + c % 16,
    },
    Layout {
        name: "blocks of one column",
        shape: |c, l| Shape::blocked(c, l, 1),
        len: |c, l| c * l,
        place: |c, l, _, layers| c * layers + l,
    },
    Layout {
        name: "one block, longer than the columns",
        shape: |c, l| Shape::blocked(c, l, c + 7),
        len: |c, l| (c + 7) * l,
        place: |c, l, columns, _| l * (columns + 7) + c,
    },
    Layout {
        name: "blocks, columns and layers backwards",
        shape: |c, l| Shape {
            offset: blocks(c, NPROMA) * l * NPROMA - 1,
            column_stride: -1,
            layer_stride: -(NPROMA as isize),
            block_stride: -((l * NPROMA) as isize),
            ..Shape::blocked(c, l, NPROMA)
        },
        len: |c, l| blocks(c, NPROMA) * l * NPROMA,
        place: |c, l, columns, layers| {
            let (block, layer, inside) = (blocks(columns, NPROMA) - 1 - c / NPROMA, layers - 1 - l, c % NPROMA);
            (block * layers + layer) * NPROMA + (NPROMA - 1 - inside)
        },
    },
    Layout {
        name: "padded rows",
        shape: |c, l| Shape { column_stride: l as isize + 3, ..Shape::level_fastest(c, l) },
        len: |c, l| c * (l + 3),
        place: |c, l, _, layers| c * (layers + 3) + l,
    },
    Layout {
        name: "nCells + 1 columns, level-fastest",
        shape: Shape::level_fastest,
        len: |c, l| (c + 1) * l,
        place: |c, l, _, layers| c * layers + l,
    },
    Layout {
        name: "nCells + 1 columns, cell-fastest",
        shape: |c, l| Shape { layer_stride: c as isize + 1, ..Shape::cell_fastest(c, l) },
        len: |c, l| (c + 1) * l,
        place: |c, l, columns, _| l * (columns + 1) + c,
    },
    Layout {
        name: "columns backwards",
        shape: |c, l| Shape { offset: (c - 1) * l, column_stride: -(l as isize), ..Shape::level_fastest(c, l) },
        len: |c, l| c * l,
        place: |c, l, columns, layers| (columns - 1 - c) * layers + l,
    },
    Layout {
        name: "layers backwards",
        shape: |c, l| Shape { offset: l - 1, layer_stride: -1, ..Shape::level_fastest(c, l) },
        len: |c, l| c * l,
        place: |c, l, _, layers| c * layers + layers - 1 - l,
    },
];

impl Layout {
    /// The array as the model has it; what no value stands in alternates between the two `garbage`.
    pub fn store<S: Copy>(
        &self,
        columns: usize,
        layers: usize,
        garbage: [S; 2],
        value: impl Fn(usize, usize) -> S,
    ) -> Vec<S> {
        let mut array: Vec<S> = garbage.into_iter().cycle().take((self.len)(columns, layers)).collect();
        for column in 0..columns {
            for layer in 0..layers {
                array[(self.place)(column, layer, columns, layers)] = value(column, layer);
            }
        }
        array
    }
}
