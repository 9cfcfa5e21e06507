//! Values at the vertices of each lane's frustum, and their interpolant along the ray.

use super::lanes::{Lanes, lanes_of};
use super::layers::Way;
use super::medium::number;
use super::part::all;
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;
use icoray_grid::samples::SampleMapping;
use icoray_grid::{Field, Reals};
use icoray_simd::{Floats, Machine, Mask, Numbers, Pairs, Table, Wide, wide};

/// A field, normalised to the range of a transfer function.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'t> {
    values: Reals<'t>,
    mapping: SampleMapping,
    /// The mark of missing values, if the array has it and lanes gather.
    fill: Option<f32>,
    /// The array for gathers; `None` if it has f64 values, is too long or the range too extreme: then values are read and
    /// normalised one by one.
    pairs: Option<Pairs<'t, f32>>,
}

/// Values at the three vertices on the layer below and on the layer above, not normalised.
pub(super) struct Vertices<V: Machine> {
    pub low: [Floats<V>; 3],
    pub high: [Floats<V>; 3],
}

/// The points at which each ray enters and leaves its frustum between concentric layers: weights of the second and
/// third vertex at the column's ends, the fractions of the way between the layers and between the edge points, the
/// relative change of height.
#[derive(Clone, Copy)]
pub(super) struct ConcentricWay<V: Machine> {
    pub weights: [[Floats<V>; 2]; 2],
    pub place: [Floats<V>; 2],
    pub tau: [Floats<V>; 2],
    pub eps: Floats<V>,
}

/// A number along each frustum: at its ends, and the bend of [`Segment`](crate::segment::Segment).
pub(super) type Course<V> = [Floats<V>; 3];

impl<'t> Source<'t> {
    /// The values of `field`, whose first layer is the innermost; `range` becomes 0 to 1.
    pub fn new(field: &Field<'t>, range: [f64; 2]) -> Self {
        /// Factors beyond which differences of values could leave the range of f32.
        const SCALES: std::ops::Range<f64> = 1e-30..1e30;
        let mapping = SampleMapping::new(field, range);
        let pairs = match field.samples() {
            Reals::F32(data) if SCALES.contains(&mapping.scale) => Pairs::new(data),
            _ => None,
        };
        Source { values: field.samples(), mapping, fill: pairs.and_then(|_| mapping.fill()), pairs }
    }

    /// The value over `cell` at `layer`, normalised; NaN if it is missing.
    #[inline(always)]
    pub fn value(&self, cell: u32, layer: usize) -> f32 {
        let base = self.mapping.elements.base(cell as usize);
        self.mapping.normal(self.values.get(self.mapping.elements.at(base, layer)))
    }

    /// Offsets of the values over cells, for [`Self::read`].
    #[inline(always)]
    pub fn bases<V: Machine>(&self, simd: V, cells: Numbers<V>, bits: u32) -> Numbers<V> {
        if self.pairs.is_none() {
            return cells;
        }
        bases_of(simd, self.mapping.elements.plain_column(), cells, bits, |cell| self.base(cell))
    }

    /// [`Self::bases`] of one cell.
    #[inline]
    pub fn base(&self, cell: u32) -> u32 {
        if self.pairs.is_some() { self.mapping.elements.base(cell as usize) as u32 } else { cell }
    }

    /// Starts to fetch the value at `layer` over the cell with this base.
    #[inline(always)]
    pub fn prefetch(&self, base: u32, layer: u32) {
        if let Some(pairs) = self.pairs {
            let stride = self.mapping.elements.layer_stride() as u32;
            pairs.table().prefetch(base.wrapping_add(layer.wrapping_mul(stride)));
        }
    }

