//! Frusta of a batch under light: gradients along them, three shades of each, and what [`Lit::light`] makes of these where it
//! would cut once at most.
//!
//! [`Lit::light`]: crate::kernel::lit::Lit::light

use super::{Batch, Known, Medium, PASSES, Rows, rows, span_of};
use crate::kernel::column::Chord;
use crate::kernel::lit::{Course, Shades, Spread, off};
use crate::kernel::piece::{Light, ThinPiece};
use crate::kernel::ray::Caster;
use crate::kernel::real::Real;
use crate::kernel::segment::Segment;
use crate::kernel::shade::{RayShading, Shade};
use crate::kernel::transfer::Span;
use crate::kernel::walk::pack::{LANES, Row, lanes};
use fearless_simd::Simd;

/// What light each ray meets: the same for all but for the directions.
#[derive(Debug)]
pub(super) struct Lights<T> {
    common: RayShading<T>,
    /// Towards the light, and half-way between that and the eye, of each lane; twice as long as a row for [`Real::look_up`].
    directions: [[T; 32]; 6],
    /// The gradient along each frustum that is usual and not clear.
    courses: [[Vectors<T>; 3]; PASSES],
    /// What the front half of each frustum in halves absorbs.
    front: Rows<T>,
}

impl<T: Real> Lights<T> {
    /// The directions of each frustum's ray.
    #[inline(always)]
    fn of<V: Simd>(&self, simd: V, lanes: &Row<u8>) -> [Row<T>; 6] {
        let mut numbers = [0; LANES];
        for i in 0..LANES {
            numbers[i] = u32::from(lanes[i]);
        }
        let mut directions = [[T::zero(); LANES]; 6];
        for k in 0..6 {
            directions[k] = T::look_up(simd, &self.directions[k], &numbers);
        }
        directions
    }
}

/// A gradient of each frustum.
type Vectors<T> = [Row<T>; 3];

impl<T: Real, const N: usize> Batch<T, N> {
    /// Makes known how the ray of a lane is lit. Must be told before its first frustum.
    #[inline]
    pub fn light_lane(&mut self, lane: usize, shading: &RayShading<T>) {
        let none = || {
            let zero = T::zero();
            Box::new(Lights {
                common: *shading,
                directions: [[zero; 32]; 6],
                courses: [[[[zero; LANES]; 3]; 3]; PASSES],
                front: rows(zero),
            })
        };
        let lights = self.lights.get_or_insert_with(none);
        let directions = shading.light.iter().chain(&shading.halfway);
        lights.directions.iter_mut().zip(directions).for_each(|(row, x)| row[lane] = *x);
    }

    /// Value, and gradient where there is light, along frustum `i` of a pass, which is usual and not clear.
    #[inline]
    pub fn usual_course(&self, pass: usize, i: usize) -> Course<T, N> {
        let piece = self.piece(pass, i);
        let of = |value: T, which: usize| {
            let mut values = [value; N];
            if let Some(lights) = &self.lights {
                for (k, value) in values.iter_mut().enumerate().skip(1) {
                    *value = lights.courses[pass][which][(k - 1) % 3][i];
                }
            }
            values
        };
        Course { from: of(piece.f0, 0), to: of(piece.f1, 1), kappa: of(piece.kappa, 2), eps: piece.eps }
    }

    /// What the front half of frustum number `n` absorbs, of which the light of two halves is known.
    #[inline(always)]
    pub fn front(&self, n: usize) -> T {
        self.lights.as_ref().map_or(T::zero(), |lights| lights.front[n / LANES][n % LANES])
    }

    /// Puts what is integrated of a pass under light, and keeps the gradients. Gives the bits of the frusta that three shades
    /// do not tell near enough.
    #[inline(always)]
    pub(super) fn shade<V: Simd>(
        &mut self,
        simd: V,
        pass: usize,
        caster: &Caster<'_, T, N>,
        medium: &Medium<T>,
    ) -> u32 {
        let courses = self.courses(pass, &self.gradients(pass, caster));
        let Some(lights) = &mut self.lights else { return 0 };
        lights.courses[pass] = courses;
        let common = lights.common;
        let directions = lights.of(simd, &self.lane[pass]);
        let mut shades = [[[T::zero(); LANES]; 5]; 3];
        for k in 0..3 {
            let u = T::of(0.5 * k as f64);
            shades[k] = shades_at(u, &courses, &self.way[8][pass], &common, &directions);
        }
        let mut lit = [[T::zero(); LANES]; 6];
        let mut is_near = [false; LANES];
        for i in 0..LANES {
            let (piece, span) = (self.piece(pass, i), span_of(medium, i));
            let shades = [&shade_of(&shades[0], i), &shade_of(&shades[1], i), &shade_of(&shades[2], i)];
            let spread = Spread::of(&piece, &span);
            let off = off(&lit_along(&common, &directions, i), shades, &span, &spread);
            let mean = RayShading::mean(shades[0], shades[1], shades[2], spread.centre);
            put(&mut lit, i, &common.apply(self.light_at(pass, i), mean, off));
            is_near[i] = off <= self.share;
        }
        self.light.iter_mut().zip(lit).for_each(|(row, lit)| row[pass] = lit);
        let mut left = 0;
        for i in 0..LANES {
            let is_left = (self.known[pass][i] == Known::Light) & !(is_near[i] | caster.is_coarse);
            self.known[pass][i] = if is_left { Known::Odd } else { self.known[pass][i] };
            left |= u32::from(is_left) << i;
        }
        left
    }

