//! Leaps of lanes over invisible macrocells.

use super::lanes::lanes_of;
use super::layers::Layers;
use super::{MOST, Packet, Start, start};
use crate::leap::{Ahead, HollowCore, Leaps};
use crate::walk::Side;
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

    /// Moves lanes that are about to enter columns of a hollow core to its far side.
    #[inline(always)]
    pub(super) fn leap_core(&mut self) {
        let Some(hollow) = self.tables.hollow.as_ref() else { return };
        let inside = self.lanes.gap.simd_eq(0).to_bitmask() as u32;
        for lane in lanes_of(inside & self.fresh) {
            self.leap_core_from(hollow, lane);
        }
    }

    #[inline(never)]
    fn leap_core_from(&mut self, hollow: &HollowCore<'p>, lane: usize) {
        let Some(Start { line, .. }) = self.starts[lane % MOST] else { return };
        let Some((at, near)) = hollow.exit(&line, self.lanes.t[1].get(lane)) else { return };
        if let Some(side) = start::side_at(&self.tables.mesh, line, at, near) {
            self.put_amid(lane, &side);
        }
    }

    /// Puts the ray of a lane before a later column, which it enters through `side`.
    fn put_amid(&mut self, lane: usize, side: &Side) {
        self.lanes.put_amid::<L>(lane, side, self.bases_of(side));
        self.layers.locate(&mut self.lanes, lane, side.height);
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
                    self.put_amid(lane, &side);
                }
            }
        }
    }
}
