//! Radii of the layers around each lane's gap, from the model's array of heights.

use super::lanes::Lanes;
use super::medium::number;
use super::read::bases_of;
use fearless_simd::prelude::*;
use icoray_grid::Reals;
use icoray_grid::array::MapInline;
use icoray_grid::heights::{Heights, PlainHeights};
use icoray_simd::{Machine, Numbers, Table, Wide, wide, wide_mask};

/// An array of heights for gathers.
#[derive(Clone, Copy)]
pub(super) struct HeightTable<'t> {
    heights: &'t Heights<'t>,
    plain: PlainHeights<'t>,
    samples: Samples<'t>,
    /// The mark of missing heights, and the radii of layers that replace them.
    missing: Option<(f64, Table<'t, f64>)>,
    layers: u32,
}

#[derive(Clone, Copy)]
enum Samples<'t> {
    Single(Table<'t, f32>),
    Double(Table<'t, f64>),
}

/// A number at each of three vertices.
pub(super) type Corners<V> = [Wide<V>; 3];

impl<'t> HeightTable<'t> {
    /// The table of these heights; `None` if they are too many for gathers.
    #[inline]
    pub fn new(heights: &'t Heights<'t>) -> Option<Self> {
        let plain = heights.plain();
        let samples = match plain.samples {
            Reals::F32(data) => Samples::Single(Table::new(data)?),
            Reals::F64(data) => Samples::Double(Table::new(data)?),
        };
        let missing = match plain.missing {
            Some((fill, mean)) => Some((fill, Table::new(mean)?)),
            None => None,
        };
        Some(HeightTable { heights, plain, samples, missing, layers: heights.layers() as u32 })
    }

    /// Offsets of the heights of cells.
    #[inline(always)]
    pub fn bases<V: Machine>(&self, simd: V, cells: Numbers<V>, bits: u32) -> Numbers<V> {
        bases_of(simd, self.plain.column, cells, bits, |cell| self.base(cell))
    }

    /// [`Self::bases`] of one cell.
    #[inline]
    pub fn base(&self, cell: u32) -> u32 {
        self.heights.base(cell) as u32
    }

    /// 1 / radius of the layers below and above the gaps over the three cells of each lane's column; if there is no
    /// such layer, of the nearest one. Equal to that of [`Heights::radii`] to the bit.
    #[inline(always)]
    pub fn inverses<V: Machine>(&self, simd: V, lanes: &Lanes<V>, gap: Numbers<V>) -> [Corners<V>; 2] {
        let top = self.layers - 1;
        let (below, above) = (gap.max(number(simd, 1)) - 1, gap.min(number(simd, top)));
        let stride = number(simd, self.plain.layer_stride as u32);
        // The layer below the topmost gap of layers midway lies between the last two rows.
        let row = if self.plain.is_midway { gap.min(number(simd, top + 1)) } else { above };
        let behind = row.min(number(simd, top)) + 1;
        let [low, high, behind] = [below * stride, row * stride, behind * stride];
        let mut radii = [[Wide::splat(simd, 0.0); 3]; 2];
        for (k, base) in lanes.heights.into_iter().enumerate() {
            let (first, known) = (self.read(simd, base + low), self.read(simd, base + high));
            let heights = if self.plain.is_midway {
                let behind = self.read(simd, base + behind);
                let half = Wide::splat(simd, 0.5);
                [half * (first + known), half * (known + behind)]
            } else {
                [first, known]
            };
            let (one, stretch) = (Wide::splat(simd, 1.0), Wide::splat(simd, self.plain.stretch));
            let mut own = [one + stretch * heights[0], one + stretch * heights[1]];
            if let Some((fill, mean)) = self.missing {
                let fill = Wide::splat(simd, fill);
                let most = Wide::splat(simd, f64::MAX);
                let is_finite = known.le(most).narrow() & known.ge(Wide::splat(simd, -f64::MAX)).narrow();
                let is_fill = known.le(fill).narrow() & known.ge(fill).narrow();
                let is_known = wide_mask::<V>(is_finite & !is_fill);
                own[0] = own[0].over(is_known, simd.gather_f64(mean, below));
                own[1] = own[1].over(is_known, simd.gather_f64(mean, above));
            }
            for (row, radius) in radii.iter_mut().zip(own) {
                row[k] = one / radius;
            }
        }
        radii
    }

    /// The heights of these elements.
    #[inline(always)]
    fn read<V: Machine>(&self, simd: V, index: Numbers<V>) -> Wide<V> {
        match self.samples {
            Samples::Single(table) => wide::<V>(simd.gather_f32(table, index)),
            Samples::Double(table) => simd.gather_f64(table, index),
        }
    }

    /// 1 / radius of a layer over three cells.
    #[inline]
    pub fn inverses_at(&self, cells: [u32; 3], layer: usize) -> [f64; 3] {
        self.heights.radii(cells, layer).map_inline(|radius| 1.0 / radius)
    }

    /// Number of layers.
    #[inline]
    pub fn layers(&self) -> usize {
        self.layers as usize
    }
}
