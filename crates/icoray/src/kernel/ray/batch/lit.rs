//! Frusta of a batch under light: gradients along them, three shades of each, and what [`Lit::light`] makes of these where it
//! would not cut.
//!
//! [`Lit::light`]: crate::kernel::lit::Lit::light

use super::{Batch, Known, Medium, span_of};
use crate::kernel::column::Chord;
use crate::kernel::lit::{Course, Spread, off};
use crate::kernel::piece::Light;
use crate::kernel::ray::Caster;
use crate::kernel::real::Real;
use crate::kernel::sample::Sample;
use crate::kernel::shade::{RayShading, Shade};
use crate::kernel::walk::pack::{LANES, Row};
use fearless_simd::Simd;

/// What light each ray meets: the same for all but for the directions.
#[derive(Debug)]
pub(super) struct Lights<T> {
    common: RayShading<T>,
    /// Towards the light, and half-way between that and the eye, of each lane; twice as long as a row for [`Real::look_up`].
    directions: [[T; 32]; 6],
}

/// A gradient of each frustum.
type Vectors<T> = [Row<T>; 3];

/// Where a frustum's shades are taken.
const PLACES: [f64; 3] = [0.0, 0.5, 1.0];

impl<T: Real, S: Sample, const N: usize> Batch<T, S, N> {
    /// Makes known how the ray of a lane is lit. Must be told before its first frustum.
    pub fn light_lane(&mut self, lane: usize, shading: &RayShading<T>) {
        let none = || Box::new(Lights { common: *shading, directions: [[T::zero(); 32]; 6] });
        let lights = self.lights.get_or_insert_with(none);
        let directions = shading.light.iter().chain(&shading.halfway);
        lights.directions.iter_mut().zip(directions).for_each(|(row, x)| row[lane] = *x);
    }

    /// Puts what is integrated of a pass under light. What three shades do not tell near enough is left to the ray.
    #[inline(always)]
    pub(super) fn shade<V: Simd>(
        &mut self,
        simd: V,
        pass: usize,
        caster: &Caster<'_, T, S, N>,
        medium: &Medium<T>,
    ) {
        let Some(lights) = &self.lights else { return };
        if self.known[pass].iter().all(|known| *known != Known::Light) {
            return;
        }
        let lane = self.lane[pass].map(u32::from);
        let directions = lights.directions.each_ref().map(|row| T::look_up(simd, row, &lane));
        let common = lights.common;
        let courses = self.courses(pass, &self.gradients(pass, caster));
        let shades = PLACES.map(|u| self.shades(pass, &courses, T::of(u), &common, &directions));
        let mut lit = [[T::zero(); LANES]; 6];
        let mut is_near = [false; LANES];
        for i in 0..LANES {
            let (piece, span) = (self.piece(pass, i), span_of(medium, i));
            let [a, m, b] = shades.each_ref().map(|rows| shade_of(rows, i));
            let spread = Spread::of(&piece, &span);
            let off = off(&common, [&a, &m, &b], &span, &spread);
            let [red, green, blue, absorbed, error, variance] = self.light.each_ref().map(|row| row[pass][i]);
            let light = Light { color: [red, green, blue], absorbed, error, variance };
            let light = common.apply(light, RayShading::mean(&a, &m, &b, spread.centre), off);
            [lit[0][i], lit[1][i], lit[2][i]] = light.color;
            [lit[3][i], lit[4][i], lit[5][i]] = [light.absorbed, light.error, light.variance];
            is_near[i] = off <= self.share;
        }
        self.light.iter_mut().zip(lit).for_each(|(row, lit)| row[pass] = lit);
        for i in 0..LANES {
            let is_left = (self.known[pass][i] == Known::Light) & !(is_near[i] | caster.is_coarse);
            self.known[pass][i] = if is_left { Known::Odd } else { self.known[pass][i] };
        }
    }

    /// The gradients at the six vertices, of frusta that are integrated.
    #[inline(always)]
    fn gradients(&self, pass: usize, caster: &Caster<'_, T, S, N>) -> [Vectors<T>; 6] {
        let layers = caster.shell.layers();
        let mut gradients = [[[T::zero(); LANES]; 3]; 6];
        for i in 0..LANES {
            if self.known[pass][i] != Known::Light {
                continue;
            }
            let (cells, [behind, ahead]) = (self.cells[pass][i], self.layers[pass][i]);
            for k in 0..6 {
                let layer = if k < 3 { behind } else { ahead };
                let gradient = caster.gradients[cells[k % 3] as usize * layers + layer as usize];
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
        let way = self.way.each_ref().map(|row| &row[pass]);
        let mut courses = [[[T::zero(); LANES]; 3]; 3];
        for k in 0..3 {
            for i in 0..LANES {
                let [a, b, c, d, e, f] = gradients.each_ref().map(|rows| [rows[k][i]]);
                let weight = [[way[0][i], way[1][i]], [way[2][i], way[3][i]]];
                let (first, second) = (Chord::over([a, b, c], &weight), Chord::over([d, e, f], &weight));
                let (at_a, at_b) = (first.mix(second, way[6][i]), first.mix(second, way[7][i]));
                let course = at_a.course(&at_b, [way[4][i], way[5][i]], way[8][i]);
                courses[0][k][i] = course.from[0];
                courses[1][k][i] = course.to[0];
                courses[2][k][i] = course.kappa[0];
            }
        }
        courses
    }

    /// The shade of each frustum at `u`: body, highlight and normal.
    #[inline(always)]
    fn shades(
        &self,
        pass: usize,
        [from, to, kappa]: &[Vectors<T>; 3],
        u: T,
        common: &RayShading<T>,
        directions: &[Row<T>; 6],
    ) -> [Row<T>; 5] {
        let eps = &self.way[8][pass];
        let mut shades = [[T::zero(); LANES]; 5];
        for i in 0..LANES {
            let of = |rows: &Vectors<T>| [T::zero(), rows[0][i], rows[1][i], rows[2][i]];
            let course = Course { from: of(from), to: of(to), kappa: of(kappa), eps: eps[i] };
            let [x, y, z, hx, hy, hz] = directions.each_ref().map(|row| row[i]);
            let shading = RayShading { light: [x, y, z], halfway: [hx, hy, hz], ..*common };
            let Shade { body, highlight, normal } = shading.shade(course.gradient(u));
            [shades[0][i], shades[1][i]] = [body, highlight];
            [shades[2][i], shades[3][i], shades[4][i]] = normal;
        }
        shades
    }
}

#[inline(always)]
fn shade_of<T: Real>(rows: &[Row<T>; 5], i: usize) -> Shade<T> {
    let [body, highlight, x, y, z] = rows.each_ref().map(|row| row[i]);
    Shade { body, highlight, normal: [x, y, z] }
}
