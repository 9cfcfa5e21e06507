//! Frusta of several rays, interpolated and integrated several at a time in the machine's widest vectors.
//!
//! The source has loops over the lanes of a row, with the functions of one frustum inlined in them, which the compiler
//! turns into vectors for each instruction set. So a lane computes the same bits as a ray that is traced alone. Only
//! the cheapest rule of integration is used here; the ray integrates the frusta for which it is not near enough.

use crate::lit::FrustumInterpolant;
use crate::piece::{Radiance, ThinPiece};
use crate::segment::Segment;
use crate::single_volume::SingleVolumeTracer;
use crate::transfer::{Media, Spans};
use crate::walk::packet::{LANES, Lanes, lanes};
use fearless_simd::Simd;
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;
use icoray_grid::sample::AnySamples;
use lit::Lights;
pub(super) use rows::FrustumCrossing;
use rows::{Rows, no_lights, no_segments};

mod lit;
mod rows;

/// Passes over all frusta of a batch: each takes a row of them.
const PASSES: usize = 9;

/// An element for each frustum.
type All<X> = [Lanes<X>; PASSES];

/// Input of a frustum: the samples at the three vertices on the layer behind and on the layer ahead, the cells and the
/// layers of these, and whether the ray has skipped a gap since its last frustum.
pub(super) type Read = ([f64; 6], [u32; 3], [u32; 2], bool);

#[inline]
fn all<X: Copy>(value: X) -> All<X> {
    [[value; LANES]; PASSES]
}

/// Result of integrating a frustum in its lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LaneStatus {
    /// Not integrated: the ray integrates it in scalar code.
    Scalar,
    /// Its light.
    Light,
    /// It is clear.
    Clear,
}

/// Frusta side by side. Without lighting (N = 1), cells and layers of the samples are not stored.
#[derive(Debug)]
pub(super) struct Batch<T, const N: usize> {
    count: usize,
    /// Error that is allowed per absorbed light.
    color_tolerance: T,
    /// The lane of the frustum's ray.
    lane: All<u8>,
    /// At the three vertices on the layer behind, and on the layer ahead.
    samples: [All<f64>; 6],
    cells: All<[u32; 3]>,
    layers: All<[u32; 2]>,
    is_fresh: All<bool>,
    crossing: FrustumCrossing<All<T>>,
    segments: [Segment<Lanes<T>>; PASSES],
    span: All<u32>,
    is_usual: All<bool>,
    is_clear: All<bool>,
    known: All<LaneStatus>,
    light: [Radiance<Lanes<T>>; PASSES],
    /// Lighting of each ray.
    lights: Option<Box<Lights<T>>>,
}

impl<T: Real, const N: usize> Batch<T, N> {
    #[inline]
    pub fn new(color_tolerance: T) -> Self {
        Batch {
            count: 0,
            color_tolerance,
            lane: all(0),
            samples: [all(0.0); 6],
            cells: all([0; 3]),
            layers: all([0; 2]),
            is_fresh: all(false),
            crossing: FrustumCrossing::splat(all(T::zero())),
            segments: [no_segments(); PASSES],
            span: all(0),
            is_usual: all(false),
            is_clear: all(false),
            known: all(LaneStatus::Scalar),
            light: [no_lights(); PASSES],
            lights: None,
        }
    }

