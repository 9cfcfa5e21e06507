//! Leaps over empty space: the distance that a ray passes over invisible macrocells.

use crate::column::Shell;
use crate::general::KernelScene;
use crate::packet::PacketFrame;
use crate::plane::RayLine;
use icoray_grid::macrocells::Macrocells;
use icoray_grid::occupancy::OccupancyMask;

/// The result of looking ahead of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ahead {
    /// Nothing is visible up to the ray's end.
    Nothing,
    /// Nothing is visible up to the distance `at`; something may be visible from there on.
    Shown {
        at: f64,
        /// Distance at which the ray leaves the macrocell that contains it at `at`.
        until: f64,
        /// A triangle nearby.
        near: u32,
    },
}

/// The macrocells of a frame.
pub(crate) struct Leaps<'t> {
    macrocells: &'t Macrocells<'t>,
    visible: &'t OccupancyMask<'t>,
    /// Blocks that surfaces adjoin in all columns.
    beside: u32,
    shell: &'t Shell,
    /// Squares of the lowest and the highest radius in the gaps of each block.
    blocks: Vec<[f64; 2]>,
    /// Square of the radius below which rays do not leap: that of an opaque core.
    inner2: f64,
}

/// A core that is hollow.
pub(crate) struct HollowCore<'t> {
    macrocells: &'t Macrocells<'t>,
    /// Square of the radius below which there are no layers.
    radius2: f64,
}

impl<'t> HollowCore<'t> {
    /// The hollow core of a frame; `None` if rays do not leap over it.
    #[inline]
    pub fn new(frame: &'t PacketFrame<'_>) -> Option<Self> {
        let (macrocells, packets) = (frame.scene.grid.macrocells(), frame.packets);
        if !packets.leaps_core {
            return None;
        }
        // On a facet of radius R are points with radii from R down to R times its lowest place.
        let radius = packets.shell.inner() * macrocells.lowest_facet * (1.0 - ROUNDING);
        Some(HollowCore { macrocells, radius2: radius * radius })
    }

    /// The distance at which a ray leaves the hollow core, if it is in it at `t` and a leap is worthwhile, and a triangle
    /// nearby.
    #[inline]
    pub fn exit(&self, line: &RayLine, t: f64) -> Option<(f64, u32)> {
        let half2 = self.radius2 - line.b * line.b;
        // Longer than several macrocells, seen from the sphere's centre.
        let is_worth = half2 > 0.0 && half2.sqrt() - t > 4.0 * self.macrocells.map.width() * self.radius2.sqrt();
        let at = half2.max(0.0).sqrt();
        (is_worth && t >= -at).then(|| {
            let map = &self.macrocells.map;
            let cell = map.find(line.b * line.plane.x + at * line.plane.y);
            (at, self.macrocells.triangle_in(map.number(cell)))
        })
    }
}

/// Fraction of a macrocell's width by which a ray continues behind its border: with [`CENTRE`] less than the margin of
/// its triangles.
const STEP: f64 = 1e-5;
/// Radius below which rays do not leap.
const CENTRE: f64 = 0.1;
/// More than the rounding of heights and of their squares, relative to them.
const ROUNDING: f64 = 1e-12;

impl<'t> Leaps<'t> {
    /// The macrocells of a frame; `None` where all or too little of it is visible to leap.
    #[inline]
    pub fn new(frame: &'t PacketFrame<'_>) -> Option<Self> {
        let KernelScene { visible, beside, .. } = frame.scene;
        let shell = &frame.packets.shell;
        if visible.macrocells.is_empty() {
            return None;
        }
        let macrocells = frame.scene.grid.macrocells();
        let radii = shell.radii();
        let square = |radius: f64, part: f64| (radius * radius) * part;
        let block = |low: usize| {
            let high = (low + (1 << visible.shift)).min(radii.len() - 1);
            // On a facet of radius R are points with radii from R down to R times its lowest place.
            [square(radii[low] * macrocells.lowest_facet, 1.0 - ROUNDING), square(radii[high], 1.0 + ROUNDING)]
        };
        let blocks = (0..radii.len() - 1).step_by(1 << visible.shift).map(block).collect();
        let inner = if frame.scene.core.is_some() { shell.inner().max(CENTRE) } else { CENTRE };
        Some(Leaps { macrocells, visible, beside: *beside, shell, blocks, inner2: square(inner, 1.0 + ROUNDING) })
    }

