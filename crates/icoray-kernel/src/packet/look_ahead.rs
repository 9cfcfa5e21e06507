//! Prefetches the data of the lanes' next columns.
//!
//! The half-edge through which a lane leaves its column is determined when it enters the column, and is fetched at
//! once. At the end of the turn the half-edge gives the apex of the next column, whose direction, value and gradient
//! are fetched.

use super::Packet;
use super::lanes::lanes_of;
use super::layers::Layers;
use icoray_simd::Machine;

impl<V: Machine, L: Layers, const N: usize> Packet<'_, '_, V, L, N> {
    /// Starts to fetch the half-edges through which these lanes leave their columns.
    #[inline(always)]
    pub(super) fn fetch_half_edges(&self, lanes: u32) {
        for lane in lanes_of(lanes) {
            self.lanes.prefetch_half_edge(&self.tables.mesh, lane);
        }
    }

    /// Starts to fetch the directions, values and gradients at the apexes of the next columns of the lanes that have
    /// stepped, at their gaps.
    #[inline(always)]
    pub(super) fn look_ahead(&mut self) {
        let stepped = std::mem::take(&mut self.stepped);
        let (tables, source) = (self.tables, &self.frame.packets.source);
        let apexes = self.lanes.next_apexes(self.simd, &tables.mesh);
        let bases = source.bases(self.simd, apexes, stepped);
        for lane in lanes_of(stepped) {
            let (apex, gap) = (apexes[lane], self.lanes.gap[lane]);
            tables.mesh.prefetch_direction(apex);
            source.prefetch(bases[lane], gap);
            if N == 4 {
                tables.slopes.prefetch(apex, gap);
            }
        }
    }
}