    /// Reads the values around the lanes' gaps in columns that begin at `bases`; those of lanes whose bits are not set are
    /// undefined.
    #[inline(always)]
    pub fn read<V: Machine>(&self, simd: V, lanes: &Lanes<V>, bases: [Numbers<V>; 3], bits: u32) -> Vertices<V> {
        let Some(pairs) = self.pairs else { return self.read_any(simd, lanes, bits) };
        let [a, b, c] = bases;
        let gap = lanes.gap;
        match self.mapping.elements.layer_stride() {
            1 => {
                let below = gap - 1;
                let (a, d) = simd.gather_pair(pairs, a + below);
                let (b, e) = simd.gather_pair(pairs, b + below);
                let (c, f) = simd.gather_pair(pairs, c + below);
                Vertices { low: [a, b, c], high: [d, e, f] }
            }
            -1 => {
                let (d, a) = simd.gather_pair(pairs, a - gap);
                let (e, b) = simd.gather_pair(pairs, b - gap);
                let (f, c) = simd.gather_pair(pairs, c - gap);
                Vertices { low: [a, b, c], high: [d, e, f] }
            }
            stride => {
                let above = gap * number(simd, stride as u32);
                let below = above - number(simd, stride as u32);
                let table = pairs.table();
                let low = [a + below, b + below, c + below];
                let high = [a + above, b + above, c + above];
                Vertices { low: gather_all(simd, table, low), high: gather_all(simd, table, high) }
            }
        }
    }

    /// Values one by one, normalised.
    #[inline(never)]
    fn read_any<V: Machine>(&self, simd: V, lanes: &Lanes<V>, bits: u32) -> Vertices<V> {
        let zero = [all(simd, 0.0); 3];
        let mut vertices: Vertices<V> = Vertices { low: zero, high: zero };
        for lane in lanes_of(bits) {
            let gap = lanes.gap[lane] as usize;
            for k in 0..3 {
                let cell = lanes.cells[k][lane];
                vertices.low[k][lane] = self.value(cell, gap - 1);
                vertices.high[k][lane] = self.value(cell, gap);
            }
        }
        vertices
    }

    /// The normalised value along each frustum.
    #[inline(always)]
    pub fn normalised<V: Machine>(&self, simd: V, vertices: &Vertices<V>, way: &impl Way<V>) -> Course<V> {
        let course = way.interpolate(vertices);
        let first = self.normal(simd, vertices.low[0]);
        if self.pairs.is_none() {
            return [first + course[0], first + course[1], course[2]];
        }
        let scale = self.mapping.scale as f32;
        [first + course[0] * scale, first + course[1] * scale, course[2] * scale]
    }

    /// The largest magnitude of the normalised values at the vertices; far beyond 1 it counts twice, as the roundings
    /// that matter there are those of a column's weights, which all of its frusta share.
    #[inline(always)]
    pub fn size<V: Machine>(&self, simd: V, vertices: &Vertices<V>) -> Floats<V> {
        let [least, most] = self.ends(simd, vertices);
        let size = least.abs().max(most.abs());
        size.max(size + size - 1.0)
    }

    /// The least and the greatest of the normalised values at the vertices.
    #[inline(always)]
    pub fn ends<V: Machine>(&self, simd: V, vertices: &Vertices<V>) -> [Floats<V>; 2] {
        let Vertices { low: [a, b, c], high: [d, e, f] } = *vertices;
        let ends = [a.min(b).min(c).min(d).min(e).min(f), a.max(b).max(c).max(d).max(e).max(f)];
        ends.map_inline(|value| self.normal(simd, value))
    }

    /// A value at a vertex, normalised.
    #[inline(always)]
    fn normal<V: Machine>(&self, simd: V, value: Floats<V>) -> Floats<V> {
        if self.pairs.is_none() {
            return value;
        }
        // Values of 1e6 + 1 keep their digits: they are subtracted before they are rounded.
        let [shift, scale] = [self.mapping.shift, self.mapping.scale].map_inline(|x| Wide::splat(simd, x));
        ((wide::<V>(value) - shift) * scale).narrow()
    }

