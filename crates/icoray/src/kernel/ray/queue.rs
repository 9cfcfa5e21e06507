//! Rays that wait to be traced.

use super::{Caster, Start};
use crate::kernel::plane::RayLine;
use crate::kernel::real::Real;
use crate::kernel::walk::Walk;

/// Rays, each searched from where the one before it began.
pub(super) struct Queue<'q, 'r, 'f, T, const N: usize> {
    caster: &'r Caster<'f, T, N>,
    rays: &'q mut dyn Iterator<Item = Start>,
    /// The first triangle of the last ray, and of the first one of its row.
    hint: u32,
    row_hint: u32,
}

impl<'q, 'r, 'f, T: Real, const N: usize> Queue<'q, 'r, 'f, T, N> {
    #[inline]
    pub fn new(caster: &'r Caster<'f, T, N>, rays: &'q mut dyn Iterator<Item = Start>) -> Self {
        Queue { caster, rays, hint: 0, row_hint: 0 }
    }

    /// The next ray that meets the shell; the numbers of those that miss it are told.
    #[inline]
    pub fn next(&mut self, mut misses: impl FnMut(usize)) -> Option<(Start, RayLine, Walk<'r, 'f>)> {
        for start in &mut *self.rays {
            let from = if start.begins_row { self.row_hint } else { self.hint };
            let line = RayLine::new(start.eye, start.dir, self.caster.outer);
            let walk = line.map(|line| (line, Walk::new(self.caster.grid, line, from)));
            self.hint = walk.as_ref().map_or(from, |(_, walk)| walk.triangle());
            if start.begins_row {
                self.row_hint = self.hint;
            }
            match walk {
                Some((line, walk)) => return Some((start, line, walk)),
                None => misses(start.number),
            }
        }
        None
    }
}