    /// Number of frusta.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Removes all frusta.
    #[inline]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Whether there may be too little room for another call of [`Self::push`].
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count > (PASSES - 2) * LANES
    }

    /// Adds a frustum of each lane whose bit is set. The batch must not be full.
    #[inline(always)]
    pub fn push<V: Simd>(
        &mut self,
        simd: V,
        bits: u32,
        crossing: FrustumCrossing<&Lanes<T>>,
        read: impl Fn(usize) -> Read,
    ) {
        let count = self.count;
        for (rows, row) in self.crossing.all_mut().into_iter().zip(crossing.all()) {
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

    /// The lane of the ray of frustum number `n`.
    #[inline(always)]
    pub fn lane(&self, n: usize) -> usize {
        self.lane[n / LANES][n % LANES] as usize % LANES
    }

    /// The status of frustum number `n`, and, unless it is `Scalar`, the span that it lies in.
    #[inline(always)]
    pub fn status(&self, n: usize) -> (LaneStatus, usize) {
        let (pass, i) = (n / LANES, n % LANES);
        (self.known[pass][i], self.span[pass][i] as usize)
    }

    /// Whether the ray has skipped a gap before frustum number `n`.
    #[inline(always)]
    pub fn is_after_skip(&self, n: usize) -> bool {
        self.is_fresh[n / LANES][n % LANES]
    }

    /// The light of frustum number `n`, where it is known.
    #[inline(always)]
    pub fn light(&self, n: usize) -> Radiance<T> {
        self.light[n / LANES].at(n % LANES)
    }

    /// The value along frustum number `n`.
    #[inline(always)]
    pub fn segment(&self, n: usize) -> Segment<T> {
        self.segments[n / LANES].at(n % LANES)
    }

    /// Value, and gradient where there is light, along frustum number `n`, and its length.
    #[inline]
    pub fn interpolant(&self, n: usize, tracer: &SingleVolumeTracer<'_, T>) -> (FrustumInterpolant<T, N>, T) {
        let (pass, i) = (n / LANES, n % LANES);
        let crossing = self.crossing.map(|rows| rows[pass][i]);
        if self.is_usual[pass][i] {
            return (self.complete_interpolant(pass, i), crossing.length);
        }
        let [a, b, c, d, e, f] = self.samples.each_ref().map_inline(|row| tracer.samples.normal(row[pass][i]));
        let (cells, layers) = (self.cells[pass][i], self.layers[pass][i]);
        let vertices =
            |values: [T; 3], layer: u32| [0, 1, 2].map_inline(|k| tracer.vertex(cells[k], values[k], layer as usize));
        (crossing.interpolant(vertices([a, b, c], layers[0]), vertices([d, e, f], layers[1])), crossing.length)
    }

    /// Interpolates all frusta, and integrates those that are thin.
    #[inline(always)]
    pub fn integrate<V: Simd>(&mut self, simd: V, tracer: &SingleVolumeTracer<'_, T>) {
        for pass in 0..self.count.div_ceil(LANES).min(PASSES) {
            let is_usual = self.interpolate(pass, &tracer.samples);
            self.is_usual[pass] = is_usual;
            if !tracer.integrates {
                self.known[pass] = [LaneStatus::Clear; LANES];
                continue;
            }
            let media = self.find_spans(simd, pass, tracer.spans);
            let is_whole = self.is_whole(pass, &media);
            let is_thin = self.thin(pass, &media);
            for i in 0..LANES {
                let is_whole = is_usual[i] & is_whole[i];
                let known = if is_thin[i] { LaneStatus::Light } else { LaneStatus::Scalar };
                let known = if self.is_clear[pass][i] { LaneStatus::Clear } else { known };
                self.known[pass][i] = if is_whole { known } else { LaneStatus::Scalar };
            }
            if N == 4 {
                self.shade(pass, tracer);
            }
        }
    }

    /// Interpolates a pass; gives for each frustum whether no sample of it is missing or beyond all bounds.
    #[inline(always)]
    fn interpolate(&mut self, pass: usize, samples: &AnySamples) -> [bool; LANES] {
        let read = self.samples.each_ref().map_inline(|row| &row[pass]);
        let crossings = self.crossing.map(|rows| &rows[pass]);
        let mut segments = no_segments();
        let mut is_usual = [true; LANES];
        for i in 0..LANES {
            let mut values = [[T::zero()]; 6];
            for k in 0..6 {
                let (value, usual) = samples.usual(read[k][i]);
                (values[k], is_usual[i]) = ([value], is_usual[i] & usual);
            }
            let [a, b, c, d, e, f] = values;
            let crossing = crossings.map(|row| row[i]);
            let interpolant = crossing.interpolant([a, b, c], [d, e, f]);
            let ([f0], [f1], [kappa]) = (interpolant.from, interpolant.to, interpolant.kappa);
            segments.set(i, &Segment { f0, f1, kappa, eps: crossing.eps, length: crossing.length });
        }
        self.segments[pass] = segments;
        is_usual
    }

    /// Finds the spans in which the least values of a pass lie, and which of its frusta are clear there.
    #[inline(always)]
    fn find_spans<V: Simd>(&mut self, simd: V, pass: usize, spans: &Spans<T>) -> Media<T> {
        let segments = &self.segments[pass];
        let mut lowest = [T::zero(); LANES];
        for i in 0..LANES {
            lowest[i] = segments.at(i).within()[0];
        }
        self.span[pass] = spans.find_all(&lowest);
        let media = spans.media(simd, &self.span[pass]);
        for i in 0..LANES {
            // As [`Span::is_clear_in`](crate::transfer::Span::is_clear_in), without a branch.
            let (segment, span) = (segments.at(i), media.span(i));
            let is_constant = segment.is_constant() & (span.extinction(segment.f0) <= T::zero());
            self.is_clear[pass][i] = span.is_clear | is_constant;
        }
        media
    }

    /// Whether each frustum of a pass stays in the span of its least value.
    #[inline(always)]
    fn is_whole(&self, pass: usize, media: &Media<T>) -> [bool; LANES] {
        let mut is_whole = [false; LANES];
        for i in 0..LANES {
            let segment = self.segments[pass].at(i);
            is_whole[i] = ThinPiece::applies_to(&segment) & (segment.within()[1] <= media.span(i).high);
        }
        is_whole
    }

    /// Integrates a pass by the rule for thin pieces; gives for each frustum whether the rule is near enough.
    #[inline(always)]
    fn thin(&mut self, pass: usize, media: &Media<T>) -> [bool; LANES] {
        let mut lights = no_lights();
        let mut is_near = [false; LANES];
        for i in 0..LANES {
            let (segment, span) = (self.segments[pass].at(i), media.span(i));
            let thin = ThinPiece::new(&segment, &span);
            lights.set(i, &thin.light(segment.reach()));
            is_near[i] = thin.is_near(self.color_tolerance);
        }
        self.light[pass] = lights;
        is_near
    }
}
