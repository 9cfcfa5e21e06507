//! Integrates the frusta of a packet, a piece of each per turn.

use super::cut::{Cutter, Pieces};
use super::integral::{Integral, LARGEST_DEPTH, LARGEST_EPS, Light, Outcome};
use super::lanes::{Lanes, lanes_of};
use super::layers::{Crossing, Layers};
use super::light::Piece;
use super::medium::{Medium, number};
use super::part::{Part, all};
use super::read::{FAR, LARGEST, Vertices};
use super::{Packet, mask};
use crate::column::Flow;
use crate::lit::FrustumInterpolant;
use crate::piece::Radiance;
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_simd::{Floats, Machine, Mask};

impl<V: Machine, L: Layers, const N: usize> Packet<'_, '_, V, L, N> {
    /// Integrates a piece of the frusta of the lanes `inside`, and sets [`Packet::mid`] to those with a remaining part.
    #[inline(always)]
    pub(super) fn frusta(&mut self, crossing: &Crossing<V, L::End<V>>, inside: u32) {
        let simd = self.simd;
        let new = inside & !self.mid;
        self.counts.frusta += u64::from(new.count_ones());
        let mut part = self.lanes.rest;
        let mut scalar = 0;
        let mut active = inside;
        if new != 0 {
            let way = L::way(&self.lanes, crossing);
            let source = &self.frame.packets.source;
            let vertices = source.read(simd, &self.lanes, self.lanes.bases, new);
            let [f0, f1, kappa] = source.normalised(simd, &vertices, &way);
            let read = Part { f0, f1, kappa, eps: crossing.eps, length: crossing.length };
            let is_new = mask::<V>(simd, new);
            part = read.over(is_new, part);
            self.lanes.is_monotone &= !is_new;
            if self.frame.needs_sizes {
                self.lanes.size = is_new.select(source.size(simd, &vertices), self.lanes.size);
            }
            self.lit.enter(simd, is_new, crossing.eps);
            let (void, beyond) = self.unusual(&vertices, &part, new);
            self.add_deviations(crossing.length, is_new);
            self.counts.void_frusta += u64::from(void.count_ones());
            active &= !void;
            scalar = beyond;
            if self.frame.needs_sizes && self.scene.is_none() {
                self.add_displacement(&part, source.ends(simd, &vertices), new & !void);
            }
            if self.scene.is_some() {
                scalar |= self.lanes.size.simd_gt(FAR).to_bitmask() as u32 & new & !void;
            }
        }
        self.mid = 0;
        if !self.frame.integrates {
            return;
        }
        let cutter =
            Cutter { simd, spans: &self.tables.spans, is_monotone: self.lanes.is_monotone, size: self.lanes.size };
        let mut pieces = cutter.pieces(part, self.lanes.span, [active, new], &mut scalar);
        self.lanes.span = pieces.span;
        let medium = self.tables.spans.medium(simd, pieces.span);
        if N == 4 {
            scalar |= self.enter_light(crossing, &pieces, &medium, new & active);
        }
        let cut = self.lit.fraction.simd_lt(1.0).to_bitmask() as u32 & active & !scalar;
        if cut != 0 {
            pieces.shorten(simd, &part, self.lit.fraction, (cut, self.lanes.is_monotone));
        }
        let piece = pieces.part;
        let integral = Integral::new(simd, &piece, &medium);
        let mut outcome = integral.thin(self.color_tolerance);
        let mut far = (!outcome.is_near).to_bitmask() as u32 & active & !scalar;
        if far != 0 {
            outcome = Outcome::over(outcome, mask::<V>(simd, !far), integral.gauss(self.color_tolerance));
            far = (!outcome.is_near).to_bitmask() as u32 & active & !scalar;
        }
        // Dense pieces are halved before scalar code takes them.
        let is_long = self.lit.fraction.simd_gt(1.0 / 16.0) & integral.depth.simd_lt(LARGEST_DEPTH);
        let mut left = far & is_long.to_bitmask() as u32;
        far &= !left;
        let mut light = integral.light(&outcome, piece.reach(self.lanes.size));
        let from = self.lit.from;
        let to = pieces.upto.mul_add(all(simd, 1.0) - from, from);
        if N == 4 {
            let taken = active & !scalar & !left & !far;
            left |= self.shade(&piece, &medium, &integral, [from, to], crossing.eps, &mut light, taken);
        }
        let taken = active & !scalar & !left;
        light.variance = medium.is_clear(simd, &piece).select(all(simd, 0.0), light.variance);
        self.lanes.add(simd, mask::<V>(simd, taken & !far), &light);
        if far != 0 {
            self.scalar_pieces(far, &pieces, [from, to]);
        }
        self.mid = taken & pieces.more | left;
        if self.mid != 0 {
            let (more, is_left) = (mask::<V>(simd, taken & pieces.more), mask::<V>(simd, left));
            self.lanes.rest = pieces.rest.over(more, part.over(is_left, self.lanes.rest));
            self.lanes.is_monotone = more.select(pieces.is_monotone, self.lanes.is_monotone);
            self.lit.go_on(simd, mask::<V>(simd, taken), is_left, to);
        }
        if scalar != 0 {
            self.scalar_frusta(scalar, crossing);
        }
        self.end(active);
    }

