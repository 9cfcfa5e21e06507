//! Pieces integrated several at a time, in the machine's widest vectors.
//!
//! There is one source: a loop over pieces that lie side by side, with the scalar functions inlined in it, which the compiler turns into
//! vectors for each kind of machine. So lanes compute what one piece after the other would. Only [`thin`] is
//! worth it: what it is not near enough for is left to [`super::integrate`].

use super::{Light, THIN, Terms, bend_series, thin, thin_error};
use crate::kernel::real::Real;
use crate::kernel::segment::Segment;
use crate::kernel::transfer::Span;
use fearless_simd::{Level, dispatch};

/// Pieces that are integrated by one pass of the loop.
const LANES: usize = 16;
/// Pieces that a batch holds.
pub(crate) const ROOM: usize = 2 * LANES;

/// A number of each piece.
type Row<T> = [[T; LANES]; ROOM / LANES];

/// Pieces side by side, in the order of a ray, and the light of those that are done.
#[derive(Debug, Clone)]
pub(crate) struct Batch<T> {
    count: usize,
    /// f0, f1, kappa, eps, length.
    piece: [Row<T>; 5],
    /// Number of the span that a piece begins in, and whether it surely stays there.
    span: Row<u32>,
    is_whole: Row<bool>,
    /// Of the span: anchor, extinction and its slope, steepest, colour, its slopes.
    medium: [Row<T>; 10],
    /// Colour, absorbed, error, variance.
    light: [Row<T>; 6],
    is_near: Row<bool>,
}

impl<T: Real> Batch<T> {
    pub fn new() -> Self {
        let zero = [[T::zero(); LANES]; ROOM / LANES];
        let (span, no) = ([[0; LANES]; ROOM / LANES], [[false; LANES]; ROOM / LANES]);
        Batch {
            count: 0,
            piece: [zero; 5],
            span,
            is_whole: no,
            medium: [zero; 10],
            light: [zero; 6],
            is_near: no,
        }
    }

    /// How many pieces there are.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Forgets all pieces.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds a piece that begins in `span`, number `k`.
    #[inline(always)]
    pub fn push(&mut self, piece: &Segment<T>, span: &Span<T>, k: usize, is_whole: bool) {
        let n = self.count.min(ROOM - 1);
        let (pass, i) = (n / LANES, n % LANES);
        let numbers = [piece.f0, piece.f1, piece.kappa, piece.eps, piece.length];
        self.piece.iter_mut().zip(numbers).for_each(|(row, number)| row[pass][i] = number);
        let ([r, g, b], [dr, dg, db]) = (span.color, span.color_slope);
        let numbers =
            [span.anchor, span.extinction, span.extinction_slope, span.steepest, r, g, b, dr, dg, db];
        self.medium.iter_mut().zip(numbers).for_each(|(row, number)| row[pass][i] = number);
        self.span[pass][i] = k as u32;
        self.is_whole[pass][i] = is_whole;
        self.count = n + 1;
    }

    /// Piece number `n` and the span that it begins in.
    #[inline(always)]
    pub fn piece(&self, n: usize) -> (Segment<T>, usize) {
        let (pass, i) = (n / LANES, n % LANES);
        let [f0, f1, kappa, eps, length] = self.piece.each_ref().map(|row| row[pass][i]);
        (Segment { f0, f1, kappa, eps, length }, self.span[pass][i] as usize)
    }

    /// The light of piece number `n`, where [`Self::integrate`] was near enough.
    #[inline(always)]
    pub fn light(&self, n: usize) -> Option<Light<T>> {
        let (pass, i) = (n / LANES, n % LANES);
        let [r, g, b, absorbed, error, variance] = self.light.each_ref().map(|row| row[pass][i]);
        (self.is_near[pass][i] & self.is_whole[pass][i]).then_some(Light {
            color: [r, g, b],
            absorbed,
            error,
            variance,
        })
    }

    /// Integrates all pieces, allowing each the error `share` per absorbed light.
    pub fn integrate(&mut self, level: Level, share: T) {
        dispatch!(level, _simd => self.passes(share));
    }

    #[inline(always)]
    fn passes(&mut self, share: T) {
        for pass in 0..self.count.div_ceil(LANES).min(ROOM / LANES) {
            self.pass(pass, share);
        }
    }

    #[inline(always)]
    fn pass(&mut self, pass: usize, share: T) {
        let [f0, f1, kappa, eps, length] = self.piece.each_ref().map(|row| &row[pass]);
        let [anchor, extinction, extinction_slope, steepest, r, g, b, dr, dg, db] =
            self.medium.each_ref().map(|row| &row[pass]);
        let mut light = [[T::zero(); LANES]; 6];
        let mut is_near = [false; LANES];
        for i in 0..LANES {
            let piece = Segment { f0: f0[i], f1: f1[i], kappa: kappa[i], eps: eps[i], length: length[i] };
            let span = Span {
                anchor: anchor[i],
                extinction: extinction[i],
                extinction_slope: extinction_slope[i],
                steepest: steepest[i],
                color: [r[i], g[i], b[i]],
                color_slope: [dr[i], dg[i], db[i]],
                ..Span::unknown()
            };
            let terms = Terms::of(&piece, &span, bend_series(piece.eps));
            let absorbed = terms.depth.absorbed_by_thin();
            let error = span.steepest() * (thin_error(&terms) + terms.skew(absorbed));
            let color = terms.light(absorbed, thin(&terms), error).color;
            [light[0][i], light[1][i], light[2][i]] = color;
            [light[3][i], light[4][i]] = [absorbed, error];
            light[5][i] = terms.variance(absorbed, piece.reach());
            is_near[i] = (terms.depth < T::of(THIN)) & (error <= share * absorbed);
        }
        self.light.iter_mut().zip(light).for_each(|(row, light)| row[pass] = light);
        self.is_near[pass] = is_near;
    }
}
