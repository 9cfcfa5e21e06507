//! Which rank draws which tile: by what each tile cost in the last frame.
//!
//! Views change slowly from frame to frame, so the dearest tiles of the last frame are dealt first, each to the rank that
//! has the least to do so far; tiles off the globe cost next to nothing and fill up. The first frame's tiles are dealt
//! along diagonals, which spreads the globe's middle over all.

use crate::raster::Raster;

/// Seconds of each tile of a raster.
#[derive(Debug, Clone)]
pub(super) struct Costs {
    raster: Raster,
    seconds: Vec<f64>,
}

impl Costs {
    pub fn new(raster: Raster) -> Self {
        Costs { raster, seconds: vec![0.0; raster.tiles() as usize] }
    }

    pub fn set(&mut self, tile: u32, seconds: f64) {
        self.seconds[tile as usize] = seconds;
    }
}

/// The rank of each tile. Costs of another raster do not count.
pub(super) fn deal(raster: Raster, ranks: usize, costs: Option<&Costs>) -> Vec<u32> {
    let costs = costs.filter(|costs| costs.raster == raster);
    let Some(costs) = costs else {
        let across = raster.tiles_across();
        return (0..raster.tiles()).map(|tile| (tile % across + tile / across) % ranks as u32).collect();
    };
    let mut order: Vec<usize> = (0..costs.seconds.len()).collect();
    order.sort_by(|a, b| costs.seconds[*b].total_cmp(&costs.seconds[*a]));
    let mut loads = vec![0.0; ranks];
    let mut owners = vec![0; order.len()];
    for tile in order {
        let least = (0..ranks).min_by(|a, b| f64::total_cmp(&loads[*a], &loads[*b])).unwrap_or(0);
        owners[tile] = least as u32;
        loads[least] += costs.seconds[tile];
    }
    owners
}

#[cfg(test)]
mod tests {
    use super::*;

    const RASTER: Raster = Raster { width: 320, height: 160, step: 1 };

    fn loads(owners: &[u32], ranks: usize, seconds: impl Fn(u32) -> f64) -> Vec<f64> {
        let mut loads = vec![0.0; ranks];
        (0u32..).zip(owners).for_each(|(tile, rank)| loads[*rank as usize] += seconds(tile));
        loads
    }

    #[test]
    fn the_first_frame_is_dealt_to_all_alike() {
        for ranks in [1, 2, 3, 5, 8] {
            let owners = deal(RASTER, ranks, None);
            assert_eq!(owners.len(), RASTER.tiles() as usize);
            let counts = loads(&owners, ranks, |_| 1.0);
            let most = counts.iter().fold(0.0, |most: f64, n| most.max(*n));
            assert!(counts.iter().all(|n| *n > 0.0 && most - n <= 6.0), "{counts:?}");
        }
    }

    #[test]
    fn later_ones_by_what_tiles_cost() {
        // A globe that is dearest in the middle of the left half, and nothing on the right.
        let across = RASTER.tiles_across();
        let cost = |tile: u32| {
            let (x, y) = (f64::from(tile % across), f64::from(tile / across));
            (3.0 - (x - 3.0).hypot(y - 2.0)).max(0.0)
        };
        let mut costs = Costs::new(RASTER);
        (0..RASTER.tiles()).for_each(|tile| costs.set(tile, cost(tile)));
        for ranks in [2, 3, 4] {
            let loads = loads(&deal(RASTER, ranks, Some(&costs)), ranks, cost);
            let most = loads.iter().fold(0.0, |most: f64, load| most.max(*load));
            let mean = loads.iter().sum::<f64>() / ranks as f64;
            assert!(mean / most > 0.95, "{loads:?}");
        }
        let other = Raster { step: 2, ..RASTER };
        assert_eq!(deal(other, 3, Some(&costs)), deal(other, 3, None), "of another raster");
        assert!(deal(RASTER, 1000, Some(&costs)).iter().all(|rank| *rank < 1000), "more ranks than tiles");
    }
}