    /// Adds the effect of rounding on new frusta with values far beyond the visible ones: it moves a part of them into
    /// or out of any span, unless all values at the vertices lie on one side of the knots.
    #[inline(never)]
    fn add_displacement(&mut self, part: &Part<V>, [least, most]: [Floats<V>; 2], new: u32) {
        let (simd, size, first) = (self.simd, self.lanes.size, self.tables.spans.origin);
        let far = mask::<V>(simd, new) & size.simd_gt(FAR) & least.simd_lt(first + 1.0) & most.simd_gt(first);
        let reach = part.reach(size);
        let moved = part.length * self.tables.spans.densest * reach / (reach + (part.f1 - part.f0).abs());
        let off = moved.min(1.0) * (all(simd, 1.0) - self.lanes.light.alpha);
        self.lanes.light.variance = far.select(off.mul_add(off, self.lanes.light.variance), self.lanes.light.variance);
    }

    /// Adds to the error of the lanes `new`, which enter frusta of this length, the difference from a finer grid's
    /// extinction there and from its colours in the frusta before.
    #[inline(always)]
    fn add_deviations(&mut self, length: Floats<V>, new: Mask<V>) {
        let Some((gaps, words)) = self.tables.deviations else { return };
        let simd = self.simd;
        self.settle_color(new);
        let word = simd.gather_u32(words, self.lanes.triangles * number(simd, gaps) + self.lanes.gap - 1);
        let extinction = (word & number(simd, 0xffff_0000)).bitcast::<Floats<V>>();
        let change = (extinction * length).min(1.0) * (all(simd, 1.0) - self.lanes.light.alpha);
        self.lanes.light.error = new.select(self.lanes.light.error + change, self.lanes.light.error);
        self.lanes.color_change = new.select((word << 16).bitcast::<Floats<V>>(), self.lanes.color_change);
    }

    /// Adds to the error of `lanes` the difference of colours in their last frusta from those of a finer grid.
    #[inline(always)]
    pub(super) fn settle_color(&mut self, lanes: Mask<V>) {
        let row = &mut self.lanes;
        let change = (row.light.alpha - row.absorbed_before) * row.color_change;
        row.light.error = lanes.select(row.light.error + change, row.light.error);
        row.color_change = lanes.select(all(self.simd, 0.0), row.color_change);
        row.absorbed_before = lanes.select(row.light.alpha, row.absorbed_before);
    }

    /// Reads the gradients along the frusta of the lanes `new`, if any of them is visible. Returns the lanes whose
    /// normals require double precision, if there are single rays.
    #[inline(always)]
    fn enter_light(
        &mut self,
        crossing: &Crossing<V, L::End<V>>,
        pieces: &Pieces<V>,
        medium: &Medium<V>,
        new: u32,
    ) -> u32 {
        let (simd, mut scalar) = (self.simd, 0);
        let is_dark = medium.extinction.simd_le(0.0) & medium.slope.simd_eq(0.0);
        let seen = new & ((!is_dark).to_bitmask() as u32 | pieces.more);
        if seen != 0 {
            let course = self.tables.slopes.read(simd, &self.lanes, &L::way(&self.lanes, crossing));
            self.lit.course.put(mask::<V>(simd, new), &course);
            if self.scene.is_some() {
                scalar = course.is_cancelled().to_bitmask() as u32 & seen;
            }
        }
        scalar
    }

    /// Lights the pieces of the lanes `taken`; returns those whose rays cannot afford the error of their shades.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "the numbers of a piece")]
    fn shade(
        &self,
        part: &Part<V>,
        medium: &Medium<V>,
        integral: &Integral<'_, V>,
        range: [Floats<V>; 2],
        eps: Floats<V>,
        light: &mut Light<V>,
        taken: u32,
    ) -> u32 {
        let simd = self.simd;
        let shown = integral.depth.simd_gt(0.0).to_bitmask() as u32 & taken;
        let Some(common) = self.shading.as_ref().filter(|_| shown != 0) else { return 0 };
        let piece = Piece { part, medium, ends: integral.ends, range, eps };
        let shade = self.lit.shade(simd, common, &piece);
        shade.apply(simd, &piece, self.lit.fraction, light);
        if self.frame.rays.is_coarse {
            return 0;
        }
        let too_far = shade.too_far(simd, &self.lanes, &piece, self.color_tolerance);
        (too_far & self.lit.may_halve(range[1])).to_bitmask() as u32 & shown
    }

    /// Ends the rays of `active` lanes whose transmittance is so small that the light from behind may be omitted.
    #[inline(always)]
    pub(super) fn end(&mut self, active: u32) {
        // The transmittance of a piece that ended early is accurate to the last digit only.
        let rest = self.min_transmittance * 1.001 + f32::EPSILON;
        let through = all(self.simd, 1.0) - self.lanes.light.alpha;
        let ends = through.simd_le(rest).to_bitmask() as u32 & active & !self.ended;
        if ends != 0 {
            let left_out = through * self.frame.rays.budget.brightest as f32;
            self.lanes.light.error =
                mask::<V>(self.simd, ends).select(self.lanes.light.error + left_out, self.lanes.light.error);
            self.ended |= ends;
        }
    }

