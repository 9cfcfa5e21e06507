//! Frusta of several rays, interpolated and integrated several at a time in the machine's widest vectors.
//!
//! There is one source: loops over frusta that lie side by side, with the functions of one frustum inlined in them, which
//! the compiler turns into vectors for each kind of machine. So lanes compute what one frustum after the other would, bit for bit. Only the
//! cheapest rule of integration is worth it; what it is not near enough for is left to the ray.

use super::Caster;
use crate::array::MapInline;
use crate::kernel::column::Chord;
use crate::kernel::lit::Course;
use crate::kernel::piece::{Light, ThinPiece};
use crate::kernel::real::Real;
use crate::kernel::sample::AnySamples;
use crate::kernel::segment::Segment;
use crate::kernel::transfer::{NUMBERS, Span, Spans};
use crate::kernel::walk::pack::{LANES, Row, lanes};
use fearless_simd::Simd;
use lit::Lights;

mod lit;

/// Passes over all frusta of a batch.
const PASSES: usize = 9;

/// Of the span that each frustum of a pass lies in: what [`Spans::media`] gives.
type Medium<T> = [Row<T>; NUMBERS];

/// Something of each frustum.
type Rows<X> = [Row<X>; PASSES];

/// What is read of a frustum: the samples at the three vertices on the layer behind and on that ahead, whose and which these
/// are, and whether the ray has leapt since its last frustum.
pub(super) type Read = ([f64; 6], [u32; 3], [u32; 2], bool);

#[inline]
fn rows<X: Copy>(value: X) -> Rows<X> {
    [[value; LANES]; PASSES]
}

/// What is known of a frustum when all have been integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::kernel::ray) enum Known {
    /// Nothing yet.
    Odd,
    /// Its light.
    Light,
    /// Its light, taken in two halves.
    Halves,
    /// That it is clear.
    Clear,
}

/// Frusta side by side. Where there is no light (N = 1) it is not kept whose the samples are.
#[derive(Debug)]
pub(super) struct Batch<T, const N: usize> {
    count: usize,
    /// Error that is allowed per absorbed light.
    share: T,
    lane: Rows<u8>,
    /// On the layer behind, and on that ahead.
    samples: [Rows<f64>; 6],
    cells: Rows<[u32; 3]>,
    layers: Rows<[u32; 2]>,
    is_fresh: Rows<bool>,
    /// Weights of the second and third vertex at the column's entry and exit; where the ray enters and leaves the frustum, between the
    /// edge points and between the layers; eps; length.
    way: [Rows<T>; 10],
    /// f0, f1, kappa.
    value: [Rows<T>; 3],
    span: Rows<u32>,
    is_usual: Rows<bool>,
    is_clear: Rows<bool>,
    known: Rows<Known>,
    /// Colour, absorbed, error, variance.
    light: [Rows<T>; 6],
    /// Of each ray.
    lights: Option<Box<Lights<T>>>,
}

impl<T: Real, const N: usize> Batch<T, N> {
    #[inline]
    pub fn new(share: T) -> Self {
        let zero = rows(T::zero());
        Batch {
            count: 0,
            share,
            lane: rows(0),
            samples: [rows(0.0); 6],
            cells: rows([0; 3]),
            layers: rows([0; 2]),
            is_fresh: rows(false),
            way: [zero; 10],
            value: [zero; 3],
            span: rows(0),
            is_usual: rows(false),
            is_clear: rows(false),
            known: rows(Known::Odd),
            light: [zero; 6],
            lights: None,
        }
    }