    /// The least length of a worthwhile leap, for a ray at radius 1.
    #[inline]
    pub fn least(&self) -> f64 {
        0.5 * self.macrocells.map.width()
    }

    /// Looks ahead of a ray at distance `t`.
    #[inline(never)]
    pub fn ahead(&self, line: &RayLine, mut t: f64) -> Ahead {
        let Macrocells { map, groups, .. } = self.macrocells;
        let (from, along) = (line.b * line.plane.x, line.plane.y);
        let (b2, step) = (line.b * line.b, STEP * map.width());
        let mut entered = u32::MAX;
        while t < line.end {
            let cell = map.find(from + t * along);
            let group = map.group_of(cell);
            let number = groups.number(group);
            if number != entered {
                let until = groups.exit(group, from, along, t) + step;
                let first = self.first(self.visible.macrocells.of_group(number) | self.beside, b2, t);
                entered = number;
                if first > t {
                    t = first.min(until);
                    continue;
                }
            }
            let until = map.exit(cell, from, along, t) + step;
            let number = map.number(cell);
            let bits = self.visible.macrocells.of_macrocell(number) | self.beside;
            let first = self.first(bits, b2, t);
            if first < until && self.shows(bits, b2, [first, until.min(line.end)]) {
                return Ahead::Shown { at: first, until, near: self.macrocells.triangle_in(number) };
            }
            t = until;
        }
        Ahead::Nothing
    }

    /// The first distance from `t` on at which a ray is between the lowest and the highest radius of these blocks, or
    /// at which rays do not leap; infinity if there is none. `b2` is the square of the line's distance from the centre.
    #[inline]
    fn first(&self, bits: u32, b2: f64, t: f64) -> f64 {
        // Half of the line's chord in a sphere.
        let half = |r2: f64| (r2 - b2).max(0.0).sqrt();
        let core = if b2 < self.inner2 { half(self.inner2) } else { f64::NEG_INFINITY };
        if t.abs() <= core {
            return t;
        }
        let to_core = if t < -core { -core } else { f64::INFINITY };
        if bits == 0 {
            return to_core;
        }
        let (lowest, highest) = (bits.trailing_zeros() as usize, (u32::BITS - 1 - bits.leading_zeros()) as usize);
        let ([low2, _], [_, high2]) = (self.blocks[lowest], self.blocks[highest]);
        let (low, high) = (half(low2), half(high2));
        let to_blocks = if b2 > high2 || t > high {
            f64::INFINITY
        } else if t < -high {
            -high
        } else if t.abs() < low {
            low
        } else {
            t
        };
        to_core.min(to_blocks)
    }

    /// Whether something may be visible, or rays do not leap, between two distances in a macrocell with these visible
    /// blocks; `b2` is the square of the line's distance from the centre.
    #[inline]
    fn shows(&self, bits: u32, b2: f64, [from, to]: [f64; 2]) -> bool {
        let near = if from < 0.0 && to > 0.0 { 0.0 } else { from.abs().min(to.abs()) };
        let near2 = b2 + near * near;
        if near2 * (1.0 - 2.0 * ROUNDING) < self.inner2 {
            return true;
        }
        let far2 = b2 + (from * from).max(to * to);
        let low = self.shell.gap(near2.sqrt() * (1.0 - ROUNDING));
        let high = self.shell.gap(far2.sqrt() / self.macrocells.lowest_facet * (1.0 + ROUNDING));
        bits & self.visible.between([low, high], self.shell.layers()) != 0
    }
}