    /// Lanes of `new` frusta in which a value is missing, and those that scalar code must integrate.
    #[inline(always)]
    fn unusual(&self, vertices: &Vertices<V>, part: &Part<V>, new: u32) -> (u32, u32) {
        let source = &self.frame.packets.source;
        let size = part.f0.abs() + part.f1.abs() + part.kappa.abs();
        let is_usual = size.simd_le(LARGEST) & part.eps.abs().simd_lt(LARGEST_EPS);
        let unusual = (!is_usual).to_bitmask() as u32 & new;
        let mut void = source.missing(self.simd, vertices).map_or(0, |missing| missing.to_bitmask() as u32 & new);
        if unusual != 0 {
            void |= source.not_finite(self.simd, vertices).to_bitmask() as u32 & unusual;
        }
        (void, unusual & !void)
    }

    /// Integrates the pieces of lanes in scalar code.
    #[inline(never)]
    fn scalar_pieces(&mut self, lanes: u32, pieces: &Pieces<V>, [from, to]: [Floats<V>; 2]) {
        for lane in lanes_of(lanes) {
            let Some(mut ray) = self.ray(lane) else { continue };
            // The lane has read the gradients of its frustum.
            ray.gradient_size = self.lit.course.size[lane];
            let segment = pieces.part.segment(lane);
            self.counts.scalar_pieces += 1;
            let [start, end, bend] = self.lit.course.interpolant(lane);
            let of = |gradient: [f32; 3]| {
                let mut values = [0.0; N];
                values.iter_mut().skip(1).zip(gradient).for_each(|(value, component)| *value = component);
                values
            };
            let interpolant =
                FrustumInterpolant { from: of(start), to: of(end), kappa: of(bend), eps: self.lit.eps[lane] };
            let range = [from[lane], to[lane]];
            ray.piece(&segment, pieces.span[lane] as usize, &interpolant, range, segment.reach(ray.size));
            self.lanes.put_light(lane, &ray.light);
        }
    }

    /// Integrates whole frusta of lanes in scalar code, in double precision where a scene has more than the volume.
    #[inline(never)]
    fn scalar_frusta(&mut self, lanes: u32, crossing: &Crossing<V, L::End<V>>) {
        for lane in lanes_of(lanes) {
            self.counts.scalar_pieces += 1;
            let Some(interpolant) = L::interpolant::<V, N>(&self.lanes, lane, self.frame, crossing) else {
                self.scene_frustum(lane, crossing);
                continue;
            };
            let Some(mut ray) = self.ray(lane) else { continue };
            let segment = interpolant.segment(crossing.length[lane]);
            if segment.is_void() {
                self.counts.void_frusta += 1;
            } else if ray.segment(&segment, &interpolant, [0.0, 1.0]) == Flow::Stop {
                self.ended |= 1 << lane;
            }
            self.lanes.put_light(lane, &ray.light);
        }
    }
}

impl<V: Machine> Lanes<V> {
    /// The light of a lane.
    pub fn light(&self, lane: usize) -> Radiance<f32> {
        Radiance {
            color: self.light.color.map_inline(|row| row[lane]),
            alpha: self.light.alpha[lane],
            error: self.light.error[lane],
            variance: self.light.variance[lane],
            shade_variance: self.light.shade_variance[lane],
        }
    }

    /// Sets the light of a lane.
    pub fn put_light(&mut self, lane: usize, light: &Radiance<f32>) {
        self.light.color.iter_mut().zip(light.color).for_each(|(row, channel)| row[lane] = channel);
        (self.light.alpha[lane], self.light.error[lane]) = (light.alpha, light.error);
        (self.light.variance[lane], self.light.shade_variance[lane]) = (light.variance, light.shade_variance);
    }

    /// Puts light behind that of the lanes of `mask`.
    #[inline(always)]
    pub(super) fn add(&mut self, simd: V, mask: Mask<V>, light: &Light<V>) {
        let own = &mut self.light;
        let through = all(simd, 1.0) - own.alpha;
        let behind = |own: Floats<V>, new: Floats<V>| mask.select(through.mul_add(new, own), own);
        for k in 0..3 {
            own.color[k] = behind(own.color[k], light.color[k]);
        }
        own.alpha = behind(own.alpha, light.alpha);
        own.error = behind(own.error, light.error);
        // The sum is rounded to its own last digit, unless nothing is added.
        let off = light.alpha.simd_gt(0.0).select(own.alpha * (0.25 * f32::EPSILON), all(simd, 0.0));
        let squared = through * through;
        let variance = squared.mul_add(light.variance, off * off);
        own.variance = mask.select(own.variance + variance, own.variance);
        own.shade_variance = mask.select(squared.mul_add(light.shade_variance, own.shade_variance), own.shade_variance);
    }
}
