//! Layers with separate heights in each column, read in place from the model's array.

use crate::array::MapInline;
use crate::error::{Error, ErrorKind, Result};
use crate::field::{Field, Location};
use crate::grid::Grid;
use crate::layers::Layers;
use crate::reals::Reals;
use crate::shape::ElementIndexer;
use rayon::prelude::*;

mod corners;

pub use corners::{check_corner_columns, check_corners};

/// The radii of a field's layers in all columns, counted from the innermost layer.
///
/// Radii never decrease upwards in a column, for any rounding: stretching and averaging are monotone.
#[derive(Debug, Clone)]
pub struct Heights<'f> {
    samples: Reals<'f>,
    elements: ElementIndexer,
    fill: Option<f64>,
    columns: usize,
    /// Whether there are columns without heights.
    has_missing: bool,
    /// Whether the field lies midway between the layers that have heights.
    is_midway: bool,
    /// Planet radii per metre of height, exaggeration included.
    stretch: f64,
    /// Radii of the field's layers in columns without heights.
    mean: Vec<f64>,
    bounds: [f64; 2],
}

/// The array of heights, for code that reads several at a time.
#[derive(Debug, Clone, Copy)]
pub struct PlainHeights<'a> {
    /// The model's array, in metres.
    pub samples: Reals<'a>,
    /// The base of cell 0 and the stride from cell to cell; `None` if cells lie in blocks.
    pub column: Option<[isize; 2]>,
    /// Elements from one layer to the next above it.
    pub layer_stride: isize,
    /// Whether layer k of the field lies midway between layers k and k + 1 of the heights.
    pub is_midway: bool,
    /// Planet radii per metre of height, exaggeration included.
    pub stretch: f64,
    /// For columns without heights: the mark of missing ones beside NaN, and the radii of their layers.
    pub missing: Option<(f64, &'a [f64])>,
}

impl<'f> Heights<'f> {
    /// Checks `heights`, in metres above the planet's surface: one column for each cell of `grid`, as many layers
    /// as `layers`. The field has `field_layers` layers, which lie on those of `heights` or midway between them.
    /// `exaggeration` stretches heights, 1 leaves them as they are. Parallel.
    ///
    /// # Errors
    /// [`ErrorKind::Layers`] if they have another shape or place, some of a column's heights but not all are missing,
    /// heights decrease upwards, or a stretched one is not above the planet's centre; as [`Layers::for_field`] and
    /// [`Layers::shell`].
    pub fn new(
        heights: &Field<'f>,
        layers: &Layers,
        grid: &Grid,
        field_layers: usize,
        exaggeration: f64,
    ) -> Result<Self> {
        let cells = grid.cells();
        check_shape(heights, layers, cells, Location::Center)?;
        let mean = layers.for_field(field_layers)?.shell(exaggeration)?;
        let elements = heights.elements();
        let mut this = Heights {
            samples: heights.samples(),
            elements: if layers.is_falling() { elements.upside_down() } else { *elements },
            fill: heights.fill(),
            columns: cells,
            has_missing: false,
            is_midway: field_layers < layers.count(),
            stretch: exaggeration / layers.planet_radius_m(),
            bounds: [mean[0], mean[mean.len() - 1]],
            mean,
        };
        let columns = (0..cells).into_par_iter().with_min_len(256);
        let checked = columns.map(|cell| this.check(cell, grid, layers)).reduce(
            || Ok(this.bounds),
            |a, b| {
                let ([low, high], b) = (a?, b?);
                Ok([low.min(b[0]), high.max(b[1])])
            },
        );
        this.bounds = checked?;
        // A column has all its heights or none.
        let is_missing = |cell: usize| this.height(this.elements.base(cell), 0).is_nan();
        this.has_missing = (0..cells).into_par_iter().with_min_len(256).any(is_missing);
        Ok(this)
    }

    /// The lowest and the highest radius of the field's layers over any column, in planet radii, mean radii included.
    pub fn bounds(&self) -> [f64; 2] {
        self.bounds
    }

    /// Number of the field's layers.
    pub fn layers(&self) -> usize {
        self.mean.len()
    }

