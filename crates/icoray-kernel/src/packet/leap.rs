//! Leaps of lanes over invisible macrocells.

use super::lanes::lanes_of;
use super::layers::Layers;
use super::{MOST, Packet, Start, start};
use crate::leap::{Ahead, Leaps};
use fearless_simd::prelude::*;
use icoray_simd::Machine;

impl<'p, V: Machine, L: Layers, const N: usize> Packet<'p, '_, V, L, N> {
    /// Moves lanes that have passed an invisible column over the invisible macrocells ahead.
    #[inline(always)]
    pub(super) fn leap(&mut self, skipped: u32) {
        let Some(leaps) = self.tables.leaps.as_ref() else { return };
        let is_due = self.lanes.next_leap.le(self.lanes.t[1]).narrow().to_bitmask() as u32;
        for lane in lanes_of(skipped & is_due & self.fresh) {
            self.leap_from(leaps, lane);
        }
    }

    #[inline(never)]
    fn leap_from(&mut self, leaps: &Leaps<'p>, lane: usize) {
        let Some(Start { line, .. }) = self.starts[lane % MOST] else { return };
        let t = self.lanes.t[1].get(lane);
        match leaps.ahead(&line, t) {
            Ahead::Nothing => {
                self.ended |= 1 << lane;
                self.fresh &= !(1 << lane);
            }
            Ahead::Shown { at, until, near } => {
                self.lanes.next_leap.set(lane, until);
                let is_worth = at - t > leaps.least() * (line.b * line.b + at * at).sqrt();
                let side = is_worth.then(|| start::side_at(&self.tables.mesh, line, at, near)).flatten();
                if let Some(side) = side {
                    self.lanes.put_amid::<L>(lane, &side, self.bases_of(&side));
                    self.layers.locate(&mut self.lanes, lane, side.height);
                }
            }
        }
    }
}