    /// Lanes in which a value is missing.
    #[inline(always)]
    pub fn missing<V: Machine>(&self, simd: V, vertices: &Vertices<V>) -> Option<Mask<V>> {
        let fill = all(simd, self.fill?);
        let Vertices { low: [a, b, c], high: [d, e, f] } = vertices;
        let [a, b, c, d, e, f] = [a, b, c, d, e, f].map_inline(|value| value.simd_eq(fill));
        Some((a | b) | (c | d) | (e | f))
    }

    /// Lanes in which a value is no finite number.
    #[inline(always)]
    pub fn not_finite<V: Machine>(&self, simd: V, vertices: &Vertices<V>) -> Mask<V> {
        let most = all(simd, f32::MAX);
        let Vertices { low: [a, b, c], high: [d, e, f] } = vertices;
        let [a, b, c, d, e, f] = [a, b, c, d, e, f].map_inline(|value| value.abs().simd_le(most));
        !((a & b) & (c & d) & (e & f))
    }
}

/// Offsets of the columns of cells: from the base of cell 0 and the stride from cell to cell, or, if they lie in
/// blocks, one by one for the lanes whose bits are set.
#[inline(always)]
pub(super) fn bases_of<V: Machine>(
    simd: V,
    plain: Option<[isize; 2]>,
    cells: Numbers<V>,
    bits: u32,
    base: impl Fn(u32) -> u32,
) -> Numbers<V> {
    #[inline(never)]
    fn one_by_one<V: Machine>(mut cells: Numbers<V>, bits: u32, base: impl Fn(u32) -> u32) -> Numbers<V> {
        for lane in lanes_of(bits) {
            cells[lane] = base(cells[lane]);
        }
        cells
    }
    match plain {
        Some([offset, stride]) => cells * number(simd, stride as u32) + number(simd, offset as u32),
        None => one_by_one::<V>(cells, bits, base),
    }
}

#[inline(always)]
fn gather_all<V: Machine>(simd: V, table: Table<'_, f32>, [a, b, c]: [Numbers<V>; 3]) -> [Floats<V>; 3] {
    [simd.gather_f32(table, a), simd.gather_f32(table, b), simd.gather_f32(table, c)]
}

impl<V: Machine> Way<V> for ConcentricWay<V> {
    #[inline(always)]
    fn interpolate(&self, vertices: &Vertices<V>) -> Course<V> {
        let [entry, exit] = self.weights;
        let Vertices { low: [a, b, c], high: [d, e, f] } = *vertices;
        let (ab, ac, ad) = (b - a, c - a, d - a);
        let (de, df) = (e - d, f - d);
        let low = [entry[1].mul_add(ac, entry[0] * ab), exit[1].mul_add(ac, exit[0] * ab)];
        let high = [entry[1].mul_add(df, entry[0].mul_add(de, ad)), exit[1].mul_add(df, exit[0].mul_add(de, ad))];
        let rise = [high[0] - low[0], high[1] - low[1]];
        let [from, to] = self.place.map_inline(|place| {
            let is_above = place.simd_eq(1.0);
            [0, 1].map_inline(|k: usize| is_above.select(high[k], place.mul_add(rise[k], low[k])))
        });
        let [slope_a, slope_b] = [from[1] - from[0], to[1] - to[0]];
        let kappa = (self.tau[1] - self.tau[0]) * (self.eps.mul_add(slope_a, slope_a - slope_b));
        [self.tau[0].mul_add(slope_a, from[0]), self.tau[1].mul_add(slope_b, to[0]), kappa]
    }
}

/// Limit of the values at a vertex, and of the ratio of gradients there to the frustum's own, beyond which frusta are
/// passed to a single ray if there is one: rounding moves the visible part of them.
pub(super) const FAR: f32 = 64.0;

/// A value is beyond all bounds if the sum of the magnitudes of a course's numbers exceeds this.
pub(super) const LARGEST: f32 = <f32 as Real>::LARGEST as f32;