    /// How many frusta there are.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Forgets all frusta.
    #[inline]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Whether there may be no room for those of another call of [`Self::push`].
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count > (PASSES - 2) * LANES
    }

    /// Adds a frustum of each lane whose bit is set. Must not be full.
    #[inline(always)]
    pub fn push<V: Simd>(&mut self, simd: V, bits: u32, way: [&Row<T>; 10], read: impl Fn(usize) -> Read) {
        let count = self.count;
        for (rows, row) in self.way.iter_mut().zip(way) {
            let free = &mut rows.as_flattened_mut()[count..count + 2 * LANES];
            T::compress(simd, row, bits, free);
        }
        for lane in lanes(bits) {
            let n = self.count.min((PASSES - 1) * LANES);
            let (pass, i) = (n / LANES, n % LANES);
            let (samples, cells, layers, is_fresh) = read(lane);
            for k in 0..6 {
                self.samples[k][pass][i] = samples[k];
            }
            (self.lane[pass][i], self.is_fresh[pass][i]) = (lane as u8, is_fresh);
            if N > 1 {
                (self.cells[pass][i], self.layers[pass][i]) = (cells, layers);
            }
            self.count += 1;
        }
    }

    /// Whose frustum number `n` is.
    #[inline(always)]
    pub fn lane(&self, n: usize) -> usize {
        self.lane[n / LANES][n % LANES] as usize % LANES
    }

    /// What is known of frustum number `n`, and the span that it surely lies in, if anything is.
    #[inline(always)]
    pub fn known(&self, n: usize) -> (Known, usize) {
        let (pass, i) = (n / LANES, n % LANES);
        (self.known[pass][i], self.span[pass][i] as usize)
    }

    /// Whether the ray has leapt before frustum number `n`.
    #[inline(always)]
    pub fn is_fresh(&self, n: usize) -> bool {
        self.is_fresh[n / LANES][n % LANES]
    }

    /// The light of frustum number `n`, where it is known.
    #[inline(always)]
    pub fn light(&self, n: usize) -> Light<T> {
        self.light_at(n / LANES, n % LANES)
    }

    #[inline(always)]
    fn light_at(&self, pass: usize, i: usize) -> Light<T> {
        let [r, g, b, absorbed, error, variance] = &self.light;
        let color = [r[pass][i], g[pass][i], b[pass][i]];
        Light { color, absorbed: absorbed[pass][i], error: error[pass][i], variance: variance[pass][i] }
    }

    /// Its value along the ray.
    #[inline(always)]
    pub fn segment(&self, n: usize) -> Segment<T> {
        self.piece(n / LANES, n % LANES)
    }

    #[inline(always)]
    fn piece(&self, pass: usize, i: usize) -> Segment<T> {
        let [f0, f1, kappa] = &self.value;
        let (eps, length) = (self.way[8][pass][i], self.way[9][pass][i]);
        Segment { f0: f0[pass][i], f1: f1[pass][i], kappa: kappa[pass][i], eps, length }
    }

    /// Value, and gradient where there is light, along frustum number `n`, and its length.
    #[inline]
    pub fn course(&self, n: usize, caster: &Caster<'_, T, N>) -> (Course<T, N>, T) {
        let (pass, i) = (n / LANES, n % LANES);
        if self.is_usual[pass][i] {
            return (self.usual_course(pass, i), self.way[9][pass][i]);
        }
        let [a, b, c, d, e, f] =
            self.samples.each_ref().map_inline(|row| caster.samples.normal(row[pass][i]));
        let (cells, layers) = (self.cells[pass][i], self.layers[pass][i]);
        let [w0, w1, w2, w3, t0, t1, p0, p1, eps, length] =
            self.way.each_ref().map_inline(|row| row[pass][i]);
        let chord = |values: [T; 3], layer: u32| {
            let vertex = |k: usize| caster.vertex(cells[k], values[k], layer as usize);
            Chord::over([vertex(0), vertex(1), vertex(2)], &[[w0, w1], [w2, w3]])
        };
        let (first, second) = (chord([a, b, c], layers[0]), chord([d, e, f], layers[1]));
        let course = first.mix(second, p0).course(&first.mix(second, p1), [t0, t1], eps);
        (course, length)
    }

    /// Interpolates all frusta, and integrates those that are thin.
    #[inline(always)]
    pub fn integrate<V: Simd>(&mut self, simd: V, caster: &Caster<'_, T, N>) {
        let mut left = [0; PASSES];
        for pass in 0..self.count.div_ceil(LANES).min(PASSES) {
            let is_usual = self.interpolate(pass, &caster.samples);
            self.is_usual[pass] = is_usual;
            if !caster.integrates {
                self.known[pass] = [Known::Clear; LANES];
                continue;
            }
            let mut medium = [[T::zero(); LANES]; NUMBERS];
            let is_whole = self.find_spans(simd, pass, caster.spans, &mut medium);
            let is_thin = self.thin(pass, &medium);
            for i in 0..LANES {
                let is_whole = is_usual[i] & is_whole[i];
                let known = if is_thin[i] { Known::Light } else { Known::Odd };
                let known = if self.is_clear[pass][i] { Known::Clear } else { known };
                self.known[pass][i] = if is_whole { known } else { Known::Odd };
            }
            if N == 4 {
                left[pass] = self.shade(simd, pass, caster, &medium);
            }
        }
        if N == 4 {
            self.halve(simd, caster, &left);
        }
    }

    /// Whether what was read is neither missing nor beyond all bounds.
    #[inline(always)]
    fn interpolate(&mut self, pass: usize, samples: &AnySamples) -> [bool; LANES] {
        let read = self.samples.each_ref().map_inline(|row| &row[pass]);
        let way = self.way.each_ref().map_inline(|row| &row[pass]);
        let mut value = [[T::zero(); LANES]; 3];
        let mut is_usual = [true; LANES];
        for i in 0..LANES {
            let mut values = [[T::zero()]; 6];
            for k in 0..6 {
                let (value, usual) = samples.usual(read[k][i]);
                (values[k], is_usual[i]) = ([value], is_usual[i] & usual);
            }
            let [a, b, c, d, e, f] = values;
            let weight = [[way[0][i], way[1][i]], [way[2][i], way[3][i]]];
            let (first, second) = (Chord::over([a, b, c], &weight), Chord::over([d, e, f], &weight));
            let (at_a, at_b) = (first.mix(second, way[6][i]), first.mix(second, way[7][i]));
            let course = at_a.course(&at_b, [way[4][i], way[5][i]], way[8][i]);
            (value[0][i], value[1][i], value[2][i]) = (course.from[0], course.to[0], course.kappa[0]);
        }
        self.value.iter_mut().zip(value).for_each(|(row, value)| row[pass] = value);
        is_usual
    }

    /// Finds the span that each frustum surely lies in, if there is one.
    #[inline(always)]
    fn find_spans<V: Simd>(
        &mut self,
        simd: V,
        pass: usize,
        spans: &Spans<T>,
        medium: &mut Medium<T>,
    ) -> [bool; LANES] {
        let [f0, f1, kappa] = self.value.each_ref().map_inline(|row| &row[pass]);
        let (eps, length) = (&self.way[8][pass], &self.way[9][pass]);
        let segment =
            |i: usize| Segment { f0: f0[i], f1: f1[i], kappa: kappa[i], eps: eps[i], length: length[i] };
        let mut lowest = [T::zero(); LANES];
        for i in 0..LANES {
            lowest[i] = segment(i).within()[0];
        }
        self.span[pass] = spans.find_all(&lowest);
        *medium = spans.media(simd, &self.span[pass]);
        let [anchor, extinction, slope, .., high, clear] = medium;
        for i in 0..LANES {
            // As [`Span::is_clear_in`].
            let there = extinction[i] + slope[i] * (f0[i] - anchor[i]);
            let is_constant = segment(i).is_constant() & (there <= T::zero());
            self.is_clear[pass][i] = (clear[i] > T::zero()) | is_constant;
        }
        // The least value lies in the span already.
        let mut is_whole = [false; LANES];
        for i in 0..LANES {
            let segment = segment(i);
            is_whole[i] = ThinPiece::takes(&segment) & (segment.within()[1] <= high[i]);
        }
        is_whole
    }

    /// Whether the rule is near enough.
    #[inline(always)]
    fn thin(&mut self, pass: usize, medium: &Medium<T>) -> [bool; LANES] {
        let mut light = [[T::zero(); LANES]; 6];
        let mut is_near = [false; LANES];
        for i in 0..LANES {
            let (segment, span) = (self.piece(pass, i), span_of(medium, i));
            let thin = ThinPiece::new(&segment, &span);
            let Light { color, absorbed, error, variance } = thin.light(segment.reach());
            [light[0][i], light[1][i], light[2][i]] = color;
            [light[3][i], light[4][i], light[5][i]] = [absorbed, error, variance];
            is_near[i] = thin.is_near(self.share);
        }
        self.light.iter_mut().zip(light).for_each(|(row, light)| row[pass] = light);
        is_near
    }
}

/// What integration asks of the span that frustum `i` of a pass lies in.
#[inline(always)]
fn span_of<T: Real>(medium: &Medium<T>, i: usize) -> Span<T> {
    let [anchor, extinction, extinction_slope, steepest, r, g, b, dr, dg, db, brightest, ..] = medium;
    Span {
        anchor: anchor[i],
        extinction: extinction[i],
        extinction_slope: extinction_slope[i],
        steepest: steepest[i],
        brightest: brightest[i],
        color: [r[i], g[i], b[i]],
        color_slope: [dr[i], dg[i], db[i]],
        ..Span::unknown()
    }
}