    /// Integrates frusta in halves, as [`Lit`] does next, those whose bits are set.
    ///
    /// [`Lit`]: crate::kernel::lit::Lit
    #[inline(always)]
    pub(super) fn halve<V: Simd>(&mut self, simd: V, caster: &Caster<'_, T, N>, left: &[u32; PASSES]) {
        let (mut some, mut count) = ([0; LANES], 0);
        for (pass, bits) in left.iter().enumerate() {
            for i in lanes(*bits) {
                some[count % LANES] = pass * LANES + i;
                count += 1;
                if count == LANES {
                    self.halve_some(simd, caster, &some, LANES);
                    count = 0;
                }
            }
        }
        if count > 0 {
            self.halve_some(simd, caster, &some, count);
        }
    }

    /// The first `count` of the frusta `some`.
    #[inline(always)]
    fn halve_some<V: Simd>(
        &mut self,
        simd: V,
        caster: &Caster<'_, T, N>,
        some: &[usize; LANES],
        count: usize,
    ) {
        let Some(lights) = &mut self.lights else { return };
        let mut courses = [[[T::zero(); LANES]; 3]; 3];
        let mut piece = [[T::zero(); LANES]; 5];
        let (mut lane, mut span) = ([0; LANES], [0; LANES]);
        for j in 0..count {
            let (pass, i) = (some[j] / LANES % PASSES, some[j] % LANES);
            for k in 0..9 {
                courses[k / 3][k % 3][j] = lights.courses[pass][k / 3][k % 3][i];
            }
            for k in 0..3 {
                piece[k][j] = self.value[k][pass][i];
            }
            (piece[3][j], piece[4][j]) = (self.way[8][pass][i], self.way[9][pass][i]);
            (lane[j], span[j]) = (self.lane[pass][i], self.span[pass][i]);
        }
        let common = lights.common;
        let directions = lights.of(simd, &lane);
        let medium = caster.spans.media(simd, &span);
        let mut shades = [[[T::zero(); LANES]; 5]; 5];
        for k in 0..5 {
            shades[k] = shades_at(T::of(0.25 * k as f64), &courses, &piece[3], &common, &directions);
        }
        let mut lit = [[T::zero(); LANES]; 6];
        let mut front = [T::zero(); LANES];
        let mut is_near = [false; LANES];
        for j in 0..LANES {
            let [f0, f1, kappa, eps, length] = &piece;
            let piece = Segment { f0: f0[j], f1: f1[j], kappa: kappa[j], eps: eps[j], length: length[j] };
            let [a, b, c, d, e] = &shades;
            let (a, b, c) = (&shade_of(a, j), &shade_of(b, j), &shade_of(c, j));
            let (d, e) = (&shade_of(d, j), &shade_of(e, j));
            let span = span_of(&medium, j);
            let shading = lit_along(&common, &directions, j);
            let halves = Halves::new(&piece, &span, &shading, self.share);
            let (mut light, front_near) = halves.light(false, [a, b, c]);
            let (behind, back_near) = halves.light(true, [c, d, e]);
            front[j] = light.absorbed;
            light.over(&behind);
            put(&mut lit, j, &light);
            is_near[j] = front_near & back_near & (halves.depth <= T::one());
        }
        for j in 0..count {
            let (pass, i) = (some[j] / LANES % PASSES, some[j] % LANES);
            for k in 0..6 {
                self.light[k][pass][i] = lit[k][j];
            }
            lights.front[pass][i] = front[j];
            self.known[pass][i] = if is_near[j] { Known::Halves } else { Known::Odd };
        }
    }

    /// The gradients at the six vertices, of the frusta that are usual and not clear.
    #[inline(always)]
    fn gradients(&self, pass: usize, caster: &Caster<'_, T, N>) -> [Vectors<T>; 6] {
        let layers = caster.shell.layers();
        let mut gradients = [[[T::zero(); LANES]; 3]; 6];
        for i in 0..LANES {
            let is_read = self.is_usual[pass][i] & (self.known[pass][i] != Known::Clear);
            if !is_read | (pass * LANES + i >= self.count) {
                continue;
            }
            let (cells, [behind, ahead]) = (self.cells[pass][i], self.layers[pass][i]);
            for k in 0..6 {
                let layer = if k < 3 { behind } else { ahead };
                let gradient = caster.gradients.at(cells[k % 3] as usize * layers + layer as usize);
                for (rows, x) in gradients[k].iter_mut().zip(gradient) {
                    rows[i] = T::of(f64::from(x));
                }
            }
        }
        gradients
    }