    /// The array and its layout.
    #[inline]
    pub fn plain(&self) -> PlainHeights<'_> {
        let missing = self.has_missing.then_some((self.fill.unwrap_or(f64::NAN), self.mean.as_slice()));
        PlainHeights {
            samples: self.samples,
            column: self.elements.plain_column(),
            layer_stride: self.elements.layer_stride(),
            is_midway: self.is_midway,
            stretch: self.stretch,
            missing,
        }
    }

    /// Offset of the column of a cell of the grid in the array.
    #[inline]
    pub fn base(&self, cell: u32) -> isize {
        self.elements.base(cell as usize)
    }

    /// [`Self::radius`] over three cells.
    #[inline]
    pub fn radii(&self, cells: [u32; 3], layer: usize) -> [f64; 3] {
        cells.map_inline(|cell| self.radius(cell, layer))
    }

    /// The radius of the field's `layer` over a cell, in planet radii, stretched. Cells that the grid does not have, such
    /// as those of void triangles, have mean heights.
    #[inline(always)]
    pub fn radius(&self, cell: u32, layer: usize) -> f64 {
        let cell = cell as usize;
        if cell < self.columns { self.radius_at(self.elements.base(cell), layer) } else { self.mean[layer] }
    }

    #[inline(always)]
    fn radius_at(&self, base: isize, layer: usize) -> f64 {
        let height = match self.is_midway {
            false => self.height(base, layer),
            true => 0.5 * (self.height(base, layer) + self.height(base, layer + 1)),
        };
        if height.is_nan() { self.mean[layer] } else { self.stretched(height) }
    }

    /// Height in metres of a layer that has one; NaN if it is missing.
    #[inline(always)]
    fn height(&self, base: isize, layer: usize) -> f64 {
        let height = self.samples.get(self.elements.at(base, layer));
        if Some(height) == self.fill || !height.is_finite() { f64::NAN } else { height }
    }

    #[inline(always)]
    fn stretched(&self, height: f64) -> f64 {
        1.0 + self.stretch * height
    }

    /// The radii at the ends of a column, or the error in its heights.
    fn check(&self, cell: usize, grid: &Grid, layers: &Layers) -> Result<[f64; 2]> {
        let (count, base) = (layers.count(), self.elements.base(cell));
        let height = |layer| self.height(base, layer);
        if !check_column(layers, height, || grid.cell_name(cell))? {
            return Ok([self.mean[0], self.mean[self.mean.len() - 1]]);
        }
        let radius = [0, count - 1].map(|layer| self.stretched(height(layer)));
        if !(radius[0] > 0.0 && radius[1].is_finite()) {
            let planet_m = layers.planet_radius_m();
            let [low, high] = [height(0), height(count - 1)];
            let message = format!(
                "heights {low} to {high} m are stretched to {} to {} m, expected heights above the planet's centre at \
                 -{planet_m} m",
                self.stretch * planet_m * low,
                self.stretch * planet_m * high
            );
            return Err(bad_column(&grid.cell_name(cell), &message));
        }
        Ok([0, self.layers() - 1].map(|layer| self.radius_at(base, layer)))
    }
}

/// Checks that `heights` have `columns` columns at `location`, of as many layers as `layers`.
fn check_shape(heights: &Field, layers: &Layers, columns: usize, location: Location) -> Result<()> {
    let (shape, count) = (heights.shape(), layers.count());
    if (shape.columns, shape.layers, heights.location()) == (columns, count, location) {
        return Ok(());
    }
    let context = format!(
        "heights: {} columns of {} layers at {:?}, expected {columns} of {count} at {location:?}",
        shape.columns,
        shape.layers,
        heights.location()
    );
    Err(Error::new(ErrorKind::Layers, context))
}

/// Checks the heights of a column, layers counted from the innermost, NaN for a missing one; `name` is for the message.
/// Returns whether the column has heights.
fn check_column(layers: &Layers, height: impl Fn(usize) -> f64, name: impl Fn() -> String) -> Result<bool> {
    let count = layers.count();
    // Layers are named in the order in which they were given, counted from 1.
    let given = |layer| if layers.is_falling() { count - layer } else { layer + 1 };
    if let Some(lost) = (0..count).find(|layer| height(*layer).is_nan()) {
        let Some(known) = (0..count).find(|layer| !height(*layer).is_nan()) else { return Ok(false) };
        let message = format!(
            "layer {} of {count}: missing, but {} m at layer {}; expected all heights of a column or none",
            given(lost),
            height(known),
            given(known)
        );
        return Err(bad_column(&name(), &message));
    }
    if let Some(l) = (1..count).find(|l| height(*l) < height(l - 1)) {
        let message = format!(
            "layers {} and {} of {count}: {} m lies below {} m, expected heights that do not fall from the innermost layer on",
            given(l),
            given(l - 1),
            height(l),
            height(l - 1)
        );
        return Err(bad_column(&name(), &message));
    }
    Ok(true)
}

fn bad_column(name: &str, what: &str) -> Error {
    Error::new(ErrorKind::Layers, format!("heights: {name}, {what}"))
}

#[cfg(test)]
mod tests;
