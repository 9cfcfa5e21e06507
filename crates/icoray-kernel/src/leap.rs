//! Leaps over empty space: how far a ray goes over macrocells in which nothing shows.

use crate::column::Shell;
use crate::plane::RayLine;
use crate::single_volume::SingleVolumeTracer;
use icoray_grid::macrocells::Macrocells;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::real::Real;
use std::sync::atomic::Ordering::Relaxed;

/// What lies ahead of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ahead {
    /// Nothing shows up to the ray's end.
    Nothing,
    /// Nothing shows up to the distance `at`; something may show from there on.
    Shown {
        at: f64,
        /// Where the ray leaves the macrocell that it is in at `at`.
        until: f64,
        /// A triangle nearby.
        near: u32,
    },
}

/// The macrocells of a frame.
pub(crate) struct Leaps<'t, T> {
    macrocells: &'t Macrocells,
    visible: &'t OccupancyMask,
    shell: &'t Shell<T>,
    /// Whether the core is opaque.
    is_solid: bool,
}

/// Part of a macrocell's width by which a ray goes on behind its border: with [`CENTRE`] less than the margin of its
/// triangles.
const STEP: f64 = 1e-5;
/// Radius below which rays do not leap.
const CENTRE: f64 = 0.1;
/// More than the rounding of heights, relative to them.
const ROUNDING: f64 = 1e-12;

impl<'t, T: Real> Leaps<'t, T> {
    /// The macrocells of a frame; `None` where all or too little of it is visible to leap.
    #[inline]
    pub fn new(tracer: &'t SingleVolumeTracer<'_, T>) -> Option<Self> {
        let SingleVolumeTracer { grid, shell, visible, .. } = *tracer;
        if visible.macrocells.is_empty() {
            return None;
        }
        Some(Leaps { macrocells: grid.macrocells(), visible, shell, is_solid: tracer.core.is_some() })
    }

    /// The least length of a leap that is worth it, for a ray at radius 1.
    #[inline]
    pub fn least(&self) -> f64 {
        0.5 * self.macrocells.map.width()
    }

    /// What lies ahead of a ray that is at distance `t`.
    #[inline(never)]
    pub fn ahead(&self, line: &RayLine, mut t: f64) -> Ahead {
        let map = &self.macrocells.map;
        let (from, along) = (line.b * line.plane.x, line.plane.y);
        let step = STEP * map.width();
        while t < line.end {
            let cell = map.find(from + t * along);
            let until = map.exit(cell, from, along, t) + step;
            let number = map.number(cell);
            if self.shows(number, line.b * line.b, [t, until.min(line.end)]) {
                return Ahead::Shown { at: t, until, near: self.macrocells.triangle_in(number) };
            }
            t = until;
        }
        Ahead::Nothing
    }

    /// Whether something may show, or the opaque core be met, between two distances in a macrocell; `b2` is the square
    /// of the line's distance from the centre.
    #[inline]
    fn shows(&self, number: u32, b2: f64, [from, to]: [f64; 2]) -> bool {
        let near = if from < 0.0 && to > 0.0 { 0.0 } else { from.abs().min(to.abs()) };
        let near2 = b2 + near * near;
        let inner = if self.is_solid { self.shell.inner().max(CENTRE) } else { CENTRE };
        if near2 * (1.0 - 2.0 * ROUNDING) < inner * inner {
            return true;
        }
        let bits = self.visible.macrocells[number as usize].load(Relaxed);
        if bits == 0 {
            return false;
        }
        let far2 = b2 + (from * from).max(to * to);
        // On a facet of radius R are points with radii from R down to R times its lowest place.
        let low = self.shell.gap(near2.sqrt() * (1.0 - ROUNDING));
        let high = self.shell.gap(far2.sqrt() / self.macrocells.lowest_facet * (1.0 + ROUNDING));
        bits & self.visible.between([low, high], self.shell.layers()) != 0
    }
}