    /// The three components along each frustum: from, to, kappa.
    #[inline(always)]
    fn courses(&self, pass: usize, gradients: &[Vectors<T>; 6]) -> [Vectors<T>; 3] {
        let way = |k: usize, i: usize| self.way[k][pass][i];
        let mut courses = [[[T::zero(); LANES]; 3]; 3];
        for k in 0..3 {
            for i in 0..LANES {
                let at = |vertex: usize| [gradients[vertex][k][i]];
                let weight = [[way(0, i), way(1, i)], [way(2, i), way(3, i)]];
                let first = Chord::over([at(0), at(1), at(2)], &weight);
                let second = Chord::over([at(3), at(4), at(5)], &weight);
                let (at_a, at_b) = (first.mix(second, way(6, i)), first.mix(second, way(7, i)));
                let course = at_a.course(&at_b, [way(4, i), way(5, i)], way(8, i));
                courses[0][k][i] = course.from[0];
                courses[1][k][i] = course.to[0];
                courses[2][k][i] = course.kappa[0];
            }
        }
        courses
    }
}

/// A piece in two halves.
struct Halves<'h, T> {
    parts: [Segment<T>; 2],
    span: &'h Span<T>,
    shading: &'h RayShading<T>,
    share: T,
    /// How far rounding may have put the whole piece's values.
    reach: T,
    /// The most that the whole piece's optical depth can be.
    depth: T,
    /// What a half's light may change and yet not be cut again.
    enough: T,
}

impl<'h, T: Real> Halves<'h, T> {
    #[inline(always)]
    fn new(piece: &Segment<T>, span: &'h Span<T>, shading: &'h RayShading<T>, share: T) -> Self {
        let half = T::of(0.5);
        let depth = most_depth(piece, span);
        let cut = (half, piece.value(half));
        let parts = [piece.part((T::zero(), piece.f0), cut), piece.part(cut, (T::one(), piece.f1))];
        let enough = T::of(0.03) * share * (half * depth).absorbed_by_thin();
        Halves { parts, span, shading, share, reach: piece.reach(), depth, enough }
    }

    /// The light of the front or back half, and whether it is near enough.
    #[inline(always)]
    fn light(&self, is_back: bool, shades: Shades<'_, T>) -> (Light<T>, bool) {
        let part = if is_back { &self.parts[1] } else { &self.parts[0] };
        let spread = Spread::of(part, self.span);
        let off = off(self.shading, shades, self.span, &spread);
        let thin = ThinPiece::new(part, self.span);
        let mean = RayShading::mean(shades[0], shades[1], shades[2], spread.centre);
        let light = self.shading.apply(thin.light(self.reach), mean, off);
        let is_near = (off <= self.share) | (off * most_depth(part, self.span) <= self.enough);
        (light, is_near & ThinPiece::takes(part) & thin.is_near(self.share))
    }
}

/// The most that the optical depth of a piece without a bend can be.
#[inline(always)]
fn most_depth<T: Real>(piece: &Segment<T>, span: &Span<T>) -> T {
    piece.length * span.extinction(piece.f0).max(span.extinction(piece.f1))
}

/// The shade of each frustum at `u`: body, highlight and normal.
#[inline(always)]
fn shades_at<T: Real>(
    u: T,
    [from, to, kappa]: &[Vectors<T>; 3],
    eps: &Row<T>,
    common: &RayShading<T>,
    directions: &[Row<T>; 6],
) -> [Row<T>; 5] {
    let mut shades = [[T::zero(); LANES]; 5];
    for i in 0..LANES {
        let of = |rows: &Vectors<T>| [T::zero(), rows[0][i], rows[1][i], rows[2][i]];
        let course = Course { from: of(from), to: of(to), kappa: of(kappa), eps: eps[i] };
        let shading = lit_along(common, directions, i);
        let Shade { body, highlight, normal } = shading.shade(course.gradient(u));
        [shades[0][i], shades[1][i]] = [body, highlight];
        [shades[2][i], shades[3][i], shades[4][i]] = normal;
    }
    shades
}

/// How the ray of frustum `i` is lit, from its directions towards the light and half-way to the eye.
#[inline(always)]
fn lit_along<T: Real>(
    common: &RayShading<T>,
    [x, y, z, hx, hy, hz]: &[Row<T>; 6],
    i: usize,
) -> RayShading<T> {
    RayShading { light: [x[i], y[i], z[i]], halfway: [hx[i], hy[i], hz[i]], ..*common }
}

#[inline(always)]
fn put<T: Real>(rows: &mut [Row<T>; 6], i: usize, light: &Light<T>) {
    [rows[0][i], rows[1][i], rows[2][i]] = light.color;
    [rows[3][i], rows[4][i], rows[5][i]] = [light.absorbed, light.error, light.variance];
}

#[inline(always)]
fn shade_of<T: Real>(rows: &[Row<T>; 5], i: usize) -> Shade<T> {
    let [body, highlight, x, y, z] = rows;
    Shade { body: body[i], highlight: highlight[i], normal: [x[i], y[i], z[i]] }
}
