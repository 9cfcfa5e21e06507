//! Load balancing: assigns tiles to ranks by their costs in the last frame.
//!
//! Views change slowly from frame to frame, so tiles are assigned in the order of their costs in the last frame, the
//! most expensive first, each to the rank with the least load so far. The tiles of the first frame are assigned in the
//! order of their distance from the middle of the picture: tiles at equal distance cost about the same on a globe.

use crate::raster::{Raster, Tiling};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Seconds of each tile of a raster.
#[derive(Debug, Clone)]
pub(crate) struct TileCosts {
    raster: Raster,
    seconds: Vec<f64>,
}

impl TileCosts {
    pub(crate) fn new(raster: Raster) -> Self {
        TileCosts { raster, seconds: vec![0.0; raster.tiles() as usize] }
    }

    pub(crate) fn set(&mut self, tile: u32, seconds: f64) {
        if let Some(cost) = self.seconds.get_mut(tile as usize) {
            // Negative or NaN seconds, from a broken clock or message, become 0.
            *cost = seconds.max(0.0);
        }
    }
}

/// The rank of each tile. Costs of another raster are ignored.
pub(super) fn assign_tiles(raster: Raster, ranks: usize, costs: Option<&TileCosts>) -> Vec<u32> {
    let mut owners = vec![0; raster.tiles() as usize];
    let mut order: Vec<u32> = (0..raster.tiles()).collect();
    let Some(TileCosts { seconds, .. }) = costs.filter(|costs| costs.raster == raster) else {
        order.sort_by_key(|tile| from_the_middle(raster, *tile));
        // In alternating order of ranks, since the first of each round gets the nearest tile.
        let round = (0..ranks as u32).chain((0..ranks as u32).rev());
        order.iter().zip(round.cycle()).for_each(|(tile, rank)| owners[*tile as usize] = rank);
        return owners;
    };
    order.sort_by(|a, b| seconds[*b as usize].total_cmp(&seconds[*a as usize]));
    // The greatest entry is the rank with the least load; non-negative seconds order as their bits do.
    let mut least: BinaryHeap<_> = (0..ranks as u32).map(|rank| Reverse((0u64, rank))).collect();
    for tile in order {
        if let Some(mut first) = least.peek_mut() {
            let Reverse((load, rank)) = *first;
            owners[tile as usize] = rank;
            *first = Reverse(((f64::from_bits(load) + seconds[tile as usize]).to_bits(), rank));
        }
    }
    owners
}

/// The square of a tile's distance from the middle of the picture, in half tiles.
fn from_the_middle(raster: Raster, tile: u32) -> u64 {
    let across = raster.tiles_across();
    let from_middle = |at: u32, side: u32| u64::from((2 * at + 1).abs_diff(side)).pow(2);
    from_middle(tile % across, across) + from_middle(tile / across, raster.tiles() / across)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RASTER: Raster = Raster { width: 320, height: 160, step: 1 };

    /// Seconds of work of each rank.
    fn loads(owners: &[u32], ranks: usize, seconds: impl Fn(u32) -> f64) -> Vec<f64> {
        let mut loads = vec![0.0; ranks];
        (0u32..).zip(owners).for_each(|(tile, rank)| loads[*rank as usize] += seconds(tile));
        loads
    }

    /// Mean over maximum.
    fn balance(loads: &[f64]) -> f64 {
        loads.iter().sum::<f64>() / loads.len() as f64 / loads.iter().fold(0.0, |most: f64, load| most.max(*load))
    }

    #[test]
    fn the_first_frame_is_dealt_to_all_alike() {
        for ranks in [1, 2, 3, 5, 8] {
            let owners = assign_tiles(RASTER, ranks, None);
            assert_eq!(owners.len(), RASTER.tiles() as usize);
            let counts = loads(&owners, ranks, |_| 1.0);
            let most = counts.iter().fold(0.0, |most: f64, n| most.max(*n));
            assert!(counts.iter().all(|n| *n > 0.0 && most - n <= 1.0), "{counts:?}");
        }
        // A globe that fills the picture, as dear as rays through it are long.
        let raster = Raster { width: 512, height: 512, step: 1 };
        let across = raster.tiles_across();
        let cost = |tile: u32| {
            let [x, y] = [tile % across, tile / across].map(|at| f64::from(2 * at + 1) / f64::from(across) - 1.0);
            (0.01 + 1.3 - x * x - y * y).max(0.01).sqrt() - (1.0 - x * x - y * y).max(0.0).sqrt()
        };
        for ranks in 2..=16 {
            let loads = loads(&assign_tiles(raster, ranks, None), ranks, cost);
            assert!(balance(&loads) > 0.9, "{ranks}: {loads:?}");
        }
    }

    #[test]
    fn later_frames_are_assigned_by_costs_of_tiles() {
        // A globe that is dearest in the middle of the left half, and nothing on the right.
        let across = RASTER.tiles_across();
        let cost = |tile: u32| {
            let (x, y) = (f64::from(tile % across), f64::from(tile / across));
            (6.0 - (x - 6.0).hypot(y - 4.0)).max(0.0)
        };
        let mut costs = TileCosts::new(RASTER);
        (0..RASTER.tiles()).for_each(|tile| costs.set(tile, cost(tile)));
        for ranks in 2..=8 {
            let loads = loads(&assign_tiles(RASTER, ranks, Some(&costs)), ranks, cost);
            assert!(balance(&loads) > 0.97, "{ranks}: {loads:?}");
        }
        let other = Raster { step: 2, ..RASTER };
        assert_eq!(assign_tiles(other, 3, Some(&costs)), assign_tiles(other, 3, None), "of another raster");
        assert!(assign_tiles(RASTER, 1000, Some(&costs)).iter().all(|rank| *rank < 1000), "more ranks than tiles");
        costs.set(0, f64::NAN);
        assert_eq!(assign_tiles(RASTER, 3, Some(&costs)).len(), RASTER.tiles() as usize, "what no clock says");
    }
}
